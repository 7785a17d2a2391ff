// Instant global illumination: the light its paths carry, and the mean over sets against exact series.
#include <gtest/gtest.h>

#include <numeric>

#include "support/traced_scene.h"
#include "techniques/light_paths.h"

namespace halflight {
namespace {

constexpr LightKinds all_kinds{true, true, true, true};

/// Mean over sets of Σ radiance of the virtual lights that lie at path vertex `from` to the end, green, and
/// its error.
struct Flux {
  double mean = 0, error = 0;
};

Flux mean_flux(const Scene& scene) {
  const RayScene rays(scene);
  const LightSources lights(scene, all_kinds);
  LightPathSettings settings;
  settings.paths = 32, settings.sets = 4096;
  RayCounters counters;
  const auto sets = trace_light_paths(lights, rays, settings, counters);
  EXPECT_GT(counters.closest, 0u);
  // The sequence spreads a set evenly: sets are not independent of their neighbours, runs of them nearly are.
  constexpr size_t run = 32;
  std::vector<double> sums(sets.size() / run, 0.0);
  for (size_t i = 0; i < sets.size(); ++i)
    for (const VirtualLight& light : sets[i]) sums[i / run] += light.radiance.y / double(run);
  Flux flux;
  const double n = static_cast<double>(sums.size());
  flux.mean = std::accumulate(sums.begin(), sums.end(), 0.0) / n;
  double squares = 0;
  for (const double sum : sums) squares += (sum - flux.mean) * (sum - flux.mean);
  flux.error = std::sqrt(squares / (n - 1) / n);
  return flux;
}

/// A lone flat patch: light meets it once, so Σ radiance · π is the flux it returns.
void expect_flux(const Scene& scene, double expected) {
  const Flux flux = mean_flux(scene);
  EXPECT_NEAR(flux.mean * pi, expected, 4 * flux.error * pi + 1e-3 * expected);
  EXPECT_LT(4 * flux.error * pi, 0.06 * expected) << "too noisy to tell";
}

constexpr float albedo = 0.5f;

Scene patch() { return floor_scene(2, Vec3(albedo)); }

TEST(LightPaths, EnvironmentSendsItsIrradianceToBothSides) {
  Scene scene = patch();
  scene.environment = constant_environment(Vec3(3), 32);
  expect_flux(scene, 2 * 4 * albedo * 3 * pi);
}

TEST(LightPaths, SunLightAndDirectionalLight) {
  Scene sun = patch();
  ImageRgb map(64, 32, Vec3(0));
  map.at(10, 8) = Vec3(500);
  sun.environment = make_environment(map, "sun", EnvironmentLayout::latlong);
  const Vec3 towards = environment_direction(sun.environment, {10.5f / 64, 8.5f / 32});
  expect_flux(sun, 4 * albedo * 500.0 * texel_solid_angle(sun.environment, 8) * towards.y);

  Scene directional = patch();
  PunctualLight light;
  light.kind = PunctualKind::directional;
  light.direction = glm::normalize(Vec3(0.4f, -0.8f, 0.1f));
  light.intensity = Vec3(7);
  directional.lights.push_back(light);
  expect_flux(directional, 4 * albedo * 7 * -light.direction.y);
}

/// ∫ E dA over the floor patch by midpoints.
double floor_flux(const Scene& scene, const PunctualLight& light) {
  constexpr int cells = 400;
  double sum = 0;
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j) {
      const Vec3 x(-1 + 2 * (i + 0.5f) / cells, 0, -1 + 2 * (j + 0.5f) / cells);
      const LightConnection link = connect_punctual(light, scene, x);
      sum += link.irradiance.y * std::max(0.0f, link.wi.y);
    }
  return sum * 4 / (cells * cells);
}

TEST(LightPaths, PointsSpotsAndProjectors) {
  PunctualLight light;
  light.position = {0.3f, 0.7f, -0.2f};
  light.direction = glm::normalize(Vec3(0.2f, -1, 0.1f));
  light.up = glm::normalize(glm::cross(light.direction, Vec3(1, 0, 0)));
  light.intensity = Vec3(5);
  light.outer_cone = 0.9f, light.inner_cone = 0.3f;
  for (const bool ranged : {false, true}) {
    light.range = ranged ? 1.2f : infinity;
    for (int kind = 0; kind < 3; ++kind) {
      Scene scene = patch();
      ImageRgb slide(2, 2, Vec3(0.2f));
      slide.at(0, 0) = Vec3(2);
      scene.pictures.push_back(slide);
      light.kind = kind == 0 ? PunctualKind::point : PunctualKind::spot;
      light.picture = kind == 2 ? 0 : -1;
      scene.lights.push_back(light);
      expect_flux(scene, albedo * floor_flux(scene, light));
    }
  }
}

TEST(LightPaths, EmittersAreChosenByPowerAndEmitFromTheirSides) {
  // A small lamp over the patch and a strong one that faces away: lights of very different power, one
  // weightless.
  Scene scene = patch();
  Material lamp = diffuse_material(Vec3(0)), other = lamp;
  lamp.emission = Vec3(4), lamp.double_sided = true;
  other.emission = Vec3(1);
  scene.materials.push_back(lamp), scene.materials.push_back(other);
  add_patch(scene, {-0.1f, 0.5f, -0.1f}, {0.2f, 0, 0}, {0, 0, 0.2f}, 1);
  add_patch(scene, {-0.5f, 0.9f, 0.5f}, {1, 0, 0}, {0, 0, -1}, 2);  // faces up
  constexpr int cells = 200;
  double form = 0;  // ∫∫ cos cos'/r² dA dA', the lamp as 4×4 pieces
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j)
      for (int k = 0; k < 16; ++k) {
        const Vec3 d = Vec3(-1 + 2 * (i + 0.5f) / cells, 0, -1 + 2 * (j + 0.5f) / cells) -
                       Vec3(-0.1f + 0.05f * (k % 4 + 0.5f), 0.5f, -0.1f + 0.05f * (k / 4 + 0.5f));
        form += 0.25 / std::pow(glm::dot(d, d), 2);
      }
  expect_flux(scene, albedo * 4 * form * (4.0 / (cells * cells)) * (0.04 / 16));
}

