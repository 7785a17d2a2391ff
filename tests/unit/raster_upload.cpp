// How a scene is cut into draws and what becomes of images that do not fit; no OpenGL needed. Then the
// manners of a context that others draw to as well.
#include "raster/scene_upload.h"

#include <dlfcn.h>

#include <map>

#include "unit/raster_scenes.h"

namespace halflight {
namespace {

using namespace test;

/// Quads with vertices in scattered order and four materials: two opaque ones that share textures, a
/// textured, a mask.
Scene scattered_scene(int quads) {
  Scene scene;
  scene.materials.resize(4, diffuse_material(Vec3(0.5f)));
  scene.materials[2].normal_texture =
      add_texture(scene, noise_image(2, 2, {9, 9, 9, 9}, {0, 0, 0, 0}, 1), false);
  scene.materials[3].alpha_mode = AlphaMode::mask;
  for (int i = 0; i < quads; ++i)
    add_quad(scene, Vec3(static_cast<float>(i * 7 % quads), 0, 0), {1, 0, 0}, {0, 1, 0},
             static_cast<uint32_t>(i % 4));
  std::reverse(scene.triangles.begin(), scene.triangles.end());
  std::reverse(scene.triangle_material.begin(), scene.triangle_material.end());
  return scene;
}

TEST(DrawList, HoldsEveryTriangleOnceInAsFewDrawsAsTexturesAllow) {
  const Scene scene = scattered_scene(200);
  const DrawList list = make_draw_list(scene, 1 << 20);
  EXPECT_EQ(list.batches.size(), 3u);
  EXPECT_EQ(list.opaque_triangles, 300u);
  std::map<uint32_t, int> seen;
  for (const DrawBatch& batch : list.batches) {
    for (uint32_t i = batch.first_triangle; i < batch.first_triangle + batch.triangle_count; ++i) {
      const uint32_t triangle = list.facts[i].x;
      ++seen[triangle];
      EXPECT_EQ(list.indices[i], scene.triangles[triangle]);
      EXPECT_EQ(list.facts[i].y, scene.triangle_material[triangle]);
      EXPECT_EQ(batch.alpha_test, list.facts[i].y == 3);
      EXPECT_EQ(batch.alpha_test, i >= list.opaque_triangles);
      EXPECT_EQ(texture_mask(batch), list.facts[i].y == 2 ? 1u << MATERIAL_NORMAL : 0u);
    }
  }
  EXPECT_EQ(seen.size(), scene.triangles.size());
  for (const auto& [triangle, times] : seen) EXPECT_EQ(times, 1);
}

TEST(DrawList, BatchesStayWithinTheWindowOfVertices) {
  const Scene scene = scattered_scene(500);
  constexpr size_t window = 256;
  const DrawList list = make_draw_list(scene, window);
  EXPECT_EQ(list.indices.size(), scene.triangles.size());
  uint32_t next = 0;
  for (const DrawBatch& batch : list.batches) {
    EXPECT_EQ(batch.first_vertex % vertex_step, 0u);
    EXPECT_EQ(batch.first_triangle, next);
    next += batch.triangle_count;
    for (uint32_t i = batch.first_triangle; i < next; ++i)
      for (int corner = 0; corner < 3; ++corner) {
        EXPECT_GE(list.indices[i][corner], batch.first_vertex);
        EXPECT_LT(list.indices[i][corner], batch.first_vertex + window);
      }
  }
  EXPECT_EQ(next, scene.triangles.size());
}

TEST(DrawList, ATriangleWiderThanTheWindowIsRefused) {
  Scene scene = scattered_scene(200);
  scene.triangles.push_back({0, 400, 799});
  scene.triangle_material.push_back(0);
  EXPECT_THROW(make_draw_list(scene, 256), Error);
}

TEST(HalvedImages, AverageFourTexelsAndRepeatTheLastOfOddSizes) {
  const ImageRgba8 image{3, 1, {0, 10, 20, 255, 100, 30, 20, 255, 7, 8, 9, 10}};
  const ImageRgba8 half = halve(image);
  EXPECT_EQ(half.width, 2);
  EXPECT_EQ(half.height, 1);
  EXPECT_EQ(half.bytes, (std::vector<uint8_t>{50, 20, 20, 255, 7, 8, 9, 10}));
}

class RasterManners : public OnBackend {};
HALFLIGHT_ON_BACKENDS(RasterManners);

TEST_P(RasterManners, StateOfTheContextIsPutBack) {
  const GlFunctions& gl = base_of(*context).gl;
  Scene scene = scattered_scene(20);
  scene.lights.emplace_back();
  update_bounds(scene);
  Rasterizer raster(*context, scene, {}, messages);
  gl.Viewport(1, 2, 3, 4);
  gl.DepthFunc(GL_LEQUAL);
  gl.Enable(GL_BLEND);
  gl.ClipControl(GL_UPPER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
  GBuffer gbuffer;
  gbuffer.resize(8, 8);
  raster.draw_gbuffer(look_at({0, 0, 9}, {0, 0, 0}, {0, 1, 0}, 1), Vec2(0), 0, gbuffer);
  raster.update_shadow_maps();
  std::vector<Vec3> radiance(64, Vec3(0));
  raster.add_punctual(gbuffer, radiance);
  raster.light_points({BouncePoint{}});

  GLint viewport[4], function = 0, origin = 0, depth_mode = 0, framebuffer = -1, program = -1,
                     vertex_array = -1;
  gl.GetIntegerv(GL_VIEWPORT, viewport);
  gl.GetIntegerv(GL_DEPTH_FUNC, &function);
  gl.GetIntegerv(GL_CLIP_ORIGIN, &origin);
  gl.GetIntegerv(GL_CLIP_DEPTH_MODE, &depth_mode);
  gl.GetIntegerv(GL_FRAMEBUFFER_BINDING, &framebuffer);
  gl.GetIntegerv(GL_CURRENT_PROGRAM, &program);
  gl.GetIntegerv(GL_VERTEX_ARRAY_BINDING, &vertex_array);
  EXPECT_EQ(std::vector<GLint>(viewport, viewport + 4), (std::vector<GLint>{1, 2, 3, 4}));
  EXPECT_EQ(function, GL_LEQUAL);
  EXPECT_EQ(origin, GL_UPPER_LEFT);
  EXPECT_EQ(depth_mode, GL_NEGATIVE_ONE_TO_ONE);
  EXPECT_EQ(framebuffer, 0);
  EXPECT_EQ(program, 0);
  EXPECT_EQ(vertex_array, 0);
  EXPECT_TRUE(gl.IsEnabled(GL_BLEND));
  EXPECT_FALSE(gl.IsEnabled(GL_DEPTH_TEST));
}

TEST_P(RasterManners, ABadShaderProgramSaysWhichAndWhy) {
  try {
    const GlProgram program(base_of(*context).gl, {{GL_COMPUTE_SHADER, "gbuffer.frag"}});
    FAIL() << "a fragment shader compiled as a compute shader";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("gbuffer.frag"), std::string::npos);
  }
}

TEST_P(RasterManners, UpdatedMaterialsAreDrawn) {
  Scene scene;
  scene.materials.push_back(diffuse_material(Vec3(0.5f)));
  add_quad(scene, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 0);
  update_bounds(scene);
  Rasterizer raster(*context, scene, {}, messages);
  scene.materials[0].emission = {1, 2, 3};
  raster.update_materials();
  GBuffer gbuffer;
  gbuffer.resize(1, 1);
  raster.draw_gbuffer(look_at({0.1f, 0.1f, 3}, {0, 0, 0}, {0, 1, 0}, 0.5f), Vec2(0), 0, gbuffer);
  EXPECT_EQ(gbuffer.texels[0].emission, Vec3(1, 2, 3));
}

void* (*egl_get_proc_address)(const char*) = nullptr;

TEST(AdoptedContext, DrawsInAContextMadeByOthers) {
  const auto owner = context_or_null(Backend::egl);
  if (!owner) GTEST_SKIP() << "libEGL is not installed";
  void* library = dlopen("libEGL.so.1", RTLD_NOW);
  ASSERT_NE(library, nullptr);
  egl_get_proc_address = reinterpret_cast<void* (*)(const char*)>(dlsym(library, "eglGetProcAddress"));
  const auto adopted = GlContext::adopt(egl_get_proc_address);
  EXPECT_EQ(adopted->description().backend, "window");
  EXPECT_EQ(adopted->description().renderer, owner->description().renderer);
  Scene scene = scattered_scene(20);
  update_bounds(scene);
  Messages messages;
  Rasterizer raster(*adopted, scene, {}, messages);
  GBuffer gbuffer;
  gbuffer.resize(8, 8);
  raster.draw_gbuffer(look_at({10, 0.5f, 9}, {10, 0.5f, 0}, {0, 1, 0}, 0.05f), Vec2(0), 0, gbuffer);
  EXPECT_TRUE(gbuffer.texels[0].hit());
}

}  // namespace
}  // namespace halflight
