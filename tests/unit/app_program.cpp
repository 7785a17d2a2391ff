// The shipped program as its users' scripts see it: exit codes, messages, files, JSON.
#include <chrono>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "scene/image_files.h"
#include "support/program.h"

namespace halflight {
namespace {

using nlohmann::json;

const std::string fixtures = HALFLIGHT_FIXTURES;

TEST_F(Program, NamesThatAreUnknown) {
  expect_fault(run({"rendr"}), 2, "did you mean 'render'?");
  expect_fault(run({"compaer"}), 2, "did you mean 'compare'?");
  expect_fault(run({"render", "bedrom", "-o", "x.exr"}), 2, "did you mean 'bedroom'?");
  expect_fault(run(small("x.exr", {"--technique", "bidirektional"})), 2, "did you mean 'bidirectional'?");
  expect_fault(run(small("x.exr", {"--sampels", "2"})), 2, "did you mean '--samples'?");
  expect_fault(run(small("x.exr", {"--set", "lights.cuont=2"})), 2, "did you mean 'lights.count'?");
  expect_fault(run(small("x.exr", {"--camera", "99"})), 2, "camera 99");
  expect_fault(run(small("x.exr", {"--camera", "no such"})), 2, "unknown camera");
  EXPECT_EQ(files(), Arguments{});
}

TEST_F(Program, UsageOfRender) {
  expect_fault(run({"render"}), 2, "needs -o FILE");
  expect_fault(run(small("x.jpg")), 2, "none of .exr, .hdr and .png");
  expect_fault(run(small("x.png", {"--aovs"})), 2, "only an .exr");
  expect_fault(run(small("x.exr", {"--size", "0x5"})), 2, "--size");
  expect_fault(run(small("x.exr", {"--trace", "./x.exr"})), 2, "--trace: names the same file as --output");
  expect_fault(run(small("x.exr", {"--json", "x.exr"})), 2, "--json: names the same file as --output");
  expect_fault(run(small("x.exr", {"--json", "t.json", "--trace", "t.json"})), 2, "same file as --json");
  expect_fault(run(small("x.exr", {"--json", "-", "--trace", "-"})), 2, "--trace and --json: only one");
  expect_fault(run(small("x.exr", {"--samples", "0"})), 2, "--samples");
  expect_fault(run(small("x.exr", {"--time", "-1"})), 2, "--time");
  expect_fault(run(small("x.exr", {"--ev", "nan"})), 2, "--ev");
  EXPECT_EQ(files(), Arguments{});
}

TEST_F(Program, FilesOfAnotherKind) {
  std::ofstream(at("picture.png"), std::ios::binary) << "\x89PNG\r\n\x1a\n and no more";
  std::ofstream(at("words.gltf")) << "these are words";
  std::ofstream(at("short.glb"), std::ios::binary) << std::string("glTF\x02\0\0\0\x40\0\0\0", 12);
  expect_fault(run({"info", "picture.png"}), 3, "picture.png");
  expect_fault(run({"info", "words.gltf"}), 3, "words.gltf");
  expect_fault(run({"render", "short.glb", "-o", "x.exr"}), 3, "short.glb: ");
  expect_fault(run({"info", "missing.glb"}), 3, "missing.glb: no such file");
  expect_fault(run({"info", "."}), 3, ".");
  expect_fault(run(small("x.exr", {"--environment", "words.gltf"})), 3, "words.gltf");
  expect_fault(run(small("x.exr", {"--environment", "missing.hdr"})), 3, "missing.hdr");
  expect_fault(run(small("x.exr", {"--view", "words.gltf"})), 3, "words.gltf");
  expect_fault(run(small("x.exr", {"--config", "words.gltf"})), 3, "words.gltf");
  expect_fault(run({"error", "picture.png", "picture.png"}), 3, "picture.png");
  EXPECT_FALSE(fs::exists(at("x.exr")));
}

TEST_F(Program, StrictRefusesWhatAPlaceholderStandsInFor) {
  const std::string scene = fixtures + "/missing-texture.gltf";
  const Outcome lenient = run({"info", scene});
  EXPECT_EQ(lenient.code, 0) << lenient.err;
  EXPECT_NE(lenient.err.find("warning: "), std::string::npos);
  EXPECT_NE(lenient.err.find("no-such-picture.png"), std::string::npos) << lenient.err;
  EXPECT_EQ(run({"info", scene, "--quiet"}).err, "");
  expect_fault(run({"info", scene, "--strict"}), 3, "no-such-picture.png");
}

TEST_F(Program, ATechniqueWithNothingToShowSaysSo) {
  const Outcome outcome = run(small("x.png", {"--technique", "filtered", "--backend", "auto"}));
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("warning: filtered shows light of the environment only"), std::string::npos)
      << outcome.err;
}

TEST_F(Program, OutputsThatCannotBeWrittenAreNoticedBeforeWork) {
  expect_fault(run(small("nowhere/x.exr")), 1, "there is no folder nowhere");
  expect_fault(run(small("x.exr", {"--json", "nowhere/x.json"})), 1, "there is no folder nowhere");
  fs::create_directory(folder / "folder.exr");
  expect_fault(run(small("folder.exr")), 1, "it is a folder");
  std::ofstream(at("file")) << "a file";
  expect_fault(run(small("file/x.exr")), 1, "is no folder");
  if (geteuid() == 0) return;  // nothing is closed to root
  fs::create_directory(folder / "closed");
  fs::permissions(folder / "closed", fs::perms::owner_read | fs::perms::owner_exec);
  expect_fault(run(small("closed/x.exr")), 1, "cannot write");
}

TEST_F(Program, AFullDiskLeavesNothingBehind) {
  expect_fault(run(small("x.exr"), 512), 1, "x.exr");
  EXPECT_EQ(files(), Arguments{});
  expect_fault(run(small("x.png", {"--size", "64x64"}), 512), 1, "x.png");
  EXPECT_EQ(files(), Arguments{});
}

TEST_F(Program, AFullDeviceIsReported) {
  Outcome outcome = run({"scenes"}, RLIM_INFINITY, "/dev/full");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.err.find("standard output"), std::string::npos) << outcome.err;
  expect_fault(run({"scenes", "--quiet", "--json", "/dev/full"}, RLIM_INFINITY, "/dev/null"), 1, "/dev/full");
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

TEST_F(Program, NoWindowWithoutADisplay) {
  expect_fault(run({"render", "cornell", "--size", "8x8", "--backend", "window", "-o", "x.exr"}), 4, "");
  EXPECT_EQ(files(), Arguments{});
}

TEST_F(Program, HelpAndListsGoToStandardOutput) {
  for (const Arguments& arguments : {Arguments{"--help"},
                                     {"render", "--help"},
                                     {"--version"},
                                     {"techniques"},
                                     {"scenes"},
                                     {"techniques", "--settings"},
                                     {"--completions", "bash"}}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, 0);
    EXPECT_NE(outcome.out, "");
    EXPECT_EQ(outcome.err, "");
  }
  EXPECT_NE(run({"techniques"}).out.find("reference "), std::string::npos);
  EXPECT_NE(run({"scenes"}).out.find("bedroom "), std::string::npos);
}

