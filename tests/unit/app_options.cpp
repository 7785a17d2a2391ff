#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <set>

#include "command_line.h"
#include "help.h"
#include "option_values.h"
#include "text_table.h"

namespace halflight {
namespace {

/// The message of the Error that `action` throws with `code`; fails the test where it does not.
template <class Action>
std::string refusal(ExitCode code, Action action) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

std::string usage_refusal(const std::vector<std::string>& arguments) {
  return refusal(ExitCode::usage, [&] { parse_arguments(arguments); });
}

void expect_has(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "'" << text << "' lacks '" << part << "'";
}

class ConfigFile {
 public:
  explicit ConfigFile(const std::string& text) {
    folder_ = std::filesystem::temp_directory_path() / fmt::format("halflight-config-{}", ::getpid());
    std::filesystem::create_directories(folder_);
    std::ofstream(path()) << text;
  }
  ~ConfigFile() { std::filesystem::remove_all(folder_); }
  std::string path() const { return (folder_ / "halflight.json").string(); }
  std::string beside(const std::string& name) const { return (folder_ / name).string(); }

 private:
  std::filesystem::path folder_;
};

TEST(OptionValues, NumbersAreStrictAndBounded) {
  EXPECT_EQ(parse_number("2.5e1", 0, 100), 25);
  EXPECT_EQ(parse_number("-3", -10, 10), -3);
  EXPECT_EQ(parse_number("+3", -10, 10), 3);
  for (const char* bad :
       {"", " 1", "1 ", "1x", "nan", "inf", "-inf", "1e400", "--1", "+-1", "0x10", "1,5", "101", "-1"})
    refusal(ExitCode::usage, [&] { parse_number(bad, 0, 100); });
}

TEST(OptionValues, IntegersAreStrictAndBounded) {
  EXPECT_EQ(parse_integer("0", 0, 5), 0u);
  EXPECT_EQ(parse_integer("18446744073709551615", 0, ~uint64_t{0}), ~uint64_t{0});
  for (const char* bad : {"", "-1", "6", "1.5", "1e3", "18446744073709551616", "nan", "0x1", "1 "})
    refusal(ExitCode::usage, [&] { parse_integer(bad, 0, 5); });
}

TEST(OptionValues, AmountsTakePowersOf1024) {
  EXPECT_EQ(parse_amount("3", 1, 1ull << 40), 3u);
  EXPECT_EQ(parse_amount("2K", 1, 1ull << 40), 2048u);
  EXPECT_EQ(parse_amount("256M", 1, 1ull << 40), 256ull << 20);
  EXPECT_EQ(parse_amount("8G", 1, 1ull << 40), 8ull << 30);
  for (const char* bad : {"K", "2k", "2T", "0", "0K", "99999999999999999G", "18014398509481985K", "-1K"})
    refusal(ExitCode::usage, [&] { parse_amount(bad, 1, 1ull << 40); });
  refusal(ExitCode::usage, [] { parse_amount("4G", 1, 0xffffffffull); });
}

TEST(OptionValues, Sizes) {
  EXPECT_EQ(parse_size("640x480"), std::make_pair(640, 480));
  EXPECT_EQ(parse_size("1X1"), std::make_pair(1, 1));
  EXPECT_EQ(parse_size("16384x16384"), std::make_pair(16384, 16384));
  for (const char* bad :
       {"", "x", "640", "640x", "x480", "0x1", "1x0", "16385x1", "-1x5", "640x480x3", "6.4x4", "640 x 480"})
    refusal(ExitCode::usage, [&] { parse_size(bad); });
}

TEST(OptionValues, Assignments) {
  EXPECT_EQ(parse_assignment("a=b=c"), std::make_pair(std::string("a"), std::string("b=c")));
  EXPECT_EQ(parse_assignment("a="), std::make_pair(std::string("a"), std::string()));
  for (const char* bad : {"", "=", "=b", "a"}) refusal(ExitCode::usage, [&] { parse_assignment(bad); });
}

TEST(OptionTable, NamesAreUniqueAndRowsComplete) {
  std::set<std::string_view> names, letters;
  for (const OptionInfo& row : option_table()) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_TRUE(row.letter.empty() || letters.insert(row.letter).second) << row.letter;
    EXPECT_FALSE(row.help.empty()) << row.name;
    EXPECT_FALSE(row.group.empty()) << row.name;
    EXPECT_NE(row.commands, 0u) << row.name;
    EXPECT_NE(row.set, nullptr) << row.name;
    EXPECT_EQ(row.help.back() == '.', false) << row.name;
  }
}

// Defaults are written twice, in the table for people and in the structs for the program.
TEST(OptionTable, DefaultsAreWhatTheProgramUses) {
  const Options fresh;
  for (const OptionInfo& row : option_table()) {
    const std::string text = option_default(row).substr(0, option_default(row).find(';'));
    if (text.empty() || row.name == "threads" || row.name == "camera" || row.name == "samples") continue;
    if (row.name == "target") continue;
    Options options;
    set_option(options, row, text);
    EXPECT_EQ(options.render.technique, fresh.render.technique) << row.name;
    EXPECT_EQ(options.render.width, fresh.render.width) << row.name;
    EXPECT_EQ(options.render.height, fresh.render.height) << row.name;
    EXPECT_EQ(options.render.light, fresh.render.light) << row.name;
    EXPECT_EQ(options.render.seed, fresh.render.seed) << row.name;
    EXPECT_EQ(options.render.backend, fresh.render.backend) << row.name;
    EXPECT_EQ(options.render.values, fresh.render.values) << row.name;
    EXPECT_EQ(options.tonemap, fresh.tonemap) << row.name;
    EXPECT_EQ(options.ev.value_or(0), 0) << row.name;
    EXPECT_EQ(options.load.at_seconds, fresh.load.at_seconds) << row.name;
    EXPECT_EQ(options.environment_rotation.value_or(0), Environment{}.rotation) << row.name;
    EXPECT_EQ(options.environment_strength.value_or(1), Environment{}.strength) << row.name;
    EXPECT_EQ(options.load.limits.image_pixels, fresh.load.limits.image_pixels) << row.name;
    EXPECT_EQ(options.load.limits.total_pixels, fresh.load.limits.total_pixels) << row.name;
    EXPECT_EQ(options.load.limits.triangles, fresh.load.limits.triangles) << row.name;
    EXPECT_EQ(options.load.limits.buffer_bytes, fresh.load.limits.buffer_bytes) << row.name;
    EXPECT_EQ(options.load.limits.nodes, fresh.load.limits.nodes) << row.name;
    EXPECT_EQ(options.load.limits.json_depth, fresh.load.limits.json_depth) << row.name;
  }
}

TEST(OptionTable, EveryChoiceIsAccepted) {
  for (const OptionInfo& row : option_table())
    if (row.choices && row.metavar != "KEY=VALUE") {
      EXPECT_FALSE(row.choices().empty()) << row.name;
      for (const std::string& choice : row.choices()) {
        Options options;
        EXPECT_NO_THROW(set_option(options, row, choice)) << row.name << ' ' << choice;
      }
    }
}

TEST(Arguments, CommandSceneAndDefaults) {
  EXPECT_EQ(parse_arguments({}).command, Command::view);
  EXPECT_EQ(parse_arguments({"cornell"}).scene, "cornell");
  const Options render = parse_arguments({"render", "-o", "x.exr"});
  EXPECT_EQ(render.command, Command::render);
  EXPECT_EQ(render.scene, "bedroom");
  EXPECT_EQ(render.output, "x.exr");
  const Options error = parse_arguments({"error", "a.exr", "--ev", "-2", "b.exr"});
  EXPECT_EQ(error.image, "a.exr");
  EXPECT_EQ(error.reference, "b.exr");
  EXPECT_EQ(error.ev, -2.0f);
}

TEST(Arguments, ValuesReachTheirFields) {
  const Options o = parse_arguments({"render",
                                     "room.glb",
                                     "--output=x.exr",
                                     "--size",
                                     "64x32",
                                     "--samples",
                                     "7",
                                     "--time=1.5",
                                     "--until-error",
                                     "0.25",
                                     "--technique",
                                     "reference",
                                     "--target",
                                     "discrete",
                                     "--light",
                                     "indirect",
                                     "--seed",
                                     "9",
                                     "--threads",
                                     "3",
                                     "--backend",
                                     "none",
                                     "--ev",
                                     "-1.5",
                                     "--tonemap",
                                     "filmic",
                                     "--camera",
                                     "2",
                                     "--view",
                                     "v.json#a",
                                     "--at",
                                     "2.5",
                                     "--environment",
                                     "e.hdr",
                                     "--environment-rotation",
                                     "180",
                                     "--environment-strength",
                                     "0.5",
                                     "--aovs",
                                     "--strict",
                                     "--quiet",
                                     "--allow-external",
                                     "--limit-nodes",
                                     "10",
                                     "--limit-json-depth",
                                     "20",
                                     "--json",
                                     "-"});
  EXPECT_EQ(o.scene, "room.glb");
  EXPECT_EQ(o.output, "x.exr");
  EXPECT_EQ(o.render.width, 64);
  EXPECT_EQ(o.render.height, 32);
  EXPECT_EQ(o.samples, 7u);
  EXPECT_EQ(o.seconds, 1.5);
  EXPECT_EQ(o.until_error, 0.25);
  EXPECT_EQ(o.render.technique, "reference");
  EXPECT_EQ(o.render.target, Target::discrete);
  EXPECT_EQ(o.render.light, LightSelection::indirect);
  EXPECT_EQ(o.render.seed, 9u);
  EXPECT_EQ(o.threads, 3);
  EXPECT_EQ(o.render.backend, Backend::none);
  EXPECT_EQ(o.ev, -1.5f);
  EXPECT_EQ(o.tonemap, "filmic");
  EXPECT_EQ(o.camera, "2");
  EXPECT_EQ(o.view, "v.json#a");
  EXPECT_EQ(o.load.at_seconds, 2.5);
  EXPECT_EQ(o.environment, "e.hdr");
  EXPECT_NEAR(*o.environment_rotation, 3.14159265, 1e-6);
  EXPECT_EQ(o.environment_strength, 0.5f);
  EXPECT_TRUE(o.aovs && o.strict && o.quiet && o.load.allow_external);
  EXPECT_EQ(o.load.limits.nodes, 10u);
  EXPECT_EQ(o.load.limits.json_depth, 20u);
  EXPECT_EQ(o.json, "-");
}

TEST(Arguments, AliasesAndSettingsShareOnePlaceAndTheLastWins) {
  EXPECT_EQ(parse_arguments({"info", "--virtual-lights", "100"}).render.values.get("lights.count"), 100);
  EXPECT_EQ(parse_arguments({"info", "--virtual-lights", "100", "--set", "lights.count=200"})
                .render.values.get("lights.count"),
            200);
  EXPECT_EQ(parse_arguments({"info", "--set", "lights.count=200", "--virtual-lights", "100"})
                .render.values.get("lights.count"),
            100);
  const Options o =
      parse_arguments({"info", "--set", "lights.seed=3", "--set", "lights.count=5", "--cut-error", "0.5",
                       "--brdf-samples", "16", "--seed", "1", "--seed", "2"});
  EXPECT_EQ(o.render.values.get("lights.seed"), 3);
  EXPECT_EQ(o.render.values.get("lights.count"), 5);
  EXPECT_EQ(o.render.values.get("cut.error"), 0.5);
  EXPECT_EQ(o.render.values.get("bidirectional.brdf-samples"), 16);
  EXPECT_EQ(o.render.seed, 2u);
}

TEST(Arguments, MistakesAreNamedAndCorrected) {
  expect_has(usage_refusal({"rendr"}), "did you mean 'render'?");
  expect_has(usage_refusal({"bedrom"}), "did you mean 'bedroom'?");
  expect_has(usage_refusal({"render", "--sampels", "3"}), "did you mean '--samples'?");
  expect_has(usage_refusal({"render", "--technique", "bidirektional"}), "did you mean 'bidirectional'?");
  expect_has(usage_refusal({"render", "--backend", "egll"}), "did you mean 'egl'?");
  expect_has(usage_refusal({"render", "--set", "lights.cuont=3"}), "did you mean 'lights.count'?");
  expect_has(usage_refusal({"--size", "4x4", "render"}), "the command comes first");
  expect_has(usage_refusal({"render", "a", "b"}), "unexpected argument 'b'");
  expect_has(usage_refusal({"scenes", "a"}), "takes no operands");
  expect_has(usage_refusal({"error", "a.exr"}), "needs an image and its reference");
  expect_has(usage_refusal({"info", "--samples", "3"}), "has no option --samples");
  expect_has(usage_refusal({"render", "--size"}), "--size expects a value");
  expect_has(usage_refusal({"render", "--size", "wide"}), "--size: ");
  for (const char* option :
       {"--samples", "--time", "--until-error", "--ev", "--seed", "--threads", "--at", "--cut-error"})
    for (const char* bad : {"nan", "inf", "", "three", "1e999"})
      expect_has(usage_refusal({"render", option, bad}), option);
  for (const char* option :
       {"--samples", "--time", "--until-error", "--seed", "--threads", "--at", "--limit-nodes"})
    expect_has(usage_refusal({"render", option, "-1"}), "out of range");
}

TEST(Arguments, WhatFollowsTheDashesIsNoOption) {
  EXPECT_EQ(parse_arguments({"render", "-o", "x.exr", "--", "--strange.glb"}).scene, "--strange.glb");
}

TEST(Arguments, HelpComesBeforeMistakes) {
  EXPECT_TRUE(parse_arguments({"render", "--size", "wrong", "--help"}).help);
  EXPECT_TRUE(parse_arguments({"-h"}).help);
  EXPECT_TRUE(parse_arguments({"--version"}).version);
}

TEST(Arguments, FailAbove) {
  const Options o =
      parse_arguments({"error", "a", "b", "--fail-above", "relmse=0.5", "--fail-above", "flip=0.1"});
  ASSERT_EQ(o.fail_above.size(), 2u);
  EXPECT_EQ(o.fail_above[1], std::make_pair(std::string("flip"), 0.1));
  expect_has(usage_refusal({"error", "a", "b", "--fail-above", "relmsee=1"}), "did you mean 'relmse'?");
  usage_refusal({"error", "a", "b", "--fail-above", "relmse=nan"});
  usage_refusal({"error", "a", "b", "--fail-above", "relmse"});
}

TEST(Config, SetsWhatTheCommandLineLeaves) {
  const ConfigFile config(R"({"scene": "cornell", "size": "32x16", "samples": 5, "quiet": true, "ev": -1,
                              "set": {"lights.count": 77, "lights.seed": 4}, "output": "out.exr", "environment": "/e.hdr"})");
  const Options o =
      parse_arguments({"render", "--samples", "9", "--config", config.path(), "--set", "lights.seed=8"});
  EXPECT_EQ(o.scene, "cornell");
  EXPECT_EQ(o.render.width, 32);
  EXPECT_EQ(o.samples, 9u);
  EXPECT_TRUE(o.quiet);
  EXPECT_EQ(o.ev, -1.0f);
  EXPECT_EQ(o.render.values.get("lights.count"), 77);
  EXPECT_EQ(o.render.values.get("lights.seed"), 8);
  EXPECT_EQ(o.output, config.beside("out.exr"));
  EXPECT_EQ(o.environment, "/e.hdr");
}

