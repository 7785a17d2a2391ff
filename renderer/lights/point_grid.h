// Finding the points near a place; private to this folder.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "core/math.h"
#include "core/parallel.h"

namespace halflight {

/// A point of a surface with the normal of its triangle.
struct PlacedPoint {
  Vec3 position, normal;
};

/// Points of surfaces that face apart by more than this cosine do not see each other: both sides of a thin
/// wall.
inline constexpr float facing_together = 0.5f;

/// Points by cell of a uniform grid, found by hashing the cell.
class PointGrid {
 public:
  struct Entry {
    PlacedPoint place;
    uint32_t point;
    uint64_t key;
  };

  PointGrid(std::span<const PlacedPoint> points, float cell_size)
      : inverse_cell_(1 / cell_size), mask_(std::bit_ceil(2 * points.size() + 3) - 1) {
    // A counting sort by bucket, in the order of the points: the same for any number of threads.
    first_.assign(mask_ + 2, 0);
    std::vector<uint64_t> keys(points.size());
    parallel_for(0, points.size(), 4096, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) keys[i] = key(cell(points[i].position));
    });
    for (const uint64_t k : keys) ++first_[bucket(k) + 1];
    for (size_t i = 0; i + 1 < first_.size(); ++i) first_[i + 1] += first_[i];
    std::vector<uint32_t> next(first_.begin(), first_.end() - 1);
    entries_.resize(points.size());
    for (uint32_t i = 0; i < points.size(); ++i) entries_[next[bucket(keys[i])]++] = {points[i], i, keys[i]};
  }

  /// Calls `visit(entry)` for the points of the 27 cells about `p`, in a fixed order: all that lie within
  /// `cell_size` of it, and others.
  template <class Visit>
  void for_neighbours(Vec3 p, Visit&& visit) const {
    const Cell centre = cell(p);
    for (int64_t z = -1; z <= 1; ++z)
      for (int64_t y = -1; y <= 1; ++y) visit_row({centre.x - 1, centre.y + y, centre.z + z}, visit);
  }

 private:
  struct Cell {
    int64_t x, y, z;
  };

  Cell cell(Vec3 p) const {
    const Vec3 c = glm::floor(glm::clamp(p * inverse_cell_, -1e15f, 1e15f));
    return {static_cast<int64_t>(c.x), static_cast<int64_t>(c.y), static_cast<int64_t>(c.z)};
  }
  /// Of neighbours along x, neighbours. Cells that share a key cost a look at points far away.
  static uint64_t key(Cell c) {
    return static_cast<uint64_t>(c.x) + static_cast<uint64_t>(c.y) * 0x9e3779b97f4a7c15ull +
           static_cast<uint64_t>(c.z) * 0xd1b54a32d192ed03ull;
  }
  size_t bucket(uint64_t key) const { return key & mask_; }

  /// A cell and the two that follow it along x: their buckets follow each other, too.
  template <class Visit>
  void visit_row(Cell first_cell, Visit&& visit) const {
    constexpr size_t cells = 3;
    const uint64_t first_key = key(first_cell);
    const size_t begin = bucket(first_key), end = begin + cells, buckets = mask_ + 1;
    const auto visit_buckets = [&](size_t from, size_t to) {
      for (uint32_t i = first_[from]; i < first_[to]; ++i)
        if (entries_[i].key - first_key < cells) visit(entries_[i]);
    };
    visit_buckets(begin, std::min(end, buckets));
    if (end > buckets) visit_buckets(0, end - buckets);
  }

  float inverse_cell_;
  size_t mask_;
  std::vector<Entry> entries_;  ///< by bucket
  std::vector<uint32_t> first_;
};

}  // namespace halflight
