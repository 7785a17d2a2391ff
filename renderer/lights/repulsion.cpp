#include "lights/repulsion.h"

#include <algorithm>

#include "core/parallel.h"
#include "core/random.h"
#include "lights/surface_walk.h"

namespace halflight {

namespace {

struct Placed {
  Vec3 position, normal;
};

/// Points by cell of a uniform grid, found by hashing the cell.
class PointGrid {
 public:
  PointGrid(const std::vector<Placed>& points, float cell_size) : inverse_cell_(1 / cell_size) {
    entries_.reserve(points.size());
    for (uint32_t i = 0; i < points.size(); ++i) entries_.push_back({key(cell(points[i].position)), i});
    std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) {
      return a.key != b.key ? a.key < b.key : a.point < b.point;
    });
    // A table of where each hash bucket begins makes look-ups constant time.
    first_.assign(bucket_count + 1, 0);
    for (const Entry& entry : entries_) ++first_[bucket(entry.key) + 1];
    for (size_t i = 0; i < bucket_count; ++i) first_[i + 1] += first_[i];
  }

  /// Calls `visit(index)` for the points of the 27 cells about `p`, in a fixed order.
  template <class Visit>
  void for_neighbours(Vec3 p, Visit&& visit) const {
    const glm::ivec3 centre = cell(p);
    for (int z = -1; z <= 1; ++z)
      for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
          const uint64_t wanted = key(centre + glm::ivec3(x, y, z));
          for (uint32_t i = first_[bucket(wanted)]; i < first_[bucket(wanted) + 1]; ++i)
            if (entries_[i].key == wanted) visit(entries_[i].point);
        }
  }

 private:
  struct Entry {
    uint64_t key;
    uint32_t point;
  };
  static constexpr int bucket_bits = 16;
  static constexpr size_t bucket_count = size_t{1} << bucket_bits;

  glm::ivec3 cell(Vec3 p) const { return glm::ivec3(glm::floor(glm::clamp(p * inverse_cell_, -1e9f, 1e9f))); }
  static uint64_t key(glm::ivec3 c) {
    return hash_combine(hash_combine(static_cast<uint32_t>(c.x), static_cast<uint32_t>(c.y)),
                        static_cast<uint32_t>(c.z));
  }
  static size_t bucket(uint64_t key) { return key >> (64 - bucket_bits); }

  float inverse_cell_;
  std::vector<Entry> entries_;  ///< sorted by key, and so by bucket
  std::vector<uint32_t> first_;
};

Placed place(const Scene& scene, SurfacePoint point) {
  const Vec3 cross = triangle_cross(scene, point.triangle);
  const float length = glm::length(cross);
  return {surface_position(scene, point), length > 0 ? cross / length : Vec3(0)};
}

/// Sum of the neighbours' pushes: each falls linearly to 0 at the radius.
Vec3 push(const std::vector<Placed>& placed, const PointGrid& grid, uint32_t self, float radius) {
  constexpr float facing_together = 0.5f;
  Vec3 sum(0);
  grid.for_neighbours(placed[self].position, [&](uint32_t other) {
    if (other == self || glm::dot(placed[self].normal, placed[other].normal) < facing_together) return;
    const Vec3 away = placed[self].position - placed[other].position;
    const float distance2 = glm::dot(away, away);
    if (distance2 >= radius * radius || !(distance2 > 0)) return;
    const float distance = std::sqrt(distance2);
    sum += away * ((1 - distance / radius) / distance);
  });
  return sum;
}

}  // namespace

void repel(const Scene& scene, std::vector<SurfacePoint>& points, float spacing, int steps) {
  if (steps <= 0 || points.size() < 2 || !(spacing > 0)) return;
  const TriangleNeighbours neighbours(scene);
  const float radius = 1.6f * spacing, strength = 0.35f * spacing, longest_step = 0.5f * spacing;
  std::vector<Placed> placed(points.size());
  constexpr size_t grain = 512;
  for (int step = 0; step < steps; ++step) {
    parallel_for(0, points.size(), grain, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) placed[i] = place(scene, points[i]);
    });
    const PointGrid grid(placed, radius);
    // All pushes come from the positions before the step, so that the order of points does not matter.
    parallel_for(0, points.size(), grain, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        Vec3 way = strength * push(placed, grid, static_cast<uint32_t>(i), radius);
        way -= placed[i].normal * glm::dot(placed[i].normal, way);
        const float length = glm::length(way);
        if (!(length > 1e-3f * spacing)) continue;
        points[i] = walk_surface(scene, neighbours, points[i], way * std::min(1.0f, longest_step / length));
      }
    });
  }
}

}  // namespace halflight
