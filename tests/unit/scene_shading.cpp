// Textures, normals, materials and hashed alpha at a point of a triangle, against values worked out by hand.
#include "scene/shading.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"

using namespace halflight;

namespace {

/// A right triangle in the plane z = 0 with front towards +z; uv = (x, y), tangent +x.
Scene one_triangle() {
  Scene scene;
  for (const Vec2 p : {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1)}) {
    Vertex v{};
    v.position = {p.x, p.y, 0};
    v.normal = {0, 0, 1};
    v.tangent = {1, 0, 0, 1};
    v.uv[0] = v.uv[1] = p;
    v.color = 0xffffffffu;
    scene.vertices.push_back(v);
  }
  scene.triangles = {{0, 1, 2}};
  scene.triangle_material = {0};
  scene.materials.resize(1);
  update_bounds(scene);
  return scene;
}

/// Adds an image of grey codes and a use of it; returns the use.
TextureUse add_texture(Scene& scene, int width, int height, std::vector<Vec4> codes, Texture texture = {}) {
  ImageRgba8 image;
  image.width = width, image.height = height;
  for (const Vec4& c : codes) {
    for (int k = 0; k < 4; ++k) image.bytes.push_back(static_cast<uint8_t>(c[k]));
  }
  texture.image = static_cast<uint32_t>(scene.images.size());
  scene.images.push_back(image);
  scene.textures.push_back(texture);
  TextureUse use;
  use.texture = static_cast<int32_t>(scene.textures.size()) - 1;
  return use;
}

Vec4 grey(float code) { return {code, code, code, 255}; }

float value_at(const Scene& scene, const TextureUse& use, Vec2 uv) {
  const Vec2 sets[2] = {uv, uv};
  return texture_value(scene, use, sets).x * 255;
}

constexpr SurfacePoint middle{0, {0.25f, 0.25f}};
const Vec3 above = glm::normalize(Vec3(0.2f, 0.1f, 1));

}  // namespace

TEST(SceneTexture, empty_use_is_white) {
  const Scene scene = one_triangle();
  const Vec2 uv[2] = {{0.3f, 0.3f}, {0, 0}};
  EXPECT_EQ(texture_value(scene, TextureUse{}, uv), Vec4(1));
}

TEST(SceneTexture, bilinear_with_centres_at_half_integers) {
  Scene scene = one_triangle();
  const TextureUse use = add_texture(scene, 2, 2, {grey(0), grey(100), grey(200), grey(60)});
  EXPECT_NEAR(value_at(scene, use, {0.25f, 0.25f}), 0, 1e-3);
  EXPECT_NEAR(value_at(scene, use, {0.75f, 0.25f}), 100, 1e-3);
  EXPECT_NEAR(value_at(scene, use, {0.25f, 0.75f}), 200, 1e-3);
  EXPECT_NEAR(value_at(scene, use, {0.5f, 0.25f}), 50, 1e-3);
  EXPECT_NEAR(value_at(scene, use, {0.5f, 0.5f}), 90, 1e-3);
  EXPECT_NEAR(value_at(scene, use, {0.375f, 0.25f}), 25, 1e-3);
  // At u = 0 half of the texel comes from the other edge: repeat is the default.
  EXPECT_NEAR(value_at(scene, use, {0.0f, 0.25f}), 50, 1e-3);
}

