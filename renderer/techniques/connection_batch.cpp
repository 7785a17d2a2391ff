#include "techniques/connection_batch.h"

#include <cstddef>
#include <cstring>

#include "core/simd.h"
#include "scene/brdf_batch.h"

namespace halflight {

namespace {

constexpr size_t lanes = 8;

using FourFloats [[gnu::vector_size(16)]] = float;
static_assert(offsetof(VirtualLight, measure) == 12 && offsetof(VirtualLight, normal) == 16 &&
              offsetof(VirtualLight, kind) == 28 && offsetof(VirtualLight, radiance) == 32 &&
              sizeof(VirtualLight) == 48);

/// Sixteen bytes of four lights become four of each array.
HALFLIGHT_INLINE void transpose(const std::array<const char*, 4>& rows, size_t offset, float* x, float* y,
                                float* z, void* w) {
  std::array<FourFloats, 4> row;
  for (size_t i = 0; i < 4; ++i) std::memcpy(&row[i], rows[i] + offset, sizeof row[i]);
  const FourFloats xy01 = __builtin_shufflevector(row[0], row[1], 0, 4, 1, 5),
                   xy23 = __builtin_shufflevector(row[2], row[3], 0, 4, 1, 5),
                   zw01 = __builtin_shufflevector(row[0], row[1], 2, 6, 3, 7),
                   zw23 = __builtin_shufflevector(row[2], row[3], 2, 6, 3, 7);
  const auto store = [](void* to, FourFloats values) { std::memcpy(to, &values, sizeof values); };
  store(x, __builtin_shufflevector(xy01, xy23, 0, 1, 4, 5));
  store(y, __builtin_shufflevector(xy01, xy23, 2, 3, 6, 7));
  store(z, __builtin_shufflevector(zw01, zw23, 0, 1, 4, 5));
  if (w) store(w, __builtin_shufflevector(zw01, zw23, 2, 3, 6, 7));
}

/// The pixel, and directions in its BRDF's frame.
struct PixelFrame {
  Vec3 x, tangent, bitangent, normal, geometric_normal;
  float bounded;  ///< 1/2π of the bounded geometry term, 0 for the exact one
};

struct LocalBatch {
  alignas(64) float x[ConnectionBatch::capacity], y[ConnectionBatch::capacity], z[ConnectionBatch::capacity];
  alignas(64) float red[ConnectionBatch::capacity], green[ConnectionBatch::capacity],
      blue[ConnectionBatch::capacity];
};

/// Directions, distances and Ω · weight, the last in `measure`; the same as `connect` in
/// lights/virtual_light.h.
HALFLIGHT_SIMD_CLONES void connect_loop(ConnectionBatch& b, const PixelFrame& pixel, LocalBatch& local,
                                        size_t count) {
  const PixelFrame p = pixel;
#pragma GCC ivdep
  for (size_t i = 0; i < count; ++i) {
    const float local_light =
        b.kind[i] == LightKind::surface || b.kind[i] == LightKind::emitter ? 1.0f : 0.0f;
    const float dx = b.position_x[i] - p.x.x * local_light, dy = b.position_y[i] - p.x.y * local_light,
                dz = b.position_z[i] - p.x.z * local_light;
    const float r2 = dx * dx + dy * dy + dz * dz;
    const float apart = r2 > 0.0f ? 1.0f : 0.0f;  // a light at the point itself has no direction
    const float r = std::sqrt(r2), inverse = 1.0f / (r2 > 0.0f ? r : 1.0f);
    const float wx = dx * inverse, wy = dy * inverse, wz = dz * inverse;
    const float faces = -(b.normal_x[i] * wx + b.normal_y[i] * wy + b.normal_z[i] * wz);
    const float projected = b.measure[i] * (faces > 0.0f ? faces : 0.0f);
    const float seen = projected / (r2 > 0.0f ? r2 + p.bounded * projected : 1.0f);
    const float omega = local_light > 0.0f ? seen : b.measure[i];
    b.distance[i] = local_light > 0.0f ? r : b.distance[i];
    b.wi_x[i] = wx, b.wi_y[i] = wy, b.wi_z[i] = wz;
    local.x[i] = p.tangent.x * wx + p.tangent.y * wy + p.tangent.z * wz;
    local.y[i] = p.bitangent.x * wx + p.bitangent.y * wy + p.bitangent.z * wz;
    local.z[i] = p.normal.x * wx + p.normal.y * wy + p.normal.z * wz;
    // Light from below the surface itself is in its own shadow, whatever the shading normal says.
    const float above = p.geometric_normal.x * wx + p.geometric_normal.y * wy + p.geometric_normal.z * wz;
    b.matters[i] = (above > 0.0f ? apart : 0.0f) * (local.z[i] > 0.0f ? 1.0f : 0.0f);
    b.measure[i] = omega;
  }
}

/// 1/(n p_v + n_b p_b) in place of Ω, with p_v = 1/(Ω weight), and 1 in place of the weight.
HALFLIGHT_SIMD_CLONES void balance_loop(ConnectionBatch& b, const float* pdf, float light_draws,
                                        size_t count) {
#pragma GCC ivdep
  for (size_t i = 0; i < count; ++i) {
    const float light_pdf = 1.0f / (b.measure[i] * b.weight[i]);
    b.measure[i] = 1.0f / (light_draws * light_pdf + b.brdf_rays[i] * pdf[i]);
    b.weight[i] = 1.0f;
  }
}

/// f cos θ · L Ω weight. The product may leave the range of floats on the way, but not in the end.
HALFLIGHT_SIMD_CLONES void multiply_loop(ConnectionBatch& b, const LocalBatch& local, size_t count) {
#pragma GCC ivdep
  for (size_t i = 0; i < count; ++i) {
    const float cosine = local.z[i], omega = b.measure[i], weight = b.weight[i];
    const float r = (local.red[i] * cosine) * ((b.red[i] * omega) * weight);
    const float g = (local.green[i] * cosine) * ((b.green[i] * omega) * weight);
    const float bl = (local.blue[i] * cosine) * ((b.blue[i] * omega) * weight);
    const float rg = r > g ? r : g, most = rg > bl ? rg : bl;
    b.matters[i] = most > 0.0f ? b.matters[i] : 0.0f;
    b.red[i] = r, b.green[i] = g, b.blue[i] = bl;
  }
}

PixelFrame pixel_frame(const GBufferTexel& texel, const Basis& basis, GeometryTerm term) {
  return {texel.position, basis.tangent,          basis.bitangent,
          basis.normal,   texel.geometric_normal, term == GeometryTerm::bounded ? 0.5f / pi : 0.0f};
}

}  // namespace

/// Fills the arrays, up to a multiple of the vector width with copies of the first draw; returns how far.
size_t ConnectionBatch::gather(const Scene& scene, Vec3 x) {
  const size_t count = (size + lanes - 1) / lanes * lanes;
  for (size_t i = size; i < count; ++i) drawn[i] = drawn[0];
  for (size_t i = 0; i < count; i += 4) {
    std::array<const char*, 4> rows;
    for (size_t j = 0; j < 4; ++j) rows[j] = reinterpret_cast<const char*>(drawn[i + j].light);
    transpose(rows, 0, position_x + i, position_y + i, position_z + i, measure + i);
    transpose(rows, 16, normal_x + i, normal_y + i, normal_z + i, kind + i);
    transpose(rows, 32, red + i, green + i, blue + i, nullptr);
  }
  bool any_punctual = false;
  for (size_t i = 0; i < count; ++i) {
    weight[i] = drawn[i].weight, brdf_rays[i] = drawn[i].brdf_rays, distance[i] = infinity;
    red[i] *= drawn[i].radiance_scale, green[i] *= drawn[i].radiance_scale;
    blue[i] *= drawn[i].radiance_scale;
    any_punctual |= kind[i] == LightKind::punctual;
  }
  if (any_punctual) connect_punctual_lights(scene, x);
  return count;
}

/// Cones, pictures and ranges are few and branchy: connected one by one, and then like a direction.
void ConnectionBatch::connect_punctual_lights(const Scene& scene, Vec3 x) {
  for (size_t i = 0; i < size; ++i) {
    if (kind[i] != LightKind::punctual) continue;
    const LightConnection link = halflight::connect(*drawn[i].light, scene, x, GeometryTerm::exact);
    const Vec3 irradiance = link.irradiance * drawn[i].radiance_scale;
    position_x[i] = link.wi.x, position_y[i] = link.wi.y, position_z[i] = link.wi.z;
    red[i] = irradiance.x, green[i] = irradiance.y, blue[i] = irradiance.z;
    distance[i] = link.distance;
    measure[i] = 1;
  }
}

void ConnectionBatch::connect(const Scene& scene, const GBufferTexel& texel, const Basis& basis,
                              GeometryTerm term, std::optional<float> draws_beside_rays) {
  const size_t count = gather(scene, texel.position);
  LocalBatch local_batch;
  LocalBatch& l = local_batch;
  alignas(64) float density[capacity];
  connect_loop(*this, pixel_frame(texel, basis, term), l, count);
  evaluate_batch(texel.brdf, basis.to_local(texel.wo),
                 {l.x, l.y, l.z, l.red, l.green, l.blue, count, draws_beside_rays ? density : nullptr});
  if (draws_beside_rays) balance_loop(*this, density, *draws_beside_rays, count);
  multiply_loop(*this, l, count);
}

void ConnectionBatch::connect(const Scene& scene, const GBufferTexel& texel, const Basis& basis,
                              GeometryTerm term) {
  connect(scene, texel, basis, term, std::nullopt);
}

void ConnectionBatch::connect_beside_rays(const Scene& scene, const GBufferTexel& texel, const Basis& basis,
                                          GeometryTerm term, float light_draws) {
  connect(scene, texel, basis, term, light_draws);
}

}  // namespace halflight
