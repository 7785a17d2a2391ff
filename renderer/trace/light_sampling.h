// Drawing light towards a point: directions of the environment, points of emitters, punctual lights; and the
// density with which each would have drawn what a ray met.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/random.h"
#include "core/tables.h"
#include "scene/scene.h"
#include "scene/shading.h"

namespace halflight {

/// A direction from a point with what arrives along it per density: the estimate of ∫ L(ω) |cos| dω is
/// radiance_over_pdf · |cos θ|.
struct IncidentSample {
  Vec3 wi;
  float distance;
  Vec3 radiance_over_pdf;
  float pdf;  ///< per solid angle; infinity for punctual lights
};

/// The environment by luminance × solid angle, piecewise constant as it is looked up: a marginal table of
/// rows and a conditional one of each row (Křivánek §3). Reads the environment it was made of; `wanted` false
/// makes an empty one.
class EnvironmentSampler {
 public:
  explicit EnvironmentSampler(const Environment&, bool wanted = true);
  bool empty() const { return table_.empty(); }
  IncidentSample sample(Vec2 u) const;
  /// Many at once: the tables and the map lie far apart in memory, and one draw need not wait for another.
  void sample(std::span<const Vec2> u, std::span<IncidentSample> out) const;
  /// Density of `sample` per solid angle.
  float pdf(Vec3 wi) const;
  /// What comes from there, and that density.
  struct Met {
    Vec3 radiance;
    float pdf;
  };
  Met met(Vec3 wi) const;

 private:
  IncidentSample incident(const PlaneTable::Draw&) const;

  const Environment& environment_;
  PlaneTable table_;
};

/// Emissive triangles by power, a uniform point on the one drawn, on either side that emits.
class EmitterSampler {
 public:
  explicit EmitterSampler(const Scene&, bool wanted = true);
  bool empty() const { return table_.empty(); }
  /// Nothing when the emitter's dark side faces x.
  std::optional<IncidentSample> sample(Vec3 x, float choose, Vec2 u) const;
  /// A point by power, whoever looks at it; `density` is per area.
  struct Point {
    SurfacePoint surface;
    float density;
  };
  Point point(float choose, Vec2 u) const;
  /// Density of `point` per area of a triangle; 0 where it emits nothing.
  float density(uint32_t triangle) const { return densities_.empty() ? 0 : densities_[triangle]; }
  /// Nearer than this, a point drawn on an emitter may weigh more than a direction drawn by the cosine: √(4
  /// A/π) of all emitters' area. Of some emitter that near to x.
  float near_distance() const { return near_distance_; }
  bool may_be_near(Vec3 x) const {
    const Vec3 apart = glm::max(glm::max(bounds_.low - x, x - bounds_.high), Vec3(0));
    return near_distance_ > 0 && glm::dot(apart, apart) < near_distance_ * near_distance_;
  }

 private:
  const Scene& scene_;
  std::vector<uint32_t> triangles_;
  std::vector<float> densities_;  ///< one a triangle of the scene
  DiscreteTable table_;
  Aabb bounds_;
  float near_distance_ = 0;
};

/// Punctual lights, chosen by what they would give a point with nothing in the way.
class PunctualSampler {
 public:
  explicit PunctualSampler(const Scene&, bool wanted = true);
  bool empty() const { return table_.empty(); }
  /// Light that reaches x from the upper side of `normal`: of a handful of lights one in exact proportion to
  /// its irradiance, of more one of eight candidates by power, resampled (Talbot et al. 2005). Nothing where
  /// no candidate's light arrives.
  std::optional<IncidentSample> sample(Vec3 x, Vec3 normal, RandomStream&) const;

 private:
  const Scene& scene_;
  std::vector<uint32_t> lights_;
  DiscreteTable table_;
};

/// Power of a punctual light (luminance): 4π I, the cone's share of it, or E⊥ over a disc of the
/// scene's radius. Fall-off and picture are taken as 1.
double punctual_power(const PunctualLight&, float scene_radius);

/// Density per area of a point → per solid angle from where it is seen: r²/|cos θ'|.
inline float area_to_solid_angle(float density, float distance, float cos_light) {
  return density * (distance * distance / std::max(cos_light, 1e-30f));
}

}  // namespace halflight
