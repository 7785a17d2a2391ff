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

struct RayCounters {
  uint64_t visibility = 0, closest = 0, rejected = 0;
  RayCounters& operator+=(const RayCounters& o) {
    visibility += o.visibility, closest += o.closest, rejected += o.rejected;
    return *this;
  }
};

struct RayHit {
  float distance;
  SurfacePoint point;
};

class RayScene {
 public:
  /// Builds the acceleration structure; keeps a reference to `scene`, whose vertices it shares.
  explicit RayScene(const Scene& scene);
  ~RayScene();
  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;

  /// Closest hit of a unit direction; false on a miss or a rejected ray. Hashed alpha uses `alpha_seed`.
  bool intersect(Vec3 origin, Vec3 direction, float near_distance, float far_distance, uint32_t alpha_seed,
                 RayHit& hit, RayCounters&) const;

  /// Traces a batch in place: `blocked()` tells afterwards. Invalid rays are blocked and counted as rejected.
  void occluded(std::span<ShadowRay> rays, uint32_t alpha_seed, RayCounters&) const;

  size_t memory_bytes() const;  ///< what Embree holds
  const Scene& scene() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Ray from a surface point x (geometric normal on wi's side) towards wi, `distance` long (infinity: to the
/// end); both ends are kept off the surfaces by `surface_epsilon`.
ShadowRay shadow_ray(const Scene&, Vec3 x, Vec3 geometric_normal, Vec3 wi, float distance);

}  // namespace halflight
