#include "techniques/light_walk.h"

#include <array>
#include <cmath>
#include <cstring>

#include "core/simd.h"
#include "lights/cut_importance.h"

namespace halflight {

namespace {

constexpr int width = WalkNode::width;
constexpr double beta = 0x1p-10;
constexpr double fresh_below = 0x1p-13;  // 53 − 13 = 40 bits

// ---- Building ----

/// Half angles of cones about the nodes' mean normals that hold all normals below; π for kinds without.
std::vector<float> cone_angles(const LightTree& tree) {
  std::vector<float> angle(tree.nodes.size(), pi);
  for (size_t i = tree.nodes.size(); i-- > 0;) {
    const LightNode& node = tree.nodes[i];
    if (node.kind != LightKind::surface && node.kind != LightKind::emitter) continue;
    if (node.left < 0) {
      angle[i] = 0;
      continue;
    }
    const float length = glm::length(node.normal);
    if (!(length > 1e-3f)) continue;
    float widest = 0;
    for (const int32_t c : {node.left, node.left + 1}) {
      const Vec3 normal = tree.nodes[c].normal;
      const float its_length = glm::length(normal);
      const float cosine = its_length > 1e-3f ? glm::dot(normal, node.normal) / (its_length * length) : -1.0f;
      widest = std::max(widest, std::acos(std::clamp(cosine, -1.0f, 1.0f)) + angle[c]);
    }
    angle[i] = std::min(widest, pi);
  }
  return angle;
}

/// A multiple of 2⁻²⁰.
float whole_share(double share) { return static_cast<float>(std::nearbyint(share * 0x1p20) * 0x1p-20); }

struct Builder {
  const LightTree& tree;
  double power_unit;
  std::vector<float> angle;
  std::vector<WalkNode>& nodes;

  struct Children {
    std::array<int32_t, width> node;
    int count = 0;
  };

  /// Lit children of a binary node, the largest opened until there are four; in the order of the tree.
  Children open(int32_t parent) const {
    Children children;
    const auto insert = [&](int place, int32_t binary) {
      int32_t both[2] = {tree.nodes[binary].left, tree.nodes[binary].left + 1};
      int lit = 0;
      for (const int32_t c : both)
        if (tree.nodes[c].power > 0) both[lit++] = c;
      std::copy_backward(children.node.begin() + place, children.node.begin() + children.count,
                         children.node.begin() + children.count + lit);
      std::copy_n(both, lit, children.node.begin() + place);
      children.count += lit;
    };
    insert(0, parent);
    while (children.count < width) {
      int largest = -1;
      for (int c = 0; c < children.count; ++c) {
        const LightNode& node = tree.nodes[children.node[c]];
        if (node.left >= 0 && (largest < 0 || node.count() > tree.nodes[children.node[largest]].count()))
          largest = c;
      }
      if (largest < 0) break;
      const int32_t binary = children.node[largest];
      std::copy(children.node.begin() + largest + 1, children.node.begin() + children.count,
                children.node.begin() + largest);
      --children.count;
      insert(largest, binary);
    }
    return children;
  }

  void fill(size_t place, const Children& children, bool kinds) {
    double sum = 0;
    for (int c = 0; c < children.count; ++c) sum += tree.nodes[children.node[c]].power;
    for (int c = 0; c < children.count; ++c) {
      const LightNode& node = tree.nodes[children.node[c]];
      const bool faces = node.kind == LightKind::surface || node.kind == LightKind::emitter;
      const Vec3 centre = 0.5f * node.low + 0.5f * node.high, half = 0.5f * (node.high - node.low);
      const float length = glm::length(node.normal);
      const Vec3 axis = length > 1e-3f ? node.normal / length : Vec3(0, 0, 1);
      const float cone = angle[children.node[c]];
      const double even = 1.0 / children.count;
      WalkNode& out = nodes[place];
      out.centre_x[c] = centre.x, out.centre_y[c] = centre.y, out.centre_z[c] = centre.z;
      out.extent_x[c] = half.x, out.extent_y[c] = half.y, out.extent_z[c] = half.z;
      out.axis_x[c] = axis.x, out.axis_y[c] = axis.y, out.axis_z[c] = axis.z;
      out.cos_cone[c] = cone < pi ? std::cos(cone) : -1.0f;
      out.power[c] = static_cast<float>(node.power / power_unit);
      out.measure[c] = faces ? node.measure : 0.0f;
      out.local[c] = node.kind == LightKind::environment ? 0.0f : 1.0f;
      out.guard[c] = whole_share(kinds ? even : 0.5 * (node.power / sum) + 0.5 * even);
      out.begin[c] = node.begin;
      out.child[c] = node.left < 0 ? ~static_cast<int32_t>(node.begin) : 0;
    }
    // What rounding left goes to the greatest: multiples of a power of two sum to 1 exactly.
    float* guard = nodes[place].guard;
    float rest = 1;
    for (int c = 0; c < children.count; ++c) rest -= guard[c];
    *std::max_element(guard, guard + children.count) += rest;
  }

