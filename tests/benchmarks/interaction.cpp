// The window's render thread without a window: how long after a change its picture is there, and how good
// that is.
#include <fmt/format.h>

#include <algorithm>
#include <thread>

#include "benchmarks/benchmarks.h"
#include "commands/render_json.h"
#include "core/parallel.h"
#include "film/metrics.h"
#include "viewer/camera_controls.h"
#include "viewer/render_thread.h"

namespace halflight {

namespace {

using Milliseconds = std::chrono::milliseconds;
constexpr int width = 640, height = 480;

RenderSettings window_settings() {
  RenderSettings settings;
  settings.width = width, settings.height = height;
  settings.backend = Backend::none;
  return settings;
}

/// Wall and processor time of something: on a busy machine the second, over its threads, is what an idle one
/// takes.
struct Latency {
  double wall, cpu;
};

class Latencies {
 public:
  void add(Latency latency) { all_.push_back(latency); }

  /// Median and 90 %, in milliseconds.
  std::string text() const {
    const auto at = [&](double Latency::*what, double share) {
      std::vector<double> values;
      for (const Latency& latency : all_) values.push_back(latency.*what);
      return 1e3 * quantile(values, share);
    };
    const double threads = thread_count();
    return fmt::format("median {:4.0f} ms, 90 % {:4.0f} ms (processor time / {:.0f}: {:4.0f}, {:4.0f})",
                       at(&Latency::wall, 0.5), at(&Latency::wall, 0.9), threads,
                       at(&Latency::cpu, 0.5) / threads, at(&Latency::cpu, 0.9) / threads);
  }

 private:
  std::vector<Latency> all_;
};

template <class Done>
std::shared_ptr<const Snapshot> wait_for(const RenderThread& thread, const Done& done) {
  for (;;) {
    thread.rethrow_if_nothing_opened();
    const auto snapshot = thread.latest();
    if (snapshot && done(*snapshot)) return snapshot;
    std::this_thread::sleep_for(Milliseconds(1));
  }
}

bool same_camera(const Camera& a, const Camera& b) { return a.position == b.position && a.back == b.back; }

/// The change, and its first picture.
template <class Change, class Done>
std::shared_ptr<const Snapshot> timed(RenderThread& thread, const Change& change, const Done& done,
                                      Latencies& latencies) {
  const double cpu = process_cpu_seconds();
  const Stopwatch watch;
  change();
  auto snapshot = wait_for(thread, done);
  latencies.add({watch.seconds(), process_cpu_seconds() - cpu});
  return snapshot;
}

ImageRgb converged(const std::string& scene, const Camera& camera) {
  constexpr uint32_t samples = 64;
  Messages messages;
  Session session(open_named(scene, messages), window_settings(), messages);
  session.set_camera(camera);
  for (int round = 0; round < 4; ++round) session.run_pass(samples, 1, 0);
  return session.film().image();
}

/// Something of the scene's light, `factor` times as bright.
LightEdits brighter(LightEdits lights, float factor) {
  for (PunctualLight& light : lights.lights) light.intensity *= factor;
  for (Vec3& emission : lights.emission) emission *= factor;
  lights.environment_strength *= factor;
  return lights;
}

constexpr int changes = 12;

/// Single moves, to and fro, each while the picture before converges; the last one's picture.
std::shared_ptr<const Snapshot> time_moves(RenderThread& thread, const Snapshot& first) {
  Camera camera = first.camera;
  Latencies latencies;
  std::shared_ptr<const Snapshot> shown;
  for (int i = 0; i < changes; ++i) {
    const float side = i % 2 == 0 ? 1.0f : -1.0f;
    camera = orbit_by_drag(camera, first.pivot, {8 * side, 2 * side}, height);
    shown = timed(
        thread, [&] { thread.set_camera(camera); },
        [&](const Snapshot& s) { return same_camera(s.camera, camera); }, latencies);
    std::this_thread::sleep_for(Milliseconds(300));
  }
  fmt::print("  camera, to its first picture: {}\n", latencies.text());
  fmt::print("    the last drawn with {}x{}\n", shown->drawn_width, shown->drawn_height);
  const StageSeconds& stages = shown->stats.seconds;
  fmt::print(
      "    of the last: G-buffer {:.0f} ms, points, tree and cut {:.0f}, distribution {:.0f}, sampling "
      "{:.0f}, "
      "visibility {:.0f}\n",
      1e3 * stages.raster, 1e3 * stages.lights, 1e3 * stages.distribution, 1e3 * stages.sampling,
      1e3 * stages.visibility);
  return shown;
}

/// Pictures while the camera moves sixty times a second.
void count_pictures(RenderThread& thread, const Snapshot& first, Camera camera) {
  constexpr double seconds = 3;
  size_t pictures = 0;
  const double cpu = process_cpu_seconds();
  std::shared_ptr<const Snapshot> last;
  for (const Stopwatch watch; watch.seconds() < seconds; std::this_thread::sleep_for(Milliseconds(16))) {
    thread.set_camera(camera =
                          orbit_by_drag(camera, first.pivot, {pictures % 20 < 10 ? 2.0f : -2.0f, 0}, height));
    if (auto latest = thread.latest(); latest != last) last = std::move(latest), ++pictures;
  }
  const double used = (process_cpu_seconds() - cpu) / thread_count();
  fmt::print("  camera that moves on: {:.1f} pictures a second ({:.1f} a second of processor time / {})\n",
             static_cast<double>(pictures) / seconds, static_cast<double>(pictures) / used, thread_count());
}

/// A slider of all light.
void time_light(RenderThread& thread, const Snapshot& first) {
  Latencies latencies;
  std::vector<double> lights;
  for (int i = 0; i < changes; ++i) {
    const LightEdits edits = brighter(first.lights, 1 + 0.02f * static_cast<float>(i + 1));
    const auto snapshot = timed(
        thread, [&] { thread.edit_lights(edits); },
        [&](const Snapshot& s) { return s.lights.environment_strength == edits.environment_strength; },
        latencies);
    lights.push_back(snapshot->stats.seconds.lights);
    std::this_thread::sleep_for(Milliseconds(50));
  }
  fmt::print("  light, to its first picture:  {}\n", latencies.text());
  fmt::print("    of it points, tree and cut: median {:.0f} ms, 90 % {:.0f} ms of wall time\n",
             1e3 * quantile(lights, 0.5), 1e3 * quantile(lights, 0.9));
}

void benchmark_scene(const std::string& scene) {
  float ev = 0;
  RenderThread thread([&](Messages& messages, DisplaySettings&) { return open_named(scene, messages, &ev); },
                      window_settings(), {}, 1 << 20);
  const auto first = wait_for(thread, [](const Snapshot& s) { return s.mean_samples > 1; });
  fmt::print("{}\n", scene);
  const auto shown = time_moves(thread, *first);
  count_pictures(thread, *first, shown->camera);
  time_light(thread, *first);
  thread.set_paused(true);

  const ImageRgb reference = converged(scene, shown->camera);
  fmt::print("  FLIP of the first picture after a move, against 256 samples a pixel: {:.3f}\n",
             measure_error(shown->picture, reference, ev).flip);
}

}  // namespace

void benchmark_interaction(const BenchmarkOptions& options) {
  fmt::print("{}x{}, pixels by rays, {} threads, technique {}\n", width, height, thread_count(),
             window_settings().technique);
  const std::vector<std::string> all{"bedroom", std::string(HALFLIGHT_VIEWS) + "#hotel-room", "statue"};
  for (const std::string& scene : options.names.empty() ? all : options.names) benchmark_scene(scene);
}

}  // namespace halflight
