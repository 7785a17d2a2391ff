// The built-in scenes as .glb, read by tinygltf: a writer that only its own reader understands would pass its own tests.
#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include "scene/load.h"

namespace halflight {
namespace {

size_t triangle_count(const tinygltf::Model& model) {
  size_t indices = 0;
  for (const tinygltf::Mesh& mesh : model.meshes)
    for (const tinygltf::Primitive& primitive : mesh.primitives)
      indices += model.accessors[static_cast<size_t>(primitive.indices)].count;
  return indices / 3;
}

TEST(GlbWriter, AnotherReaderFindsTheSameScene) {
  for (const BuiltInScene& built_in : built_in_scenes()) {
    const Scene scene = built_in.make();
    const auto file = make_glb(scene, std::string(built_in.name));
    tinygltf::Model model;
    tinygltf::TinyGLTF reader;
    std::string errors, warnings;
    ASSERT_TRUE(reader.LoadBinaryFromMemory(&model, &errors, &warnings,
                                            reinterpret_cast<const unsigned char*>(file.bytes.data()),
                                            static_cast<unsigned>(file.bytes.size())))
        << built_in.name << ": " << errors;
    EXPECT_EQ(errors, "");
    EXPECT_EQ(warnings, "") << built_in.name;
    EXPECT_EQ(triangle_count(model), scene.triangles.size());
    EXPECT_EQ(model.cameras.size(), scene.cameras.size());
    EXPECT_EQ(model.lights.size(), scene.lights.size());
    EXPECT_EQ(model.textures.size(), scene.textures.size());
    EXPECT_GE(model.materials.size(), 1u);
  }
}

}  // namespace
}  // namespace halflight