/// A closed cube whose walls all emit 1 and return `albedo`: the radiance inside is 1/(1 − albedo)
/// everywhere.
Scene furnace(Vec3 reflectance) {
  Scene scene;
  Material wall = diffuse_material(reflectance);
  wall.emission = Vec3(1);
  scene.materials.push_back(wall);
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 u(0), v(0), n(0);
    u[(axis + 1) % 3] = v[(axis + 2) % 3] = n[axis] = 2;
    add_patch(scene, Vec3(-1), u, v);  // front towards +axis, which is inside
    add_patch(scene, Vec3(-1) + n, v, u);
  }
  return scene;
}

/// In the middle, so that no wall is near.
std::vector<GBufferTexel> middle_pixels() {
  std::vector<GBufferTexel> pixels;
  for (const Vec3 n : {Vec3(0, 1, 0), glm::normalize(Vec3(1, -1, 0.3f))})
    pixels.push_back(seen_point(Vec3(0), n, diffuse_brdf(Vec3(1)), n));
  return pixels;
}

TEST(Instant, ClosedBoxGivesTheGeometricSeries) {
  const Vec3 reflectance(0.6f, 0.5f, 0.2f);
  for (const char* threshold : {"0", "1.5"}) {
    TracedScene s(furnace(reflectance), middle_pixels(), {.emitters = true, .surfaces = true});
    const auto technique = make_technique(s, "instant",
                                          {"instant.sets=redrawn", "instant.min-distance=0",
                                           std::string("instant.roulette-threshold=") + threshold});
    for (int channel = 0; channel < 3; ++channel) {
      const PassMoments m = pass_moments(s, *technique, 2, 1500, channel);
      const double exact = 1 / (1 - static_cast<double>(reflectance[channel]));
      for (size_t i = 0; i < m.mean.size(); ++i) {
        EXPECT_NEAR(m.mean[i], exact, 3.8 * m.error(i)) << threshold << " " << channel;
        EXPECT_LT(3.8 * m.error(i), 0.02 * exact);
      }
    }
  }
}

