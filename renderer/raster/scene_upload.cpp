#include "raster/scene_upload.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace halflight {

namespace {

static_assert(sizeof(Vertex) == 4 * VERTEX_WORDS && offsetof(Vertex, normal) == 4 * VERTEX_NORMAL &&
              offsetof(Vertex, tangent) == 4 * VERTEX_TANGENT && offsetof(Vertex, uv) == 4 * VERTEX_UV &&
              offsetof(Vertex, color) == 4 * VERTEX_COLOR);
static_assert(static_cast<uint32_t>(BrdfModel::none) == MODEL_NONE &&
              static_cast<uint32_t>(BrdfModel::ggx) == MODEL_GGX &&
              static_cast<uint32_t>(BrdfModel::phong) == MODEL_PHONG &&
              static_cast<uint32_t>(BrdfModel::ashikhmin_shirley) == MODEL_ASHIKHMIN_SHIRLEY);
static_assert(static_cast<uint32_t>(AlphaMode::opaque) == ALPHA_OPAQUE &&
              static_cast<uint32_t>(AlphaMode::mask) == ALPHA_MASK &&
              static_cast<uint32_t>(AlphaMode::blend) == ALPHA_BLEND);
static_assert(static_cast<uint32_t>(Wrap::repeat) == WRAP_REPEAT &&
              static_cast<uint32_t>(Wrap::mirror) == WRAP_MIRROR &&
              static_cast<uint32_t>(Wrap::clamp) == WRAP_CLAMP);

/// The material's textures in the order of MATERIAL_*.
std::array<const TextureUse*, MATERIAL_TEXTURES> texture_uses(const Material& m) {
  return {&m.base_color_texture, &m.metallic_roughness_texture, &m.normal_texture,    &m.emission_texture,
          &m.specular_texture,   &m.specular_color_texture,     &m.anisotropy_texture};
}

/// Image a use looks up; -1 where there is none, or an empty one.
int32_t image_of(const Scene& scene, const TextureUse& use) {
  if (!use.used()) return -1;
  const uint32_t image = scene.textures[use.texture].image;
  return scene.images[image].width > 0 && scene.images[image].height > 0 ? static_cast<int32_t>(image) : -1;
}

/// What has to agree within a draw.
struct BatchKey {
  bool alpha_test;
  std::array<int32_t, MATERIAL_TEXTURES> images;
  auto operator<=>(const BatchKey&) const = default;
};

BatchKey batch_key(const Scene& scene, const Material& material) {
  BatchKey key{material.alpha_mode != AlphaMode::opaque, {}};
  const auto uses = texture_uses(material);
  for (size_t slot = 0; slot < uses.size(); ++slot) key.images[slot] = image_of(scene, *uses[slot]);
  return key;
}

uint32_t least_corner(UVec3 t) { return std::min({t.x, t.y, t.z}); }
uint32_t greatest_corner(UVec3 t) { return std::max({t.x, t.y, t.z}); }

/// Appends one group's triangles, cut into batches of bounded vertex range.
void append_group(const Scene& scene, const BatchKey& key, std::vector<uint32_t>& members,
                  size_t vertex_window, DrawList& list) {
  if (scene.vertices.size() > vertex_window) {
    std::stable_sort(members.begin(), members.end(), [&](uint32_t a, uint32_t b) {
      return least_corner(scene.triangles[a]) < least_corner(scene.triangles[b]);
    });
  }
  DrawBatch* batch = nullptr;
  for (const uint32_t triangle : members) {
    const UVec3 corners = scene.triangles[triangle];
    if (batch == nullptr || greatest_corner(corners) - batch->first_vertex >= vertex_window) {
      const uint32_t first_vertex =
          scene.vertices.size() > vertex_window ? least_corner(corners) / vertex_step * vertex_step : 0;
      if (greatest_corner(corners) - first_vertex >= vertex_window)
        throw Error(ExitCode::no_gl,
                    "the scene's vertices lie too far apart for this OpenGL's storage buffers");
      const auto first = static_cast<uint32_t>(list.indices.size());
      batch = &list.batches.emplace_back(DrawBatch{first, 0, first_vertex, key.alpha_test, key.images});
    }
    list.indices.push_back(corners);
    list.facts.emplace_back(triangle, scene.triangle_material[triangle]);
    ++batch->triangle_count;
  }
}

gpu::GpuTextureUse make_texture_use(const Scene& scene, const TextureUse& use) {
  gpu::GpuTextureUse result{Vec4(use.row_u, 0), Vec4(use.row_v, 0), glm::uvec4(0)};
  if (image_of(scene, use) < 0) return result;
  const Texture& texture = scene.textures[use.texture];
  const uint32_t flags = (texture.srgb ? TEXTURE_SRGB : 0) | (texture.nearest ? TEXTURE_NEAREST : 0);
  result.look_up = {use.uv_set, flags, static_cast<uint32_t>(texture.wrap_u),
                    static_cast<uint32_t>(texture.wrap_v)};
  return result;
}

/// Uploads one image; false where it does not fit.
bool upload_image(const GlFunctions& gl, const ImageRgba8& image, GlName& texture) {
  gl.BindTexture(GL_TEXTURE_2D, texture);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, image.width, image.height, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                image.bytes.data());
  return gl.GetError() != GL_OUT_OF_MEMORY;
}

