// Real glTF files: every positive one loads, with the triangles, extents and materials its documentation
// gives.
#include <gtest/gtest.h>

#include "support/gltf_fixture.h"

namespace halflight {

namespace {

namespace fs = std::filesystem;

const fs::path data = HALFLIGHT_SHARED_DATA;

#define NEEDS_SHARED_DATA() \
  if (!fs::exists(data)) GTEST_SKIP() << "no shared data beside the checkout"

std::vector<fs::path> positive_files() {
  std::vector<fs::path> files;
  for (const char* folder : {"gltf", "gltf-conformance/asset-generator/Positive"}) {
    for (const auto& entry : fs::recursive_directory_iterator(data / folder)) {
      const auto ending = entry.path().extension();
      if (ending == ".gltf" || ending == ".glb") files.push_back(entry.path());
    }
  }
  return files;
}

/// What every consumer of a scene relies on.
void expect_sound(const Scene& scene, const fs::path& file) {
  ASSERT_EQ(scene.triangles.size(), scene.triangle_material.size()) << file;
  for (size_t i = 0; i < scene.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) ASSERT_LT(scene.triangles[i][k], scene.vertices.size()) << file;
    ASSERT_LT(scene.triangle_material[i], scene.materials.size()) << file;
  }
  for (const Vertex& vertex : scene.vertices) {
    ASSERT_TRUE(is_finite(vertex.position)) << file;
    ASSERT_NEAR(glm::length(vertex.normal), 1, 1e-4) << file;
    if (vertex.tangent.w != 0) {
      ASSERT_EQ(std::abs(vertex.tangent.w), 1) << file;
      ASSERT_NEAR(glm::length(Vec3(vertex.tangent)), 1, 1e-4) << file;
    }
  }
  for (const Texture& texture : scene.textures) ASSERT_LT(texture.image, scene.images.size()) << file;
  for (const Material& m : scene.materials) {
    for (const TextureUse* use :
         {&m.base_color_texture, &m.metallic_roughness_texture, &m.normal_texture, &m.emission_texture,
          &m.specular_texture, &m.specular_color_texture, &m.anisotropy_texture}) {
      ASSERT_LT(use->texture, static_cast<int>(scene.textures.size())) << file;
      ASSERT_LT(use->uv_set, 2u) << file;
    }
  }
}

TEST(GltfFiles, EveryPositiveFileLoads) {
  NEEDS_SHARED_DATA();
  const auto files = positive_files();
  EXPECT_GE(files.size(), 132u);
  for (const fs::path& file : files) {
    const LoadOutcome outcome = load_outcome(file);
    EXPECT_EQ(outcome.exit, ExitCode::ok) << outcome.message;
    expect_sound(outcome.scene, file);
  }
}

struct Documented {
  const char* file;
  size_t triangles;  ///< with those that have no area
  Vec3 extent;
};

/// The data's README gives these numbers.
constexpr Documented documented[] = {
    {"gltf/khronos/FlightHelmet/FlightHelmet.gltf", 94722, {0.367f, 0.716f, 0.372f}},
    {"gltf/interiors/hotel-room/hotel-room.glb", 99029, {6.5e3f, 2.2e3f, 9.99e3f}},
    {"gltf/interiors/hotel-room/scene.glb", 99029, {6.5e3f, 2.2e3f, 9.99e3f}},
    {"gltf/interiors/garage/garage.gltf", 11358, {6.78f, 2.98f, 7.55f}},
    {"gltf/interiors/home-theater/home-theater.gltf", 7915, {6.07f, 3.32f, 7.11f}},
    {"gltf/interiors/hacker-room/scene.gltf", 37372, {210, 210, 210}},
    {"gltf/interiors/cornell-bevy/CornellBox.glb", 36, {556, 549, 559}},
    {"gltf/interiors/kitchen-aen/scene.gltf", 3594, {362, 207, 60.1f}},
    {"gltf/interiors/zdm2/zdm2.glb", 58772, {77.2f, 36, 59.6f}},
    {"gltf/interiors/concert-stage/scene.gltf", 10026, {67.5f, 34.7f, 43}},
    {"gltf/khronos/Box/Box.glb", 12, {1, 1, 1}},
    {"gltf/khronos/Box-Draco/Box.gltf", 12, {1, 1, 1}},
    {"gltf/khronos/BoxInterleaved/BoxInterleaved.glb", 12, {1, 1, 1}},
    {"gltf/khronos/SimpleSparseAccessor/SimpleSparseAccessor.gltf", 12, {6, 4, 0}},
    {"gltf/khronos/RiggedSimple/RiggedSimple.glb", 188, {2, 9.15f, 2}},
    {"gltf/khronos/NegativeScaleTest/NegativeScaleTest.glb", 7724, {10.3f, 8.91f, 1}},
    {"gltf/khronos/SheenChair/SheenChair.gltf", 39936, {0.827f, 0.686f, 0.57f}},
    {"gltf/khronos/OrientationTest/OrientationTest.glb", 524, {10.7f, 10.7f, 10.7f}},
    {"gltf/khronos/MetalRoughSpheresNoTextures/MetalRoughSpheresNoTextures.glb",
     1040409,
     {0.0074f, 0.0075f, 0.0037f}},
    {"gltf/misc/shaderball.glb", 88264, {2.14f, 2.09f, 2.08f}},
};

TEST(GltfFiles, TrianglesAndExtentsAreAsDocumented) {
  NEEDS_SHARED_DATA();
  for (const Documented& expected : documented) {
    const LoadOutcome outcome = load_outcome(data / expected.file);
    const Scene& scene = outcome.scene;
    EXPECT_EQ(scene.triangles.size() + scene.facts.skipped_triangles, expected.triangles) << expected.file;
    const Vec3 extent = scene.bounds.extent();
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(extent[k], expected.extent[k], 0.008f * expected.extent[k] + 1e-6f)
          << expected.file << " axis " << k;
    }
  }
}

