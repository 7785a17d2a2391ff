#include <algorithm>
#include <cmath>
#include <queue>
#include <span>

#include "core/parallel.h"
#include "core/vector_bytes.h"
#include "lights/cut_arrays.h"
#include "lights/light_tree.h"

namespace halflight {

namespace {

/// Largest error first; among equals (a constant environment has none) the strongest, then the earliest.
struct Refinement {
  double error, power;
  uint32_t node;

  bool operator<(const Refinement& o) const {
    if (error != o.error) return error < o.error;
    if (power != o.power) return power < o.power;
    return node > o.node;
  }
};

/// |C| var(l) that a cluster of the kind may keep.
double error_bound(const LightNode& root, const CutSettings& settings) {
  if (settings.sigma > 0) return static_cast<double>(settings.sigma) * settings.sigma;  // eq. 5
  const double scale = settings.relative_error * root.mean_radiance();
  return scale * scale * root.count();
}

/// Splits clusters, the one of largest `error(node)` first, while `wants(error, clusters so far)`.
template <class Error, class Wants>
std::vector<uint32_t> split(const LightTree& tree, std::span<const uint32_t> from, const Error& error,
                            const Wants& wants) {
  std::vector<uint32_t> unsplit;
  std::priority_queue<Refinement> open;
  const auto add = [&](uint32_t index) {
    const LightNode& node = tree.nodes[index];
    if (!(node.power > 0)) return;  // holds nothing that can matter
    if (node.left < 0)
      unsplit.push_back(index);
    else
      open.push({error(node), node.power, index});
  };
  for (const uint32_t index : from) add(index);
  while (!open.empty() && wants(open.top().error, unsplit.size() + open.size())) {
    const auto left = static_cast<uint32_t>(tree.nodes[open.top().node].left);
    open.pop();
    add(left), add(left + 1);
  }
  for (; !open.empty(); open.pop()) unsplit.push_back(open.top().node);
  return unsplit;
}

/// Φ R²: what cosines and lobes vary by across a cluster of distant light. 0 for so few members that their
/// places do not tell how far it extends.
double angular_error(const LightNode& node) {
  constexpr uint32_t few = 8;
  return node.count() < few ? 0.0
                            : node.power * square(static_cast<double>(glm::length(node.high - node.low)));
}

/// Refines one kind's tree; the cluster that errs most is split first (§3.2).
void refine(const LightTree& tree, uint32_t root, const CutSettings& settings, std::vector<uint32_t>& cut) {
  const LightKind kind = tree.nodes[root].kind;
  const double bound = error_bound(tree.nodes[root], settings);
  const uint32_t least = std::max(settings.least, kind == LightKind::punctual ? settings.least_punctual : 0u);
  std::vector<uint32_t> clusters = split(
      tree, std::span(&root, 1), [](const LightNode& node) { return node.error; },
      [&](double error, size_t size) { return size < settings.most && (error > bound || size < least); });
  if (kind == LightKind::environment)
    clusters = split(tree, clusters, angular_error, [&](double error, size_t size) {
      return size < std::min(settings.least_environment, settings.most) && error > 0;
    });
  cut.insert(cut.end(), clusters.begin(), clusters.end());
}

/// Every lit leaf.
void take_leaves(const LightTree& tree, std::vector<uint32_t>& cut) {
  for (uint32_t i = 0; i < tree.nodes.size(); ++i)
    if (tree.nodes[i].left < 0 && tree.nodes[i].power > 0) cut.push_back(i);
}

/// The leaves' shares of their cluster in whole numbers, at least 1 where `weight(leaf)` is not 0;
/// `cluster_weight(k)` is their sum.
template <class Weight, class ClusterWeight>
std::vector<CutLeaf> leaf_shares(const Cut& cut, size_t count, const Weight& weight,
                                 const ClusterWeight& cluster_weight) {
  std::vector<CutLeaf> leaves(count);
  double sum = 0;
  uint32_t leaf = 0;
  for (uint32_t k = 0; k < cut.size; ++k) {
    for (; leaf < cut.begin[k]; ++leaf) leaves[leaf].end = sum;
    const double scale = 0x1p32 / cluster_weight(k);
    for (; leaf < cut.end[k]; ++leaf) {
      const double its_weight = weight(leaf);
      if (its_weight > 0) {
        const double share = std::max(1.0, std::nearbyint(its_weight * scale));
        leaves[leaf].inverse_share = static_cast<float>(1 / share);
        sum += share;
      }
      leaves[leaf].end = sum;
    }
  }
  for (; leaf < count; ++leaf) leaves[leaf].end = sum;
  return leaves;
}

/// Slots of a cluster's own: as many as it has leaves.
LeafRange make_guide(std::vector<CutLeaf>& leaves, uint32_t begin, uint32_t end) {
  LeafRange range;
  range.start = range.guide_start = begin > 0 ? leaves[begin - 1].end : 0.0;
  range.total = leaves[end - 1].end - range.start;
  const double count = end - begin, step = range.total / count;
  range.guide_step = count / range.total, range.guide_begin = begin;
  uint32_t leaf = begin;
  for (uint32_t slot = begin; slot < end; ++slot) {
    // A share less than the exact place: what the search computes may be rounded down.
    const double place = range.start + (slot - begin) * step - 1;
    while (leaves[leaf].end <= place) ++leaf;
    leaves[slot].guide = leaf;
  }
  return range;
}

/// The leaves' table, and where each cluster finds its own in it.
template <class Weight, class ClusterWeight>
void fill_leaves(Cut& cut, size_t count, const Weight& weight, const ClusterWeight& cluster_weight) {
  std::vector<CutLeaf> leaves = leaf_shares(cut, count, weight, cluster_weight);
  parallel_for(0, cut.size, 16, [&](size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) cut.leaf_range[k] = make_guide(leaves, cut.begin[k], cut.end[k]);
  });
  cut.leaves = std::make_shared<const std::vector<CutLeaf>>(std::move(leaves));
}

/// Calls f with each array of clusters and what stands where there is none.
template <class F>
void for_each_array(const F& f) {
  for (const auto array :
       {&Cut::power,     &Cut::radiance,  &Cut::centre_x,  &Cut::centre_y, &Cut::centre_z, &Cut::normal_x,
        &Cut::normal_y,  &Cut::normal_z,  &Cut::radius,    &Cut::extent_x, &Cut::extent_y, &Cut::extent_z,
        &Cut::thickness, &Cut::low_x,     &Cut::low_y,     &Cut::low_z,    &Cut::high_x,   &Cut::high_y,
        &Cut::high_z,    &Cut::softening, &Cut::has_extent})
    f(array, 0.0f);
  for (const auto array : {&Cut::measure, &Cut::local, &Cut::normal_spread}) f(array, 1.0f);
  for (const auto array : {&Cut::node, &Cut::begin, &Cut::end}) f(array, 0u);
  f(&Cut::leaf_range, LeafRange{});
  f(&Cut::kind, LightKind::surface);
}

}  // namespace