/// Uploads an image at the greatest size that fits.
GlName upload_fitting(GlContextBase& context, const Scene& scene, uint32_t index, Messages& messages) {
  const GlFunctions& gl = context.gl;
  GLint greatest_size = 0;
  gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &greatest_size);
  GlName texture = make_texture(gl);
  const ImageRgba8* image = &scene.images[index];
  ImageRgba8 halved;
  while (std::max(image->width, image->height) > greatest_size || !upload_image(gl, *image, texture)) {
    if (image->width <= 1 && image->height <= 1)
      throw Error(ExitCode::no_gl, "textures: OpenGL is out of memory");
    context.debug_error.clear();
    halved = halve(*image);
    image = &halved;
  }
  if (image == &halved)
    messages.warn(fmt::format("image {} drawn at {}×{} instead of {}×{}: OpenGL has no room for more", index,
                              halved.width, halved.height, scene.images[index].width,
                              scene.images[index].height));
  return texture;
}

/// sRGB's transfer function (IEC 61966-2-1) for each of the 256 codes.
std::vector<float> make_srgb_table() {
  std::vector<float> table(256);
  for (size_t i = 0; i < table.size(); ++i) {
    const double c = static_cast<double>(i) / 255;
    table[i] = static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
  }
  return table;
}

}  // namespace

ImageRgba8 halve(const ImageRgba8& image) {
  ImageRgba8 half{(image.width + 1) / 2, (image.height + 1) / 2, {}};
  half.bytes.reserve(4 * static_cast<size_t>(half.width) * half.height);
  const auto byte = [&](int x, int y, int channel) -> uint32_t {
    const int column = std::min(x, image.width - 1), row = std::min(y, image.height - 1);
    return image.bytes[4 * (static_cast<size_t>(row) * image.width + column) + channel];
  };
  for (int y = 0; y < half.height; ++y)
    for (int x = 0; x < half.width; ++x)
      for (int c = 0; c < 4; ++c) {
        const uint32_t sum = byte(2 * x, 2 * y, c) + byte(2 * x + 1, 2 * y, c) + byte(2 * x, 2 * y + 1, c) +
                             byte(2 * x + 1, 2 * y + 1, c);
        half.bytes.push_back(static_cast<uint8_t>((sum + 2) / 4));
      }
  return half;
}

uint32_t texture_mask(const DrawBatch& batch) {
  uint32_t mask = 0;
  for (int slot = 0; slot < MATERIAL_TEXTURES; ++slot)
    if (batch.images[slot] >= 0) mask |= 1u << slot;
  return mask;
}

DrawList make_draw_list(const Scene& scene, size_t vertex_window) {
  std::vector<BatchKey> keys;
  for (const Material& material : scene.materials) keys.push_back(batch_key(scene, material));
  std::map<BatchKey, std::vector<uint32_t>> groups;  // opaque ones sort first
  for (uint32_t triangle = 0; triangle < scene.triangles.size(); ++triangle)
    groups[keys[scene.triangle_material[triangle]]].push_back(triangle);

  DrawList list;
  list.indices.reserve(scene.triangles.size());
  list.facts.reserve(scene.triangles.size());
  for (auto& [key, members] : groups) {
    append_group(scene, key, members, vertex_window, list);
    if (!key.alpha_test) list.opaque_triangles = static_cast<uint32_t>(list.indices.size());
  }
  return list;
}

std::vector<gpu::GpuMaterial> make_gpu_materials(const Scene& scene) {
  std::vector<gpu::GpuMaterial> result;
  for (const Material& m : scene.materials) {
    gpu::GpuMaterial& g = result.emplace_back();
    g.base_color = m.base_color;
    g.diffuse = Vec4(m.diffuse, m.metallic);
    g.phong_specular = Vec4(m.phong_specular, m.roughness);
    g.specular_color = Vec4(m.specular_color, m.specular);
    g.emission = Vec4(m.emission, m.alpha_cutoff);
    g.exponents = {m.exponents, m.anisotropy, m.anisotropy_rotation};
    g.others = {m.ior, m.normal_scale, 0, 0};
    const uint32_t flags = (m.double_sided ? MATERIAL_DOUBLE_SIDED : 0) | (m.unlit ? MATERIAL_UNLIT : 0);
    g.kinds = {static_cast<uint32_t>(m.model), static_cast<uint32_t>(m.alpha_mode), flags, 0};
    const auto uses = texture_uses(m);
    for (size_t slot = 0; slot < uses.size(); ++slot) g.textures[slot] = make_texture_use(scene, *uses[slot]);
  }
  return result;
}

