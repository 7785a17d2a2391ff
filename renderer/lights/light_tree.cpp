#include "lights/light_tree.h"

#include <cmath>
#include <utility>

#include "core/errors.h"
#include "core/parallel.h"
#include "core/vector_bytes.h"

namespace halflight {

namespace {

// Below this depth splits are at the median, so that recursion stays shallow whatever the positions.
constexpr int middle_split_depth = 48;
constexpr uint32_t least_parallel_count = 8192;

// An extent of normals counts as this share of the node's diagonal: points that face opposite ways part once
// a node is about as wide as it is deep, long before leaves, and not before the scene is split into places.
constexpr float normal_weight = 0.4f;

/// What a split reads of a light: position and normal, moved together while the order is made.
struct Item {
  std::array<float, 6> key;
  uint32_t index;
};

struct Builder {
  std::vector<LightNode>& nodes;
  std::vector<Item>& items;
  bool use_normals;

  void split(uint32_t node, uint32_t begin, uint32_t end, uint32_t next_free, int depth);
  int widest_axis(uint32_t begin, uint32_t end, float& low, float& high) const;
  uint32_t partition(uint32_t begin, uint32_t end, int depth);
};

int Builder::widest_axis(uint32_t begin, uint32_t end, float& low, float& high) const {
  std::array<float, 6> least, most;
  least.fill(infinity), most.fill(-infinity);
  for (uint32_t i = begin; i < end; ++i) {
    for (int axis = 0; axis < 6; ++axis) {
      least[axis] = std::min(least[axis], items[i].key[axis]);
      most[axis] = std::max(most[axis], items[i].key[axis]);
    }
  }
  const Vec3 size(most[0] - least[0], most[1] - least[1], most[2] - least[2]);
  const float scale = use_normals ? normal_weight * glm::length(size) : 0.0f;
  int widest = 0;
  float extent = -1;
  for (int axis = 0; axis < 6; ++axis) {
    const float e = (most[axis] - least[axis]) * (axis < 3 ? 1.0f : scale);
    if (e > extent) widest = axis, extent = e;
  }
  // Coincident positions are parted by their normals alone.
  if (use_normals && !(extent > 0)) {
    for (int axis = 3; axis < 6; ++axis)
      if (most[axis] - least[axis] > extent) widest = axis, extent = most[axis] - least[axis];
  }
  low = least[widest], high = most[widest];
  return widest;
}

uint32_t Builder::partition(uint32_t begin, uint32_t end, int depth) {
  float low, high;
  const int axis = widest_axis(begin, end, low, high);
  const auto first = items.begin() + begin, last = items.begin() + end;
  if (depth < middle_split_depth && low < high) {
    const float middle = 0.5f * low + 0.5f * high;
    const auto cut = std::partition(first, last, [&](const Item& item) { return item.key[axis] < middle; });
    if (cut != first && cut != last) return static_cast<uint32_t>(cut - items.begin());
  }
  const uint32_t half = begin + (end - begin) / 2;
  std::nth_element(first, items.begin() + half, last, [&](const Item& a, const Item& b) {
    return a.key[axis] != b.key[axis] ? a.key[axis] < b.key[axis] : a.index < b.index;
  });
  return half;
}

void Builder::split(uint32_t node, uint32_t begin, uint32_t end, uint32_t next_free, int depth) {
  nodes[node].begin = begin, nodes[node].end = end;
  if (end - begin == 1) return;
  const uint32_t middle = partition(begin, end, depth);
  nodes[node].left = static_cast<int32_t>(next_free);
  // A subtree of n leaves has 2n − 2 nodes below its root: places are known before the subtrees are.
  const uint32_t left_below = next_free + 2, right_below = left_below + 2 * (middle - begin) - 2;
  const auto left = [&] { split(next_free, begin, middle, left_below, depth + 1); };
  const auto right = [&] { split(next_free + 1, middle, end, right_below, depth + 1); };
  if (end - begin >= least_parallel_count) {
    parallel_invoke(left, right);
  } else {
    left(), right();
  }
}

/// Mean of two vectors weighted by measures; the plain mean where both are 0.
Vec3 weighted_mean(Vec3 a, float weight_a, Vec3 b, float weight_b) {
  const float sum = weight_a + weight_b;
  const float share = sum > 0 ? weight_b / sum : 0.5f;
  return a + share * (b - a);
}

/// Calls `aggregate(index)` for each node under `root`, children before parents, large subtrees in parallel.
template <class Aggregate>
void children_first(const LightTree& tree, int32_t root, const Aggregate& aggregate) {
  const LightNode& node = tree.nodes[static_cast<size_t>(root)];
  if (node.left >= 0 && node.count() >= least_parallel_count) {
    parallel_invoke([&] { children_first(tree, node.left, aggregate); },
                    [&] { children_first(tree, node.left + 1, aggregate); });
  } else if (node.left >= 0) {
    // What lies below a node stands together, parents first.
    for (int32_t i = node.left + 2 * static_cast<int32_t>(node.count()) - 2; i-- > node.left;)
      aggregate(static_cast<size_t>(i));
  }
  aggregate(static_cast<size_t>(root));
}

template <class Aggregate>
void aggregate_all(const LightTree& tree, const Aggregate& aggregate) {
  for (const int32_t root : tree.roots)
    if (root >= 0) children_first(tree, root, aggregate);
}

/// Along the mean normal, from what is known of the children.
float thickness_of(const LightNode& node, const LightNode& a, const LightNode& b) {
  const float length = glm::length(node.normal);
  if (!(length > 0)) return glm::length(glm::max(node.high - node.centre, node.centre - node.low));
  const Vec3 normal = node.normal / length;
  const auto reach = [&](const LightNode& child) {
    return std::abs(glm::dot(normal, child.centre - node.centre)) + child.extent_along(normal);
  };
  return std::max(reach(a), reach(b));
}

/// Box, measure, centre, normal and thickness of one node.
void aggregate_geometry(LightTree& tree, size_t index) {
  LightNode& node = tree.nodes[index];
  if (node.left < 0) {
    const VirtualLight& light = tree.lights[node.begin];
    node.low = node.high = node.centre = light.position;
    node.measure = light.measure, node.normal = light.normal, node.kind = light.kind;
    return;
  }
  const LightNode& a = tree.nodes[node.left];
  const LightNode& b = tree.nodes[node.left + 1];
  node.low = glm::min(a.low, b.low), node.high = glm::max(a.high, b.high);
  node.measure = a.measure + b.measure, node.kind = a.kind;
  node.centre = weighted_mean(a.centre, a.measure, b.centre, b.measure);
  node.normal = weighted_mean(a.normal, a.measure, b.normal, b.measure);
  node.thickness = thickness_of(node, a, b);
}

/// Mean positions of distant lights become directions.
void normalize_directions(LightTree& tree) {
  parallel_for(0, tree.nodes.size(), 16384, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      LightNode& node = tree.nodes[i];
      if (node.kind != LightKind::environment) continue;
      const float length = glm::length(node.centre);
      // Opposite directions may cancel; any member then stands for the node.
      node.centre = length > 1e-6f ? node.centre / length : tree.lights[node.begin].position;
    }
  });
}

