// GPU Gems 3, chapter 20: pictures of 40 samples with and without filtering, error and time against the
// number of samples. The truth is the technique's own integral, without visibility: plain importance sampling
// with very many samples.
#include "commands/compare_report.h"
#include "experiments/paper_experiments.h"
#include "experiments/races.h"

namespace halflight {

namespace {

constexpr uint32_t samples_of_truth = 16384;
constexpr std::array<const char*, 2> scenes{"glossy-sphere", "bumpy-statue"};

RenderSettings settings_for(const ExperimentRun& run) {
  RenderSettings settings = run.options.render;
  settings.technique = "filtered";
  settings.width = run.choose(320, 64), settings.height = run.choose(240, 48);
  return settings;
}

RenderedPicture filtered(Session& session, RenderSettings settings, const char* filter, uint32_t samples,
                         const ExperimentRun& run) {
  settings.values.set("filtered.filter", filter);
  return render_picture(session, settings, samples, run);
}

/// Calls `measure(scene, session, settings)` for each scene.
template <class Measure>
void for_each_scene(const ExperimentRun& run, Facts& machine, const Measure& measure) {
  for (const char* name : scenes) {
    if (run.stopped()) return;
    run.bench.progress.show(name);
    Messages messages;
    const RenderSettings settings = settings_for(run);
    Session session(load_scene(name, {}, messages), settings, messages);
    run.bench.interruption.keep_what_there_is();
    measure(std::string(name), session, settings);
    machine = machine_facts(session);
  }
  run.bench.progress.hide();
}

}  // namespace

void run_gems_pictures(const ExperimentRun& run, ExperimentReport& report, Facts& machine) {
  std::vector<std::vector<std::string>> rows;
  std::vector<std::pair<std::string, std::string>> pictures;
  for_each_scene(
      run, machine, [&](const std::string& name, Session& session, const RenderSettings& settings) {
        const ImageRgb truth = filtered(session, settings, "off", samples_of_truth, run).image;
        for (const char* filter : {"off", "on"}) {
          const ImageRgb image = filtered(session, settings, filter, 40, run).image;
          const std::string file = name + (filter[1] == 'n' ? "-filtered" : "-plain");
          pictures.emplace_back(report.write_picture(file, image),
                                fmt::format("{}, 40 samples, filter {}", name, filter));
          const ErrorMetrics error = error_of(image, truth);
          rows.push_back({name, filter, cell(error.rmse), cell(error.relmse)});
        }
        pictures.emplace_back(report.write_picture(name + "-truth", truth), name + ", 16384 samples");
      });
  report.describe("samples", 40);
  report.pictures("Figure 20-5: importance sampling without and with filtering", pictures);
  report.table("fig20-5", "Error", {"scene", "filter", "rmse", "relMSE"}, rows);
}

void run_gems_error(const ExperimentRun& run, ExperimentReport& report, Facts& machine) {
  std::vector<std::vector<std::string>> rows;
  Plot plot;
  plot.x_label = "samples a pixel", plot.y_label = "RMSE";
  for_each_scene(
      run, machine, [&](const std::string& name, Session& session, const RenderSettings& settings) {
        const ImageRgb truth = filtered(session, settings, "off", samples_of_truth, run).image;
        for (const char* filter : {"on", "off"}) {
          PlotSeries series;
          series.label = fmt::format("{}, filter {}", name, filter);
          series.dashed = filter[1] == 'f';
          for (uint32_t samples = 1; samples <= 1024 && !run.stopped(); samples *= 2) {
            const ErrorMetrics error =
                error_of(filtered(session, settings, filter, samples, run).image, truth);
            series.x.push_back(samples), series.y.push_back(error.rmse);
            rows.push_back({name, filter, fmt::format("{}", samples), cell(error.rmse), cell(error.relmse)});
          }
          const std::optional<LogLine> line = fit_log_log(series.x, series.y);
          if (line) series.label += fmt::format(", slope {:.2f}", line->slope);
          series.low = series.high =
              std::vector<double>(series.x.size(), std::numeric_limits<double>::quiet_NaN());
          plot.series.push_back(series);
        }
      });
  report.plot("error", plot, "Figure 20-8: error against samples; the truth has 16384 unfiltered samples.");
  report.table("fig20-8", "Error", {"scene", "filter", "samples", "rmse", "relMSE"}, rows);
}

void run_gems_time(const ExperimentRun& run, ExperimentReport& report, Facts& machine) {
  std::vector<std::vector<std::string>> rows;
  Plot plot;
  plot.x_label = "samples a pixel", plot.y_label = "GPU seconds",
  plot.logarithmic_x = plot.logarithmic_y = false;
  for_each_scene(
      run, machine, [&](const std::string& name, Session& session, const RenderSettings& settings) {
        PlotSeries series;
        double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0;
        for (uint32_t samples = 10; samples <= 200 && !run.stopped(); samples += 10) {
          double best = infinity;
          for (int i = 0; i < 3; ++i)
            best = std::min(best, filtered(session, settings, "on", samples, run).stats.seconds.gpu);
          series.x.push_back(samples), series.y.push_back(best);
          rows.push_back({name, fmt::format("{}", samples), cell(best)});
          ++n, sx += samples, sy += best, sxx += double(samples) * samples, sxy += samples * best,
              syy += best * best;
        }
        const double covariance = n * sxy - sx * sy, slope = covariance / (n * sxx - sx * sx);
        const double correlation = covariance / std::sqrt((n * sxx - sx * sx) * (n * syy - sy * sy));
        series.label = name;
        series.low = series.high =
            std::vector<double>(series.x.size(), std::numeric_limits<double>::quiet_NaN());
        plot.series.push_back(series);
        report.text(fmt::format("{}: {:.3g} ms + {:.3g} ms a sample, r² = {:.5f}.", html_text(name),
                                1e3 * (sy - slope * sx) / n, 1e3 * slope, correlation * correlation));
      });
  report.plot("time", plot, "Figure 20-9: time against samples, the least of three runs each.");
  report.table("fig20-9", "Time", {"scene", "samples", "GPU seconds"}, rows);
}

}  // namespace halflight
