// Wang & Åkerlund 2009, figures 4, 5 to 7 and 8: the table of scenes, techniques at equal time, and SIR.
#include "commands/compare_report.h"
#include "commands/open_scene.h"
#include "experiments/paper_experiments.h"
#include "experiments/races.h"
#include "film/image_writers.h"

namespace halflight {

namespace {

/// One of the paper's five scenes: what figure 4 says of theirs, and ours.
struct PaperScene {
  std::string_view theirs, ours, kind;
  LightSelection light;
  int width, height;
  uint32_t samples;  ///< theirs
  std::string_view their_faces, their_cut, their_seconds;
};

constexpr std::array<PaperScene, 5> paper_scenes{{
    {"Hebe", "statue", "environment", LightSelection::direct, 480, 640, 32, "64 K", "420", "10"},
    {"Car", "car", "environment", LightSelection::direct, 640, 480, 128, "30 K", "648", "28"},
    {"Box", "box", "projected", LightSelection::indirect, 640, 480, 128, "20 K", "267", "27"},
    {"Plate", "plate", "projected", LightSelection::indirect, 640, 480, 128, "1 K", "492", "29"},
    {"Bed", "bedroom", "indirect", LightSelection::indirect, 640, 480, 256, "95 K", "986", "69"},
}};

// The paper's cuts have 300 to 1000 nodes.
constexpr const char* least_cut = "300";

/// Settings for a scene at the paper's size divided by `part`, or smaller where it has to be quick.
RenderSettings settings_for(const ExperimentRun& run, const PaperScene& scene, int part) {
  RenderSettings settings = run.options.render;
  if (run.options.quick) part = 8;
  settings.width = scene.width / part, settings.height = scene.height / part;
  settings.light = scene.light;
  settings.technique = default_discrete_technique, settings.target = Target::discrete;
  settings.values.set("cut.least", least_cut);
  settings.values.set("bidirectional.share", "never");  // theirs are each pixel's own
  return settings;
}

}  // namespace

void run_wa_fig4(const ExperimentRun& run, ExperimentReport& report, Facts& machine) {
  std::vector<std::vector<std::string>> rows;
  for (const PaperScene& paper : paper_scenes) {
    if (run.stopped()) break;
    run.bench.progress.show(std::string(paper.ours));
    Messages messages;
    const RenderSettings settings = settings_for(run, paper, 1);
    Session session(load_scene(std::string(paper.ours), {}, messages), settings, messages);
    run.bench.interruption.keep_what_there_is();
    const RenderedPicture picture = render_picture(session, settings, paper.samples, run);
    const StageSeconds& s = session.stats().seconds;
    rows.push_back(
        {std::string(paper.ours), fmt::format("{}", session.scene().triangles.size()),
         std::string(paper.kind), fmt::format("{}", picture.stats.light_count),
         fmt::format("{}", picture.stats.cut_size), fmt::format("{}", paper.samples),
         cell(s.lights + s.raster + s.positions + s.distribution + s.sampling + s.visibility + s.resolve),
         std::string(paper.theirs), std::string(paper.their_faces), std::string(paper.their_cut),
         std::string(paper.their_seconds)});
    report.write_picture(std::string(paper.ours), picture.image);
    machine = machine_facts(session);
  }
  run.bench.progress.hide();
  report.describe("technique", "bidirectional");
  report.table("fig4", "Figure 4: scenes and times",
               {"scene", "faces", "light", "members of S", "cut", "samples a pixel", "seconds", "theirs",
                "their faces", "their cut", "their seconds"},
               rows);
  report.text(
      "Theirs: 32 K points, σ = 5, an Intel Xeon of four cores at 2 GHz. Ours: a surface point is a member "
      "on each side, and "
      "the cut stops at a relative error (<code>cut.error</code>) instead of σ, which depends on exposure, "
      "but not "
      "before it has the 300 nodes that the paper names as the least.");
}

void run_wa_fig5(const ExperimentRun& run, ExperimentReport& report, Facts& machine) {
  std::vector<std::vector<std::string>> rows;
  std::vector<std::pair<std::string, std::string>> pictures;
  const std::vector<std::string> techniques{"bidirectional", "illumination", "brdf", "sir"};
  for (const PaperScene& paper : paper_scenes) {
    if (run.stopped()) break;
    // Half the paper's size: brute force over S costs 65,536 rays a pixel.
    const RenderSettings settings = settings_for(run, paper, 2);
    const std::string name(paper.ours);
    const std::vector<double> budgets =
        run.options.budgets_given
            ? run.options.budgets
            : run.choose(std::vector<double>{1, 2, 4, 8}, std::vector<double>{0.25, 0.5, 1});
    const Race race = run_order(run,
                                {name,
                                 paper.light,
                                 settings.width,
                                 settings.height,
                                 techniques,
                                 budgets,
                                 Equal::time,
                                 {{"cut.least", least_cut}}},
                                name);
    if (!any_complete(race)) continue;
    const Analysis analysis = analyse(race);
    for (const std::string& id : techniques) {
      const std::optional<EndOfRace> end = end_of(race, analysis, id);
      if (!end) continue;
      rows.push_back({name, id, cell(end->seconds), cell(end->spp), estimate_text(end->error),
                      id == "bidirectional" ? "" : estimate_text(error_ratio(race, id, "bidirectional"))});
      pictures.emplace_back(name + "/images/" + id + ".png", name + ", " + id);
    }
    pictures.emplace_back(name + "/images/reference.png", name + ", reference");
    machine = race.machine;
  }
  report.describe("target", "discrete: the sum over S; one brute-force reference a scene");
  report.describe("seeds", run.options.seeds);
  report.table(
      "fig5", "Figures 5 to 7: relMSE at equal wall time",
      {"scene", "technique", "seconds", "samples a pixel", "relMSE", "its relMSE over bidirectional's"},
      rows);
  report.text(
      "Brackets are 95 % bootstrap intervals over the seeds. Each scene's folder holds its whole race.");
  report.pictures("At equal time", pictures);
}

void run_wa_fig8(const ExperimentRun& run, ExperimentReport& report, Facts& machine) {
  std::vector<std::vector<std::string>> rows;
  std::vector<std::pair<std::string, std::string>> pictures;
  struct Case {
    const char* scene;
    int width, height;
  };
  for (const Case& c : {Case{"car", 960, 480}, Case{"statue", 400, 600}}) {
    if (run.stopped()) break;
    const int part = run.choose(2, 8);
    RaceOrder order{c.scene,
                    LightSelection::direct,
                    c.width / part,
                    c.height / part,
                    {"bidirectional", "sir"},
                    {32},
                    Equal::samples,
                    {{"cut.least", "800"}, {"cut.most", "800"}, {"sir.initial", "800"}}};
    const Race race = run_order(run, order, c.scene);
    if (!any_complete(race)) continue;
    const Analysis analysis = analyse(race);
    for (const char* id : {"bidirectional", "sir"}) {
      const std::optional<EndOfRace> end = end_of(race, analysis, id);
      if (!end) continue;
      rows.push_back({c.scene, id, cell(end->spp), cell(end->seconds), estimate_text(end->error)});
      pictures.emplace_back(fmt::format("{}/images/{}.png", c.scene, id), fmt::format("{}, {}", c.scene, id));
    }
    const Estimate ratio = error_ratio(race, "sir", "bidirectional");
    rows.push_back({c.scene, "sir / bidirectional", "", "", estimate_text(ratio)});
    machine = race.machine;
  }
  report.describe("samples", "M = 800, cut of 800, N = 32");
  report.table("fig8", "Figure 8: SIR against bidirectional at 32 samples a pixel",
               {"scene", "technique", "samples a pixel", "seconds", "relMSE"}, rows);
  report.pictures("32 samples a pixel", pictures);
}

}  // namespace halflight
