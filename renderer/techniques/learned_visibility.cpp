#include "techniques/learned_visibility.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "core/simd.h"

namespace halflight {

namespace {

constexpr float prior_draws = 4;       // a₀
constexpr float least_factor = 0.05f;  // what is hidden in all samples so far may still be seen in a corner
constexpr uint16_t most_counted = 0x7fff;

HALFLIGHT_SIMD_CLONES void factor_loop(const float* drawn, const float* arrived, float prior, float* out,
                                       size_t count) {
#pragma GCC ivdep
  for (size_t k = 0; k < count; ++k) {
    const float factor = std::sqrt((prior_draws * prior + arrived[k]) / (prior_draws + drawn[k]));
    out[k] = factor > least_factor ? factor : least_factor;
  }
}

}  // namespace

LearnedVisibility::LearnedVisibility(int width, int height, size_t clusters)
    : width_(width),
      height_(height),
      columns_((static_cast<uint32_t>(width) + side - 1) / side),
      rows_((static_cast<uint32_t>(height) + side - 1) / side),
      clusters_(clusters),
      pending_(columns_ * rows_ * clusters),
      known_(columns_ * rows_ * clusters) {}

void LearnedVisibility::publish() {
  parallel_for(0, pending_.size(), 1 << 14, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      VisibilityCount& pending = pending_[i];
      if (pending.drawn == 0) continue;
      uint32_t drawn = known_[i].drawn + uint32_t{pending.drawn},
               arrived = known_[i].arrived + uint32_t{pending.arrived};
      if (drawn > most_counted) drawn /= 2, arrived /= 2;
      known_[i] = {static_cast<uint16_t>(drawn), static_cast<uint16_t>(arrived)};
      pending = {};
    }
  });
  knows_ = true;
}

void LearnedVisibility::forget() {
  std::fill(pending_.begin(), pending_.end(), VisibilityCount{});
  std::fill(known_.begin(), known_.end(), VisibilityCount{});
  knows_ = false;
}

void LearnedVisibility::factors(uint32_t tile, std::span<float> out) const {
  if (!knows_) return std::fill(out.begin(), out.end(), 1.0f);
  const uint32_t column = tile % columns_, row = tile / columns_;
  thread_local std::vector<float> drawn, arrived;
  drawn.assign(clusters_, 0.0f), arrived.assign(clusters_, 0.0f);
  for (uint32_t y = row > 0 ? row - 1 : 0; y <= std::min(row + 1, rows_ - 1); ++y)
    for (uint32_t x = column > 0 ? column - 1 : 0; x <= std::min(column + 1, columns_ - 1); ++x) {
      const VisibilityCount* counts = known_.data() + (y * columns_ + x) * clusters_;
      for (size_t k = 0; k < clusters_; ++k)
        drawn[k] += static_cast<float>(counts[k].drawn), arrived[k] += static_cast<float>(counts[k].arrived);
    }
  double all_drawn = 0, all_arrived = 0;
  for (size_t k = 0; k < clusters_; ++k) all_drawn += drawn[k], all_arrived += arrived[k];
  const float prior = all_drawn > 0 ? static_cast<float>(all_arrived / all_drawn) : 1.0f;
  factor_loop(drawn.data(), arrived.data(), prior, out.data(), clusters_);
}

}  // namespace halflight
