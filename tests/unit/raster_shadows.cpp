// Light of the punctual lights through shadow maps: surface points and pixels, against `connect_punctual`,
// `evaluate` and visibility by brute force. Points within a few texels of a shadow's edge are left out: the
// maps blur there.
#include "lights/virtual_light.h"
#include "unit/raster_scenes.h"

namespace halflight {
namespace {

using namespace test;

class RasterShadows : public OnBackend {};
HALFLIGHT_ON_BACKENDS(RasterShadows);

/// A floor, two boxes on it and a sphere above, with materials of all three models.
Scene shadow_scene() {
  Scene scene;
  Material floor = diffuse_material(Vec3(0.7f, 0.6f, 0.5f));
  floor.roughness = 0.5f;
  Material phong;
  phong.model = BrdfModel::phong;
  phong.diffuse = Vec3(0.5f);
  phong.phong_specular = Vec3(0.6f);
  phong.exponents = {3, 0};
  Material ashikhmin = phong;
  ashikhmin.model = BrdfModel::ashikhmin_shirley;
  ashikhmin.exponents = {20, 60};
  scene.materials = {floor, phong, ashikhmin};
  add_quad(scene, {-5, 0, 5}, {5, 0, 0}, {0, 0, -10}, 0);
  add_quad(scene, {0, 0, 5}, {5, 0, 0}, {0, 0, -10}, 1);
  add_box(scene, {-1.5f, 0, -1}, {-0.5f, 1.2f, 0}, 1);
  add_box(scene, {1, 0, -2}, {2, 2, -1}, 2);
  add_sphere(scene, {0.4f, 0.9f, 0.6f}, 0.4f, 6, 0);
  update_bounds(scene);
  return scene;
}

PunctualLight make_light(PunctualKind kind) {
  PunctualLight light;
  light.kind = kind;
  light.position = {2.5f, 4, 3};
  light.direction = glm::normalize(Vec3(-0.5f, -0.8f, -0.6f));
  light.up = basis_along(light.direction, {0, 1, 0}).tangent;
  light.intensity = kind == PunctualKind::directional ? Vec3(3, 2, 1) : Vec3(60, 50, 40);
  light.inner_cone = 0.4f;
  light.outer_cone = 0.6f;
  return light;
}

Camera shadow_camera() { return look_at({1, 4, 6}, {0, 0.3f, 0}, {0, 1, 0}, 0.9f); }

/// Points of the floor on a grid, plus some of the walls.
std::vector<BouncePoint> grid_points(float factor) {
  std::vector<BouncePoint> points;
  for (int j = 0; j < 40; ++j)
    for (int i = 0; i < 40; ++i) {
      BouncePoint p{};
      p.position =
          factor * Vec3(-4.9f + 0.25f * static_cast<float>(i), 0, -4.9f + 0.25f * static_cast<float>(j));
      p.normal = (i + j) % 2 == 0 ? Vec3(0, 1, 0) : Vec3(0, -1, 0);
      points.push_back(p);
    }
  return points;
}

/// Visibility of a light from x: 1 or 0, or nothing where points `margin` to the side see it differently.
std::optional<float> clear_visibility(const Scene& scene, const PunctualLight& light, Vec3 x, Vec3 n,
                                      float margin) {
  const float offset = 1e-4f * scene.bounds.diagonal();
  const Basis side = basis_around(n);
  int visible = 0, total = 0;
  for (const Vec2 move : {Vec2(0), Vec2(1, 0), Vec2(-1, 0), Vec2(0, 1), Vec2(0, -1), Vec2(0.7f), Vec2(-0.7f),
                          Vec2(0.7f, -0.7f), Vec2(-0.7f, 0.7f)}) {
    const Vec3 at = x + margin * (move.x * side.tangent + move.y * side.bitangent);
    const LightConnection connection = connect_punctual(light, scene, at);
    visible += brute_visible(scene, at, n, connection.wi, connection.distance, offset);
    ++total;
  }
  if (visible != 0 && visible != total) return std::nullopt;
  return visible != 0 ? 1.0f : 0.0f;
}

float relative_difference(Vec3 a, Vec3 b) {
  const float size = std::max(max_component(glm::abs(a)), max_component(glm::abs(b)));
  return size > 0 ? max_component(glm::abs(a - b)) / size : 0;
}

/// Share of the unambiguous points whose irradiance is within 1 %; also counts them, lit and shadowed.
struct Agreement {
  int good = 0, lit = 0, shadowed = 0;
  double share() const { return good / static_cast<double>(lit + shadowed); }
};

Agreement compare_points(const Scene& scene, const std::vector<BouncePoint>& points,
                         const std::vector<Vec3>& irradiance, float margin) {
  Agreement result;
  for (size_t i = 0; i < points.size(); ++i) {
    Vec3 expected[2] = {Vec3(0), Vec3(0)};
    bool clear = true;
    for (const PunctualLight& light : scene.lights) {
      const LightConnection connection = connect_punctual(light, scene, points[i].position);
      const float cosine = glm::dot(points[i].normal, connection.wi);
      if (!(max_component(connection.irradiance) > 0)) continue;
      const Vec3 n = cosine < 0 ? -points[i].normal : points[i].normal;
      const auto visible = clear_visibility(scene, light, points[i].position, n, margin);
      clear = clear && visible.has_value();
      if (visible) expected[cosine < 0 ? 1 : 0] += *visible * std::abs(cosine) * connection.irradiance;
    }
    if (!clear) continue;
    const bool good = relative_difference(irradiance[2 * i], expected[0]) < 0.01f &&
                      relative_difference(irradiance[2 * i + 1], expected[1]) < 0.01f;
    result.good += good;
    ++(max_component(expected[0] + expected[1]) > 0 ? result.lit : result.shadowed);
  }
  return result;
}

/// Pixels against Σ f · cos θ · E with brute-force visibility.
Agreement compare_pixels(const Scene& scene, const GBuffer& gbuffer, const std::vector<Vec3>& radiance,
                         float margin) {
  std::vector<int> outcome(gbuffer.pixel_count(), 0);
  parallel_for(0, gbuffer.pixel_count(), 64, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const GBufferTexel& texel = gbuffer.texels[i];
      if (!texel.hit()) continue;
      Vec3 expected(0);
      bool clear = true;
      for (const PunctualLight& light : scene.lights) {
        const LightConnection connection = connect_punctual(light, scene, texel.position);
        const float cosine = glm::dot(texel.shading_normal, connection.wi);
        if (cosine <= 0 || glm::dot(texel.geometric_normal, connection.wi) <= 0) continue;
        const Vec3 value =
            evaluate(texel.brdf, texel.basis(), texel.wo, connection.wi) * connection.irradiance * cosine;
        if (!(max_component(value) > 0)) continue;
        const auto visible = clear_visibility(scene, light, texel.position, texel.geometric_normal, margin);
        clear = clear && visible.has_value();
        if (visible) expected += *visible * value;
      }
      if (!clear) continue;
      const bool good = relative_difference(radiance[i], expected) < 0.02f;
      outcome[i] = (good ? 1 : 0) + (max_component(expected) > 0 ? 2 : 4);
    }
  });
  Agreement result;
  for (const int o : outcome)
    result.good += o & 1, result.lit += (o & 2) != 0, result.shadowed += (o & 4) != 0;
  return result;
}

