#include "lights/spherical_fibonacci.h"

namespace halflight {

namespace {

constexpr double tau = 6.283185307179586, golden = 1.618033988749895;

double fraction(double x) { return x - std::floor(x); }

}  // namespace

Vec3d fibonacci_direction(uint32_t i, uint32_t count) {
  const double z = 1 - (2.0 * i + 1) / count, r = std::sqrt(std::max(0.0, 1 - z * z));
  const double phi = tau * fraction(i * (golden - 1));
  return {r * std::cos(phi), r * std::sin(phi), z};
}

uint32_t nearest_fibonacci(Vec3d p, uint32_t count) {
  const double n = count;
  const double phi = std::atan2(p.y, p.x), z = p.z;
  // The two grid axes through a point are steps of neighbouring Fibonacci numbers, chosen by latitude (eq.
  // 5).
  const double zone =
      std::floor(std::log(n * tau * 0.5 * std::sqrt(5.0) * (1 - z * z)) / std::log(golden * golden));
  const double k = std::max(2.0, std::isfinite(zone) ? zone : 2.0);
  const double fib = std::pow(golden, k) / std::sqrt(5.0);
  const double f0 = std::round(fib), f1 = std::round(fib * golden);
  // Basis vectors of the local grid in (φ, z) (eq. 6).
  const double b00 = tau * fraction((f0 + 1) * (golden - 1)) - tau * (golden - 1);
  const double b01 = tau * fraction((f1 + 1) * (golden - 1)) - tau * (golden - 1);
  const double b10 = -2 * f0 / n, b11 = -2 * f1 / n;
  const double determinant = b00 * b11 - b01 * b10;
  const double dz = z - (1 - 1 / n);
  const double c0 = std::floor((b11 * phi - b01 * dz) / determinant);
  const double c1 = std::floor((-b10 * phi + b00 * dz) / determinant);

  uint32_t best = 0;
  double least = 8;
  for (int corner = 0; corner < 4; ++corner) {
    const double u = c0 + (corner & 1), v = c1 + (corner >> 1);
    double cos_theta = b10 * u + b11 * v + (1 - 1 / n);
    cos_theta = std::clamp(cos_theta, -1.0, 1.0) * 2 - cos_theta;  // reflected at the poles
    const double index = std::floor(n * 0.5 - cos_theta * n * 0.5);
    const auto i = static_cast<uint32_t>(std::clamp(index, 0.0, n - 1));
    const Vec3d d = fibonacci_direction(i, count) - p;
    const double distance2 = glm::dot(d, d);
    if (distance2 < least) least = distance2, best = i;
  }
  return best;
}

FibonacciSearch::FibonacciSearch(uint32_t count)
    : count_(count), place_(fibonacci_direction(0, count)), certain_(2.2 / count) {
  // Two points of the set are at least 3.09/√n apart, for n > 20 or so (a test measures it): within half of
  // that, squared, no other is nearer.
  if (count < 32) certain_ = 0;
}

uint32_t FibonacciSearch::nearest(Vec3d direction) {
  const Vec3d offset = direction - place_;
  if (glm::dot(offset, offset) < certain_) return last_;
  last_ = nearest_fibonacci(direction, count_);
  place_ = fibonacci_direction(last_, count_);
  return last_;
}

}  // namespace halflight
