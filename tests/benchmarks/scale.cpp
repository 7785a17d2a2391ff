// Error and time against the number of lights, triangles, pixels and threads. One curve each: `scale lights`,
// `scale triangles`, `scale image`, `scale threads`; without a name all of them.
#include <fmt/format.h>

#include <array>

#include "benchmarks/benchmarks.h"
#include "benchmarks/curves.h"
#include "benchmarks/generated_scenes.h"
#include "benchmarks/time_to_error.h"
#include "core/errors.h"
#include "core/parallel.h"
#include "scene/load.h"

namespace halflight {

namespace {

RenderSettings ray_settings(int width, int height) {
  RenderSettings settings;
  settings.technique = "bidirectional";
  settings.backend = Backend::none;
  settings.width = width, settings.height = height;
  return settings;
}

std::string seconds_text(double seconds) { return fmt::format("{:.4f}", seconds); }

/// Everything but loading: S, tree, cut and G-buffer anew, then a pass.
struct FrameSeconds {
  double lights = 0, gbuffer = 0, pass = 0;
  double total() const { return lights + gbuffer + pass; }
};

FrameSeconds frame_seconds(Session& session, uint32_t samples) {
  FrameSeconds seconds;
  session.start_over();
  Stopwatch watch;
  session.frame();
  const double preparation = watch.lap();
  seconds.lights = session.stats().seconds.lights;
  seconds.gbuffer = preparation - seconds.lights;
  session.run_pass(samples, 1, 0);
  seconds.pass = watch.lap();
  return seconds;
}

/// The least of each part over some rounds: other programs only ever add to a time.
void keep_least(FrameSeconds& least, const FrameSeconds& now) {
  least = {std::min(least.lights, now.lights), std::min(least.gbuffer, now.gbuffer),
           std::min(least.pass, now.pass)};
}

constexpr FrameSeconds no_time_yet{1e30, 1e30, 1e30};

// ---- Lights ----

void scale_lights(const BenchmarkOptions& options) {
  const std::vector<int> counts =
      options.quick ? std::vector{1024, 4096, 65536} : std::vector{1024, 4096, 16384, 65536, 262144, 1000000};
  const int width = options.quick ? 160 : 640, height = options.quick ? 120 : 480;
  Curve curve{"scale-lights",
              "points of S of each kind",
              "seconds",
              {"scene", "points", "lights", "cut", "prepare_s", "goal_spp", "goal_s", "goal_cpu_s",
               "trimmed_spp", "trimmed_s", "trimmed_cpu_s", "discretisation"},
              {},
              {}};
  fmt::print(
      "time to relMSE 1e-2 of the discrete target, bidirectional, {}x{}, {} threads; everything but "
      "loading\n",
      width, height, thread_count());
  for (const std::string scene : {"bedroom", "cornell"}) {
    Messages messages;
    Session session(load_scene(scene, {}, messages), ray_settings(width, height), messages);
    std::vector<TimeToError> results;
    for (const int count : counts) {
      RenderSettings settings = session.settings();
      settings.values.set("lights.count", fmt::format("{}", count));
      session.set_settings(settings);
      results.push_back(time_to_error(session, {1e-2, options.quick ? 3 : 5, 32}));
    }
    for (size_t i = 0; i < counts.size(); ++i) {
      const TimeToError& r = results[i];
      const TimeToError& finest = results.back();
      curve.rows.push_back(
          {scene, fmt::format("{}", counts[i]), fmt::format("{}", r.lights), fmt::format("{}", r.cut),
           seconds_text(r.prepare_seconds), fmt::format("{:.1f}", r.whole.samples),
           seconds_text(r.whole.seconds), seconds_text(r.whole.cpu_seconds),
           fmt::format("{:.1f}", r.trimmed.samples), seconds_text(r.trimmed.seconds),
           seconds_text(r.trimmed.cpu_seconds),
           i + 1 == counts.size() ? "-" : fmt::format("{:.2g}", relmse_between(r.mean, finest.mean))});
    }
    const auto print_growth = [&](Reached TimeToError::*reached, std::string_view metric) {
      const Reached &few = results[1].*reached, &many = results.back().*reached;
      fmt::print(
          "{}, {}: |S| of {} to {} points a kind takes {:.2f} x the time, {:.2f} x the CPU time (goal 1.5)\n",
          scene, metric, counts[1], counts.back(), many.seconds / few.seconds,
          many.cpu_seconds / few.cpu_seconds);
    };
    print_growth(&TimeToError::whole, "relMSE");
    print_growth(&TimeToError::trimmed, "relMSE without the worst 0.1 % of pixels");
    curve.lines.push_back({9, scene + " to trimmed relMSE 1e-2", scene});
    curve.lines.push_back({4, scene + " S, tree, cut", scene});
  }
  print_curve(curve);
  write_curve(options.folder, curve);
}

// ---- Triangles ----

void scale_triangles(const BenchmarkOptions& options) {
  const std::vector<size_t> counts = options.quick
                                         ? std::vector<size_t>{10'000, 100'000}
                                         : std::vector<size_t>{10'000, 100'000, 1'000'000, 10'000'000};
  const uint32_t samples = 16;
  Curve curve{"scale-triangles",
              "triangles",
              "seconds",
              {"growth", "triangles", "scene_mb", "embree_mb", "open_s", "lights_s", "gbuffer_s", "pass_s",
               "mrays_per_s", "relmse"},
              {},
              {}};
  fmt::print("room of one mesh and of copies of a small one, 640x480, a pass of {} samples, {} threads\n",
             samples, thread_count());
  for (const auto& [growth, name] :
       {std::pair(Growth::mesh, "mesh"), std::pair(Growth::instances, "instances")}) {
    for (const size_t count : counts) {
      Scene scene = knot_room(count, growth);
      const size_t triangles = scene.triangles.size();
      const size_t scene_bytes =
          scene.vertices.size() * sizeof(Vertex) + triangles * (sizeof(UVec3) + sizeof(uint32_t));
      Messages messages;
      Stopwatch watch;
      Session session(std::move(scene), ray_settings(640, 480), messages);
      const double open = watch.seconds();
      FrameSeconds least = no_time_yet;
      for (int round = 0; round < 2; ++round) keep_least(least, frame_seconds(session, samples));
      const auto useful = static_cast<double>(session.stats().useful_rays);
      curve.rows.push_back(
          {name, fmt::format("{}", triangles), fmt::format("{:.1f}", scene_bytes * 1e-6),
           fmt::format("{:.1f}", static_cast<double>(session.frame().rays->memory_bytes()) * 1e-6),
           seconds_text(open), seconds_text(least.lights), seconds_text(least.gbuffer),
           seconds_text(least.pass), fmt::format("{:.2f}", useful / least.pass * 1e-6),
           fmt::format("{:.4f}", session.estimated_relmse())});
    }
    curve.lines.push_back({4, fmt::format("{}: opening", name), name});
    curve.lines.push_back({5, fmt::format("{}: S", name), name});
    curve.lines.push_back({7, fmt::format("{}: a pass", name), name});
  }
  print_curve(curve);
  write_curve(options.folder, curve);
}

// ---- Pixels ----

void scale_image(const BenchmarkOptions& options) {
  constexpr std::array<std::array<int, 2>, 5> sizes{
      {{320, 240}, {640, 480}, {1280, 720}, {1920, 1080}, {3840, 2160}}};
  const size_t used = options.quick ? 2 : sizes.size();
  const uint32_t samples = 16;
  Curve curve{"scale-image",
              "pixels",
              "seconds",
              {"size", "pixels", "lights_s", "gbuffer_s", "pass_s", "ns_a_sample", "relmse"},
              {},
              {{3, "G-buffer"}, {4, "a pass of 16 samples"}, {2, "S, tree, cut"}}};
  fmt::print("bedroom, a pass of {} samples, {} threads\n", samples, thread_count());
  Messages messages;
  Session session(load_scene("bedroom", {}, messages), ray_settings(320, 240), messages);
  for (size_t i = 0; i < used; ++i) {
    const auto [width, height] = sizes[i];
    session.set_settings(ray_settings(width, height));
    FrameSeconds least = no_time_yet;
    for (int round = 0; round < 2; ++round) keep_least(least, frame_seconds(session, samples));
    const double pixels = static_cast<double>(width) * height;
    curve.rows.push_back({fmt::format("{}x{}", width, height), fmt::format("{:.0f}", pixels),
                          seconds_text(least.lights), seconds_text(least.gbuffer), seconds_text(least.pass),
                          fmt::format("{:.1f}", 1e9 * least.pass / (pixels * samples)),
                          fmt::format("{:.4f}", session.estimated_relmse())});
  }
  print_curve(curve);
  write_curve(options.folder, curve);
}

// ---- Threads ----

void scale_threads(const BenchmarkOptions& options) {
  set_thread_count(0);
  const int all = thread_count();
  std::vector<int> counts;
  for (int n = 1; n < all; n *= 2) counts.push_back(n);
  counts.push_back(all);
  const uint32_t samples = 32;
  const int width = options.quick ? 160 : 640, height = options.quick ? 120 : 480,
            rounds = options.quick ? 2 : 5;
  Curve curve{"scale-threads",
              "threads",
              "seconds",
              {"scene", "threads", "lights_s", "gbuffer_s", "pass_s", "all_s"},
              {},
              {}};
  fmt::print("{}x{}, everything but loading and a pass of {} samples; least of {} alternating rounds\n",
             width, height, samples, rounds);
  for (const std::string scene : {"bedroom", "cornell"}) {
    Messages messages;
    Session session(load_scene(scene, {}, messages), ray_settings(width, height), messages);
    std::vector<FrameSeconds> least(counts.size(), no_time_yet);
    for (int round = 0; round < rounds; ++round)
      for (size_t i = 0; i < counts.size(); ++i) {
        set_thread_count(counts[i]);
        keep_least(least[i], frame_seconds(session, samples));
      }
    set_thread_count(0);
    for (size_t i = 0; i < counts.size(); ++i) {
      curve.rows.push_back({scene, fmt::format("{}", counts[i]), seconds_text(least[i].lights),
                            seconds_text(least[i].gbuffer), seconds_text(least[i].pass),
                            seconds_text(least[i].total())});
      if (i == 0) continue;
      fmt::print(
          "{}: {} to {} threads: pass {:.2f} x, S {:.2f} x, G-buffer {:.2f} x, all {:.2f} x (goal 1.85 a "
          "doubling)\n",
          scene, counts[i - 1], counts[i], least[i - 1].pass / least[i].pass,
          least[i - 1].lights / least[i].lights, least[i - 1].gbuffer / least[i].gbuffer,
          least[i - 1].total() / least[i].total());
    }
    curve.lines.push_back({4, scene + ": a pass", scene});
    curve.lines.push_back({2, scene + ": S, tree, cut", scene});
  }
  print_curve(curve);
  write_curve(options.folder, curve);
}

constexpr std::pair<std::string_view, void (*)(const BenchmarkOptions&)> parts[] = {
    {"lights", scale_lights},
    {"triangles", scale_triangles},
    {"image", scale_image},
    {"threads", scale_threads}};

}  // namespace

void benchmark_scale(const BenchmarkOptions& options) {
  std::vector<std::string> all;
  for (const auto& [name, run] : parts) all.emplace_back(name);
  const std::vector<std::string> chosen = chosen_names("curve", options.names, all);
  for (const auto& [name, run] : parts)
    if (std::find(chosen.begin(), chosen.end(), name) != chosen.end()) run(options);
}

}  // namespace halflight
