#include "raster/shadow_maps.h"

#include <algorithm>

namespace halflight {

namespace {

// Texels kept free at each border of a view, for the receiver's offset and the four texels around it.
constexpr float border_texels = 4;

// Spots wider than this are seen by a cube: the plane of one view would spread tan θ too thin.
constexpr float widest_single_view = 1.2f;

// All shadow maps of a scene together; larger ones are halved.
constexpr uint64_t greatest_shadow_bytes = uint64_t{1} << 30;

/// Near planes: what is nearer to a light than this fraction of the scene casts no shadow.
constexpr float near_fraction = 0x1p-20f;

// Hashed alpha of casters: one fixed opaque scene, as for rays with this seed.
constexpr uint32_t shadow_alpha_seed = 0;

float with_border(float half_width, int size) {
  const auto texels = static_cast<float>(size);
  return half_width * texels / std::max(texels - 2 * border_texels, 0.5f * texels);
}

bool sees_by_cube(const PunctualLight& light) {
  return light.kind == PunctualKind::point ||
         (light.kind == PunctualKind::spot && light.outer_cone > widest_single_view);
}

/// Half of the diagonal, never 0: near planes and boxes need a length.
float scene_reach(const Scene& scene) {
  const float half_diagonal = 0.5f * scene.bounds.diagonal();
  return std::isfinite(half_diagonal) && half_diagonal > 0 ? half_diagonal : 1.0f;
}

gpu::GpuLight make_gpu_light(const PunctualLight& light, std::span<const PictureSlot> pictures) {
  gpu::GpuLight g{};
  g.position = Vec4(light.position, light.range < infinity ? std::max(light.range, 0.0f) : -1.0f);
  const float outer_cosine = std::cos(light.outer_cone);
  g.direction = Vec4(light.direction, 1 / std::max(0.001f, std::cos(light.inner_cone) - outer_cosine));
  g.up = Vec4(light.up, outer_cosine);
  g.intensity = Vec4(light.intensity, 1 / std::tan(std::clamp(light.outer_cone, 1e-6f, 0.499f * pi)));
  g.kinds.x = light.kind == PunctualKind::point  ? LIGHT_POINT
              : light.kind == PunctualKind::spot ? LIGHT_SPOT
                                                 : LIGHT_DIRECTIONAL;
  if (light.kind == PunctualKind::spot && light.picture >= 0) {
    const PictureSlot& picture = pictures[light.picture];
    g.kinds = {g.kinds.x, picture.first_pixel, picture.width, picture.height};
  }
  return g;
}

gpu::GpuShadowView make_spot_view(const Scene& scene, const PunctualLight& light, int size) {
  const float half_width = with_border(std::tan(std::max(light.outer_cone, 1e-4f)), size);
  const Basis frame = basis_along(light.direction, light.up);
  return {Vec4(light.position, scene_reach(scene) * near_fraction),
          Vec4(frame.bitangent, half_width),
          Vec4(frame.tangent, 0),
          Vec4(light.direction, 0),
          {0, 0, 0, static_cast<uint32_t>(size)}};
}

/// A box around the scene along the light's way.
gpu::GpuShadowView make_directional_view(const Scene& scene, const PunctualLight& light, int size) {
  const Basis frame = basis_around(light.direction);
  const Vec3 centre = scene.bounds.empty() ? Vec3(0) : scene.bounds.centre();
  const Vec3 half = 0.5f * scene.bounds.extent();
  // A box reaches from its centre by the absolute sum of its half extents.
  const auto reach_along = [&](Vec3 axis) { return glm::dot(half, glm::abs(axis)); };
  const float margin = 1e-3f * scene_reach(scene);
  const float half_width = std::max(reach_along(frame.tangent), reach_along(frame.bitangent)) + margin;
  const float depth = reach_along(light.direction) + margin;
  return {Vec4(centre - depth * light.direction, 2 * depth),
          Vec4(frame.tangent, with_border(half_width, size)),
          Vec4(frame.bitangent, 0),
          Vec4(light.direction, 0),
          {0, 0, 1, static_cast<uint32_t>(size)}};
}

/// Face ±axis of a cube about the light.
gpu::GpuShadowView make_face_view(const Scene& scene, const PunctualLight& light, int face, int size) {
  Vec3 forward(0), right(0), up(0);
  const int axis = face / 2;
  forward[axis] = face % 2 == 0 ? 1.0f : -1.0f;
  right[(axis + 1) % 3] = 1;
  up[(axis + 2) % 3] = 1;
  return {Vec4(light.position, scene_reach(scene) * near_fraction),
          Vec4(right, with_border(1, size)),
          Vec4(up, 0),
          Vec4(forward, 0),
          {0, 1, 0, static_cast<uint32_t>(size)}};
}

/// Half the size (rounded up) by averaging 2 × 2 pixels.
ImageRgb halve(const ImageRgb& image) {
  ImageRgb half((image.width + 1) / 2, (image.height + 1) / 2);
  for (int y = 0; y < half.height; ++y)
    for (int x = 0; x < half.width; ++x) {
      const int right = std::min(2 * x + 1, image.width - 1), below = std::min(2 * y + 1, image.height - 1);
      half.at(x, y) = 0.25f * (image.at(2 * x, 2 * y) + image.at(right, 2 * y)) +
                      0.25f * (image.at(2 * x, below) + image.at(right, below));
    }
  return half;
}

GlProgram alpha_tested_program(const GlFunctions& gl, int mask) {
  return {gl,
          {{GL_VERTEX_SHADER, "shadow.vert"}, {GL_FRAGMENT_SHADER, "shadow.frag"}},
          {"ALPHA_TEST 1", fmt::format("TEXTURE_MASK {}", mask)}};
}

bool same_place(const PunctualLight& a, const PunctualLight& b) {
  return a.kind == b.kind && a.position == b.position && a.direction == b.direction && a.up == b.up &&
         a.outer_cone == b.outer_cone;
}

GlName make_depth_array(const GlFunctions& gl, int size, uint32_t layers) {
  GlName texture = make_texture(gl);
  gl.BindTexture(GL_TEXTURE_2D_ARRAY, texture);
  gl.TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl.TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl.TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAX_LEVEL, 0);
  gl.TexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_DEPTH_COMPONENT32F, size, size, static_cast<GLsizei>(layers), 0,
                GL_DEPTH_COMPONENT, GL_FLOAT, nullptr);
  gl.BindTexture(GL_TEXTURE_2D_ARRAY, 0);
  return texture;
}

}  // namespace