TEST(SceneTexture, wrap_modes) {
  const std::vector<Vec4> row{grey(0), grey(40), grey(80), grey(120)};
  const auto look = [&](Wrap wrap, bool nearest, float u) {
    Scene scene = one_triangle();
    Texture texture;
    texture.wrap_u = wrap, texture.nearest = nearest;
    const TextureUse use = add_texture(scene, 4, 1, row, texture);
    return value_at(scene, use, {u, 0.5f});
  };
  EXPECT_NEAR(look(Wrap::repeat, true, 1.3f), 40, 1e-3);
  EXPECT_NEAR(look(Wrap::repeat, true, -0.1f), 120, 1e-3);
  EXPECT_NEAR(look(Wrap::repeat, true, 0.9999f), 120, 1e-3);
  EXPECT_NEAR(look(Wrap::mirror, true, 1.3f), 80, 1e-3);
  EXPECT_NEAR(look(Wrap::mirror, true, -0.3f), 40, 1e-3);
  EXPECT_NEAR(look(Wrap::mirror, true, 2.3f), 40, 1e-3);
  EXPECT_NEAR(look(Wrap::clamp, true, 7.0f), 120, 1e-3);
  EXPECT_NEAR(look(Wrap::clamp, true, -7.0f), 0, 1e-3);
  EXPECT_NEAR(look(Wrap::repeat, false, 1.0f), 60, 1e-3);
  EXPECT_NEAR(look(Wrap::mirror, false, 1.0f), 120, 1e-3);
  EXPECT_NEAR(look(Wrap::clamp, false, 1.0f), 120, 1e-3);
  EXPECT_NEAR(look(Wrap::clamp, false, 0.0f), 0, 1e-3);
  for (const Wrap wrap : {Wrap::repeat, Wrap::mirror, Wrap::clamp}) {
    for (const float u : {1e30f, -1e30f, infinity, std::nanf("")}) {
      EXPECT_TRUE(std::isfinite(look(wrap, false, u)));
      EXPECT_TRUE(std::isfinite(look(wrap, true, u)));
    }
  }
}

TEST(SceneTexture, srgb_is_decoded_before_filtering_and_alpha_never) {
  Scene scene = one_triangle();
  Texture texture;
  texture.srgb = true;
  const TextureUse use = add_texture(scene, 2, 1, {{0, 0, 10, 0}, {255, 188, 10, 128}}, texture);
  const Vec2 uv[2] = {{0.5f, 0.5f}, {0, 0}};
  const Vec4 value = texture_value(scene, use, uv);
  EXPECT_NEAR(value.x, 0.5, 1e-6);
  EXPECT_NEAR(value.y, 0.5 * std::pow((188 / 255.0 + 0.055) / 1.055, 2.4), 1e-6);
  EXPECT_NEAR(value.z, 10 / 255.0 / 12.92, 1e-7);  // the linear part of the curve
  EXPECT_NEAR(value.w, 64 / 255.0, 1e-6);
}

TEST(SceneTexture, transform_and_uv_set) {
  Scene scene = one_triangle();
  Texture texture;
  texture.nearest = true;
  TextureUse use = add_texture(scene, 4, 1, {grey(0), grey(40), grey(80), grey(120)}, texture);
  use.row_u = {0, 1, 0.5f};  // u' = v + ½
  use.row_v = {1, 0, 0};
  EXPECT_NEAR(value_at(scene, use, {0.9f, 0.1f}), 80, 1e-3);
  use.uv_set = 1;
  const Vec2 uv[2] = {{0, 0}, {0, 0.3f}};
  EXPECT_NEAR(texture_value(scene, use, uv).x * 255, 120, 1e-3);
}

TEST(SceneShading, position_is_interpolated) {
  const Scene scene = one_triangle();
  const Vec3 p = surface_position(scene, {0, {0.2f, 0.7f}});
  EXPECT_NEAR(p.x, 0.2f, 1e-6f);
  EXPECT_NEAR(p.y, 0.7f, 1e-6f);
}

