// Materials, textures, lights and cameras of small glTF files.
#include <gtest/gtest.h>

#include "support/gltf_fixture.h"
#include "support/png_fixture.h"

namespace halflight {

namespace {

using nlohmann::json;

Scene load(const GltfFixture& gltf) {
  LoadOutcome outcome = load_outcome(gltf);
  EXPECT_EQ(outcome.exit, ExitCode::ok) << outcome.message;
  return std::move(outcome.scene);
}

GltfFixture with_material(const json& material) {
  GltfFixture gltf = triangle_fixture();
  gltf.primitive()["material"] = 0;
  gltf.primitive()["attributes"]["TEXCOORD_0"] = gltf.add_accessor<float>("VEC2", {0, 0, 1, 0, 0, 1});
  gltf.json["materials"] = json::array({material});
  return gltf;
}

/// Two images behind textures 0 and 1.
void add_textures(GltfFixture& gltf) {
  for (const uint8_t shade : {50, 200}) {
    const size_t view = gltf.add_view(make_png({shade, shade, shade, 255}));
    gltf.json["images"].push_back({{"bufferView", view}, {"mimeType", "image/png"}});
    gltf.json["textures"].push_back({{"source", gltf.json["images"].size() - 1}});
  }
}

TEST(GltfMaterials, DefaultsAreThoseOfTheStandard) {
  const Material m = load(with_material(json::object())).materials.at(0);
  EXPECT_EQ(m.model, BrdfModel::ggx);
  EXPECT_EQ(m.base_color, Vec4(1));
  EXPECT_EQ(m.metallic, 1);
  EXPECT_EQ(m.roughness, 1);
  EXPECT_EQ(m.ior, 1.5f);
  EXPECT_EQ(m.emission, Vec3(0));
  EXPECT_EQ(m.alpha_mode, AlphaMode::opaque);
  EXPECT_EQ(m.alpha_cutoff, 0.5f);
  EXPECT_FALSE(m.double_sided);
  EXPECT_FALSE(m.unlit);
}

TEST(GltfMaterials, PrimitivesWithoutOneGetTheDefault) {
  const Scene scene = load(triangle_fixture());
  ASSERT_EQ(scene.materials.size(), 1u);
  EXPECT_EQ(scene.triangle_material.at(0), 0u);
}

TEST(GltfMaterials, FactorsAndExtensions) {
  const Material m =
      load(
          with_material(
              {{"name", "lamp"},
               {"doubleSided", true},
               {"alphaMode", "MASK"},
               {"alphaCutoff", 0.25},
               {"emissiveFactor", {1, 0.5, 0}},
               {"pbrMetallicRoughness",
                {{"baseColorFactor", {0.1, 0.2, 0.3, 0.4}},
                 {"metallicFactor", 0.5},
                 {"roughnessFactor", 0.75}}},
               {"extensions",
                {{"KHR_materials_emissive_strength", {{"emissiveStrength", 8}}},
                 {"KHR_materials_ior", {{"ior", 1.33}}},
                 {"KHR_materials_specular", {{"specularFactor", 0.5}, {"specularColorFactor", {1, 2, 3}}}},
                 {"KHR_materials_anisotropy", {{"anisotropyStrength", 0.6}, {"anisotropyRotation", 1.5}}}}}}))
          .materials.at(0);
  EXPECT_EQ(m.name, "lamp");
  EXPECT_TRUE(m.double_sided);
  EXPECT_EQ(m.alpha_mode, AlphaMode::mask);
  EXPECT_EQ(m.alpha_cutoff, 0.25f);
  EXPECT_EQ(m.emission, Vec3(8, 4, 0));
  EXPECT_EQ(m.base_color, Vec4(0.1f, 0.2f, 0.3f, 0.4f));
  EXPECT_EQ(m.metallic, 0.5f);
  EXPECT_EQ(m.roughness, 0.75f);
  EXPECT_EQ(m.ior, 1.33f);
  EXPECT_EQ(m.specular, 0.5f);
  EXPECT_EQ(m.specular_color, Vec3(1, 2, 3));
  EXPECT_EQ(m.anisotropy, 0.6f);
  EXPECT_EQ(m.anisotropy_rotation, 1.5f);
  EXPECT_TRUE(
      load(with_material({{"extensions", {{"KHR_materials_unlit", json::object()}}}})).materials.at(0).unlit);
}

TEST(GltfMaterials, ThePapersModelsThroughExtras) {
  const Material phong = load(with_material({{"extras",
                                              {{"halflight",
                                                {{"brdf", "phong"},
                                                 {"diffuse", {0.1, 0.2, 0.3}},
                                                 {"specular", {0.4, 0.5, 0.6}},
                                                 {"exponent", 20}}}}}}))
                             .materials.at(0);
  EXPECT_EQ(phong.model, BrdfModel::phong);
  EXPECT_EQ(phong.diffuse, Vec3(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(phong.phong_specular, Vec3(0.4f, 0.5f, 0.6f));
  EXPECT_EQ(phong.exponents.x, 20);
  const Material brushed =
      load(with_material(
               {{"extras", {{"halflight", {{"brdf", "ashikhmin-shirley"}, {"exponents", {10, 1000}}}}}}}))
          .materials.at(0);
  EXPECT_EQ(brushed.model, BrdfModel::ashikhmin_shirley);
  EXPECT_EQ(brushed.exponents, Vec2(10, 1000));
}

TEST(GltfTextures, OneImageAsColourAndAsDataIsTwoTextures) {
  GltfFixture gltf =
      with_material({{"pbrMetallicRoughness",
                      {{"baseColorTexture", {{"index", 1}}}, {"metallicRoughnessTexture", {{"index", 1}}}}}});
  add_textures(gltf);
  const Scene scene = load(gltf);
  ASSERT_EQ(scene.images.size(), 1u);  // the other is not looked up
  EXPECT_EQ(scene.images[0].bytes[0], 200);
  ASSERT_EQ(scene.textures.size(), 2u);
  const Material& m = scene.materials[0];
  EXPECT_TRUE(scene.textures[m.base_color_texture.texture].srgb);
  EXPECT_FALSE(scene.textures[m.metallic_roughness_texture.texture].srgb);
}

TEST(GltfTextures, SamplersAndTransforms) {
  GltfFixture gltf = with_material(
      {{"emissiveFactor", {1, 1, 1}},
       {"emissiveTexture",
        {{"index", 0},
         {"texCoord", 0},
         {"extensions",
          {{"KHR_texture_transform", {{"offset", {0.25, 0.5}}, {"scale", {2, 3}}, {"texCoord", 1}}}}}}}});
  add_textures(gltf);
  gltf.json["samplers"] = {{{"magFilter", 9728}, {"wrapS", 33071}, {"wrapT", 33648}}};
  gltf.json["textures"][0]["sampler"] = 0;
  const Scene scene = load(gltf);
  const TextureUse& use = scene.materials[0].emission_texture;
  ASSERT_TRUE(use.used());
  EXPECT_EQ(use.uv_set, 1u);
  EXPECT_EQ(use.row_u, Vec3(2, 0, 0.25f));
  EXPECT_EQ(use.row_v, Vec3(0, 3, 0.5f));
  const Texture& texture = scene.textures.at(use.texture);
  EXPECT_TRUE(texture.nearest);
  EXPECT_TRUE(texture.srgb);
  EXPECT_EQ(texture.wrap_u, Wrap::clamp);
  EXPECT_EQ(texture.wrap_v, Wrap::mirror);
}

TEST(GltfTextures, NormalMapsGetTangents) {
  GltfFixture gltf = with_material({{"normalTexture", {{"index", 0}, {"scale", 0.5}}}});
  add_textures(gltf);
  const Scene scene = load(gltf);
  EXPECT_EQ(scene.materials[0].normal_scale, 0.5f);
  // Texture coordinates run with x and y here, so that v runs up and the mapping is mirrored.
  for (int k = 0; k < 3; ++k) EXPECT_EQ(scene.vertices[scene.triangles[0][k]].tangent, Vec4(1, 0, 0, -1));
}

// ---- Lights and cameras ----

GltfFixture with_light(const json& light, const json& node) {
  GltfFixture gltf = triangle_fixture();
  gltf.json["extensionsUsed"] = json::array({"KHR_lights_punctual"});
  gltf.json["extensions"]["KHR_lights_punctual"]["lights"] = json::array({light});
  json lit = node;
  lit["extensions"]["KHR_lights_punctual"]["light"] = 0;
  gltf.json["nodes"].push_back(lit);
  gltf.json["scenes"][0]["nodes"].push_back(1);
  return gltf;
}

TEST(GltfLights, SpotLooksAlongItsNodesMinusZ) {
  const double half = std::sqrt(0.5);
  // A quarter turn about x takes −z to +y; scale does not touch a light.
  const Scene scene =
      load(with_light({{"type", "spot"},
                       {"name", "desk"},
                       {"color", {1, 0.5, 0}},
                       {"intensity", 40},
                       {"range", 3},
                       {"spot", {{"innerConeAngle", 0.1}, {"outerConeAngle", 0.6}}}},
                      {{"translation", {1, 2, 3}}, {"rotation", {half, 0, 0, half}}, {"scale", {2, 5, 9}}}));
  const PunctualLight& light = scene.lights.at(0);
  EXPECT_EQ(light.kind, PunctualKind::spot);
  EXPECT_EQ(light.name, "desk");
  EXPECT_EQ(light.position, Vec3(1, 2, 3));
  EXPECT_NEAR(glm::length(light.direction - Vec3(0, 1, 0)), 0, 1e-6);
  EXPECT_NEAR(glm::length(light.up - Vec3(0, 0, 1)), 0, 1e-6);
  EXPECT_EQ(light.intensity, Vec3(40, 20, 0));
  EXPECT_EQ(light.range, 3);
  EXPECT_EQ(light.inner_cone, 0.1f);
  EXPECT_EQ(light.outer_cone, 0.6f);
  EXPECT_EQ(light.picture, -1);
}

TEST(GltfLights, DefaultsAreThoseOfTheExtension) {
  const PunctualLight spot =
      load(with_light({{"type", "spot"}, {"spot", json::object()}}, json::object())).lights.at(0);
  EXPECT_EQ(spot.intensity, Vec3(1));
  EXPECT_EQ(spot.range, infinity);
  EXPECT_EQ(spot.inner_cone, 0);
  EXPECT_NEAR(spot.outer_cone, pi / 4, 1e-6);
  EXPECT_EQ(load(with_light({{"type", "directional"}}, json::object())).lights.at(0).direction,
            Vec3(0, 0, -1));
}

TEST(GltfLights, InnerConeStaysBelowTheOuterOne) {
  const PunctualLight spot =
      load(with_light({{"type", "spot"}, {"spot", {{"innerConeAngle", 0.5}, {"outerConeAngle", 0.5}}}},
                      json::object()))
          .lights.at(0);
  EXPECT_LT(spot.inner_cone, spot.outer_cone);
}

TEST(GltfLights, ProjectorsCarryTheirPicture) {
  const GltfFixture gltf = with_light({{"type", "spot"},
                                       {"spot", json::object()},
                                       {"extras", {{"halflight", {{"picture", "slides/my%20slide.png"}}}}}},
                                      json::object());
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() / "slides");
  const auto png = make_png({255, 0, 255, 255});
  folder.write("slides/my slide.png", std::string(png.begin(), png.end()));
  const LoadOutcome outcome = load_outcome(folder.write("a.gltf", gltf.text()));
  ASSERT_EQ(outcome.scene.pictures.size(), 1u) << outcome.all();
  EXPECT_EQ(outcome.scene.lights.at(0).picture, 0);
  EXPECT_EQ(outcome.scene.pictures[0].at(0, 0), Vec3(1, 0, 1));
}

TEST(GltfEnvironment, ComesThroughTheScenesExtras) {
  GltfFixture gltf = triangle_fixture();
  gltf.json["scenes"][0]["extras"]["halflight"]["environment"] = {
      {"file", "sky.hdr"}, {"rotation", 90}, {"strength", 2}};
  const TemporaryFolder folder;
  // Two texels of radiance 1 (mantissa 128, exponent 129).
  std::string texels;
  for (int i = 0; i < 2; ++i) texels += {'\x80', '\x80', '\x80', '\x81'};
  folder.write("sky.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n" + texels);
  const LoadOutcome outcome = load_outcome(folder.write("a.gltf", gltf.text()));
  const Environment& sky = outcome.scene.environment;
  ASSERT_TRUE(sky.present()) << outcome.all();
  EXPECT_NEAR(sky.map.pixels.at(0).x, 1, 0.01);
  EXPECT_NEAR(sky.rotation, pi / 2, 1e-6);
  EXPECT_EQ(sky.strength, 2);
  std::filesystem::remove(folder.path() / "sky.hdr");
  const LoadOutcome without = load_outcome(folder.path() / "a.gltf");
  EXPECT_EQ(without.exit, ExitCode::ok);
  EXPECT_TRUE(without.tells("there is no environment")) << without.all();
}

TEST(GltfCameras, StandWhereTheirNodeDoes) {
  GltfFixture gltf = triangle_fixture();
  const double half = std::sqrt(0.5);
  gltf.json["cameras"] = {
      {{"type", "perspective"}, {"perspective", {{"yfov", 0.8}, {"znear", 0.1}}}},
      {{"type", "orthographic"}, {"orthographic", {{"xmag", 2}, {"ymag", -3}, {"znear", 0}, {"zfar", 9}}}}};
  // A quarter turn about y takes −z to −x.
  gltf.json["nodes"].push_back({{"camera", 0},
                                {"name", "door"},
                                {"translation", {0, 1, 5}},
                                {"rotation", {0, half, 0, half}},
                                {"scale", {3, 3, 3}}});
  gltf.json["nodes"].push_back({{"camera", 1}});
  gltf.json["scenes"][0]["nodes"] = {0, 1, 2};
  const Scene scene = load(gltf);
  ASSERT_EQ(scene.cameras.size(), 2u);
  const Camera& camera = scene.cameras[0];
  EXPECT_EQ(camera.name, "door");
  EXPECT_EQ(camera.position, Vec3(0, 1, 5));
  EXPECT_NEAR(glm::length(-camera.back - Vec3(-1, 0, 0)), 0, 1e-6);
  EXPECT_NEAR(glm::length(camera.up - Vec3(0, 1, 0)), 0, 1e-6);
  EXPECT_NEAR(glm::length(camera.right - Vec3(0, 0, -1)), 0, 1e-6);
  EXPECT_NEAR(camera.vertical_fov, 0.8, 1e-6);
  EXPECT_FALSE(camera.generated);
  EXPECT_EQ(scene.cameras[1].projection, Projection::orthographic);
  EXPECT_EQ(scene.cameras[1].half_height, 3);
}

}  // namespace

}  // namespace halflight
