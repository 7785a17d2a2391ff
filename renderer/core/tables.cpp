#include "core/tables.h"

#include <bit>
#include <limits>

#include "core/errors.h"

namespace halflight {

namespace {

/// (index + residual) / count, where rounding would leave the cell moved back into it: a look-up at the point
/// finds the cell that was drawn.
float place_in_cell(uint32_t index, float residual, int count) {
  const float cells = static_cast<float>(count);
  float place = (static_cast<float>(index) + residual) / cells;
  while (static_cast<uint32_t>(place * cells) > index) place = std::nextafter(place, 0.0f);
  while (static_cast<uint32_t>(place * cells) < index) place = std::nextafter(place, 1.0f);
  return place;
}

// Below, a binary search touches no more memory than a guide would.
constexpr size_t least_guided = 16;

}  // namespace

DiscreteTable::DiscreteTable(std::span<const float> weights) : prefix_(weights.size() + 1, 0.0) {
  for (size_t i = 0; i < weights.size(); ++i) {
    HALFLIGHT_CHECK(weights[i] >= 0 && std::isfinite(weights[i]));
    prefix_[i + 1] = prefix_[i] + weights[i];
  }
  total_ = prefix_.back();
  if (weights.size() < least_guided || empty()) return;
  const size_t shares = std::bit_ceil(weights.size());
  guide_.reserve(shares + 1);
  size_t entry = 0;
  for (size_t i = 0; i < shares; ++i) {
    const double begin = static_cast<double>(i) / static_cast<double>(shares) * total_;
    while (entry + 1 < weights.size() && prefix_[entry + 1] <= begin) ++entry;
    guide_.push_back(static_cast<uint32_t>(entry));
  }
  guide_.push_back(static_cast<uint32_t>(weights.size() - 1));
}

DiscreteTable::Draw DiscreteTable::draw(float u) const {
  const double target = static_cast<double>(u) * total_;
  // First entry whose upper prefix exceeds the target: never one of zero width.
  size_t first = 0, last = size();
  if (!guide_.empty()) {
    const auto share = static_cast<size_t>(static_cast<double>(u) * static_cast<double>(guide_.size() - 1));
    first = guide_[share], last = guide_[share + 1] + 1;
  }
  auto upper = std::upper_bound(prefix_.begin() + 1 + static_cast<ptrdiff_t>(first),
                                prefix_.begin() + 1 + static_cast<ptrdiff_t>(last), target);
  if (upper == prefix_.end()) upper = std::lower_bound(prefix_.begin() + 1, prefix_.end(), total_);
  const size_t index = static_cast<size_t>(upper - prefix_.begin()) - 1;
  const double width = prefix_[index + 1] - prefix_[index];
  const double residual = (target - prefix_[index]) / width;
  // Of weights 45 orders of magnitude apart the smaller one's probability is no float; callers divide by it.
  const float probability = std::max(static_cast<float>(width / total_), std::numeric_limits<float>::min());
  return {static_cast<uint32_t>(index), probability,
          std::clamp(static_cast<float>(residual), 0.0f, 0x1.fffffep-1f)};
}

PlaneTable::PlaneTable(std::span<const float> weights, int columns, int rows)
    : columns_(columns), rows_(rows) {
  HALFLIGHT_CHECK(weights.size() == static_cast<size_t>(columns) * rows);
  std::vector<float> row_totals(rows);
  conditional_.reserve(rows);
  for (int row = 0; row < rows; ++row) {
    conditional_.emplace_back(weights.subspan(static_cast<size_t>(row) * columns, columns));
    row_totals[row] = static_cast<float>(conditional_.back().total());
  }
  marginal_ = DiscreteTable(row_totals);
}

PlaneTable::Draw PlaneTable::draw(Vec2 u) const {
  const auto row = marginal_.draw(u.y);
  const auto column = conditional_[row.index].draw(u.x);
  return {
      {place_in_cell(column.index, column.residual, columns_), place_in_cell(row.index, row.residual, rows_)},
      column.probability * row.probability * columns_ * rows_,
      row.index * columns_ + column.index};
}

float PlaneTable::pdf(Vec2 position) const {
  const int row = std::clamp(static_cast<int>(position.y * rows_), 0, rows_ - 1);
  const int column = std::clamp(static_cast<int>(position.x * columns_), 0, columns_ - 1);
  if (conditional_[row].empty()) return 0;
  return static_cast<float>(marginal_.probability(row) * conditional_[row].probability(column)) * columns_ *
         rows_;
}

}  // namespace halflight
