#include "raster/filtered_light.h"

#include <cmath>

#include "core/stopwatch.h"

namespace halflight {

namespace {

// Every driver's storage buffers hold 16 MiB.
constexpr size_t band_pixels = size_t{1} << 20;
// Samples of all pixels in one dispatch: some hundredths of a second on a GPU, so that no watchdog wakes, and
// a second on a software rasteriser, so that it can be stopped.
constexpr size_t dispatch_samples = size_t{1} << 23;
constexpr uint32_t most_points = 4096;

uint32_t groups(uint32_t count) { return (count + DIRECT_LIGHT_GROUP - 1) / DIRECT_LIGHT_GROUP; }

/// Seconds the GPU is busy from construction to `seconds`: by a timer query, or by the clock, with all work
/// done at either end, where the driver has none or is a software rasteriser (llvmpipe's count no compute
/// shader).
class GpuTimer {
 public:
  explicit GpuTimer(const GlContextBase& context) : gl_(context.gl) {
    GLint bits = 0;
    gl_.GetQueryiv(GL_TIME_ELAPSED, GL_QUERY_COUNTER_BITS, &bits);
    if (bits == 0 || context.description().software) {
      gl_.Finish();
      watch_.lap();
      return;
    }
    GLuint name = 0;
    gl_.GenQueries(1, &name);
    query_ = GlName(name, gl_.DeleteQueries);
    gl_.BeginQuery(GL_TIME_ELAPSED, query_);
  }
  double seconds() {
    if (query_ == 0) {
      gl_.Finish();
      return watch_.seconds();
    }
    GLuint64 nanoseconds = 0;
    gl_.EndQuery(GL_TIME_ELAPSED);
    gl_.GetQueryObjectui64v(query_, GL_QUERY_RESULT, &nanoseconds);
    return 1e-9 * static_cast<double>(nanoseconds);
  }

 private:
  const GlFunctions& gl_;
  GlName query_;
  Stopwatch watch_;
};

/// What the shader needs of points [first, first + count) of the set (the chapter's third optimisation: the
/// trigonometry is done here).
std::vector<Vec4> sample_points(uint32_t first, uint32_t count, uint32_t n) {
  std::vector<Vec4> points;
  points.reserve(count);
  for (uint32_t i = first; i < first + count; ++i) {
    const Vec2 u = hammersley(i, n);
    const float phi = 2 * pi * u.y;
    points.emplace_back(u.x, std::log1p(-u.x), std::cos(phi), std::sin(phi));
  }
  return points;
}

gpu::GpuFilteredLight make_harmonics(const Environment& environment) {
  const SphericalHarmonics radiance = project_radiance(environment);
  const SphericalHarmonics lambert = convolve(radiance, zonal_convolution(lambert_kernel));
  const SphericalHarmonics ashikhmin = convolve(radiance, zonal_convolution(ashikhmin_kernel));
  gpu::GpuFilteredLight light;
  for (size_t i = 0; i < lambert.size(); ++i) {
    light.lambert[i] = Vec4(Vec3(lambert[i]), 0);
    light.ashikhmin[i] = Vec4(Vec3(ashikhmin[i]), 0);
  }
  const auto means = schlick_means();
  std::copy(means.begin(), means.end(), light.schlick_means);
  return light;
}

}  // namespace

FilteredLight::FilteredLight(GlContextBase& context)
    : context_(context), program_(context.gl, {{GL_COMPUTE_SHADER, "filtered.comp"}}) {}

void FilteredLight::prepare(const Environment& environment, int map_size) {
  if (map_size_ == map_size) return;
  const GlFunctions& gl = context_.gl;
  if (harmonics_ == 0) {
    const gpu::GpuFilteredLight light = make_harmonics(environment);
    harmonics_ = make_storage(gl, sizeof light, &light);
  }
  const ParaboloidMaps maps = make_paraboloid_maps(environment, map_size);
  const size_t texels = maps.texels[0].size();
  std::vector<Vec4> both(maps.texels[0]);
  both.insert(both.end(), maps.texels[1].begin(), maps.texels[1].end());
  HALFLIGHT_CHECK(both.size() == 2 * texels);

  maps_ = make_texture(gl);
  gl.ActiveTexture(GL_TEXTURE0 + UNIT_FILTERED_MAPS);
  gl.BindTexture(GL_TEXTURE_2D_ARRAY, maps_);
  gl.TexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_RGBA32F, map_size, map_size, 2, 0, GL_RGBA, GL_FLOAT, both.data());
  gl.GenerateMipmap(GL_TEXTURE_2D_ARRAY);
  gl.TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  gl.TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl.TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl.TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  context_.check("making the environment's filtered maps");
  map_size_ = map_size;
}

