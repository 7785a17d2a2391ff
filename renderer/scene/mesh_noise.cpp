// Noise for the built-in scenes' cloth and textures.
#include "core/random.h"
#include "scene/mesh_builder.h"

namespace halflight {

namespace {

float fade(float t) { return t * t * t * (t * (t * 6 - 15) + 10); }

/// Dot product of `offset` with a gradient chosen by the lattice point: towards one of the twelve edges of a
/// cube.
float gradient(int x, int y, int z, uint32_t seed, Vec3 offset) {
  const uint64_t lattice =
      (static_cast<uint64_t>(static_cast<uint32_t>(x)) << 32) ^ static_cast<uint32_t>(y) * 0x9e3779b1ull;
  const uint64_t bits = mix_bits(lattice ^ (static_cast<uint64_t>(static_cast<uint32_t>(z)) << 16) ^
                                 (static_cast<uint64_t>(seed) << 40));
  const int axis = static_cast<int>((bits >> 2) % 3);
  const float a = offset[(axis + 1) % 3], b = offset[(axis + 2) % 3];
  return ((bits & 1) ? a : -a) + ((bits & 2) ? b : -b);
}

int wrapped(int i, int period) { return period > 0 ? ((i % period) + period) % period : i; }

float lattice_noise(Vec3 p, int period, uint32_t seed) {
  const Vec3 cell = glm::floor(p), f = p - cell;
  const int x = static_cast<int>(cell.x), y = static_cast<int>(cell.y), z = static_cast<int>(cell.z);
  const auto corner = [&](int i, int j, int k) {
    return gradient(wrapped(x + i, period), wrapped(y + j, period), z + k, seed, f - Vec3(i, j, k));
  };
  const float u = fade(f.x), v = fade(f.y), w = fade(f.z);
  const auto layer = [&](int k) {
    const float low = corner(0, 0, k) + u * (corner(1, 0, k) - corner(0, 0, k));
    const float high = corner(0, 1, k) + u * (corner(1, 1, k) - corner(0, 1, k));
    return low + v * (high - low);
  };
  const float low = layer(0);
  return w == 0 ? low : low + w * (layer(1) - low);
}

}  // namespace

float gradient_noise(Vec3 p, uint32_t seed) { return lattice_noise(p, 0, seed); }
float periodic_noise(Vec2 p, int period, uint32_t seed) { return lattice_noise({p, 0}, period, seed); }

float fractal_noise(Vec2 p, int octaves, int period, uint32_t seed) {
  float sum = 0, weight = 1, scale = 1;
  for (int i = 0; i < octaves; ++i, weight *= 0.5f, scale *= 2)
    sum += weight *
           periodic_noise(scale * p, period * static_cast<int>(scale), seed + static_cast<uint32_t>(i) * 101);
  return sum;
}

}  // namespace halflight
