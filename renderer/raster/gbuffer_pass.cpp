#include "raster/gbuffer_pass.h"

#include <bit>

#include "core/parallel.h"

namespace halflight {

namespace {

constexpr size_t texel_bytes = 16;

/// What the shader needs to make `camera_ray`s.
struct RayAxes {
  Vec3 x, y;
};

RayAxes ray_axes(const Camera& camera, int width, int height) {
  const float half_height = camera.projection == Projection::perspective
                                ? std::tan(0.5f * camera.vertical_fov)
                                : camera.half_height;
  const float aspect = static_cast<float>(width) / static_cast<float>(height);
  return {camera.right * (half_height * aspect), camera.up * half_height};
}

/// One pixel of the targets, as read back.
struct RawTexel {
  glm::uvec4 position_triangle;
  Vec4 shading_normal_f90, tangent_roughness, diffuse_roughness, specular_normal, emission_normal;
};

uint32_t program_key(const DrawBatch& batch) {
  return texture_mask(batch) | (batch.alpha_test ? 1u << MATERIAL_TEXTURES : 0);
}

Vec3 xyz(Vec4 v) { return {v.x, v.y, v.z}; }

/// Unit normal of the triangle on wo's side, as `shade_surface` has it.
Vec3 facing_normal(const Scene& scene, uint32_t triangle, Vec3 wo) {
  const Vec3 cross = triangle_cross(scene, triangle);
  const float scale = max_component(glm::abs(cross));
  if (!(scale > 0) || !std::isfinite(scale)) return wo;
  const Vec3 normal = glm::normalize(cross / scale);
  return glm::dot(normal, wo) >= 0 ? normal : -normal;
}

GBufferTexel background_texel(const Scene& scene, Vec3 wo) {
  GBufferTexel texel;
  texel.wo = wo;
  texel.emission = environment_radiance(scene.environment, -wo);
  return texel;
}

GBufferTexel surface_texel(const Scene& scene, const RawTexel& raw, Vec3 wo) {
  GBufferTexel texel;
  texel.position = {std::bit_cast<float>(raw.position_triangle.x),
                    std::bit_cast<float>(raw.position_triangle.y),
                    std::bit_cast<float>(raw.position_triangle.z)};
  texel.triangle = raw.position_triangle.w;
  texel.material = scene.triangle_material[texel.triangle];
  texel.geometric_normal = facing_normal(scene, texel.triangle, wo);
  texel.shading_normal = xyz(raw.shading_normal_f90);
  texel.tangent = xyz(raw.tangent_roughness);
  texel.wo = wo;
  texel.emission = xyz(raw.emission_normal);
  const Material& material = scene.materials[texel.material];
  if (!material.unlit && material.model != BrdfModel::none) {
    texel.brdf.model = material.model;
    texel.brdf.diffuse = xyz(raw.diffuse_roughness);
    texel.brdf.specular = xyz(raw.specular_normal);
    texel.brdf.f90 = raw.shading_normal_f90.w;
    texel.brdf.roughness = {raw.tangent_roughness.w, raw.diffuse_roughness.w};
  }
  return texel;
}

}  // namespace

void bind_gbuffer(const GlFunctions& gl, const GlProgram& program, const GpuScene& scene,
                  const GBufferPass& gbuffer) {
  const Camera& camera = gbuffer.camera();
  program.set("eye", camera.position);
  program.set("ray_back", camera.back);
  program.set("orthographic", camera.projection == Projection::orthographic ? 1 : 0);
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_MATERIALS, scene.materials);
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_TRIANGLE_MATERIALS, scene.triangle_materials);
  for (int i = 0; i < GBUFFER_TARGETS; ++i) {
    gl.ActiveTexture(GL_TEXTURE0 + UNIT_GBUFFER_IDS + i);
    gl.BindTexture(GL_TEXTURE_2D, gbuffer.targets().colors[i]);
  }
}