LightViews make_light_views(const Scene& scene, const RasterSettings& settings,
                            std::span<const PictureSlot> pictures) {
  LightViews result;
  for (const PunctualLight& light : scene.lights) {
    gpu::GpuLight& g = result.lights.emplace_back(make_gpu_light(light, pictures));
    g.shadow.x = static_cast<uint32_t>(result.views.size());
    if (sees_by_cube(light)) {
      g.shadow.y = CUBE_FACES;
      for (int face = 0; face < static_cast<int>(CUBE_FACES); ++face)
        result.views.push_back(make_face_view(scene, light, face, settings.shadow_cube_size));
    } else {
      g.shadow.y = 1;
      result.views.push_back(light.kind == PunctualKind::spot
                                 ? make_spot_view(scene, light, settings.shadow_map_size)
                                 : make_directional_view(scene, light, settings.shadow_map_size));
    }
  }
  for (gpu::GpuShadowView& view : result.views)
    view.place.x = view.place.y != 0 ? result.cube_layers++ : result.map_layers++;
  return result;
}

ShadowMaps::ShadowMaps(GlContextBase& context, const Scene& scene, const RasterSettings& settings,
                       Messages& messages)
    : context_(context),
      settings_(settings),
      opaque_(context.gl, {{GL_VERTEX_SHADER, "shadow.vert"}, {GL_FRAGMENT_SHADER, "shadow.frag"}}),
      alpha_tested_{alpha_tested_program(context.gl, 0),
                    alpha_tested_program(context.gl, 1 << MATERIAL_BASE_COLOR)},
      framebuffer_(make_framebuffer(context.gl)) {
  upload_pictures(scene, messages);
  const LightViews views = make_light_views(scene, settings_, picture_slots_);
  make_arrays(views.map_layers, views.cube_layers, messages);
}

void ShadowMaps::upload_pictures(const Scene& scene, Messages& messages) {
  GLint64 limit = 0;
  context_.gl.GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &limit);
  const size_t share = static_cast<size_t>(limit) / sizeof(Vec3) / std::max<size_t>(scene.pictures.size(), 1);
  std::vector<Vec3> pixels;
  for (size_t i = 0; i < scene.pictures.size(); ++i) {
    const ImageRgb* picture = &scene.pictures[i];
    ImageRgb halved;
    while (picture->pixels.size() > share) {
      halved = halve(*picture);
      picture = &halved;
    }
    if (picture == &halved)
      messages.warn(fmt::format("projected picture {} drawn at {}×{}: OpenGL has no room for more", i,
                                halved.width, halved.height));
    picture_slots_.push_back({static_cast<uint32_t>(pixels.size()), static_cast<uint32_t>(picture->width),
                              static_cast<uint32_t>(picture->height)});
    pixels.insert(pixels.end(), picture->pixels.begin(), picture->pixels.end());
  }
  pictures_ = make_storage(context_.gl, std::span<const Vec3>(pixels));
}

