// The lights as the path tracer draws them. It is the truth other techniques are tested against, so nothing
// here is theirs: its tables, densities and fall-offs are its own, in double, and plain rather than fast.
#pragma once

#include <optional>
#include <vector>

#include "core/random.h"
#include "scene/scene.h"
#include "scene/shading.h"

namespace halflight {

/// Uniform in [0, 1) with 53 bits: a table of millions of entries has some that 24 bits would miss.
inline double uniform_number(RandomStream& random) {
  return static_cast<double>(random.next_bits() >> 11) * 0x1p-53;
}

/// A direction towards a light and what it sends along it.
struct PathLightSample {
  Vec3 wi;
  float distance;  ///< infinity for light from outside the scene
  Vec3d radiance;
  double pdf;  ///< per solid angle
};

/// The environment, directions by luminance: p(ω) = luminance(ω) / ∫ luminance, piecewise constant as the
/// map.
class PathEnvironment {
 public:
  explicit PathEnvironment(const Environment&);

  /// No direction can be drawn. Light too weak to have a luminance in float may still be there.
  bool empty() const { return !(total_ > 0); }
  PathLightSample sample(RandomStream&) const;
  /// Density of `sample` per solid angle.
  double pdf(Vec3 wi) const;

 private:
  double texel_luminance(int x, int y) const { return luminance(environment_.map.at(x, y)); }

  const Environment& environment_;
  std::vector<double> rows_;     ///< running sums of luminance × solid angle, from 0, over the rows
  std::vector<double> columns_;  ///< running sums of luminance over each row, width + 1 entries a row
  double total_ = 0;
};

/// Unit normal of the front side and area of a triangle; zeros where it has none.
struct TriangleShape {
  Vec3d normal;
  double area;
};
TriangleShape triangle_shape(const Scene&, uint32_t triangle);

/// Emissive triangles by area × largest emission, a uniform point on the one drawn.
class PathEmitters {
 public:
  explicit PathEmitters(const Scene&);

  bool empty() const { return triangles_.empty(); }
  /// Nothing where no light comes to x from the point drawn. Radiance includes coverage: a shadow ray ends
  /// before it meets the emitter itself.
  std::optional<PathLightSample> sample(Vec3 x, RandomStream&) const;
  /// Density per solid angle at x with which `sample` draws the point `y` of a triangle.
  double pdf(uint32_t triangle, Vec3 x, Vec3 y) const;

 private:
  const Scene& scene_;
  std::vector<uint32_t> triangles_;
  std::vector<double> sums_;       ///< running sums of the weights, from 0
  std::vector<double> densities_;  ///< per area, one a triangle of the scene; 0 where it does not emit
};

/// What a punctual light gives a surface at x that faces it.
struct PathPunctual {
  Vec3 wi;
  float distance;
  Vec3d irradiance;
};
PathPunctual punctual_towards(const Scene&, const PunctualLight&, Vec3 x);

/// Punctual lights: all of them when few, otherwise one by chance.
class PathPunctuals {
 public:
  static constexpr size_t few = 8;

  explicit PathPunctuals(const Scene&);

  bool empty() const { return lights_.empty(); }
  /// Appends at most `few` lights whose sum has the light of all as its mean.
  void sample(Vec3 x, RandomStream&, std::vector<PathPunctual>& out) const;

 private:
  const Scene& scene_;
  std::vector<uint32_t> lights_;
  std::vector<double> sums_;  ///< running sums of the probabilities, from 0
};

}  // namespace halflight
