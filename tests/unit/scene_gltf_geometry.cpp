// Geometry of small glTF files: modes, index types, sparse and quantised accessors, normals, tangents,
// transforms.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "scene/tangents.h"
#include "support/gltf_fixture.h"

namespace halflight {

namespace {

using Positions = std::vector<Vec3>;

Scene load(const GltfFixture& gltf) {
  LoadOutcome outcome = load_outcome(gltf);
  EXPECT_EQ(outcome.exit, ExitCode::ok) << outcome.message;
  return std::move(outcome.scene);
}

Positions corners_of(const Scene& scene, size_t triangle) {
  Positions corners;
  for (int k = 0; k < 3; ++k) corners.push_back(scene.vertices[scene.triangles.at(triangle)[k]].position);
  return corners;
}

/// Five points of a zigzag, so that strips and fans differ.
GltfFixture zigzag(uint32_t mode) {
  GltfFixture gltf;
  gltf.show(
      {{"attributes",
        {{"POSITION", gltf.add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0})}}},
       {"mode", mode}});
  return gltf;
}

TEST(GltfModes, StripsKeepTheirWinding) {
  const Scene scene = load(zigzag(5));
  ASSERT_EQ(scene.triangles.size(), 3u);
  for (uint32_t t = 0; t < 3; ++t) EXPECT_GT(triangle_cross(scene, t).z, 0) << t;
}

TEST(GltfModes, FansShareTheirFirstPoint) {
  const Scene scene = load(zigzag(6));
  ASSERT_EQ(scene.triangles.size(), 3u);
  for (size_t t = 0; t < 3; ++t) {
    const Positions corners = corners_of(scene, t);
    EXPECT_NE(std::find(corners.begin(), corners.end(), Vec3(0)), corners.end()) << t;
  }
  EXPECT_EQ(corners_of(scene, 0), (Positions{{1, 0, 0}, {0, 1, 0}, {0, 0, 0}}));
}

TEST(GltfModes, TrianglesLeaveARestOut) { EXPECT_EQ(load(zigzag(4)).triangles.size(), 1u); }