/// Distance by which two scenes' triangles differ, corner by corner, over the extent.
void expect_same_geometry(const Scene& a, const Scene& b, float tolerance, float normal_tolerance) {
  ASSERT_EQ(a.triangles.size(), b.triangles.size());
  const float scale = a.bounds.diagonal();
  // Encoders may begin a triangle at another corner.
  const auto corner_difference = [&](size_t t, int shift, auto member) {
    float largest = 0;
    for (int k = 0; k < 3; ++k) {
      largest = std::max(largest, glm::length(a.vertices[a.triangles[t][k]].*member -
                                              b.vertices[b.triangles[t][(k + shift) % 3]].*member));
    }
    return largest;
  };
  for (size_t t = 0; t < a.triangles.size(); ++t) {
    int best = 0;
    for (int shift = 1; shift < 3; ++shift) {
      if (corner_difference(t, shift, &Vertex::position) < corner_difference(t, best, &Vertex::position))
        best = shift;
    }
    ASSERT_LE(corner_difference(t, best, &Vertex::position), tolerance * scale) << "triangle " << t;
    ASSERT_LE(corner_difference(t, best, &Vertex::normal), normal_tolerance) << "triangle " << t;
    ASSERT_EQ(a.triangle_material[t], b.triangle_material[t]);
  }
}

TEST(GltfFiles, MeshoptHoldsTheSameRoom) {
  NEEDS_SHARED_DATA();
  const LoadOutcome plain = load_outcome(data / "gltf/interiors/hotel-room/hotel-room.glb");
  const LoadOutcome packed = load_outcome(data / "gltf/interiors/hotel-room/scene.glb");
  expect_same_geometry(plain.scene, packed.scene, 1e-6f, 1e-3f);
  EXPECT_EQ(plain.scene.images.size(), packed.scene.images.size());
}

TEST(GltfFiles, DracoHoldsTheSameBox) {
  NEEDS_SHARED_DATA();
  const Scene plain = load_outcome(data / "gltf/khronos/Box/Box.glb").scene;
  const Scene packed = load_outcome(data / "gltf/khronos/Box-Draco/Box.gltf").scene;
  ASSERT_EQ(plain.triangles.size(), packed.triangles.size());
  // Draco reorders triangles: each of the one has its fellow among the other.
  for (uint32_t t = 0; t < plain.triangles.size(); ++t) {
    const auto centre = [](const Scene& scene, uint32_t i) {
      const UVec3 v = scene.triangles[i];
      return (scene.vertices[v.x].position + scene.vertices[v.y].position + scene.vertices[v.z].position) /
             3.0f;
    };
    size_t fellows = 0;
    for (uint32_t u = 0; u < packed.triangles.size(); ++u) {
      const bool same_place = glm::length(centre(plain, t) - centre(packed, u)) < 1e-3f;
      const bool same_side = glm::dot(triangle_cross(plain, t), triangle_cross(packed, u)) > 0.99f;
      const Vec3 normal = packed.vertices[packed.triangles[u].x].normal;
      if (same_place && same_side && glm::dot(normal, glm::normalize(triangle_cross(packed, u))) > 0.99f)
        ++fellows;
    }
    EXPECT_EQ(fellows, 1u) << t;
  }
}

