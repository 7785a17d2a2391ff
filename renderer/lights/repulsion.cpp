#include "lights/repulsion.h"

#include "lights/surface_walk.h"

namespace halflight {

namespace {

/// How hard a neighbour at `distance` pushes: falls linearly to 0 at the radius.
float strength_at(float distance, float radius) { return std::max(0.0f, 1 - distance / radius); }

Vec3 push_of_neighbours(const PointGrid& grid, const PlacedPoint& self, uint32_t index, float radius) {
  Vec3 sum(0);
  grid.for_neighbours(self.position, [&](const PointGrid::Entry& other) {
    const Vec3 away = self.position - other.place.position;
    const float distance2 = glm::dot(away, away);
    if (distance2 >= radius * radius || !(distance2 > 0) || other.point == index ||
        glm::dot(self.normal, other.place.normal) < facing_together)
      return;
    const float distance = std::sqrt(distance2);
    sum += away * (strength_at(distance, radius) / distance);
  });
  return sum;
}

/// Where the surface ends or folds, nobody pushes back and points would crowd: each such edge of the point's
/// own triangle pushes as the point's mirror image behind it would.
Vec3 push_of_borders(const Scene& scene, const TriangleNeighbours& neighbours, SurfacePoint point,
                     float radius) {
  const UVec3 t = scene.triangles[point.triangle];
  const Vec3 weights(1 - point.barycentric.x - point.barycentric.y, point.barycentric.x, point.barycentric.y);
  Vec3 sum(0);
  for (int i = 0; i < 3; ++i) {
    if (!neighbours.folds(point.triangle, i)) continue;
    const Vec3 corner = scene.vertices[t[i]].position, begin = scene.vertices[t[(i + 1) % 3]].position,
               edge = scene.vertices[t[(i + 2) % 3]].position - begin;
    const float length2 = glm::dot(edge, edge);
    if (!(length2 > 0)) continue;
    const Vec3 inward = corner - begin - edge * (glm::dot(corner - begin, edge) / length2);
    const float height = glm::length(inward);
    if (height > 0) sum += inward * (strength_at(2 * height * weights[i], radius) / height);
  }
  return sum;
}

}  // namespace

PlacedPoint place_point(const Scene& scene, SurfacePoint point) {
  const Vec3 cross = triangle_cross(scene, point.triangle);
  const float length = glm::length(cross);
  return {surface_position(scene, point), length > 0 ? cross / length : Vec3(0)};
}

void repel(const Scene& scene, std::span<const uint32_t> triangles, std::vector<SurfacePoint>& points,
           float spacing, int steps) {
  if (steps <= 0 || points.empty() || !(spacing > 0)) return;
  const TriangleNeighbours neighbours(scene, triangles);
  const float radius = 1.6f * spacing, strength = 0.35f * spacing, longest_step = 0.5f * spacing;
  std::vector<PlacedPoint> placed(points.size());
  constexpr size_t grain = 512;
  for (int step = 0; step < steps; ++step) {
    parallel_for(0, points.size(), grain, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) placed[i] = place_point(scene, points[i]);
    });
    const PointGrid grid(placed, radius);
    // All pushes come from the positions before the step, so that the order of points does not matter.
    parallel_for(0, points.size(), grain, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        Vec3 way = strength * (push_of_neighbours(grid, placed[i], static_cast<uint32_t>(i), radius) +
                               push_of_borders(scene, neighbours, points[i], radius));
        way -= placed[i].normal * glm::dot(placed[i].normal, way);
        const float length = glm::length(way);
        if (!(length > 1e-3f * spacing)) continue;
        points[i] = walk_surface(scene, neighbours, points[i], way * std::min(1.0f, longest_step / length));
      }
    });
  }
}

}  // namespace halflight