TEST(Config, ScenesOnTheCommandLineWinAndFilesAreRelativeToTheConfig) {
  const ConfigFile config(R"({"scene": "rooms/a.glb"})");
  EXPECT_EQ(parse_arguments({"info", "--config", config.path()}).scene, config.beside("rooms/a.glb"));
  EXPECT_EQ(parse_arguments({"info", "b.glb", "--config", config.path()}).scene, "b.glb");
}

TEST(Config, BuiltInEnvironmentsStayNames) {
  for (const std::string name : {"studio", "studio.hdr"}) {
    const ConfigFile config("{\"environment\": \"" + name + "\"}");
    EXPECT_EQ(parse_arguments({"info", "--config", config.path()}).environment,
              name == "studio" ? name : config.beside(name));
  }
}

TEST(Config, FaultsNameFileAndKey) {
  const auto fault = [](const std::string& text) {
    const ConfigFile config(text);
    const std::string message = refusal(ExitCode::bad_input, [&] {
      parse_arguments({"render", "--config", config.path()});
    });
    expect_has(message, config.path());
    return message;
  };
  expect_has(fault(R"({"sampels": 3})"), "sampels: unknown key 'sampels'; did you mean 'samples'?");
  expect_has(fault(R"({"samples": -3})"), "samples: ");
  expect_has(fault(R"({"samples": [3]})"), "samples: ");
  expect_has(fault(R"({"samples": null})"), "samples: ");
  expect_has(fault(R"({"quiet": 1})"), "quiet: ");
  expect_has(fault(R"({"set": {"lights.cuont": 1}})"), "lights.count");
  expect_has(fault(R"({"config": "other.json"})"), "config: unknown key");
  fault("[1]");
  fault("{");
  fault("");
  fault(std::string(100, '['));
  refusal(ExitCode::bad_input, [] { parse_arguments({"render", "--config", "/nonexistent/c.json"}); });
}

