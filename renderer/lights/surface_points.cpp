#include <algorithm>
#include <numeric>

#include "core/parallel.h"
#include "core/random.h"
#include "core/warp.h"
#include "lights/light_points.h"
#include "lights/repulsion.h"

namespace halflight {

namespace {

bool returns_light(const Material& material) { return !material.unlit && material.model != BrdfModel::none; }

/// Interleaves the low 10 bits of three numbers.
uint32_t morton3(UVec3 v) {
  const auto spread = [](uint32_t x) {
    x = (x | x << 16) & 0x030000ff, x = (x | x << 8) & 0x0300f00f;
    x = (x | x << 4) & 0x030c30c3, x = (x | x << 2) & 0x09249249;
    return x;
  };
  return spread(v.x) | spread(v.y) << 1 | spread(v.z) << 2;
}

/// Triangles that return light, along a Morton curve: strata of equal area are then compact.
std::vector<uint32_t> reflecting_triangles(const Scene& scene) {
  std::vector<std::pair<uint32_t, uint32_t>> keyed;
  const Vec3 scale = 1023.0f / glm::max(scene.bounds.extent(), Vec3(1e-30f));
  for (uint32_t i = 0; i < scene.triangles.size(); ++i) {
    if (!returns_light(scene.materials[scene.triangle_material[i]])) continue;
    const Vec3 centre = surface_position(scene, {i, {1.0f / 3, 1.0f / 3}});
    keyed.emplace_back(morton3(UVec3(glm::clamp((centre - scene.bounds.low) * scale, 0.0f, 1023.0f))), i);
  }
  std::sort(keyed.begin(), keyed.end());
  std::vector<uint32_t> order(keyed.size());
  std::transform(keyed.begin(), keyed.end(), order.begin(), [](const auto& k) { return k.second; });
  return order;
}

BouncePoint bounce_point(const Scene& scene, SurfacePoint surface, float area) {
  BouncePoint point;
  point.position = surface_position(scene, surface);
  point.area = area;
  const Vec3 cross = triangle_cross(scene, surface.triangle);
  point.normal = cross / std::max(glm::length(cross), 1e-37f);
  point.surface = surface;
  point.albedo = bounce_albedo(surface_brdf(scene, surface));
  return point;
}

}  // namespace

std::vector<BouncePoint> spread_surface_points(const Scene& scene, const LightPointSettings& settings) {
  const std::vector<uint32_t> triangles = reflecting_triangles(scene);
  std::vector<double> prefix(triangles.size() + 1, 0.0);
  for (size_t i = 0; i < triangles.size(); ++i)
    prefix[i + 1] = prefix[i] + 0.5 * static_cast<double>(glm::length(triangle_cross(scene, triangles[i])));
  const double total = prefix.back();
  if (!(total > 0) || settings.count == 0) return {};

  // One point in each of `count` strata of equal area.
  std::vector<SurfacePoint> points(settings.count);
  parallel_for(0, points.size(), 4096, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      RandomStream random(i, 0, hash_combine(settings.seed, 0x73757266ull));
      const double target =
          (static_cast<double>(i) + random.next()) / static_cast<double>(points.size()) * total;
      const auto upper = std::upper_bound(prefix.begin() + 1, prefix.end() - 1, target);
      points[i] = {triangles[static_cast<size_t>(upper - prefix.begin()) - 1],
                   uniform_triangle(random.next2())};
    }
  });
  const double area = total / static_cast<double>(settings.count);
  repel(scene, points, static_cast<float>(std::sqrt(area)), settings.repulsion_steps);

  std::vector<BouncePoint> result(points.size());
  parallel_for(0, points.size(), 1024, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) result[i] = bounce_point(scene, points[i], static_cast<float>(area));
  });
  return result;
}

std::vector<VirtualLight> bounce_lights(const std::vector<BouncePoint>& points,
                                        const std::vector<Vec3>& irradiance) {
  std::vector<VirtualLight> lights;
  lights.reserve(2 * points.size());
  for (uint32_t i = 0; i < points.size(); ++i) {
    for (uint32_t side = 0; side < 2; ++side) {
      const BouncePoint& point = points[i];
      VirtualLight light;
      light.position = point.position;
      light.measure = point.area;
      light.normal = side == 0 ? point.normal : -point.normal;
      light.kind = LightKind::surface;
      light.radiance = point.albedo * irradiance[2 * i + side] / pi;
      light.source = 2 * i + side;
      lights.push_back(light);
    }
  }
  return lights;
}

}  // namespace halflight