void ShadowMaps::make_arrays(uint32_t map_layers, uint32_t cube_layers, Messages& messages) {
  const GlFunctions& gl = context_.gl;
  GLint most_layers = 0, greatest_size = 0;
  gl.GetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &most_layers);
  gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &greatest_size);
  if (std::max(map_layers, cube_layers) > static_cast<uint32_t>(most_layers))
    throw Error(ExitCode::no_gl, "more lights than OpenGL has room for shadow maps");
  const auto make_fitting = [&](GlName& texture, int& size, uint32_t layers, const char* what) {
    const int wanted = size;
    const auto bytes = [&] {
      return uint64_t{4} * layers * static_cast<uint64_t>(size) * static_cast<uint64_t>(size);
    };
    while (size > 16 && (size > greatest_size || bytes() > greatest_shadow_bytes)) size /= 2;
    texture = make_depth_array(gl, layers > 0 ? size : 1, std::max(layers, 1u));
    while (gl.GetError() == GL_OUT_OF_MEMORY) {
      context_.debug_error.clear();
      if (size <= 16) throw Error(ExitCode::no_gl, "shadow maps: OpenGL is out of memory");
      size /= 2;
      texture = make_depth_array(gl, size, layers);
    }
    if (size != wanted)
      messages.warn(
          fmt::format("{} of {}² texels instead of {}²: OpenGL has no room for more", what, size, wanted));
  };
  make_fitting(maps_, settings_.shadow_map_size, map_layers, "shadow maps");
  make_fitting(cubes_, settings_.shadow_cube_size, cube_layers, "shadow cubes");
  map_layers_ = map_layers;
  cube_layers_ = cube_layers;
  context_.check("making the shadow maps");
}

void ShadowMaps::draw_view(const GpuScene& gpu_scene, const gpu::GpuShadowView& view) {
  const GlFunctions& gl = context_.gl;
  const auto size = static_cast<GLsizei>(view.place.w);
  gl.FramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, view.place.y != 0 ? cubes_ : maps_, 0,
                             static_cast<GLint>(view.place.x));
  gl.Viewport(0, 0, size, size);
  const GLfloat farthest = 0;
  gl.ClearBufferfv(GL_DEPTH, 0, &farthest);
  const auto use = [&](const GlProgram& program) {
    program.use();
    program.set("view_origin", view.origin);
    program.set("view_right", view.right);
    program.set("view_up", view.up);
    program.set("view_forward", view.forward);
    program.set("orthographic", static_cast<int>(view.place.z));
  };
  if (gpu_scene.draws.opaque_triangles > 0) {
    use(opaque_);
    gl.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(3 * gpu_scene.draws.opaque_triangles), GL_UNSIGNED_INT,
                    nullptr);
  }
  for (const DrawBatch& batch : gpu_scene.draws.batches) {
    if (!batch.alpha_test) continue;
    const GlProgram& program = alpha_tested_[texture_mask(batch) >> MATERIAL_BASE_COLOR & 1];
    use(program);
    program.set("view_size", static_cast<float>(size));
    program.set("alpha_seed", shadow_alpha_seed);
    draw_batch(gl, gpu_scene, program, batch);
  }
}

void ShadowMaps::draw(const GpuScene& gpu_scene, const Scene& scene) {
  const GlFunctions& gl = context_.gl;
  const LightViews views = make_light_views(scene, settings_, picture_slots_);
  if (views.map_layers != map_layers_ || views.cube_layers != cube_layers_) {
    Messages repeated;  // the sizes were reported when the rasteriser was made
    make_arrays(views.map_layers, views.cube_layers, repeated);
    return draw(gpu_scene, scene);
  }
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  gl.DrawBuffer(GL_NONE);
  gl.ReadBuffer(GL_NONE);
  gl.Enable(GL_DEPTH_TEST);
  bind_scene(gl, gpu_scene);
  for (const gpu::GpuShadowView& view : views.views) draw_view(gpu_scene, view);
  drawn_ = scene.lights;
  context_.check("drawing the shadow maps");
}

size_t ShadowMaps::bytes() const {
  const auto texels = [](int size, uint32_t layers) { return static_cast<size_t>(size) * size * layers; };
  return sizeof(float) *
         (texels(settings_.shadow_map_size, map_layers_) + texels(settings_.shadow_cube_size, cube_layers_));
}

void ShadowMaps::draw_if_moved(const GpuScene& gpu_scene, const Scene& scene) {
  if (!std::equal(drawn_.begin(), drawn_.end(), scene.lights.begin(), scene.lights.end(), same_place))
    draw(gpu_scene, scene);
}

void ShadowMaps::bind(const Scene& scene, const GlProgram& program) {
  const GlFunctions& gl = context_.gl;
  const LightViews views = make_light_views(scene, settings_, picture_slots_);
  lights_ = make_storage(gl, std::span<const gpu::GpuLight>(views.lights), GL_STREAM_DRAW);
  views_ = make_storage(gl, std::span<const gpu::GpuShadowView>(views.views), GL_STREAM_DRAW);
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_LIGHTS, lights_);
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_SHADOW_VIEWS, views_);
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_PICTURES, pictures_);
  gl.ActiveTexture(GL_TEXTURE0 + UNIT_SHADOW_MAPS);
  gl.BindTexture(GL_TEXTURE_2D_ARRAY, maps_);
  gl.ActiveTexture(GL_TEXTURE0 + UNIT_SHADOW_CUBES);
  gl.BindTexture(GL_TEXTURE_2D_ARRAY, cubes_);
  const Aabb& b = scene.bounds;
  program.set("light_count", static_cast<uint32_t>(views.lights.size()));
  program.set("scene_extreme", b.empty() ? 0.0f : max_component(glm::max(glm::abs(b.low), glm::abs(b.high))));
}

}  // namespace halflight
