// Draws of one pixel made into light before visibility, many at once: connection, BRDF and cosines as arrays.
#pragma once

#include <array>
#include <optional>

#include "lights/cut_distribution.h"
#include "scene/gbuffer.h"
#include "scene/scene.h"

namespace halflight {

/// A member of S that was drawn.
struct DrawnLight {
  const VirtualLight* light;
  float weight;              ///< 1/P
  uint32_t tag = 0;          ///< the caller's
  float brdf_rays = 0;       ///< how many BRDF rays could have met the light
  float radiance_scale = 1;  ///< of what the light sends
};

/// Arrays for the draws of one pixel. Fill with `add`, then `connect`; slots below `size` are then valid.
struct ConnectionBatch {
  static constexpr size_t capacity = 64;

  size_t size = 0;
  std::array<DrawnLight, capacity> drawn;
  alignas(64) float position_x[capacity], position_y[capacity], position_z[capacity], measure[capacity];
  alignas(64) float normal_x[capacity], normal_y[capacity], normal_z[capacity];
  alignas(64) LightKind kind[capacity];
  alignas(64) float red[capacity], green[capacity], blue[capacity];  ///< L, then f cos θ L Ω · weight
  alignas(64) float weight[capacity], brdf_rays[capacity];
  alignas(64) float distance[capacity];
  alignas(64) float wi_x[capacity], wi_y[capacity], wi_z[capacity];
  alignas(64) float matters[capacity];  ///< 1 where light can arrive: both cosines and a channel above 0

  Vec3 wi(size_t i) const { return {wi_x[i], wi_y[i], wi_z[i]}; }
  Vec3 value(size_t i) const { return {red[i], green[i], blue[i]}; }

  bool full() const { return size == capacity; }
  /// The light must live until it is connected.
  void add(const DrawnLight& light) { drawn[size++] = light; }

  void connect(const Scene&, const GBufferTexel&, const Basis&, GeometryTerm);
  /// The same, beside BRDF rays under one balance heuristic: values are f cos θ L/(n p_v + n_b p_b), p_v =
  /// 1/(weight Ω) the density of one of n = `light_draws` per solid angle, n_b = `brdf_rays` and p_b the
  /// density of those.
  void connect_beside_rays(const Scene&, const GBufferTexel&, const Basis&, GeometryTerm, float light_draws);

 private:
  void connect(const Scene&, const GBufferTexel&, const Basis&, GeometryTerm,
               std::optional<float> draws_beside_rays);
  size_t gather(const Scene&, Vec3 x);
  void connect_punctual_lights(const Scene&, Vec3 x);
};

}  // namespace halflight
