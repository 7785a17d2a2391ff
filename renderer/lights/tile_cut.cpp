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
  return glm::length(extent) > most_reach * glm::length(apart);
}

}  // namespace

TileCut::TileCut(const LightTree& tree, const Cut& base) : tree_(&tree), base_(&base), cut_(base) {}

const Cut& TileCut::refine(const Aabb& box, float most_reach) {
  const bool was_split = !splits_.empty();
  splits_.clear(), parts_.clear();
  find_near(box, most_reach);
  for (const auto& [nearness, k] : near_)
    if (parts_.size() < most_new + splits_.size()) split(k, box, most_reach);
  if (was_split || !splits_.empty()) assemble();
  return cut_;
}

void TileCut::find_near(const Aabb& box, float most_reach) {
  near_.clear();
  reach2_.resize(base_->padded_size());
  reach_loop(*base_, box, reach2_.data(), reach2_.size());
  for (uint32_t k = 0; k < base_->size; ++k)
    if (reach2_[k] > most_reach * most_reach && tree_->nodes[base_->node[k]].left >= 0)
      near_.emplace_back(-reach2_[k], k);
  std::sort(near_.begin(), near_.end());
}

void TileCut::split(uint32_t base_cluster, const Aabb& box, float most_reach) {
  const auto first = static_cast<uint32_t>(parts_.size());
  stack_.assign(1, base_->node[base_cluster]);
  while (!stack_.empty()) {
    const uint32_t index = stack_.back();
    stack_.pop_back();
    const LightNode& node = tree_->nodes[index];
    if (!(node.power > 0)) continue;
    // Parts that wait on the stack will each need a place.
    const bool full = parts_.size() + stack_.size() + 2 > most_new + splits_.size() + 1;
    if (node.left >= 0 && !full && is_near(node, box, most_reach)) {
      stack_.push_back(static_cast<uint32_t>(node.left) + 1);
      stack_.push_back(static_cast<uint32_t>(node.left));
    } else {
      parts_.push_back(index);
    }
  }
  splits_.push_back({base_cluster, first, static_cast<uint32_t>(parts_.size())});
}

/// The base cut's clusters with the parts of those that are split in their place.
void TileCut::assemble() {
  std::sort(splits_.begin(), splits_.end(),
            [](const Split& a, const Split& b) { return a.cluster < b.cluster; });
  const auto size = static_cast<uint32_t>(base_->size + parts_.size() - splits_.size());
  cut_.size = 0;
  resize_arrays(cut_, padded_clusters(size));
  cut_.size = size;
  uint32_t from = 0, to = 0;
  const auto copy_up_to = [&](uint32_t end) {
    copy_clusters(*base_, from, end, cut_, to);
    to += end - from, from = end;
  };
  for (const Split& split : splits_) {
    copy_up_to(split.cluster);
    ++from;
    for (uint32_t part = split.first; part < split.last; ++part, ++to) {
      const LightNode& node = tree_->nodes[parts_[part]];
      cut_.node[to] = parts_[part];
      set_cluster(cut_, to, node);
      cut_.leaf_range[to] = part_of_range(cut_, base_->leaf_range[split.cluster], node.begin, node.end);
    }
  }
  copy_up_to(base_->size);
}

}  // namespace halflight
