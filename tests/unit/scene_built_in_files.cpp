// Scenes written as .glb and read again, and what load_scene does with names and files.
#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "film/image_writers.h"
#include "scene/built_in_scenes.h"
#include "scene/load.h"
#include "scene/mesh_builder.h"
#include "support/temporary_folder.h"

namespace halflight {
namespace {

using Corners = std::array<Vertex, 3>;

std::map<uint32_t, std::vector<Corners>> by_material(const Scene& scene) {
  std::map<uint32_t, std::vector<Corners>> groups;
  for (size_t t = 0; t < scene.triangles.size(); ++t) {
    const UVec3 i = scene.triangles[t];
    groups[scene.triangle_material[t]].push_back(
        {scene.vertices[i.x], scene.vertices[i.y], scene.vertices[i.z]});
  }
  return groups;
}

void expect_same_geometry(const Scene& expected, const Scene& actual) {
  ASSERT_EQ(expected.triangles.size(), actual.triangles.size());
  const auto a = by_material(expected), b = by_material(actual);
  ASSERT_EQ(a.size(), b.size());
  for (const auto& [material, triangles] : a) {
    const auto& others = b.at(material);
    ASSERT_EQ(triangles.size(), others.size());
    for (size_t t = 0; t < triangles.size(); ++t)
      for (int k = 0; k < 3; ++k) {
        ASSERT_EQ(triangles[t][k].position, others[t][k].position);
        ASSERT_LT(glm::length(triangles[t][k].normal - others[t][k].normal), 1e-5f);
        ASSERT_EQ(triangles[t][k].uv[0], others[t][k].uv[0]);
        ASSERT_EQ(triangles[t][k].color, others[t][k].color);
      }
  }
}

void expect_same_use(const Scene& a, const TextureUse& use, const Scene& b, const TextureUse& other) {
  ASSERT_EQ(use.used(), other.used());
  if (!use.used()) return;
  EXPECT_LT(glm::length(use.row_u - other.row_u), 1e-4f * glm::length(use.row_u));
  EXPECT_LT(glm::length(use.row_v - other.row_v), 1e-4f * glm::length(use.row_v));
  const Texture &texture = a.textures[use.texture], &other_texture = b.textures[other.texture];
  EXPECT_EQ(texture.srgb, other_texture.srgb);
  EXPECT_EQ(texture.wrap_u, other_texture.wrap_u);
  EXPECT_EQ(texture.wrap_v, other_texture.wrap_v);
  EXPECT_EQ(a.images[texture.image].bytes, b.images[other_texture.image].bytes);
}

void expect_same_materials(const Scene& a, const Scene& b) {
  ASSERT_EQ(a.materials.size(), b.materials.size());
  for (size_t i = 0; i < a.materials.size(); ++i) {
    const Material &m = a.materials[i], &o = b.materials[i];
    SCOPED_TRACE(m.name);
    EXPECT_EQ(m.name, o.name);
    EXPECT_EQ(m.model, o.model);
    EXPECT_LT(glm::length(m.base_color - o.base_color), 1e-6f);
    EXPECT_FLOAT_EQ(m.metallic, o.metallic);
    EXPECT_FLOAT_EQ(m.roughness, o.roughness);
    EXPECT_FLOAT_EQ(m.ior, o.ior);
    EXPECT_FLOAT_EQ(m.specular, o.specular);
    EXPECT_EQ(m.specular_color, o.specular_color);
    EXPECT_FLOAT_EQ(m.anisotropy, o.anisotropy);
    EXPECT_FLOAT_EQ(m.anisotropy_rotation, o.anisotropy_rotation);
    EXPECT_LE(glm::length(m.emission - o.emission), 1e-5f * glm::length(m.emission));
    EXPECT_EQ(m.alpha_mode, o.alpha_mode);
    EXPECT_EQ(m.double_sided, o.double_sided);
    EXPECT_EQ(m.unlit, o.unlit);
    expect_same_use(a, m.base_color_texture, b, o.base_color_texture);
    if (m.model == BrdfModel::ggx) continue;
    EXPECT_EQ(m.diffuse, o.diffuse);
    EXPECT_EQ(m.phong_specular, o.phong_specular);
    EXPECT_EQ(m.exponents.x, o.exponents.x);
  }
}

void expect_same_lights(const Scene& a, const Scene& b) {
  ASSERT_EQ(a.lights.size(), b.lights.size());
  for (size_t i = 0; i < a.lights.size(); ++i) {
    const PunctualLight &l = a.lights[i], &o = b.lights[i];
    SCOPED_TRACE(l.name);
    EXPECT_EQ(l.kind, o.kind);
    EXPECT_EQ(l.range, o.range);
    EXPECT_LE(glm::length(l.intensity - o.intensity), 1e-5f * glm::length(l.intensity));
    if (l.kind != PunctualKind::directional) {
      EXPECT_LT(glm::length(l.position - o.position), 1e-5f);
    }
    if (l.kind == PunctualKind::point) continue;
    EXPECT_LT(glm::length(l.direction - o.direction), 1e-5f);
    if (l.kind != PunctualKind::spot) continue;
    EXPECT_NEAR(l.inner_cone, o.inner_cone, 1e-6f);
    EXPECT_NEAR(l.outer_cone, o.outer_cone, 1e-6f);
    EXPECT_EQ(l.picture >= 0, o.picture >= 0);
    if (l.picture >= 0) {
      EXPECT_LT(glm::length(l.up - o.up), 1e-5f);
    }
  }
}

void expect_same_cameras(const Scene& a, const Scene& b) {
  ASSERT_EQ(a.cameras.size(), b.cameras.size());
  for (size_t i = 0; i < a.cameras.size(); ++i) {
    const Camera &c = a.cameras[i], &o = b.cameras[i];
    EXPECT_EQ(c.name, o.name);
    EXPECT_EQ(c.projection, o.projection);
    EXPECT_LT(glm::length(c.position - o.position), 1e-5f);
    EXPECT_LT(glm::length(c.right - o.right) + glm::length(c.up - o.up) + glm::length(c.back - o.back),
              1e-5f);
    EXPECT_NEAR(c.vertical_fov, o.vertical_fov, 1e-6f);
  }
}

Scene read_again(const GlbFile& file, const TemporaryFolder& folder) {
  Messages messages;
  messages.strict = true;
  Scene scene = load_gltf(folder.write("again.glb", file.bytes), {}, messages);
  for (const std::string& warning : messages.warnings) ADD_FAILURE() << warning;
  return scene;
}

TEST(GlbWriter, BuiltInScenesComeBackAsTheyWere) {
  TemporaryFolder folder;
  for (const BuiltInScene& built_in : built_in_scenes()) {
    SCOPED_TRACE(built_in.name);
    const Scene scene = built_in.make();
    const GlbFile file = make_glb(scene, "again");
    for (const SidePicture& side : file.pictures) folder.write(side.name, radiance_bytes(side.image, {}));
    const Scene again = read_again(file, folder);
    expect_same_geometry(scene, again);
    expect_same_materials(scene, again);
    expect_same_lights(scene, again);
    expect_same_cameras(scene, again);
    EXPECT_EQ(file.bytes, make_glb(scene, "again").bytes);
  }
}

/// A scene that uses what the built-in ones do not.
Scene make_oddities() {
  Scene scene;
  ImageRgba8 image;
  image.width = 2, image.height = 1, image.bytes = {255, 0, 0, 255, 0, 200, 30, 128};
  Material phong = plain_material("phong", {1, 1, 1}, 1);
  phong.model = BrdfModel::phong, phong.diffuse = {0.1f, 0.2f, 0.3f}, phong.phong_specular = Vec3(0.5f),
  phong.exponents = Vec2(40);
  Material brushed = plain_material("brushed", {1, 1, 1}, 1);
  brushed.model = BrdfModel::ashikhmin_shirley, brushed.exponents = {10, 1000},
  brushed.phong_specular = Vec3(0.25f);
  Material fancy = plain_material("fancy", {0.5f, 0.25f, 0.125f}, 0.3f);
  fancy.ior = 1.33f, fancy.specular = 0.5f, fancy.specular_color = {1, 0.5f, 0.25f};
  fancy.anisotropy = 0.7f, fancy.anisotropy_rotation = 0.4f;
  fancy.double_sided = true, fancy.alpha_mode = AlphaMode::mask, fancy.alpha_cutoff = 0.25f;
  fancy.base_color_texture = add_texture(scene, image, "two texels", {1, 1});
  scene.textures[0].wrap_u = Wrap::mirror, scene.textures[0].wrap_v = Wrap::clamp;
  // Offset, a turn by 0.3 radians and unequal scales.
  fancy.base_color_texture.row_u = {2 * std::cos(0.3f), 3 * std::sin(0.3f), 0.25f};
  fancy.base_color_texture.row_v = {-2 * std::sin(0.3f), 3 * std::cos(0.3f), -0.5f};
  Material glow = plain_material("glow", {0, 0, 0}, 1);
  glow.emission = {12, 6, 3}, glow.alpha_mode = AlphaMode::blend;
  Material flat = plain_material("flat", {0.2f, 0.4f, 0.6f}, 1);
  flat.unlit = true;
  for (const Material& m : {phong, brushed, fancy, glow, flat})
    place(scene, box_mesh(Vec3(1)), add_material(scene, m), move({2.0f * scene.materials.size(), 0, 0}));
  for (Vertex& v : scene.vertices) v.color = 0x80ff4020u;

  PunctualLight sun, bulb, projector;
  sun.kind = PunctualKind::directional, sun.direction = glm::normalize(Vec3(1, -2, 3)),
  sun.intensity = Vec3(3, 2, 1);
  bulb.position = {1, 2, 3}, bulb.range = 7;
  projector.kind = PunctualKind::spot, projector.direction = {0, -1, 0}, projector.up = {0.6f, 0, 0.8f};
  projector.inner_cone = 0.1f, projector.outer_cone = 0.5f, projector.picture = 0;
  scene.lights = {sun, bulb, projector};
  scene.pictures.push_back(ImageRgb(2, 2, Vec3(0.5f)));
  Camera flat_camera;
  flat_camera.name = "plan", flat_camera.projection = Projection::orthographic, flat_camera.half_height = 3;
  scene.cameras = {flat_camera};
  scene.environment.map = ImageRgb(4, 2, Vec3(1));
  update_bounds(scene);
  return scene;
}

TEST(GlbWriter, EveryFieldComesBack) {
  TemporaryFolder folder;
  Scene scene = make_oddities();
  const GlbFile file = make_glb(scene, "again");
  ASSERT_EQ(file.pictures.size(), 2u);
  EXPECT_EQ(file.pictures[0].name, "again-slide-0.hdr");
  EXPECT_EQ(file.pictures[1].name, "again.hdr");
  // A flat Radiance file of 2 × 2 texels of (½, ½, ½): mantissas 128, exponent 128.
  std::string slide = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n";
  for (int i = 0; i < 16; ++i) slide += static_cast<char>(128);
  folder.write("again-slide-0.hdr", slide);
  folder.write("again.hdr", slide);
  const Scene again = read_again(file, folder);
  expect_same_geometry(scene, again);
  expect_same_materials(scene, again);
  expect_same_lights(scene, again);
  expect_same_cameras(scene, again);
  EXPECT_EQ(again.materials[1].exponents.y, 1000);
  EXPECT_EQ(again.materials[2].alpha_cutoff, 0.25f);
  EXPECT_EQ(again.cameras[0].half_height, 3);
  EXPECT_TRUE(again.environment.present());
  ASSERT_EQ(again.pictures.size(), 1u);
  // A mantissa stands for its interval, whose middle readers take.
  EXPECT_NEAR(again.pictures[0].at(1, 1).x, 0.5f, 0.003f);
}

/// The JSON chunk, by the specification's layout.
nlohmann::json json_chunk(const std::string& bytes) {
  uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 12, 4);
  return nlohmann::json::parse(bytes.substr(20, length));
}

TEST(GlbWriter, LaysOutWhatTheSpecificationAsks) {
  const GlbFile file = make_glb(make_oddities(), "odd");
  uint32_t head[3];
  std::memcpy(head, file.bytes.data(), 12);
  EXPECT_EQ(file.bytes.substr(0, 4), "glTF");
  EXPECT_EQ(head[1], 2u);
  EXPECT_EQ(head[2], file.bytes.size());
  EXPECT_EQ(file.bytes.size() % 4, 0u);
  const nlohmann::json json = json_chunk(file.bytes);
  for (const auto& view : json["bufferViews"]) {
    EXPECT_EQ(view["byteOffset"].get<size_t>() % 4, 0u);
    EXPECT_LE(view["byteOffset"].get<size_t>() + view["byteLength"].get<size_t>(),
              json["buffers"][0]["byteLength"].get<size_t>());
  }
  for (const auto& material : json["materials"])
    for (const auto& x : material.value("emissiveFactor", nlohmann::json::array()))
      EXPECT_LE(x.get<double>(), 1);
  // Every extension in use is declared.
  const std::string text = json.dump();
  for (const auto& name : json["extensionsUsed"])
    EXPECT_NE(text.find("\"" + name.get<std::string>() + "\":"), std::string::npos);
  EXPECT_EQ(json["materials"][0]["extras"]["halflight"]["brdf"], "phong");
  EXPECT_EQ(json["extensions"]["KHR_lights_punctual"]["lights"][2]["extras"]["halflight"]["picture"],
            "odd-slide-0.hdr");
}

TEST(GlbWriter, AnEmptySceneIsStillAFile) {
  const GlbFile file = make_glb(Scene{}, "empty");
  EXPECT_EQ(json_chunk(file.bytes)["asset"]["version"], "2.0");
}

ExitCode code_of(const std::string& name, std::string* message = nullptr) {
  Messages messages;
  try {
    load_scene(name, {}, messages);
  } catch (const Error& error) {
    if (message) *message = error.what();
    return error.code();
  }
  return ExitCode::ok;
}

TEST(LoadScene, KnowsNamesAndKindsOfFiles) {
  TemporaryFolder folder;
  std::string message;
  EXPECT_EQ(code_of("cornell"), ExitCode::ok);
  EXPECT_EQ(code_of("cornel", &message), ExitCode::usage);
  EXPECT_NE(message.find("did you mean 'cornell'"), std::string::npos) << message;
  EXPECT_EQ(code_of((folder.path() / "missing.glb").string(), &message), ExitCode::bad_input);
  EXPECT_EQ(code_of(folder.path().string(), &message), ExitCode::bad_input);
  EXPECT_NE(message.find("folder"), std::string::npos) << message;
  EXPECT_EQ(code_of(folder.write("sky.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\nabcd").string(),
                    &message),
            ExitCode::bad_input);
  EXPECT_NE(message.find("--environment"), std::string::npos) << message;
  EXPECT_EQ(code_of(folder.write("sky.exr", "\x76\x2f\x31\x01....").string(), &message), ExitCode::bad_input);
  EXPECT_NE(message.find("--environment"), std::string::npos) << message;
  EXPECT_EQ(code_of(folder.write("notes.txt", "hello").string(), &message), ExitCode::bad_input);
  EXPECT_NE(message.find("notes.txt"), std::string::npos) << message;
  EXPECT_EQ(code_of(folder.write("empty.glb", "").string()), ExitCode::bad_input);
  EXPECT_EQ(code_of(folder.write("cut.glb", std::string("glTF\2\0\0\0", 8)).string()), ExitCode::bad_input);
}

TEST(LoadScene, GoesByContentNotByEnding) {
  TemporaryFolder folder;
  const GlbFile file = make_glb(make_cornell(), "box");
  Messages messages;
  EXPECT_EQ(load_scene(folder.write("scene.dat", file.bytes).string(), {}, messages).triangles.size(), 38u);
}

}  // namespace
}  // namespace halflight