void resize_arrays(Cut& cut, size_t padded) {
  for_each_array([&](auto array, auto none) {
    auto& values = cut.*array;
    if (values.size() > cut.size) std::fill(values.begin() + cut.size, values.end(), none);
    values.resize(padded, none);
  });
}

void set_cluster(Cut& cut, uint32_t k, const LightNode& node) {
  const bool faces = node.kind == LightKind::surface || node.kind == LightKind::emitter;
  const bool distant = node.kind == LightKind::environment, punctual = node.kind == LightKind::punctual;
  const Vec3 normal = faces ? node.normal : Vec3(0);
  cut.begin[k] = node.begin, cut.end[k] = node.end, cut.kind[k] = node.kind;
  cut.power[k] = static_cast<float>(node.power / cut.power_unit);
  cut.radiance[k] = static_cast<float>(node.mean_radiance() / cut.power_unit);
  cut.measure[k] = node.measure;
  cut.centre_x[k] = node.centre.x, cut.centre_y[k] = node.centre.y, cut.centre_z[k] = node.centre.z;
  cut.normal_x[k] = normal.x, cut.normal_y[k] = normal.y, cut.normal_z[k] = normal.z;
  const Vec3 extent = glm::max(node.high - node.centre, node.centre - node.low);
  cut.extent_x[k] = extent.x, cut.extent_y[k] = extent.y, cut.extent_z[k] = extent.z;
  cut.radius[k] = glm::length(extent), cut.thickness[k] = node.thickness;
  cut.low_x[k] = node.low.x, cut.low_y[k] = node.low.y, cut.low_z[k] = node.low.z;
  cut.high_x[k] = node.high.x, cut.high_y[k] = node.high.y, cut.high_z[k] = node.high.z;
  cut.local[k] = distant ? 0.0f : 1.0f;
  cut.normal_spread[k] = faces ? std::max(0.0f, 1 - glm::length(normal)) : 1.0f;
  cut.softening[k] = distant ? 0.0f : punctual ? square(cut.radius[k]) : node.measure * (0.5f / pi);
  cut.has_extent[k] = punctual ? 0.0f : 1.0f;
}

