// Drawing directions towards environment and emitters for the lighting of surface points; private to this
// folder.
#pragma once

#include <optional>
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
};

/// The environment by luminance × solid angle, piecewise constant as it is looked up. Reads the environment
/// it was made of; `wanted` false makes an empty one.
class EnvironmentSampler {
 public:
  explicit EnvironmentSampler(const Environment&, bool wanted = true);
  bool empty() const { return table_.empty(); }
  IncidentSample sample(Vec2 u) const;

 private:
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

 private:
  const Scene& scene_;
  std::vector<uint32_t> triangles_;
  DiscreteTable table_;
};

}  // namespace halflight