TEST(SceneShading, gltf_dielectric_and_metal) {
  Scene scene = one_triangle();
  Material& m = scene.materials[0];
  m.base_color = {0.8f, 0.4f, 0.2f, 1};
  m.metallic = 0, m.roughness = 0.5f;
  Brdf brdf = surface_brdf(scene, middle);
  EXPECT_EQ(brdf.model, BrdfModel::ggx);
  EXPECT_NEAR(brdf.specular.x, 0.04f, 1e-6f);  // ior 1.5
  EXPECT_NEAR(brdf.diffuse.y, 0.4f, 1e-6f);
  EXPECT_NEAR(brdf.roughness.x, 0.25f, 1e-6f);
  EXPECT_NEAR(brdf.roughness.y, 0.25f, 1e-6f);
  EXPECT_EQ(brdf.f90, 1);

  m.metallic = 1;
  brdf = surface_brdf(scene, middle);
  EXPECT_EQ(brdf.diffuse, Vec3(0));
  EXPECT_NEAR(brdf.specular.x, 0.8f, 1e-6f);

  m.metallic = 0.5f, m.ior = 2, m.specular = 0.5f, m.specular_color = {1, 2, 20};
  brdf = surface_brdf(scene, middle);
  EXPECT_NEAR(brdf.specular.x, 0.5f * (0.5f / 9) + 0.4f, 1e-6f);
  EXPECT_NEAR(brdf.specular.y, 0.5f * (0.5f * 2 / 9) + 0.2f, 1e-6f);
  EXPECT_NEAR(brdf.specular.z, 0.5f * 0.5f + 0.1f, 1e-6f);  // tinted reflectance is capped at 1
  EXPECT_NEAR(brdf.f90, 0.75f, 1e-6f);
}

TEST(SceneShading, metallic_roughness_texture_channels) {
  Scene scene = one_triangle();
  scene.materials[0].metallic_roughness_texture = add_texture(scene, 1, 1, {{255, 128, 51, 255}});
  const Brdf brdf = surface_brdf(scene, middle);
  EXPECT_NEAR(brdf.roughness.y, square(128 / 255.0f), 1e-6f);
  EXPECT_NEAR(brdf.diffuse.x, 1 - 0.2f, 1e-6f);
}

TEST(SceneShading, anisotropy_widens_along_the_turned_tangent) {
  Scene scene = one_triangle();
  Material& m = scene.materials[0];
  m.roughness = 0.5f, m.anisotropy = 0.6f, m.anisotropy_rotation = pi / 2;
  const GBufferTexel texel = shade_surface(scene, middle, above);
  EXPECT_NEAR(texel.brdf.roughness.x, 0.25f + 0.36f * 0.75f, 1e-6f);
  EXPECT_NEAR(texel.brdf.roughness.y, 0.25f, 1e-6f);
  EXPECT_NEAR(std::abs(texel.tangent.y), 1, 1e-5f);
  // The texture's direction (red, green) = (0, 1) is +bitangent; strength 0.2 of 0.6.
  m.anisotropy_rotation = 0;
  m.anisotropy_texture = add_texture(scene, 1, 1, {{127.5f, 255, 51, 255}});
  const GBufferTexel textured = shade_surface(scene, middle, above);
  EXPECT_NEAR(std::abs(textured.tangent.y), 1, 1e-4f);
  EXPECT_NEAR(textured.brdf.roughness.x, 0.25f + square(0.12f) * 0.75f, 1e-5f);
}

TEST(SceneShading, phong_and_ashikhmin_shirley_pass_through) {
  Scene scene = one_triangle();
  Material& m = scene.materials[0];
  m.model = BrdfModel::phong;
  m.diffuse = {0.5f, 0.4f, 0.2f}, m.phong_specular = Vec3(0.3f), m.exponents = {77, 10};
  m.base_color_texture = add_texture(scene, 1, 1, {{51, 255, 255, 255}});
  const Brdf brdf = surface_brdf(scene, middle);
  EXPECT_EQ(brdf.model, BrdfModel::phong);
  EXPECT_NEAR(brdf.diffuse.x, 0.1f, 1e-6f);
  EXPECT_NEAR(brdf.diffuse.y, 0.4f, 1e-6f);
  EXPECT_NEAR(brdf.specular.x, 0.3f, 1e-6f);
  EXPECT_EQ(brdf.roughness.x, 77);
}

