#include <gtest/gtest.h>

#include <array>

#include "core/parallel.h"
#include "support/simple_scenes.h"
#include "trace/ray_gbuffer.h"

namespace halflight {
namespace {

BouncePoint floor_point(Vec3 position) {
  BouncePoint point;
  point.position = position;
  point.area = 1;
  point.normal = {0, 1, 0};
  point.surface = {0, {0.3f, 0.3f}};
  point.albedo = Vec3(0.5f);
  return point;
}

/// Mean over independent copies of one point, front and back.
std::pair<double, double> mean_irradiance(const Scene& scene, Vec3 position, int samples = 16) {
  const RayScene rays(scene);
  const std::vector<BouncePoint> points(4000, floor_point(position));
  PointLighting lighting;
  lighting.samples = samples;
  RayCounters counters;
  const std::vector<Vec3> irradiance = irradiance_by_rays(rays, points, lighting, counters);
  double front = 0, back = 0;
  for (size_t i = 0; i < points.size(); ++i) front += irradiance[2 * i].y, back += irradiance[2 * i + 1].y;
  return {front / static_cast<double>(points.size()), back / static_cast<double>(points.size())};
}

TEST(PointLighting, ConstantEnvironmentGivesPiOnEachSide) {
  Scene scene = floor_scene(1e-3f);
  scene.environment = constant_environment(Vec3(2));
  const auto [front, back] = mean_irradiance(scene, {0, 0, 0});
  EXPECT_NEAR(front, 2 * pi, 0.01 * pi);
  EXPECT_NEAR(back, 2 * pi, 0.01 * pi);
}

TEST(PointLighting, AWallHalvesTheSky) {
  Scene scene = floor_scene(1e-3f);
  add_patch(scene, {1e-4f, -1e5f, 1e5f}, {0, 0, -2e5f}, {0, 2e5f, 0});  // everything towards +x is hidden
  scene.environment = constant_environment(Vec3(1));
  const auto [front, back] = mean_irradiance(scene, {0, 0, 0});
  EXPECT_NEAR(front, pi / 2, 0.01 * pi);
  EXPECT_NEAR(back, pi / 2, 0.01 * pi);
}

TEST(PointLighting, SquareEmitterAgreesWithTheFormFactor) {
  // Parallel square of half edge a at height h over the point: F = (2/π)·4·[X/√(1+X²) atan(X/√(1+X²))]/... by
  // corners.
  constexpr float a = 0.7f, h = 1.3f, radiance = 3;
  Scene scene = floor_scene(10);
  Material lamp = diffuse_material(Vec3(0));
  lamp.emission = Vec3(radiance);
  scene.materials.push_back(lamp);
  add_patch(scene, {-a, h, -a}, {2 * a, 0, 0}, {0, 0, 2 * a}, 1);  // faces down
  // Four rectangles a × a with a corner above the point (Howell, configuration B-3): X = Y = a/h.
  const double x = a / h, root = std::sqrt(1 + x * x);
  const double corner = 1 / (2 * 3.141592653589793) * 2 * (x / root) * std::atan(x / root);
  const double expected = radiance * 3.141592653589793 * 4 * corner;
  const auto [front, back] = mean_irradiance(scene, {0, 0, 0});
  EXPECT_NEAR(front, expected, 0.01 * expected);
  EXPECT_EQ(back, 0);
}

/// A lamp over the origin whose emission's picture has two texels side by side along x.
Scene pictured_lamp(std::array<uint8_t, 8> texels, AlphaMode mode) {
  Scene scene = floor_scene(10);
  ImageRgba8 picture;
  picture.width = 2, picture.height = 1;
  picture.bytes.assign(texels.begin(), texels.end());
  scene.images.push_back(picture);
  scene.textures.emplace_back();
  scene.textures[0].nearest = true;
  Material lamp = diffuse_material(Vec3(0));
  lamp.emission = Vec3(3);
  lamp.emission_texture.texture = lamp.base_color_texture.texture = 0;
  lamp.alpha_mode = mode;
  scene.materials.push_back(lamp);
  add_patch(scene, {-0.7f, 1.3f, -0.7f}, {1.4f, 0, 0}, {0, 0, 1.4f}, 1);
  return scene;
}

TEST(PointLighting, PicturesAndHolesOfEmittersCount) {
  constexpr uint8_t f = 255;
  const double full =
      mean_irradiance(pictured_lamp({f, f, f, f, f, f, f, f}, AlphaMode::opaque), {0, 0, 0}).first;
  // Half of the lamp dark, or a hole: half of the light, by symmetry.
  for (const double half :
       {mean_irradiance(pictured_lamp({f, f, f, f, 0, 0, 0, f}, AlphaMode::opaque), {0, 0, 0}).first,
        mean_irradiance(pictured_lamp({f, f, f, f, f, f, f, 0}, AlphaMode::mask), {0, 0, 0}).first})
    EXPECT_NEAR(half, full / 2, 0.01 * full);
  const double pale =
      mean_irradiance(pictured_lamp({f, f, f, 51, f, f, f, 51}, AlphaMode::blend), {0, 0, 0}).first;
  EXPECT_NEAR(pale, 0.2 * full, 0.01 * full);
}

TEST(PointLighting, AOneTexelSunIsNeverMissed) {
  Scene scene = floor_scene(1e-3f);
  scene.environment = constant_environment(Vec3(0), 512);
  scene.environment.map.at(100, 60) = Vec3(1e6f);
  scene.environment.rotation = 1.1f;
  scene.environment.strength = 0.5f;
  const Vec3 sun = environment_direction(scene.environment, {100.5f / 512, 60.5f / 256});
  const double expected = 0.5e6 * static_cast<double>(texel_solid_angle(scene.environment, 60) * sun.y);
  const auto [front, back] = mean_irradiance(scene, {0, 0, 0}, 2);
  EXPECT_NEAR(front, expected, 2e-3 * expected);
  EXPECT_EQ(back, 0);
}

TEST(PointLighting, EmittersAndEnvironmentTogetherAddUp) {
  Scene scene = floor_scene(1e-3f);
  Material lamp = diffuse_material(Vec3(0));
  lamp.emission = Vec3(30);
  lamp.double_sided = true;
  scene.materials.push_back(lamp);
  add_patch(scene, {-0.1f, 1, -0.1f}, {0.2f, 0, 0}, {0, 0, 0.2f}, 1);
  const double lamp_only = mean_irradiance(scene, {0, 0, 0}).first;
  scene.environment = constant_environment(Vec3(0.5f));
  const double x = 0.1, root = std::sqrt(1 + x * x),
               hidden = 4 / 3.141592653589793 * (x / root) * std::atan(x / root);
  const double expected = lamp_only + 0.5 * 3.141592653589793 * (1 - hidden);
  EXPECT_NEAR(mean_irradiance(scene, {0, 0, 0}).first, expected, 0.02 * expected);
}

TEST(PointLighting, PunctualLightsByInverseSquareAndShadow) {
  Scene scene = floor_scene(10);
  PunctualLight lamp;
  lamp.position = {0, 2, 0};
  lamp.intensity = Vec3(8);
  scene.lights.push_back(lamp);
  EXPECT_NEAR(mean_irradiance(scene, {0, 0, 0}).first, 8.0 / 4, 1e-4);
  const double r2 = 4 + 2.25, expected = 8 / r2 * (2 / std::sqrt(r2));
  EXPECT_NEAR(mean_irradiance(scene, {1.5f, 0, 0}).first, expected, 1e-4);
  add_patch(scene, {-0.5f, 1, 0.5f}, {1, 0, 0}, {0, 0, -1});
  EXPECT_EQ(mean_irradiance(scene, {0, 0, 0}).first, 0);
  EXPECT_NEAR(mean_irradiance(scene, {1.5f, 0, 0}).first, expected, 1e-4);
}

TEST(PointLighting, SameBitsForAnyNumberOfThreads) {
  Scene scene = floor_scene(10);
  scene.environment = constant_environment(Vec3(1));
  const RayScene rays(scene);
  std::vector<BouncePoint> points;
  for (int i = 0; i < 500; ++i) points.push_back(floor_point({0.01f * static_cast<float>(i), 0, 0}));
  RayCounters counters;
  std::vector<std::vector<Vec3>> results;
  for (const int threads : {1, 2, 5}) {
    set_thread_count(threads);
    results.push_back(irradiance_by_rays(rays, points, {}, counters));
  }
  set_thread_count(0);
  EXPECT_EQ(results[0], results[1]);
  EXPECT_EQ(results[0], results[2]);
}

TEST(RayGBuffer, SeesTheFloorAndTheSky) {
  Scene scene = floor_scene(1000, Vec3(0.2f, 0.4f, 0.6f));
  scene.environment = constant_environment(Vec3(3, 2, 1));
  const RayScene rays(scene);
  GBuffer gbuffer;
  gbuffer.resize(31, 21);
  RayCounters counters;
  const Camera camera = look_at({0, 2, 5}, {0, 2, 0}, {0, 1, 0}, 0.9f);
  trace_gbuffer(rays, camera, Vec2(0), 0, gbuffer, counters);
  EXPECT_EQ(counters.closest, 31u * 21u);
  const GBufferTexel& sky = gbuffer.texels[15];
  EXPECT_FALSE(sky.hit());
  EXPECT_EQ(sky.emission, Vec3(3, 2, 1));
  const GBufferTexel& floor = gbuffer.texels[20 * 31 + 15];
  ASSERT_TRUE(floor.hit());
  EXPECT_NEAR(floor.position.y, 0, 1e-5f);
  EXPECT_NEAR(floor.shading_normal.y, 1, 1e-6f);
  EXPECT_EQ(floor.brdf.diffuse, Vec3(0.2f, 0.4f, 0.6f));
  // The centre of the last row's middle pixel looks down by atan(tan(fov/2) · 20/21).
  const float down = std::tan(0.45f) * 20 / 21;
  EXPECT_NEAR(floor.position.z, 5 - 2 / down, 1e-3f);
  EXPECT_GT(glm::dot(floor.wo, floor.shading_normal), 0);
}

TEST(RayGBuffer, JitterMovesThePointSeen) {
  const Scene scene = floor_scene(1000);
  const RayScene rays(scene);
  RayCounters counters;
  GBuffer gbuffer;
  gbuffer.resize(16, 16);
  // From 4 above, straight down, 90° wide: a pixel is 8/16 of a unit of floor.
  const Camera camera = look_at({0, 4, 0}, {0, 0, 0}, {0, 0, -1}, pi / 2);
  for (const Vec2 jitter : {Vec2(0), Vec2(-0.5f, 0.25f), Vec2(0.499f, -0.125f)}) {
    trace_gbuffer(rays, camera, jitter, 0, gbuffer, counters);
    for (const int pixel : {0, 37, 255}) {
      const GBufferTexel& texel = gbuffer.texels[static_cast<size_t>(pixel)];
      const Vec2 at = Vec2(pixel % 16, pixel / 16) + 0.5f + jitter - 8.0f;
      EXPECT_NEAR(texel.position.x, 0.5f * at.x, 1e-4f);
      EXPECT_NEAR(texel.position.z, 0.5f * at.y, 1e-4f);
    }
  }
}

/// A unit sphere about the origin with smooth normals.
Scene sphere_scene(int rings) {
  Scene scene;
  scene.materials.push_back(diffuse_material(Vec3(0.5f)));
  const int columns = 2 * rings;
  for (int i = 0; i <= rings; ++i) {
    for (int j = 0; j <= columns; ++j) {
      const float theta = pi * i / rings, phi = 2 * pi * j / columns;
      const Vec3 n(std::sin(theta) * std::cos(phi), std::cos(theta), -std::sin(theta) * std::sin(phi));
      scene.vertices.push_back({n, n, Vec4(0), {Vec2(0), Vec2(0)}, 0xffffffffu});
    }
  }
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < columns; ++j) {
      const auto a = static_cast<uint32_t>(i * (columns + 1) + j), b = a + static_cast<uint32_t>(columns) + 1;
      scene.triangles.insert(scene.triangles.end(), {{a, b, a + 1}, {a + 1, b, b + 1}});
    }
  }
  scene.triangle_material.assign(scene.triangles.size(), 0);
  update_bounds(scene);
  return scene;
}