/// Power and |C| var(l) of one node; sums of squares are merged without cancellation (Chan et al. 1979).
void aggregate_radiance(LightTree& tree, size_t index) {
  LightNode& node = tree.nodes[index];
  if (node.left < 0) {
    node.power = leaf_power(tree.lights[node.begin]), node.error = 0;
    return;
  }
  const LightNode& a = tree.nodes[node.left];
  const LightNode& b = tree.nodes[node.left + 1];
  node.power = a.power + b.power;
  const double measure_a = a.measure, measure_b = b.measure, measure = measure_a + measure_b;
  const double difference = a.mean_radiance() - b.mean_radiance();
  const double squares = a.error * (measure_a / a.count()) + b.error * (measure_b / b.count()) +
                         (measure > 0 ? difference * difference * measure_a * (measure_b / measure) : 0.0);
  node.error = measure > 0 ? squares / measure * node.count() : 0.0;
}

}  // namespace

float LightNode::extent_along(Vec3 direction) const {
  const Vec3 extent = glm::max(high - centre, centre - low);
  const float along_box = glm::dot(glm::abs(direction), extent);
  // A plate across the mean normal, as wide as the box. Where that is no unit vector the bound is wider.
  const float cosine = std::abs(glm::dot(direction, normal));
  const float sine = std::sqrt(std::max(0.0f, 1 - cosine * cosine));
  return std::min(along_box, cosine * thickness + sine * glm::length(extent));
}

