#include <fmt/format.h>

#include "benchmarks/benchmarks.h"
#include "core/warp.h"
#include "lights/cut_counting.h"
#include "lights/cut_distribution.h"
#include "lights/cut_importance.h"
#include "support/random_lights.h"

namespace halflight {

namespace {

void print_step(std::string_view step, double seconds, std::string_view unit, double scale) {
  fmt::print("{:<44} {:9.3f} {}\n", step, seconds * scale, unit);
}

void benchmark_tree(uint32_t count) {
  const auto lights = wall_lights(count, 10, 1);
  LightTree tree;
  print_step(fmt::format("tree of {} lights", count),
             best_seconds(3, 1, [&] { tree = build_light_tree(lights); }), "ms", 1e3);
  std::vector<Vec3> radiance;
  for (const auto& light : lights) radiance.push_back(light.radiance);
  print_step("  relight", best_seconds(3, 1, [&] { relight(tree, radiance); }), "ms", 1e3);
  Cut cut;
  const double seconds = best_seconds(3, 1, [&] { cut = illumination_cut(tree, {}); });
  print_step(fmt::format("  cut of {}", cut.size), seconds, "ms", 1e3);
}

GBufferTexel bench_texel(const Brdf& brdf) {
  GBufferTexel texel;
  texel.triangle = 0;
  texel.position = {3, 2, 4};
  texel.geometric_normal = texel.shading_normal = {0, 1, 0};
  texel.tangent = {1, 0, 0};
  texel.wo = glm::normalize(Vec3(0.3f, 1, 0.2f));
  texel.brdf = brdf;
  return texel;
}

}  // namespace

void benchmark_steps(const BenchmarkOptions&) {
  benchmark_tree(65536);
  benchmark_tree(1000000);

  const LightTree tree = build_light_tree(wall_lights(65536, 10, 1));
  CutSettings settings;
  settings.least = settings.most = 512;
  const Cut cut = illumination_cut(tree, settings);
  std::vector<float> guard(cut.padded_size()), arriving(cut.padded_size());
  CutDistribution distribution;
  const auto importance = distribution.importance(cut);

  const std::pair<const char*, Brdf> lobes[] = {
      {"importance of 512, diffuse", {BrdfModel::ggx, Vec3(0.5f), Vec3(0), 0, Vec2(1)}},
      {"importance of 512, Phong", {BrdfModel::phong, Vec3(0.5f), Vec3(0.3f), 1, Vec2(100)}},
      {"importance of 512, GGX", {BrdfModel::ggx, Vec3(0.5f), Vec3(0.04f), 1, Vec2(0.1f)}}};
  for (const auto& [name, brdf] : lobes) {
    const GBufferTexel texel = bench_texel(brdf);
    print_step(name,
               best_seconds(7, 2000,
                            [&] {
                              analytic_importance(cut, texel, 0, {importance, guard, arriving});
                            }),
               "us", 1e6);
  }
  print_step("distribution of 512", best_seconds(7, 2000, [&] { distribution.build(cut, guard, 0.05f); }),
             "us", 1e6);

  std::vector<LightSample> draws(16);
  uint64_t pass = 0;
  print_step("16 draws",
             best_seconds(7, 2000,
                          [&] {
                            RandomStream random(0, pass++, 0);
                            distribution.draw(cut, random, draws);
                          }),
             "us", 1e6);

  for (const float exponent : {100.0f, 1e4f}) {
    RayBundle rays;
    RandomStream random(1, 2, 3);
    const Basis basis = basis_around(glm::normalize(Vec3(0.3f, 1, 0.2f)));
    for (int i = 0; i < 64; ++i)
      rays.add(glm::normalize(basis.to_world(cosine_power_lobe(random.next2(), exponent))));
    ClusterCounter counter;
    print_step(fmt::format("counting 64 rays, exponent {}", exponent),
               best_seconds(7, 500,
                            [&] {
                              counter.count(cut, {3, 2, 4}, guard, rays, CountRule::shared);
                            }),
               "us", 1e6);
  }
}

}  // namespace halflight
