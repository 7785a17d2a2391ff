#include "raster/rasterizer.h"

#include "raster/filtered_light.h"
#include "raster/gbuffer_pass.h"
#include "raster/punctual_passes.h"
#include "raster/shadow_maps.h"

namespace halflight {

struct Rasterizer::Impl {
  Impl(GlContextBase& gl_context, const Scene& the_scene, const RasterSettings& the_settings,
       Messages& the_messages)
      : context(gl_context),
        scene(the_scene),
        settings(the_settings),
        messages(the_messages),
        gpu_scene(upload_scene(gl_context, the_scene, messages)),
        gbuffer(gl_context, gpu_scene),
        punctual(gl_context) {}

  GlContextBase& context;
  const Scene& scene;
  RasterSettings settings;
  Messages& messages;
  GpuScene gpu_scene;
  GBufferPass gbuffer;
  std::optional<ShadowMaps> shadows;  ///< made when first asked for
  PunctualPasses punctual;
  std::optional<FilteredLight> filtered;  ///< made when first asked for

  ShadowMaps& shadow_maps() {
    if (!shadows) shadows.emplace(context, scene, settings, messages);
    return *shadows;
  }
};

Rasterizer::Rasterizer(GlContext& context, const Scene& scene, const RasterSettings& settings,
                       Messages& messages) {
  base_of(context).make_current();
  const StateGuard guard(base_of(context).gl);
  impl_ = std::make_unique<Impl>(base_of(context), scene, settings, messages);
}

Rasterizer::~Rasterizer() {
  // Names can only be given back with their context current; where it is lost they are gone anyway.
  try {
    impl_->context.make_current();
  } catch (const Error&) {
  }
}

void Rasterizer::draw_gbuffer(const Camera& camera, Vec2 jitter, uint32_t alpha_seed, GBuffer& gbuffer) {
  impl_->context.make_current();
  const StateGuard guard(impl_->context.gl);
  impl_->gbuffer.draw(impl_->gpu_scene, impl_->scene, camera, jitter, alpha_seed, gbuffer);
}

void Rasterizer::update_materials() {
  impl_->context.make_current();
  update_gpu_materials(impl_->context, impl_->scene, impl_->gpu_scene);
}

void Rasterizer::update_shadow_maps() {
  impl_->context.make_current();
  const StateGuard guard(impl_->context.gl);
  impl_->shadow_maps().draw(impl_->gpu_scene, impl_->scene);
}

void Rasterizer::drop_shadow_maps() {
  if (!impl_->shadows) return;
  impl_->context.make_current();
  impl_->shadows.reset();
}

size_t Rasterizer::shadow_map_bytes() const { return impl_->shadows ? impl_->shadows->bytes() : 0; }

std::vector<Vec3> Rasterizer::light_points(const std::vector<BouncePoint>& points) {
  impl_->context.make_current();
  const StateGuard guard(impl_->context.gl);
  impl_->shadow_maps().draw_if_moved(impl_->gpu_scene, impl_->scene);
  return impl_->punctual.light_points(*impl_->shadows, impl_->scene, points);
}

void Rasterizer::add_punctual(const GBuffer& gbuffer, std::vector<Vec3>& radiance) {
  HALFLIGHT_CHECK(radiance.size() == gbuffer.pixel_count());
  if (gbuffer.pixel_count() == 0) return;
  const GBufferTargets& targets = impl_->gbuffer.targets();
  HALFLIGHT_CHECK(gbuffer.width == targets.width && gbuffer.height == targets.height);
  impl_->context.make_current();
  const StateGuard guard(impl_->context.gl);
  impl_->shadow_maps().draw_if_moved(impl_->gpu_scene, impl_->scene);
  impl_->punctual.add_direct(*impl_->shadows, impl_->gpu_scene, impl_->scene, impl_->gbuffer, radiance);
}

void Rasterizer::prepare_filtered(int map_size) {
  impl_->context.make_current();
  const StateGuard guard(impl_->context.gl);
  if (!impl_->filtered) impl_->filtered.emplace(impl_->context);
  impl_->filtered->prepare(impl_->scene.environment, map_size);
}

void Rasterizer::drop_filtered() {
  if (!impl_->filtered) return;
  impl_->context.make_current();
  impl_->filtered.reset();
}

size_t Rasterizer::filtered_bytes() const { return impl_->filtered ? impl_->filtered->bytes() : 0; }

FilteredResult Rasterizer::filtered_light(const GBuffer& gbuffer, const FilteredRequest& request) {
  HALFLIGHT_CHECK(impl_->filtered);
  if (gbuffer.pixel_count() == 0) return {};
  const GBufferTargets& targets = impl_->gbuffer.targets();
  HALFLIGHT_CHECK(gbuffer.width == targets.width && gbuffer.height == targets.height);
  impl_->context.make_current();
  const StateGuard guard(impl_->context.gl);
  return impl_->filtered->light(impl_->gpu_scene, impl_->scene.environment, impl_->gbuffer, request);
}

}  // namespace halflight
