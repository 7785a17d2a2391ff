// Draws of one pixel made into light before visibility, many at once: connection, BRDF and cosines as arrays.
#pragma once

#include "lights/cut_distribution.h"
#include "scene/gbuffer.h"
#include "scene/scene.h"

namespace halflight {

/// Arrays for the draws of one pixel. Fill with `add`, then `connect`; slots below `size` are then valid.
struct ConnectionBatch {
  static constexpr size_t capacity = 64;

  size_t size = 0;
  alignas(64) float position_x[capacity], position_y[capacity], position_z[capacity];
  alignas(64) float normal_x[capacity], normal_y[capacity], normal_z[capacity];
  alignas(64) float red[capacity], green[capacity], blue[capacity];  ///< L, then f cos θ L Ω · weight
  alignas(64) float measure[capacity];
  alignas(64) float weight[capacity];
  alignas(64) float brdf_rays[capacity];  ///< how many BRDF rays could have met the light
  alignas(64) float local[capacity];      ///< 0: position is the direction already
  alignas(64) float distance[capacity];
  alignas(64) float wi_x[capacity], wi_y[capacity], wi_z[capacity];
  alignas(64) float matters[capacity];  ///< 1 where light can arrive: both cosines and a channel above 0
  uint32_t tag[capacity];               ///< the caller's

  Vec3 wi(size_t i) const { return {wi_x[i], wi_y[i], wi_z[i]}; }
  Vec3 value(size_t i) const { return {red[i], green[i], blue[i]}; }

  void add(const VirtualLight&, const Scene&, Vec3 x, float sample_weight, uint32_t its_tag,
           float its_brdf_rays = 0);
  void connect(const GBufferTexel&, const Basis&, GeometryTerm);
  /// The same, beside BRDF rays under one balance heuristic: values are f cos θ L/(n p_v + n_b p_b), p_v =
  /// 1/(weight Ω) the density of one of n = `light_draws` per solid angle, n_b = `brdf_rays` and p_b the
  /// density of those.
  void connect_beside_rays(const GBufferTexel&, const Basis&, GeometryTerm, float light_draws);

 private:
  void pad();
};

}  // namespace halflight