GpuScene upload_scene(GlContextBase& context, const Scene& scene, Messages& messages) {
  const GlFunctions& gl = context.gl;
  GLint64 block_limit = 0;
  gl.GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &block_limit);
  const size_t limit = static_cast<size_t>(block_limit);

  // Sort the triangles into draws
  GpuScene result;
  result.vertex_bytes = scene.vertices.size() * sizeof(Vertex);
  const size_t window = limit / sizeof(Vertex) / vertex_step * vertex_step;
  result.vertex_window_bytes = window * sizeof(Vertex);
  result.draws = make_draw_list(scene, window);
  if (result.draws.indices.size() * sizeof(UVec3) > limit)
    throw Error(ExitCode::no_gl, fmt::format("{} triangles are too many for this OpenGL's storage buffers",
                                             scene.triangles.size()));

  // Upload geometry and materials
  result.vertices = make_storage(gl, std::span(scene.vertices));
  result.indices = make_storage(gl, std::span<const UVec3>(result.draws.indices));
  result.triangles = make_storage(gl, std::span<const glm::uvec2>(result.draws.facts));
  result.materials = make_storage(gl, std::span<const gpu::GpuMaterial>(make_gpu_materials(scene)));
  result.triangle_materials = make_storage(gl, std::span(scene.triangle_material));
  result.srgb_table = make_storage(gl, std::span<const float>(make_srgb_table()));
  result.vertex_array = make_vertex_array(gl);
  gl.BindVertexArray(result.vertex_array);
  gl.BindBuffer(GL_ARRAY_BUFFER, result.vertices);
  gl.EnableVertexAttribArray(0);
  gl.VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(Vertex), nullptr);
  gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, result.indices);
  gl.BindVertexArray(0);
  context.check("uploading the scene");
  result.draws.indices = {};
  result.draws.facts = {};

  // Upload the images that materials in use look up
  result.white = make_texture(gl);
  upload_image(gl, {1, 1, {255, 255, 255, 255}}, result.white);
  result.images.resize(scene.images.size());
  for (const DrawBatch& batch : result.draws.batches)
    for (const int32_t image : batch.images)
      if (image >= 0 && result.images[image] == 0)
        result.images[image] = upload_fitting(context, scene, image, messages);
  gl.BindTexture(GL_TEXTURE_2D, 0);
  context.check("uploading the textures");
  return result;
}

void update_gpu_materials(GlContextBase& context, const Scene& scene, GpuScene& gpu_scene) {
  gpu_scene.materials =
      make_storage(context.gl, std::span<const gpu::GpuMaterial>(make_gpu_materials(scene)));
  context.check("uploading the materials");
}

void bind_scene(const GlFunctions& gl, const GpuScene& scene) {
  gl.BindVertexArray(scene.vertex_array);
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_INDICES, scene.indices);
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_TRIANGLES, scene.triangles);
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_MATERIALS, scene.materials);
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_SRGB_TABLE, scene.srgb_table);
}

void draw_batch(const GlFunctions& gl, const GpuScene& scene, const GlProgram& program,
                const DrawBatch& batch) {
  for (int slot = 0; slot < MATERIAL_TEXTURES; ++slot) {
    gl.ActiveTexture(GL_TEXTURE0 + slot);
    gl.BindTexture(GL_TEXTURE_2D, batch.images[slot] >= 0 ? scene.images[batch.images[slot]] : scene.white);
  }
  const size_t offset = batch.first_vertex * sizeof(Vertex);
  gl.BindBufferRange(
      GL_SHADER_STORAGE_BUFFER, BINDING_VERTICES, scene.vertices, static_cast<GLintptr>(offset),
      static_cast<GLsizeiptr>(std::min(scene.vertex_bytes - offset, scene.vertex_window_bytes)));
  program.set("first_triangle", batch.first_triangle);
  program.set("first_vertex", batch.first_vertex);
  gl.DrawElements(
      GL_TRIANGLES, static_cast<GLsizei>(3 * batch.triangle_count), GL_UNSIGNED_INT,
      reinterpret_cast<const void*>(static_cast<uintptr_t>(batch.first_triangle) * sizeof(UVec3)));
}

}  // namespace halflight