TEST(GltfFiles, InterleavedIsTheSameBox) {
  NEEDS_SHARED_DATA();
  const Scene plain = load_outcome(data / "gltf/khronos/Box/Box.glb").scene;
  const Scene interleaved = load_outcome(data / "gltf/khronos/BoxInterleaved/BoxInterleaved.glb").scene;
  EXPECT_EQ(plain.triangles.size(), interleaved.triangles.size());
  EXPECT_EQ(plain.bounds.low, interleaved.bounds.low);
  EXPECT_EQ(plain.bounds.high, interleaved.bounds.high);
}

TEST(GltfFiles, FrontsFaceTheWayTheNormalsDo) {
  NEEDS_SHARED_DATA();
  // Mirrored nodes among them: a flipped winding would turn a whole object inside out.
  for (const char* file :
       {"gltf/khronos/NegativeScaleTest/NegativeScaleTest.glb", "gltf/khronos/FlightHelmet/FlightHelmet.gltf",
        "gltf/khronos/RiggedSimple/RiggedSimple.glb", "gltf/khronos/Box-Draco/Box.gltf"}) {
    const Scene scene = load_outcome(data / file).scene;
    size_t agreeing = 0;
    for (uint32_t t = 0; t < scene.triangles.size(); ++t) {
      const UVec3 v = scene.triangles[t];
      const Vec3 sum = scene.vertices[v.x].normal + scene.vertices[v.y].normal + scene.vertices[v.z].normal;
      if (glm::dot(sum, triangle_cross(scene, t)) > 0) ++agreeing;
    }
    EXPECT_GT(agreeing, scene.triangles.size() * 98 / 100) << file;
  }
}

TEST(GltfFiles, LightsAndCameras) {
  NEEDS_SHARED_DATA();
  const Scene lamp = load_outcome(data / "gltf/khronos/LightsPunctualLamp/LightsPunctualLamp.gltf").scene;
  EXPECT_EQ(lamp.lights.size(), 5u);
  const Scene cameras = load_outcome(data / "gltf/khronos/Cameras/Cameras.gltf").scene;
  ASSERT_EQ(cameras.cameras.size(), 2u);
  EXPECT_EQ(cameras.cameras[0].projection, Projection::perspective);
  EXPECT_NEAR(cameras.cameras[0].vertical_fov, 0.7, 1e-6);
  EXPECT_EQ(cameras.cameras[1].projection, Projection::orthographic);
  EXPECT_EQ(cameras.cameras[1].half_height, 1);
  EXPECT_EQ(cameras.cameras[0].position, Vec3(0.5f, 0.5f, 3));
  EXPECT_EQ(cameras.cameras[0].back, Vec3(0, 0, 1));
}

/// The test scene's markers say where the arrow's tip must come to lie: the texture's own tip is at 45° from
/// its corner, so the coordinates looked up at the right marker must lie on the diagonal, those at the wrong
/// one not.
TEST(GltfFiles, TextureTransformTurnsTheRightWay) {
  NEEDS_SHARED_DATA();
  const Scene scene =
      load_outcome(data / "gltf/khronos/TextureTransformTest/TextureTransformTest.gltf").scene;
  const auto looked_up = [&](const char* material, Vec2 marker) {
    for (const Material& m : scene.materials) {
      if (m.name != material) continue;
      const Vec3 uv(marker.x + 0.5f, 0.5f - marker.y, 1);  // of the unit quad about the origin
      return Vec2(glm::dot(m.base_color_texture.row_u, uv), glm::dot(m.base_color_texture.row_v, uv));
    }
    return Vec2(NAN);
  };
  const Vec2 right = looked_up("Rotation", {-0.0790482244f, -0.5162674858f});
  EXPECT_NEAR(right.x, right.y, 1e-5);
  const Vec2 wrong = looked_up("Rotation", {0.5162674858f, 0.0790482244f});
  EXPECT_GT(std::abs(wrong.x - wrong.y), 0.5f);
  const Vec2 all = looked_up("All", {-0.07f, -0.25f});
  EXPECT_NEAR(all.x, all.y, 0.05f);
}

}  // namespace

}  // namespace halflight