struct Case {
  const char* name;
  std::vector<PunctualLight> lights;
  bool lights_some = true, shadows_some = true;  ///< of the floor's points
};

std::vector<Case> light_cases() {
  PunctualLight wide = make_light(PunctualKind::spot);
  wide.outer_cone = 1.5f;
  PunctualLight ranged = make_light(PunctualKind::point);
  ranged.range = 6;
  PunctualLight projector = make_light(PunctualKind::spot);
  projector.picture = 0;
  PunctualLight below = make_light(PunctualKind::point);
  below.position = {0.3f, -2, 0.2f};
  PunctualLight inside = make_light(PunctualKind::point);
  inside.position = {-1, 0.6f, -0.5f};
  return {{"point", {make_light(PunctualKind::point)}},
          {"spot", {make_light(PunctualKind::spot)}},
          {"directional", {make_light(PunctualKind::directional)}},
          {"wide spot", {wide}},
          {"ranged", {ranged}},
          {"projector", {projector}},
          {"below the floor", {below}, true, false},
          {"inside a box", {inside}},
          {"several", {ranged, projector, make_light(PunctualKind::directional), below}, true, false}};
}

Scene with_lights(const std::vector<PunctualLight>& lights) {
  Scene scene = shadow_scene();
  ImageRgb picture(4, 3);
  for (size_t i = 0; i < picture.pixels.size(); ++i)
    picture.pixels[i] = Vec3(static_cast<float>(i % 4), static_cast<float>(i / 4), 1) * 0.5f;
  scene.pictures.push_back(picture);
  scene.lights = lights;
  return scene;
}