void copy_clusters(const Cut& from, uint32_t begin, uint32_t end, Cut& to, uint32_t to_k) {
  for_each_array([&](auto array, auto) {
    std::copy((from.*array).begin() + begin, (from.*array).begin() + end, (to.*array).begin() + to_k);
  });
}

LeafRange part_of_range(const Cut& cut, const LeafRange& whole, uint32_t begin, uint32_t end) {
  LeafRange part = whole;
  part.start = cut.sum_before(begin);
  part.total = cut.sum_before(end) - part.start;
  return part;
}

Cut illumination_cut(const LightTree& tree, const CutSettings& settings) {
  Cut cut;
  std::vector<uint32_t> nodes;
  if (settings.leaves) take_leaves(tree, nodes);
  for (const int32_t root : tree.roots)
    if (root >= 0 && !settings.leaves) refine(tree, static_cast<uint32_t>(root), settings, nodes);
  std::sort(nodes.begin(), nodes.end(),
            [&](uint32_t a, uint32_t b) { return tree.nodes[a].begin < tree.nodes[b].begin; });
  resize_arrays(cut, padded_clusters(nodes.size()));
  cut.size = static_cast<uint32_t>(nodes.size());
  std::copy(nodes.begin(), nodes.end(), cut.node.begin());
  refresh_cut(tree, cut);
  return cut;
}

void refresh_cut(const LightTree& tree, Cut& cut) {
  cut.power_unit = power_unit(tree);
  for (uint32_t k = 0; k < cut.size; ++k) set_cluster(cut, k, tree.nodes[cut.node[k]]);
  fill_leaves(
      cut, tree.lights.size(), [&](uint32_t leaf) { return leaf_power(tree.lights[leaf]); },
      [&](uint32_t k) { return tree.nodes[cut.node[k]].power; });
}

double leaf_probability(const Cut& cut, uint32_t k, uint32_t leaf) {
  return cut.share(leaf) / cut.leaf_range[k].total;
}

void weigh_leaves(Cut& cut, std::span<const float> weight) {
  fill_leaves(
      cut, weight.size(), [&](uint32_t leaf) { return static_cast<double>(weight[leaf]); },
      [](uint32_t) { return 1.0; });
}

size_t held_bytes_of_clusters(const Cut& cut) {
  size_t bytes = 0;
  for_each_array([&](auto array, auto) { bytes += vector_bytes(cut.*array); });
  return bytes;
}

size_t held_bytes(const Cut& cut) {
  return held_bytes_of_clusters(cut) + (cut.leaves ? vector_bytes(*cut.leaves) : 0);
}

Aabb local_bounds(const Cut& cut) {
  Aabb box;
  for (uint32_t k = 0; k < cut.size; ++k) {
    if (cut.local[k] == 0) continue;
    box.extend(Vec3(cut.low_x[k], cut.low_y[k], cut.low_z[k]));
    box.extend(Vec3(cut.high_x[k], cut.high_y[k], cut.high_z[k]));
  }
  return box;
}

Cut equal_radiance_cut(const LightTree& tree, const Cut& lit) {
  Cut cut = lit;
  const float extent = 0.5f * local_bounds(lit).diagonal();
  const float per_light = 4 * pi / static_cast<float>(tree.lights.size());
  const float punctual_area = per_light * (extent > 0 ? square(extent) : 1.0f);
  cut.power_unit = 1;
  for (uint32_t k = 0; k < cut.size; ++k) {
    if (cut.kind[k] == LightKind::punctual) {
      cut.measure[k] = punctual_area * static_cast<float>(cut.end[k] - cut.begin[k]);
      cut.softening[k] = cut.measure[k] * (0.5f / pi);
    }
    cut.power[k] = cut.measure[k], cut.radiance[k] = 1;
  }
  // A radiance that is no number never counts.
  const auto sane = [](const VirtualLight& light) {
    return light.radiance == Vec3(0) || leaf_power(light) > 0;
  };
  fill_leaves(
      cut, tree.lights.size(),
      [&](uint32_t i) { return sane(tree.lights[i]) ? static_cast<double>(tree.lights[i].measure) : 0.0; },
      [&](uint32_t k) { return static_cast<double>(tree.nodes[cut.node[k]].measure); });
  return cut;
}

}  // namespace halflight