TEST(SceneShading, vertex_colors_multiply) {
  Scene scene = one_triangle();
  scene.materials[0].metallic = 0;
  scene.vertices[0].color = 0xff0000ffu;  // red
  scene.vertices[1].color = 0xff00ff00u;  // green
  scene.vertices[2].color = 0xffff0000u;  // blue
  const Brdf brdf = surface_brdf(scene, {0, {0.3f, 0.2f}});
  EXPECT_NEAR(brdf.diffuse.x, 0.5f, 1e-6f);
  EXPECT_NEAR(brdf.diffuse.y, 0.3f, 1e-6f);
  EXPECT_NEAR(brdf.diffuse.z, 0.2f, 1e-6f);
}

TEST(SceneShading, emission_per_side_and_unlit) {
  Scene scene = one_triangle();
  Material& m = scene.materials[0];
  m.emission = {2, 3, 4};
  EXPECT_EQ(surface_emission(scene, middle, 1), Vec3(2, 3, 4));
  EXPECT_EQ(surface_emission(scene, middle, -1), Vec3(0));
  EXPECT_EQ(shade_surface(scene, middle, above).emission, Vec3(2, 3, 4));
  EXPECT_EQ(shade_surface(scene, middle, -above).emission, Vec3(0));
  m.double_sided = true;
  EXPECT_EQ(surface_emission(scene, middle, -1), Vec3(2, 3, 4));
  m.emission_texture = add_texture(scene, 1, 1, {{51, 255, 0, 255}});
  EXPECT_NEAR(surface_emission(scene, middle, 1).x, 0.4f, 1e-6f);

  m.unlit = true, m.base_color = {0.1f, 0.2f, 0.3f, 1};
  const GBufferTexel texel = shade_surface(scene, middle, above);
  EXPECT_TRUE(texel.brdf.black());
  EXPECT_EQ(texel.emission, Vec3(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(surface_emission(scene, middle, 1), Vec3(0));
}

TEST(SceneShading, normal_map_follows_tangent_and_handedness) {
  Scene scene = one_triangle();
  Material& m = scene.materials[0];
  // (0.6, 0.48, 0.64) encoded: tilted towards +tangent and +bitangent.
  m.normal_texture = add_texture(scene, 1, 1, {{204, 188.7f, 209.1f, 255}});
  const Vec3 value = glm::normalize(2.0f * Vec3(204, 188, 209) / 255.0f - 1.0f);
  const auto expect_normal = [&](Vec3 wo, Vec3 expected) {
    const Vec3 n = shade_surface(scene, middle, wo).shading_normal;
    EXPECT_NEAR(glm::distance(n, glm::normalize(expected)), 0, 2e-3) << n.x << " " << n.y << " " << n.z;
  };
  const Vec3 up(0, 0, 1);
  expect_normal(up, value);
  for (Vertex& v : scene.vertices) v.tangent.w = -1;
  expect_normal(up, {value.x, -value.y, value.z});
  for (Vertex& v : scene.vertices) v.tangent = {0, 1, 0, 1};  // T = +y, B = N × T = −x
  expect_normal(up, {-value.y, value.x, value.z});
  // From behind the whole surface is turned round.
  expect_normal(-up, {value.y, -value.x, -value.z});
  for (Vertex& v : scene.vertices) v.tangent = {1, 0, 0, 1};
  m.normal_scale = 0.5f;
  expect_normal(up, {0.5f * value.x, 0.5f * value.y, value.z});
}

TEST(SceneShading, normals_face_the_viewer) {
  Scene scene = one_triangle();
  for (Vertex& v : scene.vertices) v.normal = glm::normalize(Vec3(-0.9f, 0, 0.45f));
  RandomStream random(1, 2, 3);
  for (int i = 0; i < 2000; ++i) {
    const Vec2 u = random.next2();
    const float z = 2 * u.x - 1, r = std::sqrt(1 - z * z);
    const Vec3 wo(r * std::cos(6.28f * u.y), r * std::sin(6.28f * u.y), z);
    const GBufferTexel texel = shade_surface(scene, middle, wo);
    ASSERT_GT(glm::dot(texel.shading_normal, wo), 0);
    ASSERT_GE(glm::dot(texel.geometric_normal, wo), 0);
    ASSERT_NEAR(glm::length(texel.shading_normal), 1, 1e-5f);
    ASSERT_NEAR(glm::length(texel.tangent), 1, 1e-5f);
    ASSERT_NEAR(glm::dot(texel.tangent, texel.shading_normal), 0, 1e-5f);
  }
  // A normal the viewer sees is left as it is; the opposite of wo has no nearest side and becomes wo.
  const GBufferTexel seen = shade_surface(scene, middle, {0, 0, 1});
  EXPECT_NEAR(glm::dot(seen.shading_normal, scene.vertices[0].normal), 1, 1e-6f);
}

TEST(SceneShading, degenerate_geometry_stays_finite) {
  Scene scene = one_triangle();
  for (Vertex& v : scene.vertices) v = Vertex{};
  const GBufferTexel texel = shade_surface(scene, middle, above);
  EXPECT_TRUE(is_finite(texel.shading_normal) && is_finite(texel.tangent) &&
              is_finite(texel.geometric_normal));
  EXPECT_GT(glm::dot(texel.shading_normal, above), 0);
  // A triangle whose squared lengths vanish in float still has its normal.
  Scene tiny = one_triangle();
  for (Vertex& v : tiny.vertices) v.position *= 1e-15f;
  EXPECT_NEAR(shade_surface(tiny, middle, above).geometric_normal.z, 1, 1e-6f);
}

TEST(SceneShading, alpha_modes) {
  Scene scene = one_triangle();
  Material& m = scene.materials[0];
  m.base_color.w = 0.4f;
  EXPECT_EQ(surface_alpha(scene, middle), 1);
  m.alpha_mode = AlphaMode::mask;
  EXPECT_EQ(surface_alpha(scene, middle), 0);
  m.alpha_cutoff = 0.4f;
  EXPECT_EQ(surface_alpha(scene, middle), 1);  // alpha ≥ cutoff is kept
  m.alpha_mode = AlphaMode::blend;
  EXPECT_NEAR(surface_alpha(scene, middle), 0.4f, 1e-6f);
}

TEST(SceneShading, hashed_alpha_blocks_in_proportion) {
  Scene scene = one_triangle();
  scene.materials[0].alpha_mode = AlphaMode::blend;
  for (const float alpha : {0.0f, 0.03f, 0.5f, 0.9f, 1.0f}) {
    scene.materials[0].base_color.w = alpha;
    constexpr int n = 40000;
    int over_points = 0, over_seeds = 0, changed = 0;
    RandomStream random(5, 6, 7);
    for (int i = 0; i < n; ++i) {
      const SurfacePoint p{0, random.next2() * 0.5f};
      over_points += surface_blocks(scene, p, 3);
      over_seeds += surface_blocks(scene, middle, i);
      changed += surface_blocks(scene, p, 3) != surface_blocks(scene, p, 4);
      ASSERT_EQ(surface_blocks(scene, p, 3), surface_blocks(scene, p, 3));
    }
    const double deviation = 4.5 * std::sqrt(alpha * (1 - alpha) / n) + 1e-9;
    EXPECT_NEAR(over_points / double(n), alpha, deviation);
    EXPECT_NEAR(over_seeds / double(n), alpha, deviation);
    // Seeds are independent of each other: two differ in 2α(1 − α) of the points.
    const double differing = 2 * alpha * (1 - alpha);
    EXPECT_NEAR(changed / double(n), differing, 4.5 * std::sqrt(differing * (1 - differing) / n) + 1e-9);
  }
}
