// Pharr, instant global illumination, figure 2: 1, 16 and 256 sets of light paths. Few sets show the virtual
// lights' shadows, many turn them into noise.
#include "commands/compare_report.h"
#include "experiments/paper_experiments.h"
#include "experiments/races.h"

namespace halflight {

void run_pharr_fig2(const ExperimentRun& run, ExperimentReport& report, Facts& machine) {
  Messages messages;
  RenderSettings settings = run.options.render;
  settings.technique = "instant";
  settings.width = run.choose(480, 96), settings.height = run.choose(360, 72);
  const uint32_t samples = run.choose(32u, 4u), samples_of_truth = run.choose(512u, 16u);
  run.bench.progress.show("hall");
  Session session(load_scene("hall", {}, messages), settings, messages);
  run.bench.interruption.keep_what_there_is();
  RenderSettings redrawn = settings;
  redrawn.values.set("instant.sets", "redrawn");
  redrawn.values.set("instant.light-sets", "64");
  redrawn.seed = settings.seed + 1000;
  const RenderedPicture truth = render_picture(session, redrawn, samples_of_truth, run);
  std::vector<std::vector<std::string>> rows;
  std::vector<std::pair<std::string, std::string>> pictures;
  for (const char* sets : {"1", "16", "256"}) {
    if (run.stopped()) break;
    settings.values.set("instant.light-sets", sets);
    const RenderedPicture picture = render_picture(session, settings, samples, run);
    const ErrorMetrics error = error_of(picture.image, truth.image);
    rows.push_back({sets, cell(picture.spp), cell(error.relmse), cell(error.rmse)});
    pictures.emplace_back(report.write_picture("sets-" + std::string(sets), picture.image),
                          fmt::format("{} sets", sets));
  }
  pictures.emplace_back(report.write_picture("redrawn", truth.image), "sets redrawn each round, converged");
  run.bench.progress.hide();
  machine = machine_facts(session);
  report.describe("target", "its own: distance fade, surfaces return light as Lambertian ones");
  report.describe("samples", samples);
  report.pictures("64 paths a set", pictures);
  report.table("fig2", "Error against the technique's own converged picture",
               {"sets", "samples a pixel", "relMSE", "rmse"}, rows);
}

}  // namespace halflight
