#include "lights/tile_cut.h"

#include <algorithm>

#include "core/simd.h"
#include "lights/cut_arrays.h"

namespace halflight {

namespace {

constexpr float endless_reach2 = 1e36f;  // of a cluster that the box touches

/// R²/r² of each cluster, r the distance from its centre to the box; 0 at infinity.
HALFLIGHT_SIMD_CLONES void reach_loop(const Cut& cut, const Aabb& box, float* reach2, size_t count) {
  const float *x = cut.centre_x.data(), *y = cut.centre_y.data(), *z = cut.centre_z.data();
  const float *radius = cut.radius.data(), *local = cut.local.data();
  const Vec3 low = box.low, high = box.high;
#pragma GCC ivdep
  for (size_t k = 0; k < count; ++k) {
    const float below_x = low.x - x[k], above_x = x[k] - high.x, below_y = low.y - y[k],
                above_y = y[k] - high.y, below_z = low.z - z[k], above_z = z[k] - high.z;
    const float out_x = below_x > above_x ? below_x : above_x, out_y = below_y > above_y ? below_y : above_y,
                out_z = below_z > above_z ? below_z : above_z;
    const float dx = out_x > 0.0f ? out_x : 0.0f, dy = out_y > 0.0f ? out_y : 0.0f,
                dz = out_z > 0.0f ? out_z : 0.0f;
    const float r2 = dx * dx + dy * dy + dz * dz, bounds2 = radius[k] * radius[k];
    reach2[k] = local[k] * (bounds2 < endless_reach2 * r2 ? bounds2 / r2 : endless_reach2);
  }
}

bool is_near(const LightNode& node, const Aabb& box, float most_reach) {
  const Vec3 extent = glm::max(node.high - node.centre, node.centre - node.low);
  const Vec3 apart = glm::max(glm::max(box.low - node.centre, node.centre - box.high), Vec3(0));
  return glm::dot(extent, extent) > most_reach * most_reach * glm::dot(apart, apart);
}

/// What draws inside a node add to the variance at a near point, but for cosines: light varies by 1/r² there,
/// and ∫ (l/r²)² dA over a patch of area A from r on is about l² A/r²; a member of area a is never nearer
/// than a/2π in effect.
double variation(const LightNode& node, const Aabb& box) {
  const Vec3 apart = glm::max(glm::max(box.low - node.high, node.low - box.high), Vec3(0));
  const double area = node.measure;
  const double nearest2 = glm::dot(apart, apart) + area / node.count() * (0.5 / pi);
  return nearest2 > 0 ? square(node.mean_radiance()) * area / nearest2 : 0.0;
}

}  // namespace

void PointGroup::add(Vec3 point, Vec3 normal) {
  constexpr float same_normal = 0.9999f;
  box_.extend(point);
  const auto has_normal = [&](const Plane& plane) { return glm::dot(plane.normal, normal) > same_normal; };
  const auto end = planes_.begin() + static_cast<ptrdiff_t>(plane_count_);
  if (const auto plane = std::find_if(planes_.begin(), end, has_normal); plane != end)
    plane->height = std::min(plane->height, glm::dot(plane->normal, point));
  else if (plane_count_ < most_planes)
    planes_[plane_count_++] = {normal, glm::dot(normal, point)};
  else
    planes_are_full_ = true;
}

bool PointGroup::sees(const LightNode& node) const {
  constexpr float slack = 1e-3f;  // of a node's size: what lies in a plane is not above it
  if (planes_are_full_) return true;
  const float least = slack * glm::length(node.high - node.low);
  const auto is_above = [&](const Plane& plane) {
    return glm::dot(plane.normal, node.centre) + node.extent_along(plane.normal) > plane.height + least;
  };
  return std::any_of(planes_.begin(), planes_.begin() + static_cast<ptrdiff_t>(plane_count_), is_above);
}

TileCut::TileCut(const LightTree& tree, const Cut& base) : tree_(&tree), base_(&base), cut_(base) {
  // Nothing has to grow later.
  resize_arrays(cut_, most_padded());
  resize_arrays(cut_, base.padded_size());
  open_.reserve(base.size + most_new), parts_.reserve(base.size + 2 * most_new);
  reach2_.resize(base.padded_size());
}

size_t TileCut::most_padded() const { return padded_clusters(base_->size + most_new); }

const Cut& TileCut::refine(const PointGroup& points, float most_reach) {
  const bool was_split = !parts_.empty();
  find_near(points, most_reach);
  split(points, most_reach);
  if (was_split || !parts_.empty()) assemble();
  return cut_;
}

void TileCut::find_near(const PointGroup& points, float most_reach) {
  const Aabb& box = points.box();
  open_.clear();
  reach_loop(*base_, box, reach2_.data(), reach2_.size());
  for (uint32_t k = 0; k < base_->size; ++k) {
    const LightNode& node = tree_->nodes[base_->node[k]];
    if (reach2_[k] > most_reach * most_reach && node.left >= 0 && points.sees(node))
      open_.push_back({variation(node, box), base_->node[k], node.begin, k});
  }
  std::make_heap(open_.begin(), open_.end());
}

void TileCut::split(const PointGroup& points, float most_reach) {
  const Aabb& box = points.box();
  parts_.clear();
  for (uint32_t added = 0; !open_.empty() && added < most_new; ++added) {
    std::pop_heap(open_.begin(), open_.end());
    const Part whole = open_.back();
    open_.pop_back();
    const auto left = static_cast<uint32_t>(tree_->nodes[whole.node].left);
    for (const uint32_t child : {left, left + 1}) {
      const LightNode& node = tree_->nodes[child];
      if (!(node.power > 0)) continue;
      const Part part{variation(node, box), child, node.begin, whole.base_cluster};
      if (node.left >= 0 && is_near(node, box, most_reach) && points.sees(node)) {
        open_.push_back(part);
        std::push_heap(open_.begin(), open_.end());
      } else {
        parts_.push_back(part);
      }
    }
  }
  for (const Part& part : open_)
    if (part.node != base_->node[part.base_cluster]) parts_.push_back(part);
  std::sort(parts_.begin(), parts_.end(), [](const Part& a, const Part& b) { return a.begin < b.begin; });
}

/// The base cut's clusters with the parts of those that are split in their place.
void TileCut::assemble() {
  uint32_t split = 0;
  for (size_t i = 0; i < parts_.size(); ++i)
    split += i == 0 || parts_[i].base_cluster != parts_[i - 1].base_cluster ? 1 : 0;
  const auto size = static_cast<uint32_t>(base_->size + parts_.size() - split);
  cut_.size = 0;
  resize_arrays(cut_, padded_clusters(size));
  cut_.size = size;
  uint32_t from = 0, to = 0;
  const auto copy_up_to = [&](uint32_t end) {
    copy_clusters(*base_, from, end, cut_, to);
    to += end - from, from = end;
  };
  for (const Part& part : parts_) {
    if (part.base_cluster >= from) {
      copy_up_to(part.base_cluster);
      ++from;
    }
    const LightNode& node = tree_->nodes[part.node];
    cut_.node[to] = part.node;
    set_cluster(cut_, to, node);
    cut_.leaf_range[to] = part_of_range(cut_, base_->leaf_range[part.base_cluster], node.begin, node.end);
    ++to;
  }
  copy_up_to(base_->size);
}

}  // namespace halflight