TEST(RayGBuffer, SphereIsWhereItsEquationSays) {
  const Scene scene = sphere_scene(200);
  const RayScene rays(scene);
  RayCounters counters;
  GBuffer gbuffer;
  gbuffer.resize(64, 48);
  const Camera camera = look_at({1, 2, 3}, {0.2f, 0.1f, 0}, {0, 1, 0}, 0.7f);
  trace_gbuffer(rays, camera, Vec2(0), 0, gbuffer, counters);
  int hits = 0;
  for (int i = 0; i < 64 * 48; ++i) {
    const GBufferTexel& texel = gbuffer.texels[static_cast<size_t>(i)];
    const CameraRay ray = camera_ray(camera, {i % 64 + 0.5f, i / 64 + 0.5f}, 64, 48);
    const float b = glm::dot(ray.origin, ray.direction), d = b * b - glm::dot(ray.origin, ray.origin) + 1;
    if (std::abs(d) < 0.01f) continue;  // the silhouette of the polygons differs
    EXPECT_EQ(texel.hit(), d > 0);
    if (!texel.hit()) continue;
    ++hits;
    const Vec3 exact = ray.origin + (-b - std::sqrt(d)) * ray.direction;
    EXPECT_LT(glm::length(texel.position - exact), 3e-3f);
    EXPECT_GT(glm::dot(texel.shading_normal, exact), 0.9999f);
  }
  EXPECT_GT(hits, 500);
}