Mat4 raster_projection(const Camera& camera, const Aabb& bounds, int width, int height, Vec2 jitter) {
  const ClipRange range = clip_range(camera, bounds);
  // The sample points move one way, the picture the other.
  Mat4 projection = projection_matrix(camera, width, height, range.near_plane, range.far_plane, -jitter);
  for (int column = 0; column < 4; ++column) projection[column][1] = -projection[column][1];
  if (camera.projection == Projection::perspective) {
    // Rays start at the eye: the near plane may be as close as numbers allow, at no loss of resolution.
    const float reach =
        bounds.empty() ? 1.0f : bounds.diagonal() + glm::length(bounds.centre() - camera.position);
    projection[2][2] = 0;
    projection[3][2] = std::max(reach * 0x1p-24f, std::numeric_limits<float>::min() * 0x1p24f);
  } else {
    projection[2][2] = 1 / range.far_plane;
    projection[3][2] = 1;
  }
  Mat4 rotation = view_matrix(camera);
  rotation[3] = {0, 0, 0, 1};
  return projection * rotation;
}

GBufferPass::GBufferPass(GlContextBase& context, const GpuScene& gpu_scene) : context_(context) {
  for (const DrawBatch& batch : gpu_scene.draws.batches) {
    GlProgram& program = programs_[program_key(batch)];
    if (program) continue;
    std::vector<std::string> defines = {fmt::format("TEXTURE_MASK {}", texture_mask(batch))};
    if (batch.alpha_test) defines.push_back("ALPHA_TEST 1");
    program = GlProgram(context.gl,
                        {{GL_VERTEX_SHADER, "gbuffer.vert"}, {GL_FRAGMENT_SHADER, "gbuffer.frag"}}, defines);
  }
}

void GBufferPass::make_targets(int width, int height) {
  if (targets_.width == width && targets_.height == height) return;
  const GlFunctions& gl = context_.gl;
  const auto refuse = [&] {
    throw Error(ExitCode::no_gl, fmt::format("OpenGL cannot draw a G-buffer of {}×{}", width, height));
  };
  GLint greatest_size = 0;
  gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &greatest_size);
  if (std::max(width, height) > greatest_size) refuse();
  targets_ = {};
  const auto make_target = [&](GLint internal_format, GLenum format, GLenum type) {
    GlName texture = make_texture(gl);
    gl.BindTexture(GL_TEXTURE_2D, texture);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    gl.TexImage2D(GL_TEXTURE_2D, 0, internal_format, width, height, 0, format, type, nullptr);
    return texture;
  };
  targets_.framebuffer = make_framebuffer(gl);
  gl.BindFramebuffer(GL_FRAMEBUFFER, targets_.framebuffer);
  GLenum attachments[GBUFFER_TARGETS];
  for (int i = 0; i < GBUFFER_TARGETS; ++i) {
    targets_.colors[i] = i == 0 ? make_target(GL_RGBA32UI, GL_RGBA_INTEGER, GL_UNSIGNED_INT)
                                : make_target(GL_RGBA32F, GL_RGBA, GL_FLOAT);
    attachments[i] = GL_COLOR_ATTACHMENT0 + i;
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, attachments[i], GL_TEXTURE_2D, targets_.colors[i], 0);
  }
  targets_.depth = make_target(GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT);
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, targets_.depth, 0);
  gl.BindTexture(GL_TEXTURE_2D, 0);
  gl.DrawBuffers(GBUFFER_TARGETS, attachments);
  targets_.read_back = make_buffer(gl);
  gl.BindBuffer(GL_PIXEL_PACK_BUFFER, targets_.read_back);
  gl.BufferData(GL_PIXEL_PACK_BUFFER, GBUFFER_TARGETS * texel_bytes * static_cast<GLsizeiptr>(width) * height,
                nullptr, GL_STREAM_READ);
  gl.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  context_.check("making the G-buffer");
  if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) refuse();
  targets_.width = width, targets_.height = height;
}

void GBufferPass::draw_batches(const GpuScene& gpu_scene, const Mat4& projection, Vec2 jitter,
                               uint32_t alpha_seed) {
  const RayAxes axes = ray_axes(camera_, targets_.width, targets_.height);
  const GlProgram* in_use = nullptr;
  for (const DrawBatch& batch : gpu_scene.draws.batches) {
    const GlProgram& program = programs_.at(program_key(batch));
    if (&program != in_use) {
      program.use();
      program.set("eye", camera_.position);
      program.set("clip_from_eye_offset", projection);
      program.set("ray_x", axes.x);
      program.set("ray_y", axes.y);
      program.set("ray_back", camera_.back);
      program.set("jitter", jitter);
      program.set("picture_size", Vec2(targets_.width, targets_.height));
      program.set("orthographic", camera_.projection == Projection::orthographic ? 1 : 0);
      program.set("alpha_seed", alpha_seed);
      in_use = &program;
    }
    draw_batch(context_.gl, gpu_scene, program, batch);
  }
}

