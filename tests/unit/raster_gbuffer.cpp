// The rasteriser's G-buffer against camera rays by brute force, analytic floors, and itself on the other back
// end.
#include <cstring>

#include "unit/raster_scenes.h"

namespace halflight {
namespace {

using namespace test;

class RasterGBuffer : public OnBackend {};
HALFLIGHT_ON_BACKENDS(RasterGBuffer);

TEST_P(RasterGBuffer, AFloorHasItsAnalyticPositions) {
  Scene scene;
  scene.materials.push_back(diffuse_material(Vec3(0.5f)));
  add_quad(scene, {-5, 0, 5}, {10, 0, 0}, {0, 0, -10}, 0);
  update_bounds(scene);
  const Camera camera = look_at({0, 2, 4}, {0, 0, 0}, {0, 1, 0}, 0.8f);
  Rasterizer raster(*context, scene, {}, messages);
  GBuffer gbuffer;
  gbuffer.resize(64, 48);
  raster.draw_gbuffer(camera, Vec2(0.25f, -0.5f), 0, gbuffer);
  int hits = 0;
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      const CameraRay ray = camera_ray(camera, Vec2(static_cast<float>(x) + 0.75f, y), 64, 48);
      const Vec3 expected = ray.origin - ray.direction * (ray.origin.y / ray.direction.y);
      const GBufferTexel& texel = gbuffer.texels[static_cast<size_t>(y * 64 + x)];
      const bool inside = ray.direction.y < 0 && std::max(std::abs(expected.x), std::abs(expected.z)) < 4.99f;
      if (!inside) continue;
      ASSERT_TRUE(texel.hit()) << x << ' ' << y;
      ++hits;
      EXPECT_LT(glm::length(texel.position - expected), 1e-5f * glm::length(expected - ray.origin));
      EXPECT_EQ(texel.geometric_normal, Vec3(0, 1, 0));
      EXPECT_LT(glm::length(texel.shading_normal - Vec3(0, 1, 0)), 1e-6f);
      EXPECT_EQ(texel.brdf.diffuse, Vec3(0.5f));
    }
  }
  EXPECT_GT(hits, 1500);
}

/// Every feature of a material at once: what the G-buffer must agree on with the rays.
Scene feature_scene() {
  Scene scene;
  const auto add = [&](const Material& m) {
    scene.materials.push_back(m);
    return static_cast<uint32_t>(scene.materials.size()) - 1;
  };
  const TextureUse color =
      add_texture(scene, noise_image(16, 16, {128, 150, 90, 255}, {100, 60, 80, 0}, 1), true);
  const TextureUse normals =
      add_texture(scene, noise_image(8, 8, {128, 128, 220, 255}, {70, 70, 30, 0}, 2), false);
  const TextureUse rough =
      add_texture(scene, noise_image(7, 5, {0, 128, 100, 255}, {0, 100, 90, 0}, 3), false, Wrap::mirror);
  const TextureUse holes =
      add_texture(scene, noise_image(6, 6, {200, 60, 60, 128}, {40, 40, 40, 127}, 4), true, Wrap::clamp);
  const TextureUse angle =
      add_texture(scene, noise_image(8, 8, {128, 128, 200, 255}, {120, 120, 50, 0}, 5), false);
  const TextureUse blocks = add_texture(
      scene, noise_image(5, 3, {128, 128, 128, 200}, {127, 127, 127, 55}, 6), true, Wrap::repeat, true);

  Material floor = diffuse_material(Vec3(0.9f, 0.8f, 0.7f));
  floor.base_color_texture = color;
  floor.base_color_texture.row_u = {3, 1, 0.2f};
  floor.base_color_texture.row_v = {-1, 3, -0.4f};
  floor.base_color_texture.uv_set = 1;
  add_quad(scene, {-4, -1, 3}, {8, 0, 0}, {0, 0, -9}, add(floor));

  Material metal;
  metal.metallic = 0.8f;
  metal.metallic_roughness_texture = rough;
  metal.normal_texture = normals;
  metal.normal_texture.row_u = {4, 0, 0};
  metal.normal_texture.row_v = {0, 4, 0};
  metal.normal_scale = 0.7f;
  metal.anisotropy = 0.8f;
  metal.anisotropy_rotation = 0.6f;
  metal.anisotropy_texture = angle;
  metal.ior = 1.8f;
  metal.specular = 0.7f;
  metal.specular_color = {0.5f, 0.9f, 1.2f};
  metal.specular_texture = blocks;
  metal.specular_color_texture = blocks;
  add_sphere(scene, {-1.2f, 0, 0}, 0.9f, 12, add(metal));

  Material mask = diffuse_material(Vec3(1));
  mask.base_color_texture = holes;
  mask.alpha_mode = AlphaMode::mask;
  mask.alpha_cutoff = 0.45f;
  add_quad(scene, {0.2f, -0.8f, 1}, {1.2f, 0, 0.3f}, {0, 1.2f, 0}, add(mask));
  Material blend = mask;
  blend.alpha_mode = AlphaMode::blend;
  add_quad(scene, {0.3f, 0.5f, 0.9f}, {0.9f, 0, 0}, {0, 0.6f, -0.2f}, add(blend));

  // Mirrored uv, seen from behind, with vertex colours
  Material wall = diffuse_material(Vec3(0.8f));
  wall.normal_texture = normals;
  wall.emission = {2, 1, 0.5f};
  wall.emission_texture = color;
  wall.double_sided = true;
  add_quad(scene, {2.6f, -1, -2}, {-2, 0, -1}, {0, 2.5f, 0}, add(wall), -1);
  for (size_t i = scene.vertices.size() - 4; i < scene.vertices.size(); ++i)
    scene.vertices[i].color = 0xff204080u + static_cast<uint32_t>(i % 4) * 0x00300a30u;
  Material one_sided = wall;
  one_sided.double_sided = false;
  add_quad(scene, {-3, -0.9f, -1}, {0, 0, -2}, {0, 2, 0}, add(one_sided));

  Material phong;
  phong.model = BrdfModel::phong;
  phong.diffuse = {0.4f, 0.3f, 0.2f};
  phong.phong_specular = Vec3(0.3f);
  phong.exponents = {40, 0};
  phong.base_color_texture = color;
  add_sphere(scene, {1.3f, -0.6f, 0.2f}, 0.4f, 8, add(phong));
  Material ashikhmin = phong;
  ashikhmin.model = BrdfModel::ashikhmin_shirley;
  ashikhmin.exponents = {10, 200};
  add_sphere(scene, {2.2f, -0.6f, 0.4f}, 0.4f, 8, add(ashikhmin));
  Material unlit = diffuse_material({0.2f, 0.6f, 0.9f});
  unlit.unlit = true;
  unlit.base_color_texture = blocks;
  add_box(scene, {-2.8f, -1, 1}, {-2.3f, -0.4f, 1.5f}, add(unlit));
  // A vertex without tangent, and one whose normal contradicts the winding
  scene.vertices[5].tangent = Vec4(0);
  for (Vertex& v : std::span(scene.vertices).last(24)) v.normal = -v.normal;
  update_bounds(scene);
  return scene;
}

