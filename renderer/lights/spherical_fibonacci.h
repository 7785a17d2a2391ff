// The spherical Fibonacci set: points as even as repulsion would leave them, with the nearest one found in
// constant time (Keinert et al. 2015, "Spherical Fibonacci Mapping").
#pragma once

#include <cstdint>

#include "core/math.h"

namespace halflight {

/// Unit direction of point `i` of `count`.
Vec3d fibonacci_direction(uint32_t i, uint32_t count);

/// Index of the point nearest to a unit direction.
uint32_t nearest_fibonacci(Vec3d direction, uint32_t count);

/// `nearest_fibonacci` for directions that follow one another closely: the same answers, sooner.
class FibonacciSearch {
 public:
  explicit FibonacciSearch(uint32_t count);
  uint32_t nearest(Vec3d direction);

 private:
  uint32_t count_, last_ = 0;
  Vec3d place_;     ///< of the last answer
  double certain_;  ///< squared distance from it within which no other point can be nearer
};

}  // namespace halflight