template <class Index>
void expect_indexed() {
  GltfFixture gltf;
  const size_t positions = gltf.add_accessor<float>("VEC3", {9, 9, 9, 0, 1, 0, 1, 0, 0, 0, 0, 0});
  gltf.show({{"attributes", {{"POSITION", positions}}},
             {"indices", gltf.add_accessor<Index>("SCALAR", {3, 2, 1})}});
  const Scene scene = load(gltf);
  EXPECT_EQ(corners_of(scene, 0), (Positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
}

TEST(GltfIndices, EveryType) {
  expect_indexed<uint8_t>();
  expect_indexed<uint16_t>();
  expect_indexed<uint32_t>();
}

TEST(GltfAccessors, SparseReplacesValues) {
  GltfFixture gltf = triangle_fixture();
  const size_t at = gltf.add_view<uint8_t>({0, 2}), values = gltf.add_view<float>({0, 0, 5, 0, 7, 0});
  gltf.json["accessors"][0]["sparse"] = {{"count", 2},
                                         {"indices", {{"bufferView", at}, {"componentType", 5121}}},
                                         {"values", {{"bufferView", values}}}};
  EXPECT_EQ(corners_of(load(gltf), 0), (Positions{{0, 0, 5}, {1, 0, 0}, {0, 7, 0}}));
  // Without a view, what is not replaced is zero.
  gltf.json["accessors"][0].erase("bufferView");
  gltf.json["accessors"][0]["sparse"]["count"] = 2;
  EXPECT_EQ(load_outcome(gltf).scene.facts.skipped_triangles, 0u);
  EXPECT_EQ(corners_of(load(gltf), 0), (Positions{{0, 0, 5}, {0, 0, 0}, {0, 7, 0}}));
}

TEST(GltfAccessors, StridesSkipWhatLiesBetween) {
  GltfFixture gltf;
  const size_t view = gltf.add_view<float>({0, 0, 0, 50, 1, 0, 0, 60, 0, 1, 0, 70}, {{"byteStride", 16}});
  const size_t positions = gltf.add_accessor_of(view, "VEC3", 5126, 3);
  gltf.show({{"attributes", {{"POSITION", positions}}}});
  EXPECT_EQ(corners_of(load(gltf), 0), (Positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
}

TEST(GltfAccessors, QuantizedPositionsNeedTheExtension) {
  GltfFixture gltf;
  const size_t view = gltf.add_view<int8_t>({0, 0, 0, 0, 127, 0, 0, 0, 0, -128, 0, 0}, {{"byteStride", 4}});
  const size_t plain = gltf.add_accessor_of(view, "VEC3", 5120, 3);
  gltf.show({{"attributes", {{"POSITION", plain}}}});
  EXPECT_EQ(load_outcome(gltf).exit, ExitCode::bad_input);
  gltf.json["extensionsRequired"] = gltf.json["extensionsUsed"] = {"KHR_mesh_quantization"};
  EXPECT_EQ(corners_of(load(gltf), 0), (Positions{{0, 0, 0}, {127, 0, 0}, {0, -128, 0}}));
  gltf.json["accessors"][0]["normalized"] = true;  // glTF 2.0 §3.11: max(c / 127, -1)
  EXPECT_EQ(corners_of(load(gltf), 0), (Positions{{0, 0, 0}, {1, 0, 0}, {0, -1, 0}}));
}

TEST(GltfAttributes, TexCoordsAndColorsOfEveryType) {
  GltfFixture gltf = triangle_fixture();
  auto& attributes = gltf.primitive()["attributes"];
  attributes["TEXCOORD_0"] =
      gltf.add_accessor<uint8_t>("VEC2", {0, 255, 51, 102, 0, 0}, {{"normalized", true}});
  attributes["TEXCOORD_1"] =
      gltf.add_accessor<uint16_t>("VEC2", {0, 65535, 13107, 26214, 0, 0}, {{"normalized", true}});
  attributes["COLOR_0"] = gltf.add_accessor<float>("VEC3", {1, 0, 0, 0, 0.5f, 2, -1, 0.2f, 0});
  const Scene scene = load(gltf);
  const UVec3 t = scene.triangles.at(0);
  EXPECT_EQ(scene.vertices[t.x].uv[0], Vec2(0, 1));
  EXPECT_NEAR(scene.vertices[t.y].uv[0].x, 0.2f, 1e-6);
  EXPECT_NEAR(scene.vertices[t.y].uv[1].y, 0.4f, 1e-6);
  EXPECT_EQ(scene.vertices[t.x].color, 0xff0000ffu);
  EXPECT_EQ(scene.vertices[t.y].color, 0xffff8000u);
  EXPECT_EQ(scene.vertices[t.z].color, 0xff003300u);
}

// ---- Normals and transforms ----

TEST(GltfNormals, FlatWhereThereAreNone) {
  GltfFixture gltf;
  // Two faces at a right angle that share an edge.
  const size_t positions = gltf.add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1});
  gltf.show({{"attributes", {{"POSITION", positions}}},
             {"indices", gltf.add_accessor<uint8_t>("SCALAR", {0, 1, 2, 0, 3, 1})}});
  const Scene scene = load(gltf);
  EXPECT_EQ(scene.vertices.size(), 6u);
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(scene.vertices[scene.triangles[0][k]].normal, Vec3(0, 0, 1));
    EXPECT_EQ(scene.vertices[scene.triangles[1][k]].normal, Vec3(0, 1, 0));
  }
}

GltfFixture triangle_with_frame() {
  GltfFixture gltf = triangle_fixture();
  auto& attributes = gltf.primitive()["attributes"];
  const float s = std::sqrt(0.5f);
  attributes["NORMAL"] = gltf.add_accessor<float>("VEC3", {s, 0, s, s, 0, s, s, 0, s});
  attributes["TANGENT"] = gltf.add_accessor<float>("VEC4", {s, 0, -s, 1, s, 0, -s, 1, s, 0, -s, 1});
  return gltf;
}

TEST(GltfTransforms, NormalsStayPerpendicularUnderStretching) {
  GltfFixture gltf = triangle_with_frame();
  gltf.json["nodes"][0]["scale"] = {4, 1, 0.5};
  const Scene scene = load(gltf);
  const Vertex& v = scene.vertices[scene.triangles.at(0).x];
  EXPECT_NEAR(glm::length(v.normal - glm::normalize(Vec3(0.25f, 0, 2))), 0, 1e-6);
  EXPECT_NEAR(glm::length(Vec3(v.tangent) - glm::normalize(Vec3(4, 0, -0.5f))), 0, 1e-6);
  EXPECT_NEAR(glm::dot(v.normal, Vec3(v.tangent)), 0, 1e-6);
  EXPECT_EQ(v.tangent.w, 1);
}

TEST(GltfTransforms, MirroringTurnsTheWindingAndTheHandednessRound) {
  GltfFixture gltf = triangle_with_frame();
  gltf.json["nodes"][0]["scale"] = {-1, 1, 1};
  const Scene scene = load(gltf);
  const Vertex& v = scene.vertices[scene.triangles.at(0).x];
  EXPECT_GT(glm::dot(triangle_cross(scene, 0), v.normal), 0);
  EXPECT_NEAR(glm::length(v.normal - glm::normalize(Vec3(-1, 0, 1))), 0, 1e-6);
  // What the bitangent was, mirrored, is what normal, tangent and handedness say now.
  const Vec3 bitangent = v.tangent.w * glm::cross(v.normal, Vec3(v.tangent));
  const float s = std::sqrt(0.5f);
  const Vec3 before = glm::cross(Vec3(s, 0, s), Vec3(s, 0, -s));
  EXPECT_NEAR(glm::length(bitangent - before * Vec3(-1, 1, 1)), 0, 1e-6);
}

TEST(GltfTransforms, HierarchiesMultiplyAndOnlyTheDefaultSceneIsShown) {
  GltfFixture gltf = triangle_fixture();
  gltf.json["nodes"] = {{{"mesh", 0}, {"translation", {1, 0, 0}}},
                        {{"children", {0}}, {"rotation", {0, 0, std::sqrt(0.5), std::sqrt(0.5)}}},
                        {{"children", {1}}, {"matrix", {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 7, 1}}},
                        {{"mesh", 0}}};
  gltf.json["scenes"] = {{{"nodes", {3}}}, {{"nodes", {2}}}};
  gltf.json["scene"] = 1;
  const Scene scene = load(gltf);
  ASSERT_EQ(scene.triangles.size(), 1u);
  // (0,0,0) moves to (1,0,0), turns to (0,1,0), doubles to (0,2,0) and is lifted by 7.
  EXPECT_NEAR(glm::length(corners_of(scene, 0)[0] - Vec3(0, 2, 7)), 0, 1e-5);
}

TEST(GltfTransforms, InstancesShareTheirDataAndStandApart) {
  GltfFixture gltf = triangle_fixture();
  gltf.json["nodes"].push_back({{"mesh", 0}, {"translation", {5, 0, 0}}});
  gltf.json["scenes"][0]["nodes"] = {0, 1};
  const Scene scene = load(gltf);
  ASSERT_EQ(scene.triangles.size(), 2u);
  EXPECT_EQ(corners_of(scene, 1)[0], corners_of(scene, 0)[0] + Vec3(5, 0, 0));
  EXPECT_EQ(scene.bounds.high, Vec3(6, 1, 0));
}

TEST(GltfTransforms, TinyAndHugeScalesKeepUnitNormals) {
  for (const double scale : {1e-12, 1e-6, 1e6, 1e12}) {
    GltfFixture gltf = triangle_with_frame();
    gltf.json["nodes"][0]["scale"] = {scale, scale, scale};
    const Scene scene = load(gltf);
    ASSERT_EQ(scene.triangles.size(), 1u) << scale;
    EXPECT_NEAR(glm::length(scene.vertices[0].normal - glm::normalize(Vec3(1, 0, 1))), 0, 1e-6) << scale;
  }
}

// ---- Tangents ----

/// A grid over a wavy sheet whose texture coordinates are an affine map of its parameters.
struct Sheet {
  std::vector<Vertex> vertices;
  std::vector<UVec3> triangles;
};

Sheet wavy_sheet(Vec2 across, Vec2 along) {
  constexpr uint32_t n = 24;
  Sheet sheet;
  for (uint32_t j = 0; j <= n; ++j) {
    for (uint32_t i = 0; i <= n; ++i) {
      const float x = static_cast<float>(i) / n, y = static_cast<float>(j) / n;
      Vertex v{};
      v.position = {x, y, 0.1f * std::sin(3 * x) * std::cos(2 * y)};
      v.normal = glm::normalize(
          Vec3(-0.3f * std::cos(3 * x) * std::cos(2 * y), 0.2f * std::sin(3 * x) * std::sin(2 * y), 1));
      v.uv[0] = x * across + y * along;
      sheet.vertices.push_back(v);
    }
  }
  for (uint32_t j = 0; j < n; ++j) {
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      sheet.triangles.push_back({a, b, d}), sheet.triangles.push_back({a, d, c});
    }
  }
  return sheet;
}

