#include "options.h"

#include <algorithm>
#include <array>

#include "film/tonemap.h"
#include "option_values.h"

namespace halflight {

namespace {

constexpr uint32_t bit(Command command) { return 1u << static_cast<uint32_t>(command); }
constexpr uint32_t of_one = bit(Command::view) | bit(Command::render) | bit(Command::info);
constexpr uint32_t of_scenes = of_one | bit(Command::compare);
constexpr uint32_t of_files = of_scenes | bit(Command::error);
constexpr uint32_t of_shown = bit(Command::view) | bit(Command::render);
constexpr uint32_t of_pictures = of_shown | bit(Command::compare);
constexpr uint32_t of_outputs = bit(Command::render) | bit(Command::compare);
constexpr uint32_t of_results = bit(Command::render) | bit(Command::info) | bit(Command::error) |
                                bit(Command::techniques) | bit(Command::scenes);
constexpr uint32_t of_all = of_scenes | of_results | bit(Command::experiments) | bit(Command::stress);
constexpr uint32_t of_experiments = bit(Command::experiments);
constexpr uint32_t of_stress = bit(Command::stress);
constexpr uint32_t of_races = bit(Command::compare);

constexpr std::array<CommandInfo, 9> commands{{
    {Command::view, "view", "[SCENE]", "open the window on a scene"},
    {Command::render, "render", "[SCENE] -o OUT", "make one picture, without a window"},
    {Command::compare, "compare", "[SCENE] -o DIR", "race techniques: error against time, as a report"},
    {Command::experiments, "experiments", "[NAME] -o DIR",
     "make the papers' figures; without a name, list them"},
    {Command::stress, "stress", "[NAME] -o DIR",
     "try the extreme cases on every technique; alone, list them"},
    {Command::info, "info", "[SCENE]", "show what is in a scene, and which stages rendering it takes"},
    {Command::error, "error", "IMAGE REFERENCE", "measure how far a picture is from its reference"},
    {Command::techniques, "techniques", "", "list the sampling techniques"},
    {Command::scenes, "scenes", "", "list the built-in scenes, or save them as files"},
}};

constexpr std::array<std::string_view, 2> on_off{"on", "off"};
constexpr std::array<std::string_view, 5> backends{"auto", "window", "egl", "osmesa", "none"};
constexpr std::array<std::string_view, 3> light_selections{"all", "direct", "indirect"};
constexpr std::array<std::string_view, 2> targets{"discrete", "continuous"};
constexpr std::array<std::string_view, 4> supports{"discrete", "continuous", "both", "own"};
constexpr std::array<std::string_view, 3> equals{"time", "samples", "rays"};
constexpr std::array<std::string_view, 5> metrics{"relmse", "relmse-trimmed", "rmse", "smape", "flip"};

template <class Names>
std::vector<std::string> strings(const Names& names) {
  return std::vector<std::string>(names.begin(), names.end());
}

std::vector<std::string> technique_ids() {
  std::vector<std::string> ids;
  for (const TechniqueInfo& info : techniques()) ids.emplace_back(info.id);
  return ids;
}

std::vector<std::string> technique_ids_or_all() {
  std::vector<std::string> ids = technique_ids();
  ids.emplace_back("all");
  return ids;
}

std::vector<std::string> tone_map_ids() {
  std::vector<std::string> ids;
  for (const ToneMap& map : tone_maps()) ids.emplace_back(map.id);
  return ids;
}

std::vector<std::string> setting_keys() {
  std::vector<std::string> keys;
  for (const SettingInfo* info : all_settings()) keys.emplace_back(info->key);
  return keys;
}

template <auto& names>
std::vector<std::string> choices_of() {
  return strings(names);
}

void set_fail_above(Options& o, const std::string& value) {
  const auto [metric, bound] = parse_assignment(value);
  const size_t index = parse_choice(metric, strings(metrics));
  o.fail_above.emplace_back(metrics[index], parse_number(bound, 0, 1e30));
}

void set_setting(Options& o, const std::string& value) {
  const auto [key, number] = parse_assignment(value);
  o.render.values.set(key, number);
}

constexpr std::string_view lights_count = "lights.count", cut_error = "cut.error",
                           brdf_samples = "bidirectional.brdf-samples";

template <const std::string_view& key>
void set_setting_of(Options& o, const std::string& value) {
  o.render.values.set(key, value);
}

void set_technique(Options& o, const std::string& value) {
  o.render.technique = find_technique(value).id;
  o.technique_given = true;
}

void set_techniques(Options& o, const std::string& value) {
  const std::vector<std::string> valid = technique_ids_or_all();
  o.techniques.clear();
  for (const std::string& name : parse_list(value)) o.techniques.push_back(valid[parse_choice(name, valid)]);
}

void set_budgets(Options& o, const std::string& value) {
  o.budgets.clear();
  o.budgets_given = true;
  for (const std::string& word : parse_list(value)) o.budgets.push_back(parse_number(word, 1e-3, 1e9));
}

void set_size(Options& o, const std::string& value) {
  std::tie(o.render.width, o.render.height) = parse_size(value);
  o.size_given = true;
}

template <std::string Options::*field>
void set_text(Options& o, const std::string& value) {
  if (value.empty()) throw usage_error("expects a value");
  o.*field = value;
}

template <bool Options::*field>
void set_switch(Options& o, const std::string& value) {
  o.*field = parse_switch(value);
}

template <auto field>
void set_limit(Options& o, const std::string& value) {
  using Field = std::remove_reference_t<decltype(o.load.limits.*field)>;
  o.load.limits.*field = static_cast<Field>(parse_amount(value, 1, std::numeric_limits<Field>::max()));
}

constexpr std::string_view scene_group = "Scene", picture_group = "Picture", sampling_group = "Sampling",
                           race_group = "Race", output_group = "Output", machine_group = "Machine",
                           limits_group = "Limits on what files may ask for", program_group = "Program";

// Name, letter, metavar, default, group, label, help, commands, set, repeatable, path, choices, setting.
const OptionInfo table[] = {
    {"environment", "", "FILE|NAME", "", scene_group, "Environment",
     "light from all around: a .hdr or .exr map, latitude-longitude, or square for an angular map; or a "
     "built-in "
     "one's name (`halflight scenes` lists them)",
     of_scenes, [](Options& o, const std::string& v) { o.environment = v; }, false, true},
    {"environment-rotation", "", "DEG", "0", scene_group, "Rotation",
     "turn the environment about the vertical axis", of_scenes,
     [](Options& o, const std::string& v) {
       o.environment_rotation =
           static_cast<float>(parse_number(v, -36000, 36000) * 3.14159265358979323846 / 180);
     }},
    {"environment-strength", "", "X", "1", scene_group, "Strength", "multiply the environment's radiance",
     of_scenes,
     [](Options& o, const std::string& v) {
       o.environment_strength = static_cast<float>(parse_number(v, 0, 1e30));
     }},
    {"camera", "", "NAME|INDEX", "0", scene_group, "Camera",
     "the scene's camera of that name, or by its place in `info`", of_scenes, set_text<&Options::camera>},
    {"view", "", "FILE[#NAME]", "", scene_group, "View",
     "a JSON file with camera, added lights, environment and exposure; #NAME picks one of several", of_scenes,
     set_text<&Options::view>, false, true},
    {"at", "", "SECONDS", "0", scene_group, "Time", "moment of the scene's animations", of_scenes,
     [](Options& o, const std::string& v) { o.load.at_seconds = parse_number(v, 0, 1e9); }},
    {"allow-external", "", "", "", scene_group, "", "let a scene name files outside its own folder",
     of_scenes, [](Options& o, const std::string& v) { o.load.allow_external = parse_switch(v); }},
    {"strict", "", "", "", scene_group, "", "a missing or damaged texture is an error instead of a warning",
     of_scenes, set_switch<&Options::strict>},

    {"output", "o", "OUT", "", picture_group, "",
     "the picture: .exr and .hdr hold radiance, .png what a screen shows; compare, experiments, stress: a "
     "folder",
     of_outputs | of_experiments | of_stress, set_text<&Options::output>, false, true},
    {"size", "", "WxH", "640x480; view: the window's", picture_group, "Size", "width and height in pixels",
     of_scenes, set_size},
    {"light", "", "KIND", "all", picture_group, "Light",
     "direct (straight from lamps, sky and emitters), indirect (one bounce), or all", of_scenes,
     [](Options& o, const std::string& v) {
       o.render.light = static_cast<LightSelection>(parse_choice(v, strings(light_selections)));
     },
     false, false, choices_of<light_selections>},
    {"ev", "", "X", "0", picture_group, "Exposure",
     "exposure in stops; for PNG, window and FLIP, as EXR and HDR hold radiance",
     of_pictures | bit(Command::error),
     [](Options& o, const std::string& v) { o.ev = static_cast<float>(parse_number(v, -100, 100)); }},
    {"tonemap", "", "ID", "linear", picture_group, "Tone map", "tone curve of PNG and window: {choices}",
     of_pictures, [](Options& o, const std::string& v) { o.tonemap = find_tone_map(v).id; }, false, false,
     tone_map_ids},
    {"aovs", "", "", "", picture_group, "", "add layers Albedo, N, P and Variance to an .exr",
     bit(Command::render), set_switch<&Options::aovs>},

    {"technique", "", "ID", default_technique, sampling_group, "Technique",
     "how light is sampled; `halflight techniques` lists them; in the discrete target bidirectional", of_one,
     set_technique, false, false, technique_ids},
    {"target", "", "KIND", "the technique's own", sampling_group, "Target",
     "discrete (one fixed set of virtual lights) or continuous (the integral, antialiased)", of_scenes,
     [](Options& o, const std::string& v) {
       o.render.target = static_cast<Target>(parse_choice(v, strings(targets)));
     },
     false, false, choices_of<targets>},
    {"samples", "", "N", "32; view: 4096", sampling_group, "Samples",
     "stop at N samples a pixel, light samples and BRDF rays together", of_shown,
     [](Options& o, const std::string& v) {
       o.samples = static_cast<uint32_t>(parse_integer(v, 1, 1'000'000'000));
     }},
    {"time", "", "SECONDS", "", sampling_group, "",
     "stop after so long, from the moment the scene is read; --samples then has no default",
     bit(Command::render), [](Options& o, const std::string& v) { o.seconds = parse_number(v, 1e-3, 1e9); }},
    {"until-error", "", "X", "", sampling_group, "",
     "stop when the estimated relMSE is X or less; --samples then has no default", bit(Command::render),
     [](Options& o, const std::string& v) { o.until_error = parse_number(v, 1e-12, 1e12); }},
    {"adaptive", "", "ON|OFF", "", sampling_group, "",
     "on: pixels get samples by their estimated error, so that the picture's falls soonest (discrete "
     "target); off: all as "
     "many; without it: on with --until-error in the discrete target, where no --time is given",
     bit(Command::render),
     [](Options& o, const std::string& v) { o.adaptive = parse_choice(v, strings(on_off)) == 0; }, false,
     false, choices_of<on_off>},
    {"seed", "", "N", "0", sampling_group, "Seed",
     "seed of the samples; the virtual lights have their own, --set lights.seed=N", of_scenes,
     [](Options& o, const std::string& v) {
       o.render.seed = parse_integer(v, 0, std::numeric_limits<uint64_t>::max());
     }},
    {"virtual-lights", "", "N", "", sampling_group, "Virtual lights", "points placed for each kind of light",
     of_scenes, set_setting_of<lights_count>, false, false, nullptr, lights_count},
    {"cut-error", "", "X", "", sampling_group, "Cut error",
     "relative error that a cluster of the illumination cut may keep", of_scenes, set_setting_of<cut_error>,
     false, false, nullptr, cut_error},
    {"brdf-samples", "", "N", "", sampling_group, "BRDF samples",
     "rays a pixel that count the BRDF over the cut", of_scenes, set_setting_of<brdf_samples>, false, false,
     nullptr, brdf_samples},
    {"set", "", "KEY=VALUE", "", sampling_group, "",
     "any setting of the lights, the cut or a technique; `halflight techniques --settings` lists them",
     of_scenes, set_setting, true, false, setting_keys},

    {"techniques", "", "A,B,C", "all", race_group, "",
     "who races, or is tried; `halflight techniques` lists them", of_races | of_stress, set_techniques, false,
     false, technique_ids_or_all},
    {"equal", "", "WHAT", "time", race_group, "", "what each of them gets as much of: {choices}", of_races,
     [](Options& o, const std::string& v) { o.equal = static_cast<Equal>(parse_choice(v, strings(equals))); },
     false, false, choices_of<equals>},
    {"budgets", "", "X,Y,Z", "0.5,1,2,4,8", race_group, "",
     "where errors are taken: seconds, samples a pixel or rays a pixel, as --equal says",
     of_races | of_experiments, set_budgets},
    {"seeds", "", "N", "5", race_group, "",
     "runs of each technique, from --seed on; fewer than 5 give no intervals; stress: at most, where a case "
     "has its own "
     "number",
     of_races | of_experiments | of_stress,
     [](Options& o, const std::string& v) {
       o.seeds = static_cast<uint32_t>(parse_integer(v, 1, 10000));
       o.seeds_given = true;
     }},
    {"reference", "", "FILE", "", race_group, "",
     "measure against this picture; else discrete: brute force, kept in a cache, continuous: a long run",
     of_races, set_text<&Options::reference>, false, true},

    {"no-discretisation", "", "", "", race_group, "",
     "discrete target: leave out how far its sum is from the integral, which takes as long as the race at "
     "most",
     of_races, set_switch<&Options::no_discretisation>},

    {"quick", "", "", "", race_group, "",
     "small pictures and few samples: to see that all is in place, not to measure",
     of_experiments | of_stress, set_switch<&Options::quick>},

    {"json", "", "FILE|-", "", output_group, "", "write the results as JSON, - to standard output",
     of_results, set_text<&Options::json>, false, true},
    {"trace", "", "FILE", "", output_group, "",
     "write a timeline of stages and tiles on each thread, as Chrome trace events (JSON)", of_shown,
     set_text<&Options::trace>, false, true},
    {"fail-above", "", "METRIC=X", "", output_group, "",
     "end with exit code 5 when a metric (relmse, relmse-trimmed, rmse, smape, flip) is above X",
     bit(Command::error), set_fail_above, true},
    {"settings", "", "", "", output_group, "", "list what --set takes, with defaults and bounds",
     bit(Command::techniques), set_switch<&Options::list_settings>},
    {"write", "", "FOLDER", "", output_group, "",
     "save each scene as a .glb, with its environment as .hdr, in FOLDER", bit(Command::scenes),
     set_text<&Options::write_folder>, false, true},
    {"capture", "", "FILE", "", output_group, "",
     "write a .png of the window's content, panels and all, without opening one", bit(Command::view),
     set_text<&Options::capture>, false, true},
    {"quiet", "", "", "", output_group, "", "no warnings, progress or summary; errors only", of_all,
     set_switch<&Options::quiet>},

    {"threads", "", "N", "all cores", machine_group, "Threads",
     "threads to use; the picture does not depend on it", of_files | of_experiments | of_stress,
     [](Options& o, const std::string& v) { o.threads = static_cast<int>(parse_integer(v, 1, 1024)); }},
    {"backend", "", "NAME", "auto", machine_group, "Back end",
     "where pixels' surfaces come from: OpenGL by window, egl or osmesa; none: rays; auto: OpenGL on a "
     "graphics card, else rays",
     of_scenes | of_experiments,
     [](Options& o, const std::string& v) {
       o.render.backend = static_cast<Backend>(parse_choice(v, strings(backends)));
     },
     false, false, choices_of<backends>},

    {"limit-image-pixels", "", "N", "256M", limits_group, "", "pixels of one image", of_files,
     set_limit<&LoadLimits::image_pixels>},
    {"limit-total-pixels", "", "N", "1G", limits_group, "", "pixels of all images of a scene", of_files,
     set_limit<&LoadLimits::total_pixels>},
    {"limit-triangles", "", "N", "200000000", limits_group, "", "triangles of a scene", of_scenes,
     set_limit<&LoadLimits::triangles>},
    {"limit-buffer-bytes", "", "N", "8G", limits_group, "", "bytes of all buffers of a scene", of_scenes,
     set_limit<&LoadLimits::buffer_bytes>},
    {"limit-nodes", "", "N", "1000000", limits_group, "", "nodes of a scene", of_scenes,
     set_limit<&LoadLimits::nodes>},
    {"limit-json-depth", "", "N", "256", limits_group, "", "nesting of a scene's JSON", of_scenes,
     [](Options& o, const std::string& v) {
       o.load.limits.json_depth = static_cast<uint32_t>(parse_integer(v, 1, 1000));
     }},

    {"config", "", "FILE", "", program_group, "",
     "read options from a JSON object with the same names; the command line wins", of_all,
     set_text<&Options::config>},
    {"completions", "", "SHELL", "", program_group, "", "print completions for bash, zsh or fish",
     bit(Command::view), set_text<&Options::completions>},
    {"version", "", "", "", program_group, "", "print the version", of_all, set_switch<&Options::version>},
    {"help", "h", "", "", program_group, "", "print this help", of_all, set_switch<&Options::help>},
};

}  // namespace

std::span<const CommandInfo> command_table() { return commands; }
const CommandInfo& command_info(Command command) { return commands[static_cast<size_t>(command)]; }

std::span<const OptionInfo> option_table() { return table; }

const OptionInfo* find_option(std::string_view name) {
  const auto found =
      std::find_if(std::begin(table), std::end(table), [&](const OptionInfo& o) { return o.name == name; });
  return found == std::end(table) ? nullptr : found;
}

std::string option_help(const OptionInfo& info) {
  constexpr std::string_view placeholder = "{choices}";
  std::string help(info.help);
  if (const size_t at = help.find(placeholder); at != std::string::npos)
    help.replace(at, placeholder.size(), fmt::format("{}", fmt::join(info.choices(), ", ")));
  if (!info.setting.empty()) help += fmt::format("; same as --set {}={}", info.setting, info.metavar);
  return help;
}

std::string option_default(const OptionInfo& info) {
  if (info.setting.empty()) return std::string(info.default_text);
  return fmt::format("{:.10g}", SettingValues{}.get(info.setting));
}

void set_option(Options& options, const OptionInfo& info, const std::string& value) {
  try {
    info.set(options, value);
  } catch (const Error& error) {
    throw usage_error(fmt::format("--{}: {}", info.name, error.what()));
  }
}

std::string_view backend_name(Backend backend) { return backends[static_cast<size_t>(backend)]; }
std::string_view light_selection_name(LightSelection light) {
  return light_selections[static_cast<size_t>(light)];
}
std::string_view target_support_name(TargetSupport support) { return supports[static_cast<size_t>(support)]; }
std::span<const std::string_view> metric_names() { return metrics; }

}  // namespace halflight