  void add(const Children& children, bool kinds) {
    const size_t place = nodes.size();
    nodes.emplace_back();
    fill(place, children, kinds);
    for (int c = 0; c < children.count; ++c) {
      if (nodes[place].child[c] < 0) continue;
      const Children below = open(children.node[c]);
      nodes[place].child[c] = static_cast<int32_t>(nodes.size());
      add(below, false);
    }
  }
};

}  // namespace

void WalkTree::build(const LightTree& tree, double power_unit) {
  nodes.clear();
  Builder builder{tree, power_unit, cone_angles(tree), nodes};
  Builder::Children roots;
  for (const int32_t root : tree.roots)
    if (root >= 0 && tree.nodes[root].power > 0) roots.node[roots.count++] = root;
  if (roots.count == 0) return;
  nodes.reserve(tree.lights.size() / 2 + 1);
  builder.add(roots, true);
}

LobeBound lobe_bound(const GBufferTexel& texel) {
  const Brdf& brdf = texel.brdf;
  LobeBound bound{};
  const float cos_o = std::max(glm::dot(texel.shading_normal, texel.wo), 0.1f);
  bound.axis = 2 * glm::dot(texel.shading_normal, texel.wo) * texel.shading_normal - texel.wo;
  bound.diffuse = std::max(luminance(brdf.diffuse), 0.0f) / pi;
  if (!brdf.has_specular()) return bound;
  const float strength = specular_strength(texel);
  // cosⁿ ≤ e^{−n(1 − c)} ≤ 1/(1 + n (1 − c)/2)². For lobes of half vectors 1 − c is about four times as much,
  // and GGX falls like that by itself, its density at the peak D/(4 cos²).
  switch (brdf.model) {
    case BrdfModel::phong:
      bound.peak = strength * (brdf.roughness.x + 2) / (2 * pi), bound.sharpness = brdf.roughness.x / 2;
      break;
    case BrdfModel::ashikhmin_shirley:
      bound.peak = strength * std::sqrt((brdf.roughness.x + 1) * (brdf.roughness.y + 1)) / (8 * pi * cos_o);
      bound.sharpness = std::min(brdf.roughness.x, brdf.roughness.y) / 8;
      break;
    case BrdfModel::ggx: {
      const Vec2 alpha = glm::max(brdf.roughness, Vec2(1e-4f));
      bound.peak = strength / (4 * pi * alpha.x * alpha.y * square(cos_o));
      bound.sharpness = 0.5f / square(std::max(alpha.x, alpha.y));
      break;
    }
    case BrdfModel::none:
      break;
  }
  return bound;
}

namespace {

// Four children side by side; vector extensions of the compiler.
using Lanes [[gnu::vector_size(width * sizeof(float))]] = float;

HALFLIGHT_INLINE Lanes load(const float* values) {
  Lanes lanes;
  std::memcpy(&lanes, values, sizeof lanes);
  return lanes;
}

HALFLIGHT_INLINE Lanes larger(Lanes a, Lanes b) { return a > b ? a : b; }
HALFLIGHT_INLINE Lanes smaller(Lanes a, Lanes b) { return a < b ? a : b; }
HALFLIGHT_INLINE Lanes size_of(Lanes v) { return larger(v, -v); }

HALFLIGHT_INLINE Lanes root_of(Lanes v) {
  Lanes root;
  for (int c = 0; c < width; ++c) root[c] = std::sqrt(v[c]);
  return root;
}

/// cos max(0, a − b) from cosines.
HALFLIGHT_INLINE Lanes cos_of_difference(Lanes cos_a, Lanes cos_b) {
  const Lanes zero{}, one = zero + 1.0f;
  const Lanes sines2 = larger(one - cos_a * cos_a, zero) * larger(one - cos_b * cos_b, zero);
  return cos_a >= cos_b ? one : cos_a * cos_b + root_of(sines2);
}

template <bool least_distance, bool lobe>
HALFLIGHT_INLINE void weigh(const WalkNode& node, const WalkPoint& point, float* out) {
  const Lanes zero{}, one = zero + 1.0f, tiny = zero + 1e-36f;
  const Vec3 x = point.x, n = point.normal;
  const Lanes local = load(node.local);
  const Lanes dx = load(node.centre_x) - x.x * local, dy = load(node.centre_y) - x.y * local,
              dz = load(node.centre_z) - x.z * local;
  const Lanes ex = load(node.extent_x), ey = load(node.extent_y), ez = load(node.extent_z);
  const Lanes ax = load(node.axis_x), ay = load(node.axis_y), az = load(node.axis_z);
  const Lanes r2 = larger(dx * dx + dy * dy + dz * dz, tiny), radius2 = ex * ex + ey * ey + ez * ez;
  const Lanes r = root_of(r2), inverse_r = one / r, radius = root_of(radius2);

  // At the point: positive where the box's farthest point along the normal lies above the horizon.
  const Lanes above =
      (n.x * dx + n.y * dy + n.z * dz) + (std::abs(n.x) * ex + std::abs(n.y) * ey + std::abs(n.z) * ez);
  const Lanes cosine = smaller(larger(above * inverse_r, zero), one);

  // At the light: the cosine of the axis for the box's point that sees most of it (where that lies behind, as
  // far off as the box allows); then the cone.
  const Lanes faces =
      (size_of(ax) * ex + size_of(ay) * ey + size_of(az) * ez) - (ax * dx + ay * dy + az * dz);
  const Lanes cos_axis = smaller(faces > zero ? faces * inverse_r : faces / (r + radius), one);
  const Lanes cos_light = larger(cos_of_difference(cos_axis, load(node.cos_cone)), zero);

  Lanes d2 = larger(r2, radius2);
  if (least_distance) {
    const Lanes d = larger(r - radius, 0.125f * radius);
    d2 = larger(d * d, tiny);
  }
  const Lanes distance2 = local > zero ? d2 + point.softening * load(node.measure) * cos_light : one;
  Lanes reflected = cosine;
  if (lobe) {
    // The sphere is seen under the angle with this cosine; all round from inside.
    const Lanes cos2_u = one - radius2 / r2;
    const Lanes cos_u = cos2_u > zero ? root_of(larger(cos2_u, zero)) : -one;
    const Vec3 mirror = point.lobe.axis;
    const Lanes cos_mirror = (mirror.x * dx + mirror.y * dy + mirror.z * dz) * inverse_r;
    const Lanes fall = one + point.lobe.sharpness * (one - cos_of_difference(cos_mirror, cos_u));
    reflected = cosine * (point.lobe.diffuse + point.lobe.peak / (fall * fall));
  }
  const Lanes result = load(node.power) * cos_light * reflected / distance2;
  std::memcpy(out, &result, sizeof result);
}

using Branch = std::array<double, width>;

/// p_c of all children; their sum is 1.
template <bool lobe>
HALFLIGHT_INLINE void branch_probabilities(const WalkNode& node, const WalkPoint& point, double* p) {
  float importance[width];
  weigh<false, lobe>(node, point, importance);
  const double sum = (double{importance[0]} + importance[1]) + (double{importance[2]} + importance[3]);
  constexpr double most = double{std::numeric_limits<float>::max()} * width;
  const bool usable = (sum > 0) & (sum <= most);
  const double scale = (1 - beta) / (usable ? sum : 1.0), guard = usable ? beta : 1.0;
  for (int c = 0; c < width; ++c) p[c] = guard * node.guard[c] + (usable ? scale * importance[c] : 0.0);
}

HALFLIGHT_SIMD_CLONES void weigh_places(const WalkNode* nodes, const int32_t* which, size_t count,
                                        const WalkPoint& point, Branch* out) {
  const WalkPoint at = point;
  for (size_t i = 0; i < count; ++i) branch_probabilities<false>(nodes[which[i]], at, out[i].data());
}

HALFLIGHT_SIMD_CLONES void weigh_lobes(const WalkNode* nodes, const int32_t* which, size_t count,
                                       const WalkPoint& point, Branch* out) {
  const WalkPoint at = point;
  for (size_t i = 0; i < count; ++i) branch_probabilities<true>(nodes[which[i]], at, out[i].data());
}

/// p of the children of some nodes.
void weigh_nodes(const WalkTree& tree, const int32_t* which, size_t count, const WalkPoint& point,
                 Branch* out) {
  (point.has_lobe ? weigh_lobes : weigh_places)(tree.nodes.data(), which, count, point, out);
}

double unit_double(RandomStream& random) { return static_cast<double>(random.next_bits() >> 11) * 0x1p-53; }

void prefetch_node(const WalkNode& node) {
  for (size_t line = 0; line < sizeof(WalkNode); line += 64)
    prefetch(reinterpret_cast<const char*>(&node) + line);
}

// Just below 1: what a number may become by rounding.
constexpr double most_number = 1 - 0x1p-53;

}  // namespace

HALFLIGHT_SIMD_CLONES void bound_children(const WalkNode& node, const WalkPoint& point, float* bound) {
  weigh<true, true>(node, point, bound);
}

void LightWalk::start(std::span<LightSample> out) {
  out_ = out;
  entered_ = 0, step_count_ = 0;
  number_.resize(std::max(number_.size(), out.size()));
}

void LightWalk::enter(const WalkTree& tree, int32_t node, uint32_t count, double share,
                      RandomStream& random) {
  const uint32_t begin = entered_;
  entered_ += count;
  for (uint32_t j = 0; j < count; ++j)
    number_[begin + j] = std::min((j + unit_double(random)) / count, most_number);
  go(tree, {node, begin, entered_, share, 1});
}

void LightWalk::go(const WalkTree& tree, const Step& step) {
  if (step.node < 0) {
    const LightSample sample{static_cast<uint32_t>(~step.node), static_cast<float>(1 / step.probability)};
    std::fill(out_.begin() + step.begin, out_.begin() + step.end, sample);
    return;
  }
  prefetch_node(tree.nodes[step.node]);
  if (step_count_ == steps_.size()) {
    steps_.resize(2 * steps_.size() + 256);
    nodes_.resize(steps_.size());
  }
  nodes_[step_count_] = step.node;
  steps_[step_count_++] = step;
}

void LightWalk::finish(const WalkTree& tree, const WalkPoint& point, RandomStream& random) {
  for (size_t first = 0; first < step_count_;) {
    // All of a level at once: its weighing has no branches, and overlaps.
    const size_t end = step_count_;
    if (branch_.size() < end - first) branch_.resize(2 * (end - first));
    weigh_nodes(tree, nodes_.data() + first, end - first, point, branch_.data());
    for (size_t s = first; s < end; ++s) {
      Step& step = steps_[s];
      if (step.used < fresh_below) renew(step, random);
      const Step from = step;
      if (from.end - from.begin == 1)
        take_one(tree, from, branch_[s - first].data());
      else
        split(tree, from, branch_[s - first].data());
    }
    first = end;
  }
}

void LightWalk::renew(Step& step, RandomStream& random) {
  step.used = 1;
  for (uint32_t j = step.begin; j < step.end; ++j) number_[j] = unit_double(random);
  std::sort(number_.begin() + step.begin, number_.begin() + step.end);
}

void LightWalk::take_one(const WalkTree& tree, const Step& from, const double* p) {
  const WalkNode& node = tree.nodes[from.node];
  const double u = number_[from.begin];
  const std::array<double, width> above{p[0], p[0] + p[1], (p[0] + p[1]) + p[2], 2.0};
  const int last = (p[1] > 0) + (p[2] > 0) + (p[3] > 0);
  const int c = std::min((u >= above[0]) + (u >= above[1]) + (u >= above[2]), last);
  const double below = c > 0 ? above[c - 1] : 0.0;
  number_[from.begin] = std::clamp((u - below) / p[c], 0.0, most_number);
  go(tree, {node.child[c], from.begin, from.end, from.probability * p[c], from.used * p[c]});
}

/// Numbers ascend.
void LightWalk::split(const WalkTree& tree, const Step& from, const double* p) {
  const WalkNode& node = tree.nodes[from.node];
  const int last = (p[1] > 0) + (p[2] > 0) + (p[3] > 0);
  double below = 0;
  uint32_t j = from.begin;
  for (int c = 0; c <= last && j < from.end; ++c) {
    const double above = c < last ? below + p[c] : 2.0;
    const uint32_t first = j;
    for (; j < from.end && number_[j] < above; ++j)
      number_[j] = std::clamp((number_[j] - below) / p[c], 0.0, most_number);
    if (j > first) go(tree, {node.child[c], first, j, from.probability * p[c], from.used * p[c]});
    below = above;
  }
}

double walk_probability(const WalkTree& tree, const WalkPoint& point, int32_t node, uint32_t leaf,
                        double share) {
  double probability = share;
  while (node >= 0) {
    const WalkNode& here = tree.nodes[node];
    int c = width - 1;
    while (c > 0 && !(here.guard[c] > 0 && here.begin[c] <= leaf)) --c;
    Branch p;
    weigh_nodes(tree, &node, 1, point, &p);
    probability *= p[c];
    node = here.child[c];
  }
  return static_cast<uint32_t>(~node) == leaf ? probability : 0.0;
}

}  // namespace halflight
