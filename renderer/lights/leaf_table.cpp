#include "lights/leaf_table.h"

#include <algorithm>
#include <cmath>

#include "core/simd.h"

namespace halflight {

namespace {

constexpr double share_total = 0x1p40;

}  // namespace

void LeafTable::build(const Cut& cut, const CutDistribution& distribution, uint32_t leaves, bool drawable) {
  entries_.assign(leaves, {});
  total_ = 0;
  if (!drawable) return;
  uint32_t leaf = 0;
  for (uint32_t k = 0; k < cut.size; ++k) {
    for (; leaf < cut.begin[k]; ++leaf) entries_[leaf].end = total_;
    for (; leaf < cut.end[k]; ++leaf) {
      const double p = distribution.probability(cut, k, leaf);
      if (p > 0) total_ += std::max(1.0, std::nearbyint(p * share_total));
      entries_[leaf].end = total_;
    }
  }
  for (; leaf < leaves; ++leaf) entries_[leaf].end = total_;

  double before = 0;
  for (Entry& entry : entries_) {
    if (entry.end > before) entry.weight = static_cast<float>(total_ / (entry.end - before));
    before = entry.end;
  }
  uint32_t guide = 0;
  for (uint32_t slot = 0; slot < leaves; ++slot) {
    // A share less than the exact place: what the search computes may be rounded down.
    const double place = slot * (total_ / leaves) - 1;
    while (entries_[guide].end <= place) ++guide;
    entries_[slot].guide = guide;
  }
}

double LeafTable::probability(uint32_t leaf) const {
  return (entries_[leaf].end - (leaf > 0 ? entries_[leaf - 1].end : 0.0)) / total_;
}

void LeafTable::draw(RandomStream& random, std::span<LightSample> out) const {
  const Entry* entries = entries_.data();
  const double step = total_ / static_cast<double>(out.size()), last = std::nextafter(total_, 0.0);
  const double slots = static_cast<double>(entries_.size()) / total_;
  const size_t last_slot = entries_.size() - 1;
  const auto slot_of = [&](double target) {
    return std::min(static_cast<size_t>(static_cast<int64_t>(target * slots)), last_slot);
  };
  // Look-ups are scattered: those of a run are asked for before the first is needed.
  constexpr size_t run = 64;
  double target[run];
  for (size_t first = 0; first < out.size(); first += run) {
    const size_t count = std::min(run, out.size() - first);
    for (size_t j = 0; j < count; ++j) {
      const double jitter = static_cast<double>(static_cast<int64_t>(random.next_bits() >> 20)) * 0x1p-44;
      target[j] = std::min((static_cast<double>(static_cast<int64_t>(first + j)) + jitter) * step, last);
      prefetch(&entries[slot_of(target[j])]);
    }
    for (size_t j = 0; j < count; ++j) {
      uint32_t leaf = entries[slot_of(target[j])].guide;
      while (entries[leaf].end <= target[j]) ++leaf;
      out[first + j] = {leaf, entries[leaf].weight};
    }
  }
}

}  // namespace halflight