/// Fraction of the pixels on which `agree` holds.
template <class Agree>
double agreement(const GBuffer& a, const GBuffer& b, Agree&& agree) {
  size_t count = 0;
  for (size_t i = 0; i < a.pixel_count(); ++i) count += agree(a.texels[i], b.texels[i]);
  return static_cast<double>(count) / static_cast<double>(a.pixel_count());
}

bool near(Vec3 a, Vec3 b, float tolerance) { return max_component(glm::abs(a - b)) <= tolerance; }

void expect_same_gbuffer(const Scene& scene, const GBuffer& raster, const GBuffer& rays) {
  const auto both = [](const GBufferTexel& a, const GBufferTexel& b) {
    return a.triangle == b.triangle && a.hit();
  };
  const float size = scene.bounds.diagonal();
  // Texels of 8-bit pictures are blended over the width of a pixel: what a position error of 1e-5 can do.
  constexpr float tolerance = 2e-3f;
  EXPECT_GE(agreement(raster, rays, [](auto& a, auto& b) { return a.triangle == b.triangle; }), 0.995);
  const auto expect = [&](const char* what, auto&& agree) {
    EXPECT_GE(agreement(raster, rays, [&](auto& a, auto& b) { return !both(a, b) || agree(a, b); }), 0.9995)
        << what;
  };
  expect("material", [](auto& a, auto& b) { return a.material == b.material; });
  expect("position", [&](auto& a, auto& b) { return near(a.position, b.position, 1e-5f * size); });
  expect("geometric normal", [](auto& a, auto& b) { return a.geometric_normal == b.geometric_normal; });
  expect("shading normal",
         [](auto& a, auto& b) { return near(a.shading_normal, b.shading_normal, tolerance); });
  expect("tangent", [](auto& a, auto& b) { return near(a.tangent, b.tangent, 4 * tolerance); });
  expect("wo", [](auto& a, auto& b) { return near(a.wo, b.wo, 1e-6f); });
  expect("emission", [](auto& a, auto& b) { return near(a.emission, b.emission, tolerance); });
  expect("model", [](auto& a, auto& b) { return a.brdf.model == b.brdf.model; });
  expect("diffuse", [](auto& a, auto& b) { return near(a.brdf.diffuse, b.brdf.diffuse, tolerance); });
  expect("specular", [](auto& a, auto& b) { return near(a.brdf.specular, b.brdf.specular, tolerance); });
  expect("f90", [](auto& a, auto& b) { return std::abs(a.brdf.f90 - b.brdf.f90) <= tolerance; });
  expect("roughness", [](auto& a, auto& b) {
    return near(Vec3(a.brdf.roughness, 0), Vec3(b.brdf.roughness, 0), tolerance);
  });
}