TEST_F(Program, RenderReportsWhatItDid) {
  const Outcome outcome =
      run(small("x.exr", {"--json", "x.json", "--seed", "5", "--threads", "2", "--aovs"}));
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_NE(outcome.err.find("x.exr: 32x24, 2 samples a pixel"), std::string::npos) << outcome.err;
  EXPECT_EQ(files(), (Arguments{"x.exr", "x.json"}));

  const json report = json::parse(text_of(at("x.json")));
  for (const char* key : {"scene",
                          "technique",
                          "target",
                          "width",
                          "height",
                          "seed",
                          "threads",
                          "spp",
                          "passes",
                          "seconds",
                          "cpu_seconds",
                          "rays",
                          "nan_samples",
                          "estimated_relmse",
                          "mean_radiance",
                          "peak_memory_mb",
                          "gl",
                          "plan",
                          "light_count",
                          "cut_size",
                          "warnings"})
    EXPECT_TRUE(report.contains(key)) << key;
  for (const char* key :
       {"total", "load", "raster", "lights", "distribution", "sampling", "visibility", "resolve", "gpu"})
    EXPECT_GE(report["seconds"].at(key).get<double>(), 0) << key;
  for (const char* key : {"visibility", "closest", "rejected"})
    EXPECT_TRUE(report["rays"].contains(key)) << key;
  EXPECT_EQ(report["width"], 32);
  EXPECT_EQ(report["height"], 24);
  EXPECT_EQ(report["spp"], 2.0);
  EXPECT_EQ(report["seed"], 5);
  EXPECT_EQ(report["threads"], 2);
  EXPECT_EQ(report["technique"], "halflight");
  EXPECT_EQ(report["target"], "continuous");
  EXPECT_EQ(report["stopped_by"], "samples");
  EXPECT_EQ(report["partial"], false);
  EXPECT_EQ(report["gl"]["backend"], "none");
  EXPECT_EQ(report["nan_samples"], 0);
  EXPECT_GT(report["rays"]["visibility"], 0);
  EXPECT_GT(report["estimated_relmse"], 0);
  EXPECT_GT(report["peak_memory_mb"], 1);
  EXPECT_GE(report["cpu_seconds"], 0);
  double stages = 0;
  for (const auto& [key, seconds] : report["seconds"].items())
    if (key != "total") stages += seconds.get<double>();
  EXPECT_LE(stages, 1.5 * report["seconds"]["total"].get<double>());
  for (const json& stage : report["plan"]) {
    EXPECT_FALSE(stage.at("stage").get<std::string>().empty());
    EXPECT_TRUE(stage.at("runs").is_boolean());
    EXPECT_FALSE(stage.at("why").get<std::string>().empty());
    EXPECT_EQ(stage.at("calls").get<uint64_t>() > 0, stage.at("runs").get<bool>()) << stage;
    if (!stage.at("runs").get<bool>()) {
      EXPECT_EQ(stage.at("bytes"), 0) << stage;
    }
    EXPECT_GE(stage.at("seconds").get<double>(), 0);
  }
}

