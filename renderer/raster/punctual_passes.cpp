#include "raster/punctual_passes.h"

#include <algorithm>

namespace halflight {

namespace {

// Pixels lit in one dispatch: their radiances stay well within any driver's storage buffers.
constexpr size_t band_pixels = size_t{1} << 22;

constexpr uint32_t groups(size_t count, uint32_t group) {
  return static_cast<uint32_t>((count + group - 1) / group);
}

/// A storage buffer for `count` triples, bound as the result.
GlName bind_result(const GlFunctions& gl, size_t count) {
  GlName buffer = make_storage(gl, count * sizeof(Vec3), nullptr, GL_STREAM_READ);
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_RESULT, buffer);
  return buffer;
}

}  // namespace

PunctualPasses::PunctualPasses(GlContextBase& context)
    : context_(context),
      points_(context.gl, {{GL_COMPUTE_SHADER, "light_points.comp"}}),
      direct_(context.gl, {{GL_COMPUTE_SHADER, "direct.comp"}}) {}

std::vector<Vec3> PunctualPasses::light_points(ShadowMaps& shadows, const Scene& scene,
                                               std::span<const BouncePoint> points) {
  std::vector<Vec3> irradiance(2 * points.size(), Vec3(0));
  if (points.empty() || scene.lights.empty()) return irradiance;
  const GlFunctions& gl = context_.gl;
  std::vector<gpu::GpuPoint> gpu_points;
  gpu_points.reserve(points.size());
  for (const BouncePoint& p : points) gpu_points.push_back({Vec4(p.position, 1), Vec4(p.normal, 0)});
  const GlName input = make_storage(gl, std::span<const gpu::GpuPoint>(gpu_points), GL_STREAM_DRAW);

  points_.use();
  shadows.bind(scene, points_);
  points_.set("point_count", static_cast<uint32_t>(points.size()));
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_POINTS, input);
  const GlName result = bind_result(gl, irradiance.size());
  gl.DispatchCompute(groups(points.size(), LIGHT_POINT_GROUP), 1, 1);
  read_triples(gl, result, irradiance);
  context_.check("lighting the surface points");
  return irradiance;
}

void PunctualPasses::add_direct(ShadowMaps& shadows, const GpuScene& gpu_scene, const Scene& scene,
                                const GBufferPass& gbuffer, std::span<Vec3> radiance) {
  if (radiance.empty() || scene.lights.empty()) return;
  const GlFunctions& gl = context_.gl;
  const GBufferTargets& targets = gbuffer.targets();
  const size_t width = static_cast<size_t>(targets.width), height = static_cast<size_t>(targets.height);

  direct_.use();
  shadows.bind(scene, direct_);
  bind_gbuffer(gl, direct_, gpu_scene, gbuffer);
  direct_.set("picture_width", static_cast<uint32_t>(width));

  const size_t band_rows = std::max<size_t>(1, std::min(height, band_pixels / width));
  std::vector<Vec3> band(band_rows * width);
  const GlName result = bind_result(gl, band.size());
  for (size_t row = 0; row < height; row += band_rows) {
    const size_t rows = std::min(band_rows, height - row);
    direct_.set("first_row", static_cast<uint32_t>(row));
    direct_.set("row_count", static_cast<uint32_t>(rows));
    gl.DispatchCompute(groups(width, DIRECT_LIGHT_GROUP), groups(rows, DIRECT_LIGHT_GROUP), 1);
    read_triples(gl, result, std::span(band).first(rows * width));
    for (size_t i = 0; i < rows * width; ++i) radiance[row * width + i] += band[i];
  }
  context_.check("adding the direct light");
}

}  // namespace halflight