/// On the sheet, ∂p/∂u and the direction against v are known.
TEST(Tangents, FollowTheTextureCoordinates) {
  for (const bool mirrored : {false, true}) {
    const Vec2 across(mirrored ? -2.0f : 2.0f, 0), along(0, -3);  // v runs down
    Sheet sheet = wavy_sheet(across, along);
    const size_t before = sheet.vertices.size();
    make_tangents(sheet.vertices, sheet.triangles, TextureUse{});
    EXPECT_EQ(sheet.vertices.size(), before);
    for (const Vertex& v : sheet.vertices) {
      const Vec3 tangent(v.tangent), bitangent = v.tangent.w * glm::cross(v.normal, tangent);
      EXPECT_NEAR(glm::length(tangent), 1, 1e-5);
      EXPECT_NEAR(glm::dot(tangent, v.normal), 0, 1e-5);
      EXPECT_GT((mirrored ? -1 : 1) * tangent.x, 0.9f);
      EXPECT_GT(bitangent.y, 0.9f);
      EXPECT_EQ(v.tangent.w, mirrored ? -1 : 1);
    }
  }
}

TEST(Tangents, MirroredHalvesDoNotShareVertices) {
  Sheet sheet = wavy_sheet({1, 0}, {0, -1});
  for (Vertex& v : sheet.vertices) v.uv[0].x = std::abs(v.uv[0].x - 0.5f);
  const size_t before = sheet.vertices.size();
  make_tangents(sheet.vertices, sheet.triangles, TextureUse{});
  EXPECT_EQ(sheet.vertices.size(), before + 25);  // those on the seam
  for (const UVec3& t : sheet.triangles) {
    EXPECT_EQ(sheet.vertices[t.x].tangent.w, sheet.vertices[t.y].tangent.w);
    EXPECT_EQ(sheet.vertices[t.x].tangent.w, sheet.vertices[t.z].tangent.w);
    const Vec3 centre =
        (sheet.vertices[t.x].position + sheet.vertices[t.y].position + sheet.vertices[t.z].position) / 3.0f;
    EXPECT_EQ(sheet.vertices[t.x].tangent.w, centre.x > 0.5f ? 1 : -1);
  }
}

