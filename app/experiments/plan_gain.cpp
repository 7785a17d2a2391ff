// What the plan saves: frames with it beside frames in which a stage runs that the scene does not need.
#include "commands/compare_report.h"
#include "commands/render_json.h"
#include "experiments/paper_experiments.h"
#include "experiments/races.h"
#include "scene/load.h"

namespace halflight {

namespace {

using Edit = void (*)(Scene&);

/// A lamp that sends nothing: the plan passes it over.
void add_dark_lamp(Scene& scene) {
  PunctualLight lamp;
  lamp.position = scene.bounds.centre() + Vec3(0, 0.4f * scene.bounds.extent().y, 0);
  lamp.intensity = Vec3(0);
  scene.lights.push_back(lamp);
}

void blacken_environment(Scene& scene) {
  scene.environment = make_environment(ImageRgb(1024, 512, Vec3(0)), "black", EnvironmentLayout::latlong);
}

void make_diffuse(Scene& scene) {
  for (Material& material : scene.materials) {
    material.model = BrdfModel::phong;
    material.diffuse = Vec3(0.5f), material.phong_specular = Vec3(0);
  }
}

/// Twelve lamps and nothing else that shines.
void light_by_lamps(Scene& scene) {
  scene.lights.clear();
  scene.environment = {};
  for (Material& material : scene.materials) material.emission = Vec3(0);
  for (int i = 0; i < 12; ++i) {
    add_dark_lamp(scene);
    scene.lights.back().position.x += 0.02f * static_cast<float>(i - 6) * scene.bounds.extent().x;
    scene.lights.back().intensity = Vec3(0.1f * glm::dot(scene.bounds.extent(), scene.bounds.extent()));
  }
}

/// A scene that does not need some stages, drawn by a technique that could have them.
struct GainCase {
  const char* what;
  std::vector<Stage> stages;
  const char* scene;
  Edit edit = nullptr;
  const char* note = "";
  const char* technique = "bidirectional";
  Target target = Target::discrete;
  LightSelection light = LightSelection::all;
  uint32_t rounds = 1;
  Backend backend = Backend::none;
};

const std::vector<GainCase>& gain_cases() {
  constexpr auto discrete = Target::discrete, continuous = Target::continuous;
  constexpr auto all = LightSelection::all, direct = LightSelection::direct;
  static const std::vector<Stage> whole_set{Stage::environment_points, Stage::emitter_points,
                                            Stage::punctual_points,    Stage::surface_points,
                                            Stage::light_tree,         Stage::cut};
  static const std::vector<GainCase> cases{
      {"alpha filter", {Stage::alpha_filter}, "bedroom"},
      {"alpha filter", {Stage::alpha_filter}, "cornell"},
      {"g-buffer", {Stage::gbuffer}, "cornell", nullptr, "", "path", continuous},
      {"antialiasing",
       {Stage::antialiasing},
       "bedroom",
       nullptr,
       "4 rounds",
       "bidirectional",
       discrete,
       all,
       4},
      {"shadow maps",
       {Stage::shadow_maps},
       "statue",
       add_dark_lamp,
       "a dark lamp; EGL",
       "bidirectional",
       discrete,
       all,
       1,
       Backend::egl},
      {"direct punctual light", {Stage::direct_punctual}, "statue", add_dark_lamp, "a dark lamp"},
      {"environment points", {Stage::environment_points}, "cornell", blacken_environment, "a black map"},
      {"emitter points", {Stage::emitter_points}, "statue"},
      {"surface points", {Stage::surface_points}, "bedroom", nullptr, "", "bidirectional", discrete, direct},
      {"surface points", {Stage::surface_points}, "statue", nullptr, "", "bidirectional", discrete, direct},
      {"S, tree and cut", whole_set, "bedroom", nullptr, "", "mis", continuous},
      {"S, tree and cut", whole_set, "cornell", nullptr, "", "mis", continuous},
      {"cut", {Stage::cut}, "bedroom", nullptr, "", "light-bvh"},
      {"cut", {Stage::cut}, "cornell", light_by_lamps, "12 lamps", "bidirectional", discrete, direct},
      {"near clusters", {Stage::near_clusters}, "statue", nullptr, "", "bidirectional", discrete, direct},
      {"counted BRDF rays", {Stage::counted_brdf_rays}, "cornell"},
      {"traced BRDF rays",
       {Stage::traced_brdf_rays},
       "statue",
       make_diffuse,
       "made diffuse",
       "halflight",
       continuous,
       direct},
  };
  return cases;
}

/// CPU seconds of a frame from the start and its rounds.
double frame_seconds(Session& session, const GainCase& c, uint32_t samples) {
  const double before = process_cpu_seconds();
  session.start_over();
  for (uint32_t round = 0; round < c.rounds; ++round) session.run_pass(samples, 1, 0);
  return process_cpu_seconds() - before;
}

/// The plan's seconds and the forced ones, frame by frame in turn.
struct GainTimes {
  std::vector<double> planned, forced;
};

GainTimes measure(const ExperimentRun& run, Session& planned, Session& forced, const GainCase& c) {
  const uint32_t samples = 8, repeats = run.choose(15u, 5u);
  GainTimes times;
  frame_seconds(planned, c, samples), frame_seconds(forced, c, samples);  // warm
  for (uint32_t i = 0; i < repeats && !run.stopped(); ++i) {
    // Which goes first alternates too.
    if (i % 2 == 0) times.planned.push_back(frame_seconds(planned, c, samples));
    times.forced.push_back(frame_seconds(forced, c, samples));
    if (i % 2 == 1) times.planned.push_back(frame_seconds(planned, c, samples));
  }
  return times;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

std::vector<std::string> row_of(const ExperimentRun& run, const GainCase& c, Facts& machine) {
  Messages messages;
  RenderSettings settings = run.options.render;
  settings.technique = c.technique, settings.target = c.target, settings.light = c.light;
  settings.width = run.choose(160, 64), settings.height = run.choose(120, 48);
  settings.backend = c.backend;
  const auto open = [&] {
    Scene scene = load_scene(c.scene, run.options.load, messages);
    if (c.edit) c.edit(scene);
    return std::make_unique<Session>(std::move(scene), settings, messages);
  };
  const std::unique_ptr<Session> planned = open();
  for (const Stage stage : c.stages) settings.forced.add(stage);
  const std::unique_ptr<Session> forced = open();
  for (const Stage stage : c.stages) HALFLIGHT_CHECK(forced->plan().runs.has(stage));
  const GainTimes times = measure(run, *planned, *forced, c);
  if (times.planned.size() != times.forced.size() || times.planned.empty()) return {};
  machine = machine_facts(*planned);
  const auto of = [&](const std::vector<double>& values, std::span<const uint32_t> chosen) {
    std::vector<double> picked;
    for (const uint32_t i : chosen) picked.push_back(values[i]);
    return median(picked);
  };
  const Estimate ratio = bootstrap(times.planned.size(), [&](std::span<const uint32_t> chosen) {
    return of(times.forced, chosen) / of(times.planned, chosen);
  });
  const Estimate saved = bootstrap(times.planned.size(), [&](std::span<const uint32_t> chosen) {
    return 1e3 * (of(times.forced, chosen) - of(times.planned, chosen));
  });
  return {c.what,
          std::string(c.scene) + (*c.note ? fmt::format(" ({})", c.note) : ""),
          fmt::format("{}, {}, {}", c.technique, target_name(c.target), light_selection_name(c.light)),
          fmt::format("{:.1f}", 1e3 * median(times.planned)),
          fmt::format("{:.1f}", 1e3 * median(times.forced)),
          estimate_text(saved),
          estimate_text(ratio)};
}

}  // namespace

void run_plan_gain(const ExperimentRun& run, ExperimentReport& report, Facts& machine) {
  std::vector<std::vector<std::string>> rows;
  for (const GainCase& c : gain_cases()) {
    if (run.stopped()) break;
    run.bench.progress.show(fmt::format("{} on {}", c.what, c.scene));
    try {
      auto row = row_of(run, c, machine);
      if (!row.empty()) rows.push_back(std::move(row));
    } catch (const Error& error) {
      report.text(html_text(fmt::format("{} on {}: {}", c.what, c.scene, error.what())));
    }
  }
  run.bench.progress.hide();
  report.describe("size", fmt::format("{}x{}", run.choose(160, 64), run.choose(120, 48)));
  report.describe("samples a pixel and round", 8);
  report.table("plan",
               "CPU milliseconds of a frame with the plan, and with a stage that its scene does not need",
               {"stage left out", "scene", "technique, target, light", "with the plan", "with the stage",
                "saved, ms", "ratio"},
               rows);
  report.text(
      "A frame is a session's start over (light set, tree, cut, G-buffer, the technique's own preparation) "
      "and its "
      "rounds of 8 samples a pixel; CPU time of all threads, medians over frames with and without in turn. "
      "Brackets "
      "are 95 % bootstrap intervals over the frames.");
}

}  // namespace halflight