TEST_F(Program, JsonOnStandardOutputStandsAlone) {
  const Outcome outcome = run(small("x.hdr", {"--json", "-"}));
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(json::parse(outcome.out).at("width"), 32);
  EXPECT_EQ(json::parse(run({"info", "cornell", "--json", "-"}).out).at("triangles"),
            json::parse(run({"info", "cornell", "--json", "-"}).out).at("triangles"));
  EXPECT_FALSE(json::parse(run({"techniques", "--json", "-"}).out).at("techniques").empty());
  EXPECT_FALSE(json::parse(run({"scenes", "--json", "-"}).out).at("scenes").empty());
}

TEST_F(Program, EveryEndingIsWrittenAndReadable) {
  for (const char* name : {"x.exr", "x.hdr", "x.png", "X.PNG"}) {
    const Outcome outcome = run(small(name, {"--quiet"}));
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    const ImageRgb image = read_image(at(name), LoadLimits{});
    EXPECT_EQ(image.width, 32) << name;
    EXPECT_EQ(image.height, 24) << name;
  }
}

TEST_F(Program, ThePictureDoesNotDependOnThreads) {
  for (const char* target : {"discrete", "continuous"}) {
    for (const char* threads : {"1", "2", "5"})
      ASSERT_EQ(run(small(fmt::format("{}.exr", threads),
                          {"--threads", threads, "--target", target, "--samples", "8"}))
                    .code,
                0);
    for (const char* other : {"2.exr", "5.exr"})
      EXPECT_EQ(run({"error", "1.exr", other, "--fail-above", "rmse=0"}).code, 0) << target << ' ' << other;
  }
  // The comparison can fail: another seed is another picture.
  ASSERT_EQ(run(small("seed.exr", {"--seed", "1", "--target", "continuous", "--samples", "8"})).code, 0);
  EXPECT_EQ(run({"error", "1.exr", "seed.exr", "--fail-above", "rmse=0"}).code, 5);
}