TEST(Tangents, NoMappingGivesNone) {
  Sheet sheet = wavy_sheet({0, 0}, {0, 0});
  make_tangents(sheet.vertices, sheet.triangles, TextureUse{});
  for (const Vertex& v : sheet.vertices) EXPECT_EQ(v.tangent, Vec4(0));
}

/// Meshes that bring tangents are their own reference: made anew, they must agree.
TEST(Tangents, AgreeWithThoseOfRealFiles) {
  const std::filesystem::path data = HALFLIGHT_SHARED_DATA;
  if (!std::filesystem::exists(data)) GTEST_SKIP() << "no shared data beside the checkout";
  for (const char* file :
       {"gltf/khronos/FlightHelmet/FlightHelmet.gltf", "gltf/khronos/WaterBottle/WaterBottle.gltf"}) {
    const Scene scene = load_outcome(data / file).scene;
    std::vector<Vertex> vertices = scene.vertices;
    std::vector<UVec3> triangles = scene.triangles;
    make_tangents(vertices, triangles, TextureUse{});
    size_t agreeing = 0, compared = 0;
    for (size_t t = 0; t < triangles.size(); ++t) {
      for (int k = 0; k < 3; ++k) {
        const Vec4 ours = vertices[triangles[t][k]].tangent,
                   theirs = scene.vertices[scene.triangles[t][k]].tangent;
        if (theirs.w == 0 || ours.w == 0) continue;
        ++compared;
        if (ours.w == theirs.w && glm::dot(Vec3(ours), Vec3(theirs)) > 0.9f) ++agreeing;
      }
    }
    EXPECT_GT(compared, triangles.size()) << file;
    EXPECT_GT(agreeing, compared * 95 / 100) << file << ": " << agreeing << " of " << compared;
  }
}

}  // namespace

}  // namespace halflight