TEST_P(RasterGBuffer, EveryMaterialFeatureAgreesWithRays) {
  const Scene scene = feature_scene();
  Rasterizer raster(*context, scene, {}, messages);
  Camera camera = look_at({0.6f, 1.2f, 4.5f}, {0, -0.1f, 0}, {0, 1, 0}, 0.9f);
  for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
    camera.projection = projection;
    camera.half_height = 1.7f;
    GBuffer gbuffer;
    gbuffer.resize(160, 120);
    raster.draw_gbuffer(camera, Vec2(0.3f, -0.2f), 7, gbuffer);
    expect_same_gbuffer(scene, gbuffer, brute_gbuffer(scene, camera, 160, 120, Vec2(0.3f, -0.2f), 7));
  }
  EXPECT_TRUE(messages.warnings.empty());
}

TEST_P(RasterGBuffer, LengthUnitsDoNotMatter) {
  for (const float factor : {1e-6f, 1e6f}) {
    Scene scene = feature_scene();
    Camera camera = look_at({0.6f, 1.2f, 4.5f}, {0, -0.1f, 0}, {0, 1, 0}, 0.9f);
    scale_lengths(scene, camera, factor);
    Rasterizer raster(*context, scene, {}, messages);
    GBuffer gbuffer;
    gbuffer.resize(96, 72);
    raster.draw_gbuffer(camera, Vec2(0), 7, gbuffer);
    SCOPED_TRACE(factor);
    expect_same_gbuffer(scene, gbuffer, brute_gbuffer(scene, camera, 96, 72, Vec2(0), 7));
  }
}

TEST_P(RasterGBuffer, EmptyScenesAndTinyPicturesAreDrawn) {
  Scene empty;
  Rasterizer nothing(*context, empty, {}, messages);
  const Camera camera = look_at({0, 2, 4}, {0, 0, 0}, {0, 1, 0}, 0.8f);
  GBuffer gbuffer;
  nothing.draw_gbuffer(camera, Vec2(0), 0, gbuffer);
  EXPECT_EQ(gbuffer.pixel_count(), 0u);
  gbuffer.resize(3, 2);
  nothing.draw_gbuffer(camera, Vec2(0), 0, gbuffer);
  for (const GBufferTexel& texel : gbuffer.texels) EXPECT_FALSE(texel.hit());
  std::vector<Vec3> radiance(6, Vec3(1));
  nothing.add_punctual(gbuffer, radiance);
  EXPECT_EQ(radiance[5], Vec3(1));

  Scene scene;
  scene.materials.push_back(diffuse_material(Vec3(0.5f)));
  add_quad(scene, {-5, 0, 5}, {10, 0, 0}, {0, 0, -10}, 0);
  update_bounds(scene);
  Rasterizer raster(*context, scene, {}, messages);
  gbuffer.resize(1, 1);
  raster.draw_gbuffer(camera, Vec2(0), 0, gbuffer);
  EXPECT_TRUE(gbuffer.texels[0].hit());
}

TEST_P(RasterGBuffer, BlendsAreOpaqueAsOftenAsTheirAlpha) {
  Scene scene;
  Material glass = diffuse_material(Vec3(1));
  glass.alpha_mode = AlphaMode::blend;
  glass.base_color.w = 0.3f;
  scene.materials.push_back(glass);
  add_quad(scene, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 0);
  update_bounds(scene);
  Rasterizer raster(*context, scene, {}, messages);
  GBuffer gbuffer;
  gbuffer.resize(100, 100);
  Camera camera = look_at({0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 0.5f);
  int hits = 0;
  for (uint32_t seed = 0; seed < 4; ++seed) {
    raster.draw_gbuffer(camera, Vec2(0), seed, gbuffer);
    for (const GBufferTexel& texel : gbuffer.texels) hits += texel.hit();
  }
  // 40,000 draws: five standard deviations are 0.0115.
  EXPECT_NEAR(hits / 40000.0, 0.3, 0.0115);
}

TEST(RasterGBufferBackends, EglAndOsMesaGiveTheSameBits) {
  const auto egl = context_or_null(Backend::egl), osmesa = context_or_null(Backend::osmesa);
  if (!egl || !osmesa) GTEST_SKIP() << "libEGL and libOSMesa are not both installed";
  if (!egl->description().software) GTEST_SKIP() << "EGL runs on a GPU: " << egl->description().renderer;
  const Scene scene = feature_scene();
  Messages messages;
  Rasterizer a(*egl, scene, {}, messages), b(*osmesa, scene, {}, messages);
  const Camera camera = look_at({0.6f, 1.2f, 4.5f}, {0, -0.1f, 0}, {0, 1, 0}, 0.9f);
  GBuffer first, second;
  first.resize(120, 90);
  second.resize(120, 90);
  // Alternating: each call makes its own context current.
  for (int round = 0; round < 2; ++round) {
    a.draw_gbuffer(camera, Vec2(0.1f), 3, first);
    b.draw_gbuffer(camera, Vec2(0.1f), 3, second);
    ASSERT_EQ(
        std::memcmp(first.texels.data(), second.texels.data(), first.pixel_count() * sizeof(GBufferTexel)),
        0);
  }
}

}  // namespace
}  // namespace halflight
