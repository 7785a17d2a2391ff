// CPU seconds of the shipped program, from the start of its process, to an error: on scenes of the kinds that
// other renderers were timed on. The scenes are not theirs; what is alike is the transport, the size and the
// metric.
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <cmath>
#include <optional>

#include "benchmarks/benchmarks.h"
#include "benchmarks/generated_scenes.h"
#include "core/errors.h"
#include "core/random.h"
#include "film/image_writers.h"
#include "film/metrics.h"
#include "scene/built_in_lit.h"
#include "scene/image_files.h"
#include "support/temporary_folder.h"

extern char** environ;

namespace halflight {

namespace {

namespace fs = std::filesystem;

// ---- The scenes ----

Scene furnished_room() {
  Scene scene = empty_room();
  scene.materials[scene.triangle_material.back()].emission = Vec3(0);
  const uint32_t wood = add_material(scene, plain_material("wood", {0.45f, 0.28f, 0.15f}, 0.5f));
  const uint32_t gloss = add_material(scene, plain_material("glaze", {0.2f, 0.3f, 0.5f}, 0.3f));
  place(scene, box_mesh({1.6f, 0.08f, 0.9f}, 0.02f, 2), wood, move({-0.3f, 0.75f, -0.3f}));
  for (const Vec2 corner : {Vec2(-1, -1), Vec2(1, -1), Vec2(-1, 1), Vec2(1, 1)})
    place(scene, box_mesh({0.08f, 0.72f, 0.08f}), wood,
          move({-0.3f + 0.7f * corner.x, 0.36f, -0.3f + 0.35f * corner.y}));
  place(scene, box_mesh({0.9f, 1.9f, 0.5f}, 0.02f, 2), wood, move({-1.5f, 0.95f, -1.7f}));
  place(scene, knot_mesh(20'000), gloss, move({-0.3f, 1.05f, -0.3f}) * stretch(Vec3(0.4f)));
  return scene;
}

/// All light comes off one patch of the ceiling; the camera sees neither it nor the lamp.
Scene one_bounce_room() {
  Scene scene = furnished_room();
  scene.lights.push_back(aimed_spot("spot", {1.2f, 1.9f, -1.2f}, {1.4f, 3.0f, -1.3f}, 30, Vec3(330)));
  update_bounds(scene);
  return scene;
}

Scene thousand_lights_room() {
  Scene scene = furnished_room();
  RandomStream random(1, 2, 3);
  for (int i = 0; i < 1000; ++i) {
    PunctualLight light;
    light.name = fmt::format("light {}", i);
    light.position = {-1.9f + 3.8f * random.next(), 0.1f + 2.8f * random.next(),
                      -1.9f + 3.8f * random.next()};
    const float hue = random.next();
    light.intensity = Vec3(0.01f + 0.01f * hue, 0.015f, 0.02f - 0.01f * hue);
    scene.lights.push_back(light);
  }
  update_bounds(scene);
  return scene;
}

/// A blue sky, lighter towards the horizon, with a sun of 1.5° radius, 40° high; both give about as much.
Environment sun_and_sky() {
  ImageRgb map(1024, 512);
  const float height = glm::radians(40.0f), turn = glm::radians(35.0f);
  const Vec3 sun(std::cos(height) * std::sin(turn), std::sin(height), std::cos(height) * std::cos(turn));
  const float edge = std::cos(glm::radians(1.5f));
  Environment environment = make_environment(std::move(map), "sun and sky");
  for (int y = 0; y < environment.map.height; ++y)
    for (int x = 0; x < environment.map.width; ++x) {
      const Vec3 way = environment_direction(
          environment, {(static_cast<float>(x) + 0.5f) / 1024, (static_cast<float>(y) + 0.5f) / 512});
      const float up = std::max(way.y, 0.0f);
      Vec3 radiance =
          way.y < 0 ? Vec3(0.1f) : glm::mix(Vec3(0.75f, 0.8f, 0.85f), Vec3(0.15f, 0.3f, 0.65f), up);
      if (glm::dot(way, sun) > edge) radiance = Vec3(900, 850, 750);
      environment.map.pixels[static_cast<size_t>(y) * 1024 + static_cast<size_t>(x)] = radiance;
    }
  return environment;
}

Scene outdoor_knot() {
  Scene scene;
  scene.facts.source = "outdoor knot";
  place(scene, knot_mesh(100'000), add_material(scene, plain_material("knot", {0.5f, 0.1f, 0.08f}, 0.2f)),
        move({0, 0.36f, 0}));
  place(scene, rectangle_mesh({-8, 0, -8}, {0, 0, 16}, {16, 0, 0}),
        add_material(scene, plain_material("ground", Vec3(0.4f), 0.6f)));
  add_camera(scene, "main", {1.6f, 1.5f, 2.2f}, {0, 0.3f, 0}, 45);
  scene.environment = sun_and_sky();
  update_bounds(scene);
  return scene;
}

struct OutsideScene {
  std::string_view name, light, others;
  double goal;
  Scene (*make)();
};

constexpr OutsideScene outside_scenes[] = {
    {"one-bounce-room", "all", "0.10 in 12 s (pbrt-v4, bidirectional); 0.68 in 5.8 s (Cycles)", 0.10,
     one_bounce_room},
    {"thousand-lights", "direct", "0.074 in 19 s (pbrt-v4, light BVH)", 0.074, thousand_lights_room},
    {"outdoor-knot", "direct", "0.0067 in 7.2 s (Cycles)", 0.0067, outdoor_knot}};

// ---- The program ----

/// CPU seconds of a run of the program, all of its threads, from the start of the process to its end.
double run_program(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), HALFLIGHT_PROGRAM);
  std::vector<char*> words;
  for (std::string& word : arguments) words.push_back(word.data());
  words.push_back(nullptr);
  pid_t child = 0;
  if (posix_spawn(&child, HALFLIGHT_PROGRAM, nullptr, nullptr, words.data(), environ) != 0)
    throw Error(ExitCode::failure, "the program cannot be started: " HALFLIGHT_PROGRAM);
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw Error(ExitCode::failure, fmt::format("failed: {}", fmt::join(arguments, " ")));
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// mean((x − r)² / (r² + 0.01)), the metric of the figures of the other renderers.
double relmse_over_hundredth(const ImageRgb& image, const ImageRgb& reference) {
  double sum = 0;
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    const Vec3d r(reference.pixels[i]), difference = Vec3d(image.pixels[i]) - r;
    for (int c = 0; c < 3; ++c) sum += difference[c] * difference[c] / (r[c] * r[c] + 0.01);
  }
  return sum / (3 * static_cast<double>(image.pixels.size()));
}

struct OutsidePoint {
  uint32_t samples;
  double cpu_seconds, error, own_metric;
};

/// CPU seconds where the error meets the goal, between the points around it; nothing where none of them
/// reaches it. The first point's where that is below the goal already.
std::optional<double> seconds_to_goal(const std::vector<OutsidePoint>& points, double goal) {
  if (points.front().error <= goal) return points.front().cpu_seconds;
  for (size_t i = 1; i < points.size(); ++i) {
    if (points[i].error > goal) continue;
    const double share =
        std::log(points[i - 1].error / goal) / std::log(points[i - 1].error / points[i].error);
    return points[i - 1].cpu_seconds * std::pow(points[i].cpu_seconds / points[i - 1].cpu_seconds, share);
  }
  return {};
}

void time_scene(const OutsideScene& scene, const fs::path& folder, const BenchmarkOptions& options) {
  const std::string name(scene.name), file = (folder / (name + ".glb")).string();
  const GlbFile glb = make_glb(scene.make(), name);
  write_bytes_atomically(file, glb.bytes);
  for (const SidePicture& picture : glb.pictures) write_radiance(folder / picture.name, picture.image, {});

  const std::string size = options.quick ? "160x120" : "640x480";
  const auto render = [&](const std::string& technique, uint32_t samples, int seed, const std::string& out) {
    return run_program({"render", file, "-o", out, "--technique", technique, "--target", "continuous",
                        "--light", std::string(scene.light), "--size", size, "--samples",
                        fmt::format("{}", samples), "--seed", fmt::format("{}", seed), "--backend", "none",
                        "--quiet"});
  };
  const std::string reference_file = (folder / (name + ".exr")).string(),
                    picture_file = (folder / "picture.exr").string();
  const uint32_t reference_samples = options.quick ? 256 : 1024;
  render("halflight", reference_samples, 1000, reference_file);
  const ImageRgb reference = read_image(reference_file, {});
  Vec3d mean(0);
  for (const Vec3& pixel : reference.pixels)
    mean += Vec3d(pixel) / static_cast<double>(reference.pixels.size());
  fmt::print("{}: --light {}, relMSE {} wanted; mean radiance {:.2f}\n  others, on their scenes: {}\n", name,
             scene.light, scene.goal, (mean.x + mean.y + mean.z) / 3, scene.others);
  for (const std::string technique : {"halflight", "bidirectional"}) {
    std::vector<OutsidePoint> points;
    for (uint32_t samples = 1; samples <= 64; samples *= 2) {
      const double seconds = render(technique, samples, 1, picture_file);
      const ImageRgb picture = read_image(picture_file, {});
      points.push_back({samples, seconds, relmse_over_hundredth(picture, reference),
                        measure_radiance_error(picture, reference).relmse});
      fmt::print(
          "  {:<14} {:>3} samples {:7.2f} CPU s, relMSE {:.4f} (denominator r² + (0.01 mean)²: {:.4f})\n",
          technique, samples, seconds, points.back().error, points.back().own_metric);
      std::fflush(stdout);
      if (points.back().error < 0.7 * scene.goal && points.size() > 1) break;
    }
    const auto seconds = seconds_to_goal(points, scene.goal);
    fmt::print(
        "  {:<14} relMSE {} in {} CPU seconds{}\n", technique, scene.goal,
        seconds ? fmt::format("{:.2f}", *seconds) : "more than were tried",
        points.front().error <= scene.goal ? " at most: the least number of samples is there already" : "");
  }
}

}  // namespace

void benchmark_outside(const BenchmarkOptions& options) {
  const TemporaryFolder temporary;
  const fs::path folder = options.folder.empty() ? temporary.path() : options.folder;
  std::vector<std::string> all;
  for (const OutsideScene& scene : outside_scenes) all.emplace_back(scene.name);
  const std::vector<std::string> chosen = chosen_names("scene", options.names, all);
  for (const OutsideScene& scene : outside_scenes)
    if (std::find(chosen.begin(), chosen.end(), scene.name) != chosen.end())
      time_scene(scene, folder, options);
}

}  // namespace halflight
