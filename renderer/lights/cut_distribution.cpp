#include "lights/cut_distribution.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

#include "core/errors.h"
#include "core/simd.h"

namespace halflight {

namespace {

constexpr size_t block = 16;

// Vector extensions of the compiler. Four lanes are what AVX2 has; wider ones it takes apart, one by one.
constexpr size_t double_lanes = 4;
using DoubleLanes [[gnu::vector_size(double_lanes * sizeof(double))]] = double;
using CountLanes [[gnu::vector_size(double_lanes * sizeof(int64_t))]] = int64_t;
/// Running sums of blocks are looked at so many at a time.
constexpr size_t block_stride = 8;
static_assert(block % double_lanes == 0 && block_stride % double_lanes == 0);
constexpr double share_total = 0x1p40;

// Within the guard, this much is spread evenly over the clusters: a light whose guard is lost beside far
// stronger ones may still be the only one that is not hidden.
constexpr double even_share = 0x1p-16;

/// Sum over a padded array, in one fixed order for every vector width.
HALFLIGHT_SIMD_CLONES double padded_sum(const float* values, size_t count) {
  std::array<double, block> lane{};
  for (size_t i = 0; i < count; i += block)
    for (size_t l = 0; l < block; ++l) lane[l] += values[i + l];
  double sum = 0;
  for (const double l : lane) sum += l;
  return sum;
}

struct Mixture {
  double importance_scale, guard_scale, even, least;
};

/// share = max(least, round(a q̂ + b u + c)); `least` applies where the argument is not zero.
HALFLIGHT_SIMD_CLONES void round_shares(const float* importance, const float* guard, size_t count,
                                        const Mixture& mixture, double* share) {
  const double a = mixture.importance_scale, b = mixture.guard_scale, c = mixture.even;
#pragma GCC ivdep
  for (size_t i = 0; i < count; ++i) {
    const double x = a * importance[i] + b * guard[i] + c;
    const double whole = (x + 0x1.8p52) - 0x1.8p52;
    const double least = x > 0 ? 1.0 : 0.0;
    share[i] = whole > least ? whole : least;
  }
}

/// Running sums inside each block, and over blocks; exact, because all are whole numbers below 2^53.
double running_sums(double* share, double* block_end, size_t blocks) {
  double total = 0;
  for (size_t b = 0; b < blocks; ++b) {
    double sum = 0;
    for (size_t i = 0; i < block; ++i) share[b * block + i] = sum += share[b * block + i];
    block_end[b] = total += sum;
  }
  return total;
}

/// The slot of the guide that a sum lies in.
HALFLIGHT_INLINE size_t slot_of(double sum, double slots_per_share) {
  return static_cast<size_t>(static_cast<int64_t>(sum * slots_per_share));
}

/// How many of `size` ascending numbers do not exceed `target`.
template <size_t size>
HALFLIGHT_INLINE size_t count_not_above(const double* ascending, double target) {
  CountLanes sum{};
  for (size_t i = 0; i < size; i += double_lanes) {
    DoubleLanes values;
    std::memcpy(&values, ascending + i, sizeof values);
    sum += values <= target;  // −1 where it holds
  }
  return static_cast<size_t>(-((sum[0] + sum[2]) + (sum[1] + sum[3])));
}

/// First block at or behind `b` whose running sum exceeds `target`; sums of blocks that follow the last are
/// infinite.
HALFLIGHT_INLINE size_t find_block(const double* block_end, size_t b, double target) {
  while (block_end[b + block_stride - 1] <= target) b += block_stride;
  return b + count_not_above<block_stride>(block_end + b, target);
}

/// 1/P of a leaf with a share of 1 in its cluster, of those that sum up to `sum`: the same bits for draws and
/// for those who ask.
HALFLIGHT_INLINE float weight_in_cluster(double total, double cluster_share, double sum) {
  return static_cast<float>(total * sum / cluster_share);
}

struct Tables {
  const double *share, *block_end;
  const uint32_t* guide;
  double slots_per_share, total;
};

constexpr size_t most_in_a_run = 64;

/// Draws half done: their clusters, those clusters' shares, and what is left of the numbers, in [0, 1).
struct ClusterDraws {
  std::array<uint32_t, most_in_a_run> cluster;
  std::array<double, most_in_a_run> share, fraction;
};

/// Finds the clusters of draws [first, first + count) of `of`. Step by step for all of them: what one draw
/// waits for, the processor does of others.
HALFLIGHT_SIMD_CLONES void draw_clusters(const Tables& tables, RandomStream& random, size_t first,
                                         size_t count, size_t of, ClusterDraws& out) {
  const double step = tables.total / static_cast<double>(of);
  const double last = tables.total * 0x1.fffffffffffffp-1;  // the number before it
  std::array<double, most_in_a_run> target;
  std::array<uint32_t, most_in_a_run> in_block;
  for (size_t j = 0; j < count; ++j) {
    const double jitter = static_cast<double>(static_cast<int64_t>(random.next_bits() >> 20)) * 0x1p-44;
    target[j] = std::min((static_cast<double>(static_cast<int64_t>(first + j)) + jitter) * step, last);
  }
  for (size_t j = 0; j < count; ++j)
    in_block[j] = static_cast<uint32_t>(
        find_block(tables.block_end, tables.guide[slot_of(target[j], tables.slots_per_share)], target[j]));
  for (size_t j = 0; j < count; ++j) {
    const size_t b = in_block[j];
    const double* share = tables.share + b * block;
    const double inside = target[j] - (b > 0 ? tables.block_end[b - 1] : 0.0);
    const size_t below = count_not_above<block>(share, inside);
    const double lower = below > 0 ? share[below - 1] : 0.0;
    out.cluster[j] = static_cast<uint32_t>(b * block + below);
    out.share[j] = share[below] - lower;
    out.fraction[j] = inside - lower;
  }
  for (size_t j = 0; j < count; ++j) out.fraction[j] /= out.share[j];
}

/// Picks the leaves with what is left of the numbers, so that strata run along the leaves. Each look-up hangs
/// on the one before, and all are scattered: one is asked for of all draws before the next is needed.
void draw_leaves(const Cut& cut, double total, const ClusterDraws& draws, size_t count, LightSample* out) {
  const CutLeaf* leaves = cut.leaves->data();
  const LeafRange* ranges = cut.leaf_range.data();
  std::array<double, most_in_a_run> target;
  std::array<float, most_in_a_run> cluster_weight;
  std::array<uint32_t, most_in_a_run> at;
  for (size_t j = 0; j < count; ++j) {
    const LeafRange& range = ranges[draws.cluster[j]];
    // Shares are whole: half below the end falls to the last that is not empty, should the sum be rounded up
    // to it.
    target[j] = std::min(range.start + draws.fraction[j] * range.total, range.start + range.total - 0.5);
    at[j] = range.guide_begin +
            static_cast<uint32_t>(static_cast<int32_t>((target[j] - range.guide_start) * range.guide_step));
    prefetch(&leaves[at[j]]);
    cluster_weight[j] = weight_in_cluster(total, draws.share[j], range.total);
  }
  for (size_t j = 0; j < count; ++j) {
    at[j] = leaves[at[j]].guide;
    prefetch(&leaves[at[j]]);
  }
  for (size_t j = 0; j < count; ++j) {
    uint32_t leaf = at[j];
    // Two steps without a branch: most searches end there, and none can tell after how many.
    leaf += leaves[leaf].end <= target[j] ? 1 : 0;
    leaf += leaves[leaf].end <= target[j] ? 1 : 0;
    while (leaves[leaf].end <= target[j]) ++leaf;
    out[j] = {leaf, cluster_weight[j] * leaves[leaf].inverse_share, draws.cluster[j]};
  }
}

void draw_leaves_alike(const Cut& cut, double total, const ClusterDraws& draws, size_t count,
                       LightSample* out) {
  for (size_t j = 0; j < count; ++j) {
    const uint32_t begin = cut.begin[draws.cluster[j]], leaves = cut.end[draws.cluster[j]] - begin;
    out[j] = {begin + static_cast<uint32_t>(draws.fraction[j] * leaves),
              weight_in_cluster(total, draws.share[j], leaves), draws.cluster[j]};
  }
}

bool usable(double sum) { return sum > 0 && std::isfinite(sum); }

}  // namespace

std::span<float> CutDistribution::importance(const Cut& cut) {
  importance_.resize(cut.padded_size());
  return importance_;
}

bool CutDistribution::build(const Cut& cut, std::span<const float> guard, float alpha, LeafRule rule) {
  rule_ = rule;
  total_ = 0;
  const size_t padded = cut.padded_size();
  if (cut.size == 0) return false;
  HALFLIGHT_CHECK(importance_.size() == padded && (alpha == 0 || guard.size() == padded));
  share_.resize(padded);
  const size_t blocks = padded / block;
  block_end_.resize(blocks + block_stride), guide_.resize(blocks + 1);

  std::fill(importance_.begin() + cut.size, importance_.end(), 0.0f);
  const float* guard_or_any = alpha > 0 ? guard.data() : importance_.data();
  const double importance_sum = padded_sum(importance_.data(), padded);
  const double guard_sum = alpha > 0 ? padded_sum(guard_or_any, padded) : 0;
  const bool has_importance = usable(importance_sum), has_guard = usable(guard_sum);
  if (!has_importance && alpha == 0) return false;

  const double guard_weight = share_total * (has_importance ? alpha : 1.0);
  Mixture mixture{};
  mixture.importance_scale = has_importance ? share_total * (1.0 - alpha) / importance_sum : 0;
  mixture.guard_scale = has_guard ? guard_weight * (1 - even_share) / guard_sum : 0;
  mixture.even = alpha > 0 ? guard_weight * (has_guard ? even_share : 1.0) / cut.size : 0;
  if (!has_importance) std::fill(importance_.begin(), importance_.end(), 0.0f);
  if (alpha > 0 && !has_guard)
    round_shares(importance_.data(), importance_.data(), padded, mixture, share_.data());
  else
    round_shares(importance_.data(), guard_or_any, padded, mixture, share_.data());
  std::fill(share_.begin() + cut.size, share_.end(), 0.0);
  total_ = running_sums(share_.data(), block_end_.data(), blocks);
  std::fill(block_end_.begin() + blocks, block_end_.end(), std::numeric_limits<double>::infinity());
  if (!(total_ > 0)) return false;
  make_guide();
  return true;
}

void CutDistribution::make_guide() {
  const size_t slots = guide_.size() - 1;
  slots_per_share_ = static_cast<double>(slots) / total_;
  size_t slot = 0;
  for (uint32_t b = 0; b < slots; ++b)
    for (const size_t end = slot_of(block_end_[b], slots_per_share_); slot <= std::min(end, slots); ++slot)
      guide_[slot] = b;
  std::fill(guide_.begin() + slot, guide_.end(), static_cast<uint32_t>(slots - 1));
}

double CutDistribution::cluster_share(uint32_t k) const {
  return share_[k] - (k % block ? share_[k - 1] : 0.0);
}

double CutDistribution::cluster_probability(uint32_t k) const { return cluster_share(k) / total_; }

double CutDistribution::probability(const Cut& cut, uint32_t k, uint32_t leaf) const {
  const uint32_t count = cut.end[k] - cut.begin[k];
  const double inside = rule_ == LeafRule::uniform ? 1.0 / count : leaf_probability(cut, k, leaf);
  return cluster_share(k) / total_ * inside;
}

float CutDistribution::weight(const Cut& cut, uint32_t k, uint32_t leaf) const {
  if (rule_ == LeafRule::uniform)
    return weight_in_cluster(total_, cluster_share(k), cut.end[k] - cut.begin[k]);
  return weight_in_cluster(total_, cluster_share(k), cut.leaf_range[k].total) *
         (*cut.leaves)[leaf].inverse_share;
}

void CutDistribution::draw(const Cut& cut, RandomStream& random, std::span<LightSample> out) const {
  const Tables tables{share_.data(), block_end_.data(), guide_.data(), slots_per_share_, total_};
  ClusterDraws run;
  for (size_t first = 0; first < out.size(); first += most_in_a_run) {
    const size_t count = std::min(most_in_a_run, out.size() - first);
    draw_clusters(tables, random, first, count, out.size(), run);
    if (rule_ == LeafRule::uniform)
      draw_leaves_alike(cut, total_, run, count, out.data() + first);
    else
      draw_leaves(cut, total_, run, count, out.data() + first);
  }
}

}  // namespace halflight
