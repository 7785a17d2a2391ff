#include "lights/surface_strata.h"

#include <algorithm>
#include <bit>

#include "core/parallel.h"
#include "core/radix_sort.h"
#include "core/warp.h"

namespace halflight {

namespace {

constexpr size_t grain = 8192;

bool returns_light(const Material& material) {
  if (material.unlit || material.model == BrdfModel::none) return false;
  // GGX is left with its Fresnel reflectance where everything else is black.
  if (material.model == BrdfModel::ggx)
    return max_component(Vec3(material.base_color)) > 0 || material.specular > 0;
  return max_component(material.diffuse) > 0 || max_component(material.phong_specular) > 0;
}

/// Interleaves the low 10 bits of three numbers.
uint32_t morton3(UVec3 v) {
  const auto spread = [](uint32_t x) {
    x = (x | x << 16) & 0x030000ff, x = (x | x << 8) & 0x0300f00f;
    x = (x | x << 4) & 0x030c30c3, x = (x | x << 2) & 0x09249249;
    return x;
  };
  return spread(v.x) | spread(v.y) << 1 | spread(v.z) << 2;
}

}  // namespace

std::vector<uint32_t> reflecting_triangles(const Scene& scene) {
  std::vector<uint8_t> returns(scene.materials.size());
  for (size_t m = 0; m < returns.size(); ++m) returns[m] = returns_light(scene.materials[m]);
  std::vector<std::pair<uint32_t, uint32_t>> keyed;
  keyed.reserve(scene.triangles.size());
  for (uint32_t i = 0; i < scene.triangles.size(); ++i)
    if (returns[scene.triangle_material[i]]) keyed.emplace_back(0, i);
  const Vec3 scale = 1023.0f / glm::max(scene.bounds.extent(), Vec3(1e-30f));
  parallel_for(0, keyed.size(), grain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const Vec3 centre = surface_position(scene, {keyed[i].second, {1.0f / 3, 1.0f / 3}});
      keyed[i].first = morton3(UVec3(glm::clamp((centre - scene.bounds.low) * scale, 0.0f, 1023.0f)));
    }
  });
  radix_sort(keyed);
  std::vector<uint32_t> order(keyed.size());
  std::transform(keyed.begin(), keyed.end(), order.begin(), [](const auto& k) { return k.second; });
  return order;
}

Vec3 covered_albedo(const Scene& scene, SurfacePoint surface) {
  return bounce_albedo(surface_brdf(scene, surface)) * surface_alpha(scene, surface);
}

SurfaceStrata::SurfaceStrata(const Scene& scene) : triangles_(reflecting_triangles(scene)) {
  prefix_.assign(triangles_.size() + 1, 0.0);
  parallel_for(0, triangles_.size(), grain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      prefix_[i + 1] = 0.5 * static_cast<double>(glm::length(triangle_cross(scene, triangles_[i])));
  });
  for (size_t i = 0; i < triangles_.size(); ++i) prefix_[i + 1] += prefix_[i];
  if (triangles_.empty()) return;
  const size_t shares = std::bit_ceil(triangles_.size());
  guide_.reserve(shares + 1);
  for (size_t i = 0, triangle = 0; i < shares; ++i) {
    const double begin = static_cast<double>(i) / static_cast<double>(shares) * area();
    while (triangle + 1 < triangles_.size() && prefix_[triangle + 1] <= begin) ++triangle;
    guide_.push_back(static_cast<uint32_t>(triangle));
  }
  guide_.push_back(static_cast<uint32_t>(triangles_.size() - 1));
}

SurfacePoint SurfaceStrata::at(double share, Vec2 u) const {
  const auto at_share = static_cast<size_t>(share * static_cast<double>(guide_.size() - 1));
  const auto upper = std::upper_bound(prefix_.begin() + 1 + guide_[at_share],
                                      prefix_.begin() + 1 + guide_[at_share + 1], share * area());
  return {triangles_[static_cast<size_t>(upper - prefix_.begin()) - 1], uniform_triangle(u)};
}

}  // namespace halflight