TEST_P(RasterShadows, SurfacePointsReceiveWhatReachesThem) {
  Scene scene = with_lights({});
  Rasterizer raster(*context, scene, {}, messages);
  for (const Case& c : light_cases()) {
    SCOPED_TRACE(c.name);
    scene.lights = c.lights;
    raster.update_shadow_maps();
    const auto points = grid_points(1);
    const Agreement agreement = compare_points(scene, points, raster.light_points(points), 0.05f);
    EXPECT_GE(agreement.share(), 0.995);
    EXPECT_GT(agreement.lit + agreement.shadowed, 1000);
    EXPECT_EQ(agreement.lit > 5, c.lights_some);
    EXPECT_EQ(agreement.shadowed > 5, c.shadows_some);
  }
}

TEST_P(RasterShadows, PixelsReceiveWhatReachesThem) {
  Scene scene = with_lights({});
  Rasterizer raster(*context, scene, {}, messages);
  GBuffer gbuffer;
  gbuffer.resize(80, 60);
  raster.draw_gbuffer(shadow_camera(), Vec2(0), 0, gbuffer);
  for (const Case& c : light_cases()) {
    SCOPED_TRACE(c.name);
    scene.lights = c.lights;
    std::vector<Vec3> radiance(gbuffer.pixel_count(), Vec3(0));
    raster.add_punctual(gbuffer, radiance);
    const Agreement agreement = compare_pixels(scene, gbuffer, radiance, 0.04f);
    EXPECT_GE(agreement.share(), 0.99) << agreement.lit << " lit, " << agreement.shadowed << " not";
    EXPECT_GT(agreement.lit + agreement.shadowed, 2000);
  }
}

TEST_P(RasterShadows, LengthUnitsDoNotMatter) {
  for (const float factor : {1e-6f, 1e6f}) {
    SCOPED_TRACE(factor);
    Scene scene = with_lights({make_light(PunctualKind::point), make_light(PunctualKind::directional)});
    Camera camera = shadow_camera();
    scale_lengths(scene, camera, factor);
    Rasterizer raster(*context, scene, {}, messages);
    const auto points = grid_points(factor);
    EXPECT_GE(compare_points(scene, points, raster.light_points(points), 0.05f * factor).share(), 0.99);
    GBuffer gbuffer;
    gbuffer.resize(64, 48);
    raster.draw_gbuffer(camera, Vec2(0), 0, gbuffer);
    std::vector<Vec3> radiance(gbuffer.pixel_count(), Vec3(0));
    raster.add_punctual(gbuffer, radiance);
    EXPECT_GE(compare_pixels(scene, gbuffer, radiance, 0.04f * factor).share(), 0.99);
  }
}