TEST(RayGBuffer, SameForAnyNumberOfThreads) {
  const Scene scene = sphere_scene(40);
  const RayScene rays(scene);
  std::vector<std::vector<Vec3>> positions;
  for (const int threads : {1, 4}) {
    set_thread_count(threads);
    RayCounters counters;
    GBuffer gbuffer;
    gbuffer.resize(40, 30);
    trace_gbuffer(rays, look_at({1, 2, 3}, {0, 0, 0}, {0, 1, 0}, 0.7f), Vec2(0.1f), 0, gbuffer, counters);
    EXPECT_EQ(counters.closest, 1200u);
    positions.emplace_back();
    for (const GBufferTexel& texel : gbuffer.texels) positions.back().push_back(texel.position);
  }
  set_thread_count(0);
  EXPECT_EQ(positions[0], positions[1]);
}

TEST(RayGBuffer, DirectPunctualLightIsTheRenderingEquation) {
  Scene scene = floor_scene(1000, Vec3(0.5f));
  PunctualLight sun;
  sun.kind = PunctualKind::directional;
  sun.direction = glm::normalize(Vec3(1, -2, 0.5f));
  sun.intensity = Vec3(4, 2, 1);
  scene.lights.push_back(sun);
  const RayScene rays(scene);
  GBuffer gbuffer;
  gbuffer.resize(8, 8);
  RayCounters counters;
  trace_gbuffer(rays, look_at({0, 3, 0}, {0, 0, 0}, {0, 0, -1}, 0.5f), Vec2(0), 0, gbuffer, counters);
  std::vector<Vec3> radiance(64, Vec3(0));
  add_punctual_by_rays(rays, gbuffer, 0, radiance, counters);
  const Vec3 expected = 0.5f / pi * sun.intensity * -sun.direction.y;
  for (const Vec3& value : radiance)
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(value[c], expected[c], 1e-5f);
}