TEST_F(Program, TimeAndErrorEndAPicture) {
  ASSERT_EQ(run(small("x.exr", {"--samples", "1000000", "--time", "0.3", "--json", "x.json"})).code, 0);
  json report = json::parse(text_of(at("x.json")));
  EXPECT_EQ(report["stopped_by"], "time");
  EXPECT_GE(report["spp"], 1.0);

  ASSERT_EQ(run(small("x.exr", {"--samples", "1000000", "--until-error", "0.05", "--json", "x.json"})).code,
            0);
  report = json::parse(text_of(at("x.json")));
  EXPECT_EQ(report["stopped_by"], "error");
  EXPECT_LE(report["estimated_relmse"], 0.05);

  ASSERT_EQ(
      run({"render", "cornell", "--size", "32x24", "--backend", "none", "-o", "x.exr", "--json", "x.json"})
          .code,
      0);
  EXPECT_EQ(json::parse(text_of(at("x.json")))["spp"], 32.0);
}

TEST_F(Program, AdaptiveSamplingIsAskedForAndSaid) {
  const auto render = [&](const std::string& output, const Arguments& more) {
    Arguments arguments = small(output, {"--target", "discrete", "--samples", "1000000", "--until-error",
                                         "0.01", "--json", "x.json"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    EXPECT_EQ(run(arguments).code, 0);
    return json::parse(text_of(at("x.json")));
  };
  const json adaptive = render("1.exr", {"--threads", "1"}), uniform = render("u.exr", {"--adaptive", "off"});
  EXPECT_EQ(adaptive["adaptive"], true);
  EXPECT_EQ(uniform["adaptive"], false);
  EXPECT_LT(adaptive["spp"], uniform["spp"]);
  EXPECT_NE(text_of(at("1.exr")).find("stopped by its estimated error"), std::string::npos);
  EXPECT_NE(text_of(at("1.exr")).find("adaptive"), std::string::npos);
  EXPECT_EQ(text_of(at("u.exr")).find("adaptive"), std::string::npos);

  for (const char* threads : {"2", "5"}) {
    render(fmt::format("{}.exr", threads), {"--threads", threads});
    EXPECT_EQ(run({"error", fmt::format("{}.exr", threads), "1.exr", "--fail-above", "relmse=0"}).code, 0)
        << threads << " threads";
  }
  expect_fault(run(small("x.exr", {"--technique", "halflight", "--adaptive", "on"})), 2, "--adaptive on");
  EXPECT_EQ(json::parse((run(small("x.exr", {"--json", "x.json"})), text_of(at("x.json"))))["adaptive"],
            false);
  expect_fault(run(small("x.exr", {"--adaptive", "perhaps"})), 2, "--adaptive");
}

TEST_F(Program, ATimelineHoldsStagesAndTiles) {
  ASSERT_EQ(run(small("x.exr", {"--target", "discrete", "--trace", "trace.json"})).code, 0);
  struct Span {
    double begin, end;
  };
  std::map<std::string, std::vector<Span>> spans;
  std::map<int, std::vector<Span>> of_thread;
  const json trace = json::parse(text_of(at("trace.json")));
  for (const json& event : trace["traceEvents"]) {
    EXPECT_EQ(event["ph"], "X");
    const Span span{event["ts"], event["ts"].get<double>() + event["dur"].get<double>()};
    spans[event["name"]].push_back(span);
    of_thread[event["tid"]].push_back(span);
  }
  constexpr double rounding = 0.002;  // microseconds
  const auto inside = [&](const Span& a, const Span& b) {
    return a.begin >= b.begin - rounding && a.end <= b.end + rounding;
  };
  const auto each_inside = [&](const char* inner, const char* outer) {
    EXPECT_FALSE(spans[inner].empty()) << inner;
    for (const Span& a : spans[inner])
      EXPECT_TRUE(
          std::any_of(spans[outer].begin(), spans[outer].end(), [&](const Span& b) { return inside(a, b); }))
          << inner << " outside of " << outer;
  };
  EXPECT_EQ(spans["load"].size(), 1u);
  each_inside("place points", "lights");
  each_inside("tree and cut", "lights");
  each_inside("sampling", "pass");
  each_inside("tile", "sampling");
  EXPECT_GE(spans["tile"].size(), 4u);  // 32×24 pixels are 2×2 tiles of 16×16
  // On one thread two events are apart, or one holds the other.
  for (const auto& [thread, all] : of_thread)
    for (const Span& a : all)
      for (const Span& b : all)
        EXPECT_TRUE(inside(a, b) || inside(b, a) || a.end <= b.begin + rounding ||
                    b.end <= a.begin + rounding);
  ASSERT_EQ(run(small("x.exr")).code, 0);
}

TEST_F(Program, CtrlCKeepsWhatThereIs) {
  for (const int signal : {SIGINT, SIGTERM}) {
    // Interrupted before the first sample there is nothing to keep: a slow machine gets more time.
    Outcome outcome;
    for (int seconds = 1; seconds <= 64; seconds *= 4) {
      const pid_t child =
          start({"render", "cornell", "--size", "160x120", "--time", "1000", "--virtual-lights", "512",
                 "--backend", "none", "-o", "x.exr", "--json", "x.json"});
      std::this_thread::sleep_for(std::chrono::seconds(seconds));
      kill(child, signal);
      outcome = finish(child);
      if (fs::exists(at("x.exr"))) break;
    }
    EXPECT_EQ(outcome.code, 130);
    EXPECT_EQ(files(), (Arguments{"x.exr", "x.json"}));
    const json report = json::parse(text_of(at("x.json")));
    EXPECT_EQ(report["stopped_by"], "interrupted");
    EXPECT_EQ(report["partial"], true);
    EXPECT_EQ(read_image(at("x.exr"), LoadLimits{}).width, 160);
    EXPECT_NE(text_of(at("x.exr")).find("partial"), std::string::npos);
    fs::remove(at("x.exr"));
  }
}

TEST_F(Program, ErrorMeasuresAndJudges) {
  ASSERT_EQ(run(small("a.exr")).code, 0);
  ASSERT_EQ(run(small("b.exr", {"--seed", "3"})).code, 0);
  ASSERT_EQ(run(small("c.exr", {"--size", "24x32"})).code, 0);
  Outcome outcome = run(
      {"error", "a.exr", "a.exr", "--json", "e.json", "--fail-above", "relmse=0", "--fail-above", "flip=0"});
  EXPECT_EQ(outcome.code, 0);
  json report = json::parse(text_of(at("e.json")));
  for (const char* metric : {"relmse", "relmse-trimmed", "rmse", "smape", "flip"}) {
    EXPECT_EQ(report.at(metric), 0.0) << metric;
    EXPECT_NE(outcome.out.find(metric), std::string::npos);
  }
  outcome = run({"error", "a.exr", "b.exr", "--json", "e.json", "--fail-above", "rmse=1e-9", "--fail-above",
                 "smape=2"});
  EXPECT_EQ(outcome.code, 5);
  report = json::parse(text_of(at("e.json")));
  ASSERT_EQ(report["failed"].size(), 1u);
  EXPECT_EQ(report["failed"][0]["metric"], "rmse");
  expect_fault(run({"error", "a.exr", "c.exr"}), 3, "32x24");
  expect_fault(run({"error", "a.exr", "missing.exr"}), 3, "missing.exr");
}

TEST_F(Program, InfoShowsSceneAndPlan) {
  const Outcome outcome = run({"info", "cornell"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  for (const char* words : {"Geometry", "triangles", "Materials", "Cameras", "Plan for halflight", "runs"})
    EXPECT_NE(outcome.out.find(words), std::string::npos) << words;
}

TEST_F(Program, ScenesAreWrittenAndOpenAgain) {
  ASSERT_EQ(run({"scenes", "--write", "made/here"}).code, 0);
  const json made = json::parse(run({"info", "made/here/cornell.glb", "--json", "-"}).out);
  const json built_in = json::parse(run({"info", "cornell", "--json", "-"}).out);
  EXPECT_EQ(made["triangles"], built_in["triangles"]);
  EXPECT_EQ(made["materials"]["models"], built_in["materials"]["models"]);
}

}  // namespace
}  // namespace halflight