size_t FilteredLight::bytes() const {
  // A third more for the mip levels.
  return 2 * sizeof(Vec4) * static_cast<size_t>(map_size_) * map_size_ * 4 / 3;
}

void FilteredLight::bind(const GpuScene& scene, const Environment& environment, const GBufferPass& gbuffer,
                         const FilteredRequest& request) {
  const GlFunctions& gl = context_.gl;
  program_.use();
  bind_gbuffer(gl, program_, scene, gbuffer);
  gl.ActiveTexture(GL_TEXTURE0 + UNIT_FILTERED_MAPS);
  gl.BindTexture(GL_TEXTURE_2D_ARRAY, maps_);
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_FILTERED_LIGHT, harmonics_);
  const float n = static_cast<float>(request.samples), size = static_cast<float>(map_size_);
  program_.set("level_of_set", 0.5f * std::log2(size * size / n));
  program_.set("level_bias", request.bias);
  program_.set("filter_samples", request.filter ? 1 : 0);
  program_.set("paraboloid_scale", paraboloid_scale);
  program_.set("turn", Vec2(std::cos(environment.rotation), std::sin(environment.rotation)));
  program_.set("strength_per_sample", environment.strength / n);
  program_.set("strength", environment.strength);
  program_.set("stride", request.stride);
  program_.set("first_pixel_x", request.offset % request.stride);
}

FilteredResult FilteredLight::light(const GpuScene& scene, const Environment& environment,
                                    const GBufferPass& gbuffer, const FilteredRequest& request) {
  HALFLIGHT_CHECK(map_size_ > 0 && request.samples > 0);
  const GlFunctions& gl = context_.gl;
  const auto subset = [&](int size, uint32_t first) {
    return (static_cast<uint32_t>(size) - std::min(first, static_cast<uint32_t>(size)) + request.stride - 1) /
           request.stride;
  };
  const uint32_t first_y = request.offset / request.stride;
  const uint32_t width = subset(gbuffer.targets().width, request.offset % request.stride);
  const uint32_t height = subset(gbuffer.targets().height, first_y);
  FilteredResult result;
  result.radiance.assign(static_cast<size_t>(width) * height, Vec3(0));
  if (result.radiance.empty()) return result;

  bind(scene, environment, gbuffer, request);
  program_.set("subset_width", width);
  const auto band_rows = static_cast<uint32_t>(std::clamp<size_t>(band_pixels / width, 1, height));
  const auto chunk = static_cast<uint32_t>(
      std::clamp<size_t>(dispatch_samples / (static_cast<size_t>(band_rows) * width), 1, most_points));
  const GlName lit = make_storage(gl, size_t{band_rows} * width * sizeof(Vec3), nullptr, GL_STREAM_READ);
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_RESULT, lit);
  for (uint32_t row = 0; row < height; row += band_rows) {
    const uint32_t rows = std::min(band_rows, height - row);
    program_.set("row_count", rows);
    program_.set("first_pixel_y", first_y + row * request.stride);
    GpuTimer timer(context_);
    for (uint32_t first = 0; first < request.samples && result.finished; first += chunk) {
      const auto points = sample_points(first, std::min(chunk, request.samples - first), request.samples);
      const GlName storage = make_storage(gl, std::span<const Vec4>(points), GL_STREAM_DRAW);
      gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_POINTS, storage);
      program_.set("first_points", first == 0 ? 1 : 0);
      program_.set("point_count", static_cast<uint32_t>(points.size()));
      gl.DispatchCompute(groups(width), groups(rows), 1);
      gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
      result.finished = !request.stop.stop_requested();
    }
    result.gpu_seconds += timer.seconds();
    if (!result.finished) break;
    read_triples(gl, lit, std::span(result.radiance).subspan(size_t{row} * width, size_t{rows} * width));
  }
  context_.check("lighting pixels by the filtered environment");
  return result;
}

}  // namespace halflight
