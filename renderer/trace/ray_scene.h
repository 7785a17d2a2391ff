// Embree behind one header; versions 3 and 4. Every ray passes one validity gate, because Debian's library
// aborts on a ray that is not finite.
#pragma once

#include <memory>
#include <span>

#include "core/math.h"
#include "scene/scene.h"
#include "scene/shading.h"

namespace halflight {

/// A shadow ray, laid out as Embree's RTCRay so that batches are traced in place.
struct alignas(16) ShadowRay {
  float origin_x, origin_y, origin_z;
  float near_distance;
  float direction_x, direction_y, direction_z;
  float time;
  float far_distance;  ///< −infinity after tracing means blocked
  uint32_t mask = ~0u;
  uint32_t id = 0;
  uint32_t flags = 0;

  bool blocked() const { return far_distance < 0; }
};

/// A ray for its closest hit, laid out as Embree's RTCRayHit.
struct ClosestRay {
  ShadowRay ray;  ///< `far_distance` is the hit's afterwards
  float normal_x = 0, normal_y = 0, normal_z = 0, u = 0, v = 0;
  uint32_t primitive = ~0u, geometry = ~0u, instance = ~0u;

  bool met() const { return geometry != ~0u; }
};

struct RayCounters {
  uint64_t visibility = 0, closest = 0, rejected = 0;
  uint64_t alpha_tests = 0;  ///< crossings of triangles that may let rays through
  RayCounters& operator+=(const RayCounters& o) {
    visibility += o.visibility, closest += o.closest, rejected += o.rejected;
    alpha_tests += o.alpha_tests;
    return *this;
  }
};

struct RayHit {
  float distance;
  SurfacePoint point;
};

class RayScene {
 public:
  /// Builds the acceleration structure; keeps a reference to `scene`, whose vertices it shares. `filter_all`:
  /// opaque triangles are asked for their alpha too, as if they had one (benchmarks).
  explicit RayScene(const Scene& scene, bool filter_all = false);
  ~RayScene();
  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;

  /// Closest hit of a unit direction; false on a miss or a rejected ray. Hashed alpha uses `alpha_seed`.
  bool intersect(Vec3 origin, Vec3 direction, float near_distance, float far_distance, uint32_t alpha_seed,
                 RayHit& hit, RayCounters&) const;

  /// The same of a batch, in place: `met()` tells afterwards. Rays of a camera's neighbouring pixels are
  /// `coherent`.
  void intersect(std::span<ClosestRay> rays, bool coherent, uint32_t alpha_seed, RayCounters&) const;
  /// What a traced ray met.
  RayHit hit_of(const ClosestRay&) const;

  /// Traces a batch in place: `blocked()` tells afterwards. Invalid rays are blocked and counted as rejected.
  void occluded(std::span<ShadowRay> rays, uint32_t alpha_seed, RayCounters&) const;

  size_t memory_bytes() const;  ///< what Embree holds
  size_t alpha_bytes() const;   ///< tables of the triangles that may let rays through
  const Scene& scene() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Where the rays of a surface point start: off the surface by `surface_epsilon`, on either side of it.
struct RayOrigin {
  Vec3 normal;  ///< geometric
  Vec3 front, back;
  float epsilon;

  RayOrigin() = default;
  RayOrigin(const Scene& scene, Vec3 x, Vec3 geometric_normal)
      : normal(geometric_normal), epsilon(surface_epsilon(scene, x)) {
    front = x + normal * epsilon, back = x - normal * epsilon;
  }
};

/// Ray from the front towards wi, `distance` long (infinity: to the end). The far end stops short of the
/// light's own surface: by the offset, and by the rounding of a long ray.
inline ShadowRay shadow_ray_in_front(const RayOrigin& from, Vec3 wi, float distance) {
  // Of infinity this leaves infinity.
  const float far_distance = std::max(distance * (1 - 0x1p-16f) - 4 * from.epsilon, 0.0f);
  return {from.front.x, from.front.y, from.front.z, 0, wi.x, wi.y, wi.z, 0, far_distance};
}

/// The same from the side of the surface that wi is on.
inline ShadowRay shadow_ray(const RayOrigin& from, Vec3 wi, float distance) {
  ShadowRay ray = shadow_ray_in_front(from, wi, distance);
  if (!(glm::dot(from.normal, wi) >= 0))
    ray.origin_x = from.back.x, ray.origin_y = from.back.y, ray.origin_z = from.back.z;
  return ray;
}

inline ShadowRay shadow_ray(const Scene& scene, Vec3 x, Vec3 geometric_normal, Vec3 wi, float distance) {
  return shadow_ray(RayOrigin(scene, x, geometric_normal), wi, distance);
}

}  // namespace halflight
