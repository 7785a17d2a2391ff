// The bare loop gets the very rays of the renderer's pass, in several orders and batch sizes; the best
// counts.
#include <fmt/format.h>

#include <mutex>
#include <numeric>

#include "benchmarks/benchmarks.h"
#include "core/parallel.h"
#include "core/random.h"
#include "scene/view_file.h"
#include "session.h"

namespace halflight {

namespace {

/// Bits of a Morton code of a point in the box, above its direction's octant.
uint64_t sort_key(const ShadowRay& ray, const Aabb& box) {
  const Vec3 extent = glm::max(box.extent(), Vec3(1e-30f));
  const Vec3 place = (Vec3(ray.origin_x, ray.origin_y, ray.origin_z) - box.low) / extent * 1023.0f;
  uint64_t key =
      (ray.direction_x < 0 ? 4u : 0u) | (ray.direction_y < 0 ? 2u : 0u) | (ray.direction_z < 0 ? 1u : 0u);
  key <<= 30;
  for (int bit = 0; bit < 10; ++bit)
    for (int axis = 0; axis < 3; ++axis)
      key |= static_cast<uint64_t>(static_cast<uint32_t>(std::clamp(place[axis], 0.0f, 1023.0f)) >> bit & 1)
             << (3 * bit + axis);
  return key;
}

/// Rays a second on all cores, batches of `size`.
double bare_rate(const RayScene& scene, const std::vector<ShadowRay>& rays, size_t size) {
  double best = 0;
  for (int round = 0; round < 4; ++round) {
    std::vector<ShadowRay> copy = rays;
    const Stopwatch watch;
    const size_t batches = (copy.size() + size - 1) / size;
    parallel_for(0, batches, std::max<size_t>(1, 16384 / size), [&](size_t begin, size_t end) {
      RayCounters counters;
      for (size_t b = begin; b < end; ++b)
        scene.occluded(std::span(copy).subspan(b * size, std::min(size, copy.size() - b * size)), 0,
                       counters);
    });
    best = std::max(best, static_cast<double>(copy.size()) / watch.seconds());
  }
  return best;
}

double best_bare_rate(const Session& session, const RayScene& scene, std::vector<ShadowRay> rays) {
  double best = 0;
  const auto try_order = [&](const char* order) {
    for (const size_t size : {64, 256, 1024}) {
      const double rate = bare_rate(scene, rays, size);
      fmt::print("  bare loop, {:<24} batches of {:>4}: {:6.2f} Mrays/s\n", order, size, rate * 1e-6);
      best = std::max(best, rate);
    }
  };
  try_order("the renderer's order");
  std::vector<std::pair<uint64_t, ShadowRay>> keyed;
  for (const ShadowRay& ray : rays) keyed.emplace_back(sort_key(ray, session.scene().bounds), ray);
  std::stable_sort(keyed.begin(), keyed.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::transform(keyed.begin(), keyed.end(), rays.begin(), [](const auto& k) { return k.second; });
  try_order("octant + Morton");
  RandomStream random(1, 2, 3);
  for (size_t i = rays.size(); i-- > 1;) std::swap(rays[i], rays[random.next_bits() % (i + 1)]);
  try_order("random");
  return best;
}

}  // namespace

Scene open_named(const std::string& name, Messages& messages, float* ev) {
  if (name.find(".json") == std::string::npos) return load_scene(name, {}, messages);
  const View view = read_view(name);
  if (!view.scene) throw usage_error(name + ": the view names no scene");
  Scene scene = load_scene(view.scene->string(), {}, messages);
  apply_view(scene, view, {}, messages);
  if (ev) *ev = view.ev.value_or(0.0f);
  return scene;
}

namespace {

void benchmark_rays_of(const std::string& name, std::string_view id) {
  Messages messages;
  RenderSettings settings;
  settings.technique = id;
  settings.backend = Backend::none;
  Session session(open_named(name, messages), settings, messages);
  const FrameView frame = session.frame();
  const auto technique = find_technique(settings.technique).make();
  technique->prepare(frame);

  PassRequest request;
  PassStats best;
  double best_rate = 0;
  for (int round = 0; round < 4; ++round) {
    Film film(settings.width, settings.height);
    request.pass = round;
    // As the session does where S is redrawn: a round belongs to one half of the film.
    if (frame.target == Target::continuous) request.half = round % 2;
    const PassStats stats = technique->run_pass(frame, request, film);
    const double seconds = (stats.sampling_seconds + stats.visibility_seconds) / thread_count();
    const double rate = static_cast<double>(stats.useful_rays) / seconds;
    if (rate > best_rate) best_rate = rate, best = stats;
  }

  std::vector<ShadowRay> rays;
  std::mutex mutex;
  request.watch_rays = [&](std::span<const ShadowRay> batch) {
    const std::lock_guard lock(mutex);
    rays.insert(rays.end(), batch.begin(), batch.end());
  };
  Film film(settings.width, settings.height);
  technique->run_pass(frame, request, film);

  const bool own = best.light_count > 0;
  fmt::print("{}, {}: {} triangles, {} lights, cut of {}, {}x{}, {} samples a pixel, {} threads\n", name, id,
             session.scene().triangles.size(), own ? best.light_count : frame.tree->lights.size(),
             own ? best.cut_size : frame.cut->size, settings.width, settings.height, request.samples,
             thread_count());
  const double bare = best_bare_rate(session, *frame.rays, std::move(rays));
  const double total = best.gbuffer_seconds + best.distribution_seconds + best.sampling_seconds +
                       best.visibility_seconds + best.resolve_seconds;
  const double pixels = static_cast<double>(best.pixels), drawn = static_cast<double>(best.useful_rays);
  fmt::print(
      "  renderer: {:.2f} M useful rays ({:.0f} % of the draws), {:.2f} Mrays/s of sampling + visibility\n",
      drawn * 1e-6, 100 * drawn / (pixels * request.samples), best_rate * 1e-6);
  fmt::print("  ratio to the bare loop: {:.3f} (whole CPU stage: {:.3f})\n", best_rate / bare,
             drawn / (total / thread_count()) / bare);
  fmt::print("  share of the CPU stage inside visibility: {:.1f} %\n", 100 * best.visibility_seconds / total);
  fmt::print(
      "  a pixel, one core: positions {:.2f} us, distribution {:.2f} us, sampling {:.2f} us, visibility "
      "{:.2f} "
      "us, resolve {:.2f} us\n",
      1e6 * best.gbuffer_seconds / pixels, 1e6 * best.distribution_seconds / pixels,
      1e6 * best.sampling_seconds / pixels, 1e6 * best.visibility_seconds / pixels,
      1e6 * best.resolve_seconds / pixels);
}

}  // namespace

void benchmark_rays(const BenchmarkOptions& options) {
  for (const std::string& name : options.names)
    for (const std::string_view id : {default_technique, default_discrete_technique})
      benchmark_rays_of(name, id);
}

}  // namespace halflight
