// Counting rays of a BRDF against the boxes of a cut's clusters (Wang & Åkerlund §3.3).
#pragma once

#include <span>
#include <vector>

#include "lights/light_tree.h"

namespace halflight {

/// A bundle of rays from one point, as arrays for SIMD; at most `capacity`.
struct RayBundle {
  static constexpr uint32_t capacity = 256;

  uint32_t size = 0;
  alignas(64) float x[capacity], y[capacity], z[capacity];  ///< unit directions

  void clear() { size = 0; }
  void add(Vec3 direction) {
    x[size] = direction.x, y[size] = direction.y, z[size] = direction.z;
    ++size;
  }
};

/// What a ray adds to each of the m boxes it meets.
enum class CountRule {
  whole,   ///< 1 (as printed)
  shared,  ///< 1/m, and none to a plate that the point itself lies in
};

/// Scratch of one thread.
class ClusterCounter {
 public:
  struct Count {
    uint32_t cluster;
    float rays;  ///< N_k
  };

  /// Clusters that rays from `x` meet. A box of directions is met by a ray whose direction lies in it, give
  /// or take rounding. Clusters with `arriving` 0 and punctual lights are passed over; an empty `arriving`
  /// admits all others.
  std::span<const Count> count(const Cut&, Vec3 x, std::span<const float> arriving, RayBundle&, CountRule);

 private:
  std::vector<float> may_meet_;
  std::vector<uint32_t> candidates_;
  std::vector<Count> counts_;
};

}  // namespace halflight