TEST(Instant, DirectAndIndirectLightApart) {
  for (const bool direct : {true, false}) {
    TracedScene s(furnace(Vec3(0.5f)), middle_pixels(), {.emitters = direct, .surfaces = !direct});
    const auto technique = make_technique(s, "instant", {"instant.sets=redrawn", "instant.min-distance=0"});
    const PassMoments m = pass_moments(s, *technique, 2, 400);
    for (size_t i = 0; i < m.mean.size(); ++i) EXPECT_NEAR(m.mean[i], 1, 3.8 * m.error(i)) << direct;
  }
}

TEST(Instant, FadeTakesLightOfNearLightsOnly) {
  // All walls are at 1 or further from the middle, and at √3 or nearer.
  const auto mean = [](const char* distance) {
    TracedScene s(furnace(Vec3(0.5f)), middle_pixels(), {.surfaces = true});
    const auto technique =
        make_technique(s, "instant",
                       {"instant.sets=redrawn", "instant.distance-unit=absolute",
                        "instant.roulette-threshold=0", std::string("instant.min-distance=") + distance});
    return pass_moments(s, *technique, 2, 100).mean[0];
  };
  const double whole = mean("0");
  EXPECT_EQ(mean("0.9"), whole);  // 1.2 · 0.81 < 1
  const double some = mean("1.2");
  EXPECT_LT(some, 0.95 * whole);
  EXPECT_GT(some, 0.05 * whole);
  EXPECT_EQ(mean("2"), 0);  // 0.8 · 4 > 3
}

TEST(Instant, KeptSetsServeEverySampleAndEachHalfHasItsOwn) {
  TracedScene s(furnace(Vec3(0.5f)), middle_pixels(), {.surfaces = true});
  const auto technique = make_technique(
      s, "instant", {"instant.light-paths=1", "instant.light-sets=8", "instant.roulette-threshold=0"});
  // Four samples of a half go round its four sets: the next four add nothing new.
  const auto first = one_pass(s, *technique, 0, 4), later = one_pass(s, *technique, 2, 4);
  for (size_t i = 0; i < first.size(); ++i) EXPECT_NEAR(first[i].y, later[i].y, 1e-5 * first[i].y);
  EXPECT_NE(one_pass(s, *technique, 1, 4)[0].y, first[0].y) << "the other half has other sets";
  s.frame.seed = 1;
  technique->prepare(s.frame);
  EXPECT_NE(one_pass(s, *technique, 0, 4)[0].y, first[0].y) << "another seed, other sets";
}

TEST(Instant, WhiteAndGainingBoxesEnd) {
  // Albedo 1 never ends by roulette, and this lobe with this lambertian part returns more than arrives.
  Scene scene = furnace(Vec3(1));
  scene.materials[0].phong_specular = Vec3(0.9f);
  TracedScene s(scene, middle_pixels(), {.surfaces = true});
  const auto technique = make_technique(s, "instant", {"instant.light-paths=1", "instant.light-sets=1"});
  EXPECT_GT(one_pass(s, *technique, 0, 1)[0].y, 0);
}

TEST(Instant, IsBiasedAndHasItsOwnTarget) {
  const TechniqueInfo& info = find_technique("instant");
  EXPECT_EQ(info.bias, Bias::biased);
  EXPECT_EQ(info.target, TargetSupport::own);
  EXPECT_FALSE(uses_light_set(info, choose_target(info, std::nullopt)));
}

}  // namespace
}  // namespace halflight
