// Counter-based random numbers: every number is a pure function of (pixel, pass, seed, dimension), so a picture has
// the same bits for any number of threads and any order of tiles.
#pragma once

#include <cstdint>

#include "core/math.h"

namespace halflight {

/// Finaliser of splitmix64 (Steele et al. 2014): a bijection on 64 bits with full avalanche.
constexpr uint64_t mix_bits(uint64_t v) {
  v ^= v >> 30, v *= 0xbf58476d1ce4e5b9ull;
  v ^= v >> 27, v *= 0x94d049bb133111ebull;
  return v ^ (v >> 31);
}

constexpr uint64_t hash_combine(uint64_t a, uint64_t b) { return mix_bits(a + 0x9e3779b97f4a7c15ull + mix_bits(b)); }

/// Uniform in [0, 1): the top 24 bits, so that 1 is never reached.
constexpr float to_unit_float(uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24f; }

/// A stream of independent numbers; copying it repeats them.
class RandomStream {
 public:
  RandomStream(uint64_t pixel, uint64_t pass, uint64_t seed) : key_(hash_combine(hash_combine(seed, pass), pixel)) {}

  /// Uniform 64 bits.
  uint64_t next_bits() { return mix_bits(key_ + 0x9e3779b97f4a7c15ull * ++counter_); }
  /// Uniform in [0, 1).
  float next() { return to_unit_float(static_cast<uint32_t>(next_bits() >> 32)); }
  /// Two independent numbers uniform in [0, 1).
  Vec2 next2() {
    const uint64_t bits = next_bits();
    return {to_unit_float(static_cast<uint32_t>(bits >> 32)), to_unit_float(static_cast<uint32_t>(bits))};
  }

 private:
  uint64_t key_;
  uint64_t counter_ = 0;
};

}  // namespace halflight