double power_unit(const LightTree& tree) {
  double power = 0;
  for (const int32_t root : tree.roots)
    if (root >= 0) power += tree.nodes[static_cast<size_t>(root)].power;
  return power > 0 ? std::ldexp(1.0, std::ilogb(power) + 1) : 1;
}

size_t held_bytes(const LightTree& tree) { return vector_bytes(tree.nodes, tree.lights, tree.original); }

double leaf_power(const VirtualLight& light) {
  const Vec3d l(light.radiance);
  const double power = (0.2126 * l.x + 0.7152 * l.y + 0.0722 * l.z) * light.measure;
  return power > 0 && std::isfinite(power) ? power : 0.0;
}

LightTree build_light_tree(std::vector<VirtualLight> lights) {
  LightTree tree;
  const auto count = static_cast<uint32_t>(lights.size());
  std::array<uint32_t, light_kind_count + 1> first{};
  for (const VirtualLight& light : lights) ++first[static_cast<uint32_t>(light.kind) + 1];
  for (int kind = 0; kind < light_kind_count; ++kind) first[kind + 1] += first[kind];

  std::vector<Item> items(count);
  std::array<uint32_t, light_kind_count> place;
  std::copy_n(first.begin(), light_kind_count, place.begin());
  for (uint32_t i = 0; i < count; ++i) {
    const VirtualLight& light = lights[i];
    HALFLIGHT_CHECK(is_finite(light.position) && is_finite(light.normal));
    const Vec3 p = light.position, n = light.normal;
    items[place[static_cast<uint32_t>(light.kind)]++] = {{p.x, p.y, p.z, n.x, n.y, n.z}, i};
  }

  const auto kinds = static_cast<uint32_t>(
      std::count_if(first.begin() + 1, first.end(),
                    [&, last = 0u](uint32_t end) mutable { return std::exchange(last, end) != end; }));
  tree.nodes.resize(count > 0 ? 2 * size_t{count} - kinds : 0);
  uint32_t next = 0;
  for (int kind = 0; kind < light_kind_count; ++kind) {
    const uint32_t members = first[kind + 1] - first[kind];
    if (members == 0) continue;
    const auto which = static_cast<LightKind>(kind);
    Builder builder{tree.nodes, items, which == LightKind::surface || which == LightKind::emitter};
    tree.roots[kind] = static_cast<int32_t>(next);
    builder.split(next, first[kind], first[kind + 1], next + 1, 0);
    next += 2 * members - 1;
  }

  tree.lights.resize(count), tree.original.resize(count);
  parallel_for(0, count, 16384, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      tree.original[i] = items[i].index;
      tree.lights[i] = lights[items[i].index];
    }
  });
  aggregate_all(tree, [&](size_t node) { aggregate_geometry(tree, node), aggregate_radiance(tree, node); });
  normalize_directions(tree);
  return tree;
}

void relight(LightTree& tree, std::span<const Vec3> radiance) {
  HALFLIGHT_CHECK(radiance.size() == tree.lights.size());
  parallel_for(0, tree.lights.size(), 16384, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) tree.lights[i].radiance = radiance[tree.original[i]];
  });
  aggregate_all(tree, [&](size_t node) { aggregate_radiance(tree, node); });
}

}  // namespace halflight
