// `halflight`: drawing and weighing use one density.
#include <gtest/gtest.h>

#include "lights/cut_importance.h"
#include "support/halflight_rooms.h"
#include "techniques/connection_batch.h"
#include "techniques/traced_loop.h"

namespace halflight {
namespace {

struct DensityScene {
  const char* name;
  Scene (*make)();
  std::vector<LightKind> kinds;  ///< that must be found by rays
};

void PrintTo(const DensityScene& scene, std::ostream* out) { *out << scene.name; }

class OneDensity : public testing::TestWithParam<DensityScene> {};

/// As the technique makes it for a pixel; the factors of visibility are known to both sides alike.
bool build_distribution(const Cut& cut, const GBufferTexel& texel, CutDistribution& distribution) {
  std::vector<float> guard(cut.padded_size()), arriving(guard.size());
  const std::span<float> importance = distribution.importance(cut);
  analytic_importance(cut, texel, 0, {importance, guard, arriving});
  return distribution.build(cut, guard, 0.05f);
}

/// What a BRDF ray towards `light` finds there: the density of light samples per solid angle, or nothing
/// where another surface is in the way.
std::optional<float> density_met(const FrameView& frame, const StrataDensity& strata,
                                 const GBufferTexel& texel, const VirtualLight& light, Vec3 wi,
                                 float distance) {
  const ShadowRay probe = shadow_ray(*frame.scene, texel.position, texel.geometric_normal, wi, infinity);
  RayHit hit;
  RayCounters counters;
  const bool met = frame.rays->intersect({probe.origin_x, probe.origin_y, probe.origin_z}, wi, 0, infinity, 0,
                                         hit, counters);
  if (light.at_infinity())
    return met ? std::nullopt
               : std::optional(strata.of(
                     strata.lights->met_environment(environment_texel(frame.scene->environment, wi))));
  if (!met || std::abs(hit.distance - distance) > 1e-4f * distance) return std::nullopt;
  const auto place = bounce_place(*frame.scene, hit.point, wi);
  // Through a surface that lies in another it may be the other that is met.
  if (!place || glm::dot(place->normal, light.normal) < 0.9999f) return std::nullopt;
  const auto on_it = light.kind == LightKind::emitter ? strata.lights->met_emitter(hit.point, place->front)
                                                      : strata.lights->met_surface(hit.point, place->front);
  return area_to_solid_angle(strata.of(on_it), distance, place->cos_light);
}

struct Tally {
  size_t compared = 0, astray = 0;
  std::array<size_t, light_kind_count> of_kind{};
};

/// Each stratum at one pixel: both ways of drawing its point have weights that add to one.
void check_pixel(const FrameView& frame, const LearnedLights& lights, const GBufferTexel& texel,
                 Tally& tally) {
  constexpr float samples = 7, rays = 2;
  CutDistribution distribution;
  const Cut& cut = lights.cut();
  if (!build_distribution(cut, texel, distribution)) return;
  const StrataDensity strata{&lights, &distribution};
  double sum = 0;
  for (uint32_t leaf = 0; leaf < lights.tree().lights.size(); ++leaf) {
    const uint32_t k = lights.cluster_of(leaf);
    const double p = k == LearnedLights::none ? 0 : distribution.probability(cut, k, leaf);
    ASSERT_EQ(p > 0, leaf_power(lights.tree().lights[leaf]) > 0);
    if (p == 0) continue;
    const float weight = distribution.weight(cut, k, leaf);
    ASSERT_NEAR(p * weight, 1, 1e-6);
    sum += p;
    if (!lights.met_by_rays(leaf)) continue;

    VirtualLight light = lights.light(leaf);
    const LightConnection link = connect(light, *frame.scene, texel.position, GeometryTerm::exact);
    const float cosine = glm::dot(texel.shading_normal, link.wi);
    if (!(cosine > 1e-3f) || !(glm::dot(texel.geometric_normal, link.wi) > 1e-3f)) continue;
    const float faces = -glm::dot(light.normal, link.wi);
    if (!light.at_infinity() && faces < 1e-3f) continue;
    const auto met = density_met(frame, strata, texel, light, link.wi, link.distance);
    if (!met) continue;

    // The sample of light, whose radiance does not matter here.
    light.radiance = Vec3(1);
    ConnectionBatch batch;
    batch.add({&light, weight, leaf, rays});
    batch.connect_beside_rays(*frame.scene, texel, texel.basis(), GeometryTerm::exact, samples);
    const BrdfValue brdf = evaluate_with_pdf(texel.brdf, texel.basis(), texel.wo, link.wi);
    if (!(brdf.f.y > 1e-12f) || !(brdf.pdf > 0)) continue;
    const double omega = light.at_infinity() ? light.measure : light.measure * faces / square(link.distance);
    const double by_light = static_cast<double>(batch.green[0]) / (static_cast<double>(brdf.f.y) * cosine) *
                            samples / (static_cast<double>(weight) * omega);
    const double by_ray =
        static_cast<double>(rays) * static_cast<double>(balance_over_n(rays, brdf.pdf, samples, *met));
    ++tally.compared, ++tally.of_kind[static_cast<size_t>(light.kind)];
    // A point within rounding of its stratum's edge may be met in the next one.
    if (std::abs(by_light + by_ray - 1) > 2e-3) ++tally.astray;
  }
  ASSERT_NEAR(sum, 1, 1e-9);
}

/// Leaves are drawn by what the set in hand sends, and what that has over the learned probability is taken
/// back from their light.
void check_drawn(const LearnedLights& lights) {
  const Cut &learned = lights.cut(), &drawn = lights.drawn();
  size_t by_set = 0;
  for (uint32_t k = 0; k < learned.size; ++k) {
    double sum = 0, power = 0;
    for (uint32_t i = learned.begin[k]; i < learned.end[k]; ++i) power += leaf_power(lights.light(i));
    for (uint32_t i = learned.begin[k]; i < learned.end[k]; ++i) {
      const double p = leaf_probability(drawn, k, i), ratio = lights.learned_over_drawn(i);
      sum += p;
      ASSERT_NEAR(p * ratio, leaf_probability(learned, k, i), 1e-6 * p * ratio + 1e-9);
      ASSERT_LT(ratio, 10.1) << "no sample may weigh much more than what was learned makes of it";
      if (learned.kind[k] == LightKind::punctual || !(power > 0)) {
        ASSERT_NEAR(ratio, 1, 1e-6);
      } else {
        ASSERT_GT(p, 0.89 * leaf_power(lights.light(i)) / power - 1e-9);
        by_set += std::abs(ratio - 1) > 0.01;
      }
    }
    ASSERT_NEAR(sum, 1, 1e-9);
  }
  EXPECT_GT(by_set, 100u) << "a set like what was learned shows nothing";
}

TEST_P(OneDensity, BothWaysToAPointShareItInFull) {
  const DensityScene& c = GetParam();
  Messages messages;
  Session session(c.make ? c.make() : load_scene(c.name, {}, messages), halflight_settings(32, 24), messages);
  const FrameView frame = session.frame();
  PassStats stats;
  LearnedLights lights(frame, 4, true, 512, stats);
  Tally tally;
  for (const uint64_t round : {0u, 5u}) {
    lights.draw_set(frame, round, 1, stats);
    check_drawn(lights);
    for (uint32_t pixel = 100; pixel < frame.gbuffer->texels.size(); pixel += 131) {
      const GBufferTexel& texel = frame.gbuffer->texels[pixel];
      if (texel.hit() && !texel.brdf.black()) check_pixel(frame, lights, texel, tally);
    }
  }
  EXPECT_LE(static_cast<double>(tally.astray), 1e-3 * static_cast<double>(tally.compared));
  for (const LightKind kind : c.kinds)
    EXPECT_GE(tally.of_kind[static_cast<size_t>(kind)], 20u) << static_cast<int>(kind);
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, OneDensity,
    testing::Values(DensityScene{"cornell", nullptr, {LightKind::emitter, LightKind::surface}},
                    DensityScene{"spheres", nullptr, {LightKind::environment, LightKind::surface}},
                    DensityScene{"bedroom", nullptr, {LightKind::surface}},
                    DensityScene{"lit_corner",
                                 lit_corner,
                                 {LightKind::environment, LightKind::emitter, LightKind::surface}}),
    [](const auto& test) { return std::string(test.param.name); });

// A sample of light that rays cannot meet stands for itself.
TEST(ConnectionBesideRays, WithoutRaysItIsTheSampleAlone) {
  const Scene scene = lit_corner();
  const GBufferTexel texel = corner_pixels()[2];
  for (const VirtualLight& light :
       {VirtualLight{{0, 0.4f, 0.3f}, 0.02f, {1, 0, 0}, LightKind::surface, Vec3(3, 2, 1), 0},
        VirtualLight{
            glm::normalize(Vec3(0.3f, 1, 0.2f)), 0.1f, {0, -1, 0}, LightKind::environment, Vec3(2), 0},
        VirtualLight{scene.lights[0].position, 1, {0, -1, 0}, LightKind::punctual, Vec3(0.05f), 0}}) {
    const LightConnection link = connect(light, scene, texel.position, GeometryTerm::exact);
    const BrdfValue brdf = evaluate_with_pdf(texel.brdf, texel.basis(), texel.wo, link.wi);
    const float cosine = glm::dot(texel.shading_normal, link.wi);
    constexpr float weight = 30, samples = 5;
    for (const float rays : {0.0f, 3.0f}) {
      ConnectionBatch batch;
      batch.add({&light, weight, 0, rays});
      batch.connect_beside_rays(scene, texel, texel.basis(), GeometryTerm::exact, samples);
      // Punctual light has no density that rays share; the rest has 1/(weight Ω).
      double omega = light.kind == LightKind::punctual      ? 1
                     : light.kind == LightKind::environment ? light.measure
                                                            : link.irradiance.x / light.radiance.x;
      const double radiance = link.irradiance.x / omega, pdf = 1 / (weight * omega);
      const double expected = brdf.f.x * cosine * radiance / (samples * pdf + rays * brdf.pdf);
      EXPECT_NEAR(batch.red[0], expected, 1e-4 * expected) << static_cast<int>(light.kind) << " " << rays;
    }
  }
}

}  // namespace
}  // namespace halflight
