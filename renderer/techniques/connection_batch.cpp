#include "techniques/connection_batch.h"

#include "core/simd.h"
#include "scene/brdf_batch.h"

namespace halflight {

namespace {

constexpr size_t lanes = 8;

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
    const float dx = b.position_x[i] - p.x.x * b.local[i], dy = b.position_y[i] - p.x.y * b.local[i],
                dz = b.position_z[i] - p.x.z * b.local[i];
    const float r2 = dx * dx + dy * dy + dz * dz;
    const float apart = r2 > 0.0f ? 1.0f : 0.0f;  // a light at the point itself has no direction
    const float r = std::sqrt(r2), inverse = 1.0f / (r2 > 0.0f ? r : 1.0f);
    const float wx = dx * inverse, wy = dy * inverse, wz = dz * inverse;
    const float faces = -(b.normal_x[i] * wx + b.normal_y[i] * wy + b.normal_z[i] * wz);
    const float projected = b.measure[i] * (faces > 0.0f ? faces : 0.0f);
    const float seen = projected / (r2 > 0.0f ? r2 + p.bounded * projected : 1.0f);
    const float omega = b.local[i] > 0.0f ? seen : b.measure[i];
    b.distance[i] = b.local[i] > 0.0f ? r : b.distance[i];
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

size_t padded(size_t size) { return (size + lanes - 1) / lanes * lanes; }

}  // namespace

void ConnectionBatch::add(const VirtualLight& light, const Scene& scene, Vec3 x, float sample_weight,
                          uint32_t its_tag, float its_brdf_rays) {
  const size_t i = size++;
  const bool is_local = light.kind == LightKind::surface || light.kind == LightKind::emitter;
  if (light.kind == LightKind::punctual) {
    // Cones, pictures and ranges are few and branchy: connected here, and then like a direction.
    const LightConnection link = halflight::connect(light, scene, x, GeometryTerm::exact);
    position_x[i] = link.wi.x, position_y[i] = link.wi.y, position_z[i] = link.wi.z;
    red[i] = link.irradiance.x, green[i] = link.irradiance.y, blue[i] = link.irradiance.z;
    distance[i] = link.distance;
    measure[i] = 1;
  } else {
    position_x[i] = light.position.x, position_y[i] = light.position.y, position_z[i] = light.position.z;
    red[i] = light.radiance.x, green[i] = light.radiance.y, blue[i] = light.radiance.z;
    distance[i] = infinity;
    measure[i] = light.measure;
  }
  normal_x[i] = light.normal.x, normal_y[i] = light.normal.y, normal_z[i] = light.normal.z;
  local[i] = is_local ? 1.0f : 0.0f;
  weight[i] = sample_weight;
  tag[i] = its_tag;
  brdf_rays[i] = its_brdf_rays;
}

void ConnectionBatch::pad() {
  for (size_t i = size; i % lanes != 0; ++i) {
    for (float* array : {position_x, position_y, position_z, normal_x, normal_y, normal_z, red, green, blue,
                         measure, weight, local, distance, brdf_rays})
      array[i] = array[0];
  }
}

void ConnectionBatch::connect(const GBufferTexel& texel, const Basis& basis, GeometryTerm term) {
  pad();
  const size_t count = padded(size);
  LocalBatch local_batch;
  LocalBatch& l = local_batch;
  connect_loop(*this, pixel_frame(texel, basis, term), l, count);
  evaluate_batch(texel.brdf, basis.to_local(texel.wo), {l.x, l.y, l.z, l.red, l.green, l.blue, count});
  multiply_loop(*this, l, count);
}

void ConnectionBatch::connect_beside_rays(const GBufferTexel& texel, const Basis& basis, GeometryTerm term,
                                          float light_draws) {
  pad();
  const size_t count = padded(size);
  LocalBatch local_batch;
  LocalBatch& l = local_batch;
  alignas(64) float density[capacity];
  connect_loop(*this, pixel_frame(texel, basis, term), l, count);
  evaluate_batch(texel.brdf, basis.to_local(texel.wo),
                 {l.x, l.y, l.z, l.red, l.green, l.blue, count, density});
  balance_loop(*this, density, light_draws, count);
  multiply_loop(*this, l, count);
}

}  // namespace halflight