TEST(Completion, EnclosedSceneGetsALampAndOpenOneASky) {
  Messages messages;
  Scene box;
  box.materials.push_back(diffuse_material(Vec3(0.6f)));
  add_patch(box, {0, 0, 0}, {0, 0, 4}, {4, 0, 0});
  add_patch(box, {0, 3, 0}, {4, 0, 0}, {0, 0, 4});
  add_patch(box, {0, 0, 0}, {4, 0, 0}, {0, 3, 0});
  add_patch(box, {0, 0, 4}, {0, 3, 0}, {4, 0, 0});
  add_patch(box, {0, 0, 0}, {0, 3, 0}, {0, 0, 4});
  add_patch(box, {4, 0, 0}, {0, 0, 4}, {0, 3, 0});
  box.cameras.push_back(look_at({1, 1.5f, 1}, {3, 1, 3}, {0, 1, 0}, 1));
  complete_lights(box, RayScene(box), messages);
  EXPECT_TRUE(box.facts.added_lamp);
  ASSERT_EQ(box.lights.size(), 1u);
  EXPECT_GT(box.lights[0].position.y, 2);
  EXPECT_LT(box.lights[0].position.y, 3);
  EXPECT_EQ(messages.warnings.size(), 1u);
  // White walls show between a tenth of white and a little above it.
  const double floor_irradiance = mean_irradiance(box, {1.5f, 0, 2.5f}).first;
  EXPECT_GT(floor_irradiance, 0.1 * pi);
  EXPECT_LT(floor_irradiance, 1.5 * pi);

  Scene open = floor_scene(10);
  open.cameras.push_back(look_at({1, 1.5f, 1}, {0, 0, 0}, {0, 1, 0}, 1));
  complete_lights(open, RayScene(open), messages);
  EXPECT_TRUE(open.facts.added_sky);
  EXPECT_TRUE(open.environment.present());

  // Unlit surfaces show without light; what stands among them does not.
  Scene sign = floor_scene(10);
  sign.cameras = open.cameras;
  sign.materials.push_back(diffuse_material(Vec3(1)));
  sign.materials[1].unlit = true;
  add_patch(sign, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, 1);
  Scene only_signs = sign;
  only_signs.materials[0].unlit = true;
  complete_lights(sign, RayScene(sign), messages);
  EXPECT_TRUE(sign.facts.added_sky);
  complete_lights(only_signs, RayScene(only_signs), messages);
  EXPECT_FALSE(only_signs.facts.added_sky || only_signs.facts.added_lamp);

  Scene lit = floor_scene(10);
  lit.lights.emplace_back();
  complete_lights(lit, RayScene(lit), messages);
  EXPECT_FALSE(lit.facts.added_sky || lit.facts.added_lamp);
}

}  // namespace
}  // namespace halflight