void GBufferPass::draw(const GpuScene& gpu_scene, const Scene& scene, const Camera& camera, Vec2 jitter,
                       uint32_t alpha_seed, GBuffer& gbuffer) {
  if (gbuffer.width <= 0 || gbuffer.height <= 0) return;
  const GlFunctions& gl = context_.gl;
  camera_ = camera;
  make_targets(gbuffer.width, gbuffer.height);

  // Draw
  gl.BindFramebuffer(GL_FRAMEBUFFER, targets_.framebuffer);
  gl.Viewport(0, 0, targets_.width, targets_.height);
  gl.Enable(GL_DEPTH_TEST);
  const GLuint background[4] = {0, 0, 0, NO_TRIANGLE};
  const GLfloat zero[4] = {0, 0, 0, 0};
  gl.ClearBufferuiv(GL_COLOR, 0, background);
  for (int i = 1; i < GBUFFER_TARGETS; ++i) gl.ClearBufferfv(GL_COLOR, i, zero);
  gl.ClearBufferfv(GL_DEPTH, 0, zero);
  bind_scene(gl, gpu_scene);
  const Mat4 projection = raster_projection(camera, scene.bounds, targets_.width, targets_.height, jitter);
  draw_batches(gpu_scene, projection, jitter, alpha_seed);

  read_back(scene, jitter, gbuffer);
}

void GBufferPass::read_back(const Scene& scene, Vec2 jitter, GBuffer& gbuffer) {
  const GlFunctions& gl = context_.gl;
  const size_t pixels = gbuffer.pixel_count(), target_bytes = texel_bytes * pixels;

  // All copies are queued before the first wait
  gl.BindBuffer(GL_PIXEL_PACK_BUFFER, targets_.read_back);
  for (int i = 0; i < GBUFFER_TARGETS; ++i) {
    gl.ReadBuffer(GL_COLOR_ATTACHMENT0 + i);
    gl.ReadPixels(0, 0, targets_.width, targets_.height, i == 0 ? GL_RGBA_INTEGER : GL_RGBA,
                  i == 0 ? GL_UNSIGNED_INT : GL_FLOAT, reinterpret_cast<void*>(i * target_bytes));
  }
  const void* mapped = gl.MapBufferRange(
      GL_PIXEL_PACK_BUFFER, 0, static_cast<GLsizeiptr>(GBUFFER_TARGETS * target_bytes), GL_MAP_READ_BIT);
  if (mapped == nullptr) {
    gl.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    context_.check("reading the G-buffer");
    throw Error(ExitCode::no_gl, "the G-buffer cannot be read back");
  }

  // Assemble the texels
  const auto target = [&](int i) {
    return reinterpret_cast<const Vec4*>(static_cast<const std::byte*>(mapped) + i * target_bytes);
  };
  const auto* ids = static_cast<const glm::uvec4*>(mapped);
  const int width = gbuffer.width, height = gbuffer.height;
  parallel_for(0, pixels, 2048, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const Vec2 pixel(static_cast<float>(i % width) + 0.5f + jitter.x,
                       static_cast<float>(i / width) + 0.5f + jitter.y);
      const Vec3 wo = -camera_ray(camera_, pixel, width, height).direction;
      const RawTexel raw{ids[i], target(1)[i], target(2)[i], target(3)[i], target(4)[i], target(5)[i]};
      gbuffer.texels[i] = raw.position_triangle.w == no_triangle ? background_texel(scene, wo)
                                                                 : surface_texel(scene, raw, wo);
    }
  });
  gl.UnmapBuffer(GL_PIXEL_PACK_BUFFER);
  gl.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  context_.check("reading the G-buffer");
}

}  // namespace halflight
