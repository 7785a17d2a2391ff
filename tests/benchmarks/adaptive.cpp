// Adaptive sampling against uniform: what `render --until-error` takes with either, at equal measured error.
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "benchmarks/benchmarks.h"
#include "commands/compare_race.h"
#include "commands/render_json.h"
#include "commands/sampling.h"
#include "option_values.h"

namespace halflight {

namespace {

struct AdaptiveBenchmark {
  std::vector<std::string> scenes;
  RenderSettings settings;
  uint32_t seeds = 3;
  double error = 0.01;
};

AdaptiveBenchmark parse(const std::vector<std::string>& options) {
  AdaptiveBenchmark benchmark;
  benchmark.settings.backend = Backend::none;
  benchmark.settings.technique = "bidirectional";
  benchmark.settings.target = Target::discrete;
  benchmark.settings.width = 320, benchmark.settings.height = 240;
  for (const std::string& option : options) {
    if (option.find('=') == std::string::npos) {
      benchmark.scenes.push_back(option);
      continue;
    }
    const auto [key, value] = parse_assignment(option);
    if (key == "technique")
      benchmark.settings.technique = find_technique(value).id;
    else if (key == "size")
      std::tie(benchmark.settings.width, benchmark.settings.height) = parse_size(value);
    else if (key == "seeds")
      benchmark.seeds = static_cast<uint32_t>(parse_integer(value, 1, 1000));
    else if (key == "error")
      benchmark.error = parse_number(value, 1e-6, 1);
    else
      throw usage_error("no option '" + key + "'");
  }
  if (benchmark.scenes.empty()) benchmark.scenes = {"bedroom", "statue", "car", "box", "plate"};
  return benchmark;
}

/// A long uniform run of another seed, with the error that it has itself.
ReferencePicture long_run(Session& session, const AdaptiveBenchmark& benchmark) {
  constexpr double share_of_error = 0.1;
  constexpr uint64_t own_seed = 1000;
  RenderSettings settings = benchmark.settings;
  settings.seed = own_seed;
  session.set_settings(settings);
  session.start_over();
  SamplingGoal goal;
  goal.error = share_of_error * benchmark.error;
  sample_until(session, goal, Stopwatch(), {}, {});
  const Film& film = session.film();
  ImageRgb variance(film.width(), film.height());
  for (uint32_t i = 0; i < variance.pixels.size(); ++i) variance.pixels[i] = film.variance(i);
  ReferencePicture reference;
  reference.image = film.image();
  reference.own = own_error(reference.image, variance);
  fmt::print("  reference: {:.0f} samples a pixel, own relMSE {:.1e}\n", film.mean_samples(),
             reference.own.relmse);
  return reference;
}

struct Measured {
  double cpu_seconds, lights_seconds, error, estimate, samples;
};

Measured run_until_error(Session& session, const AdaptiveBenchmark& benchmark,
                         const ReferencePicture& reference, uint64_t seed, bool adaptive) {
  RenderSettings settings = benchmark.settings;
  settings.seed = seed;
  session.set_settings(settings);
  session.start_over();
  SamplingGoal goal;
  goal.error = benchmark.error, goal.adaptive = adaptive;
  const double start = process_cpu_seconds();
  session.frame();
  const double lights = process_cpu_seconds();
  sample_until(session, goal, Stopwatch(), {}, {});
  const double end = process_cpu_seconds();
  const Film& film = session.film();
  const double error = measure_radiance_error(film.image(), reference.image).relmse - reference.own.relmse;
  return {end - start, lights - start, error, film.estimated_relmse(), film.mean_samples()};
}

/// CPU seconds of sampling at the measured error `wanted`: they scale with 1/error, near enough for errors
/// that are near.
double at_error(const Measured& m, double wanted) {
  return (m.cpu_seconds - m.lights_seconds) * m.error / wanted;
}

}  // namespace

void benchmark_adaptive(const BenchmarkOptions& options) {
  const AdaptiveBenchmark benchmark = parse(options.names);
  fmt::print(
      "--until-error {}: {}, {}x{}, {} seeds; CPU seconds of S and sampling, errors against a long run\n",
      benchmark.error, benchmark.settings.technique, benchmark.settings.width, benchmark.settings.height,
      benchmark.seeds);
  double sum_sampling = 0, sum_whole = 0;
  for (const std::string& scene : benchmark.scenes) {
    Messages messages;
    Session session(load_scene(scene, {}, messages), benchmark.settings, messages);
    fmt::print("{}\n", scene);
    const ReferencePicture reference = long_run(session, benchmark);
    double log_sampling = 0, log_whole = 0;
    for (uint64_t seed = 0; seed < benchmark.seeds; ++seed) {
      std::array<double, 2> seconds, whole;
      for (const bool adaptive : {false, true}) {
        const Measured m = run_until_error(session, benchmark, reference, seed, adaptive);
        seconds[adaptive] = at_error(m, benchmark.error);
        whole[adaptive] = m.lights_seconds + seconds[adaptive];
        fmt::print(
            "  seed {} {:<8} {:6.2f} s ({:.2f} of them S), {:6.1f} samples a pixel, relMSE {:.5f} (estimated "
            "{:.5f}); "
            "at {}: {:.2f} s and S\n",
            seed, adaptive ? "adaptive" : "uniform", m.cpu_seconds, m.lights_seconds, m.samples, m.error,
            m.estimate, benchmark.error, seconds[adaptive]);
      }
      log_sampling += std::log(seconds[1] / seconds[0]) / benchmark.seeds;
      log_whole += std::log(whole[1] / whole[0]) / benchmark.seeds;
    }
    fmt::print("  adaptive / uniform: sampling {:.3f}, with S {:.3f}\n", std::exp(log_sampling),
               std::exp(log_whole));
    sum_sampling += log_sampling, sum_whole += log_whole;
  }
  const auto scenes = static_cast<double>(benchmark.scenes.size());
  fmt::print("geometric mean over {} scenes: sampling {:.3f}, with S {:.3f}\n", scenes,
             std::exp(sum_sampling / scenes), std::exp(sum_whole / scenes));
}

}  // namespace halflight