TEST_P(RasterShadows, AFlatFloorNeverShadowsItself) {
  Scene scene;
  scene.materials.push_back(diffuse_material(Vec3(0.5f)));
  // Tilted, so that no texel row lies along it
  const Vec3 a = 10.0f * glm::normalize(Vec3(1, 0.2f, 0.1f)),
             b = 10.0f * glm::normalize(Vec3(0.13f, 0.3f, -1));
  add_quad(scene, -0.5f * (a + b), a, b, 0);
  update_bounds(scene);
  const Vec3 n = glm::normalize(glm::cross(a, b));
  std::vector<BouncePoint> points;
  RandomStream random(0, 0, 1);
  for (int i = 0; i < 4000; ++i) {
    BouncePoint p{};
    p.position = (random.next() - 0.5f) * 0.98f * a + (random.next() - 0.5f) * 0.98f * b;
    p.normal = n;
    points.push_back(p);
  }
  Rasterizer raster(*context, scene, {}, messages);
  for (const float elevation : {90.0f, 45.0f, 10.0f, 3.0f, 1.0f}) {
    SCOPED_TRACE(elevation);
    const float angle = elevation * pi / 180;
    const Vec3 to_light = std::sin(angle) * n + std::cos(angle) * glm::normalize(a);
    PunctualLight sun = make_light(PunctualKind::directional), lamp = make_light(PunctualKind::point);
    sun.direction = -to_light;
    lamp.position = 7.0f * to_light;
    for (const PunctualLight& light : {sun, lamp}) {
      scene.lights = {light};
      const auto irradiance = raster.light_points(points);
      int dark = 0;
      for (size_t i = 0; i < points.size(); ++i) {
        const LightConnection c = connect_punctual(light, scene, points[i].position);
        dark += relative_difference(irradiance[2 * i], c.irradiance * glm::dot(n, c.wi)) > 1e-3f;
        EXPECT_EQ(irradiance[2 * i + 1], Vec3(0));
      }
      EXPECT_LE(dark, 4);
    }
  }
}

TEST_P(RasterShadows, LightPassesThroughTheHolesOfMasks) {
  Scene scene;
  scene.materials.push_back(diffuse_material(Vec3(0.5f)));
  Material mask = diffuse_material(Vec3(1));
  mask.alpha_mode = AlphaMode::mask;
  mask.base_color_texture =
      add_texture(scene, {2, 1, {255, 255, 255, 0, 255, 255, 255, 255}}, true, Wrap::clamp, true);
  scene.materials.push_back(mask);
  add_quad(scene, {-5, 0, 5}, {10, 0, 0}, {0, 0, -10}, 0);
  add_quad(scene, {-1, 1, 1}, {2, 0, 0}, {0, 0, -2}, 1);
  update_bounds(scene);
  scene.lights.push_back(make_light(PunctualKind::point));
  scene.lights[0].position = {0, 3, 0};
  Rasterizer raster(*context, scene, {}, messages);
  BouncePoint hole{}, shadow{};
  hole.position = {-0.7f, 0, 0.2f}, shadow.position = {0.7f, 0, 0.2f};
  hole.normal = shadow.normal = {0, 1, 0};
  const auto irradiance = raster.light_points({hole, shadow});
  EXPECT_GT(irradiance[0].x, 1.0f);
  EXPECT_EQ(irradiance[2], Vec3(0));
}

TEST_P(RasterShadows, MapsFollowLightsThatMoveAndMultiply) {
  Scene scene = with_lights({make_light(PunctualKind::point)});
  Rasterizer raster(*context, scene, {}, messages);
  const auto points = grid_points(1);
  raster.light_points(points);
  scene.lights[0].position = {-3, 3, -2};
  EXPECT_GE(compare_points(scene, points, raster.light_points(points), 0.05f).share(), 0.995);
  for (int i = 0; i < 15; ++i) {
    scene.lights.push_back(make_light(static_cast<PunctualKind>(i % 3)));
    scene.lights.back().position += Vec3(0.2f * static_cast<float>(i), 0.1f * static_cast<float>(i), 0);
    scene.lights.back().intensity *= 1 + static_cast<float>(i);
  }
  EXPECT_GE(compare_points(scene, points, raster.light_points(points), 0.05f).share(), 0.99);
  scene.lights.clear();
  for (const Vec3 e : raster.light_points(points)) EXPECT_EQ(e, Vec3(0));
}

}  // namespace
}  // namespace halflight
