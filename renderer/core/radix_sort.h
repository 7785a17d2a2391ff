// Sorting by whole-number keys.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace halflight {

/// Sorts by `first` in steps of 10 bits; equal keys keep their order. For tens of thousands of entries and
/// more, where it is several times as fast as a sort by comparisons.
inline void radix_sort(std::vector<std::pair<uint32_t, uint32_t>>& entries) {
  constexpr uint32_t bits = 10, buckets = 1u << bits;
  std::vector<std::pair<uint32_t, uint32_t>> sorted(entries.size());
  for (uint32_t shift = 0; shift < 32; shift += bits) {
    std::array<size_t, buckets + 1> first{};
    for (const auto& entry : entries) ++first[(entry.first >> shift & (buckets - 1)) + 1];
    if (first[1] == entries.size()) continue;  // all have 0 here
    for (uint32_t b = 0; b < buckets; ++b) first[b + 1] += first[b];
    for (const auto& entry : entries) sorted[first[entry.first >> shift & (buckets - 1)]++] = entry;
    entries.swap(sorted);
  }
}

}  // namespace halflight