TEST(Help, FitsAHundredColumnsAndNamesEveryOption) {
  for (const CommandInfo& command : command_table()) {
    const std::string text = help_text(command.id);
    expect_has(text, fmt::format("halflight {}", command.name));
    for (const OptionInfo& row : option_table())
      if (row.taken_by(command.id)) expect_has(text, fmt::format("--{}", row.name));
    EXPECT_EQ(text.find("{choices}"), std::string::npos);
    expect_has(overview_text(), std::string(command.summary));
    std::istringstream lines(text + overview_text());
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
  }
}

TEST(Help, CompletionsNameEveryOption) {
  for (const char* shell : {"bash", "zsh", "fish"})
    for (const OptionInfo& row : option_table()) expect_has(completion_script(shell), std::string(row.name));
  expect_has(refusal(ExitCode::usage, [] { completion_script("bsh"); }), "did you mean 'bash'?");
}

TEST(TextTable, AlignsCodePoints) {
  EXPECT_EQ(text_table({{"a", "b"}, {"Å…", "c", "d"}}), "a   b\nÅ…  c  d\n");
  EXPECT_EQ(text_table({{"a\x1b[2J\n", "b"}}), "a\\x1b[2J\\x0a  b\n");
  EXPECT_EQ(grouped(0), "0");
  EXPECT_EQ(grouped(1234567), "1,234,567");
  EXPECT_EQ(grouped(123456), "123,456");
  EXPECT_EQ(counted(1, "light", "lights"), "1 light");
}

}  // namespace
}  // namespace halflight
