// The surfaces that return light, laid out one after the other by area.
#pragma once

#include <span>
#include <vector>

#include "scene/scene.h"
#include "scene/shading.h"

namespace halflight {

/// Triangles that return light, along a Morton curve.
std::vector<uint32_t> reflecting_triangles(const Scene&);

/// They laid out by area: strata of equal area are then compact.
class SurfaceStrata {
 public:
  SurfaceStrata() : prefix_(1, 0.0) {}  ///< of nothing
  explicit SurfaceStrata(const Scene&);

  std::span<const uint32_t> triangles() const { return triangles_; }
  double area() const { return prefix_.back(); }

  /// The point at `share` in [0, 1) of the area; `u` says where on its triangle. Uniform numbers give points
  /// of density 1/area per area. There must be some area.
  SurfacePoint at(double share, Vec2 u) const;

 private:
  std::vector<uint32_t> triangles_;
  std::vector<double> prefix_;
  std::vector<uint32_t>
      guide_;  ///< for each of 2ᵏ equal shares the triangle in which it begins (Chen & Asau 1974)
};

/// What a surface returns of the light that reaches it: `bounce_albedo`; a hole of a mask or a blend returns
/// its share only.
Vec3 covered_albedo(const Scene&, SurfacePoint);

}  // namespace halflight
