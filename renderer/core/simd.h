// Plain loops compiled several times, the widest version chosen at run time. Contraction is off everywhere
// (see cmake/compile_options.cmake), so every version gives the same bits.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

// Sanitizers instrument the resolvers of such functions, which run before their run-time library is up.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define HALFLIGHT_SIMD_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define HALFLIGHT_SIMD_CLONES
#endif

/// For helpers of such loops: they must become part of each version.
#define HALFLIGHT_INLINE inline __attribute__((always_inline))

namespace halflight {

/// Asks for memory that is read soon: look-ups in the light tree are scattered, but known a while before.
HALFLIGHT_INLINE void prefetch([[maybe_unused]] const void* address) {
#if defined(__GNUC__)
  __builtin_prefetch(address);
#endif
}

/// The same for all of a record that may lie across two cache lines.
template <class Record>
HALFLIGHT_INLINE void prefetch_whole(const Record& record) {
  const char* first = reinterpret_cast<const char*>(&record);
  prefetch(first);
  prefetch(first + sizeof(Record) - 1);
}

/// e^x for x ≤ 0 with a relative error below 3e-7; 0 below −87. Vectorises, and has the same bits on every
/// machine.
HALFLIGHT_INLINE float exp_negative(float x) {
  const float bounded = x > -87.0f ? x : -87.0f;
  const float shifted = bounded * 1.44269504f + 12582912.0f;  // rounds to a whole number in the low bits
  const float whole = shifted - 12582912.0f;
  const float r = (bounded - whole * 0.693359375f) + whole * 2.12194440e-4f;  // ln 2 in two parts
  // Taylor polynomial of e^r on |r| ≤ ln(2)/2.
  float p = 1.0f / 720;
  p = p * r + 1.0f / 120;
  p = p * r + 1.0f / 24;
  p = p * r + 1.0f / 6;
  p = p * r + 0.5f;
  p = p * r + 1.0f;
  p = p * r + 1.0f;
  const float power = std::bit_cast<float>((std::bit_cast<int32_t>(shifted) - 0x4b400000 + 127) << 23);
  return x > -87.0f ? p * power : 0.0f;
}

/// ln(1 − x) for 0 ≤ x < 1 with a relative error below 3e-7, however small x is; x ≥ 1 counts as the number
/// before it.
HALFLIGHT_INLINE float log_of_complement(float x) {
  const float below = x < 0x1.fffffep-1f ? x : 0x1.fffffep-1f;
  const float y = 1.0f - below;
  // y = m 2^e with m in [√½, √2); where e is 0, m − 1 is −x with all its digits.
  const int32_t bits = std::bit_cast<int32_t>(y), e = (bits - 0x3f3504f3) >> 23;
  const float m = std::bit_cast<float>(bits - (e << 23));
  const float f = e == 0 ? -below : m - 1.0f;
  // ln m = 2 artanh(f/(2 + f)).
  const float s = f / (2.0f + f), s2 = s * s;
  float p = 2.0f / 11;
  p = p * s2 + 2.0f / 9;
  p = p * s2 + 2.0f / 7;
  p = p * s2 + 2.0f / 5;
  p = p * s2 + 2.0f / 3;
  return s * (p * s2 + 2.0f) + static_cast<float>(e) * 0.693147181f;
}

}  // namespace halflight
