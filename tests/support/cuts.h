// Checks of cuts.
#pragma once

#include <gtest/gtest.h>

#include "lights/light_tree.h"

namespace halflight {

inline void expect_covers_every_lit_leaf_once(const LightTree& tree, const Cut& cut) {
  std::vector<int> covered(tree.lights.size(), 0);
  uint32_t last = 0;
  for (uint32_t k = 0; k < cut.size; ++k) {
    ASSERT_GE(cut.begin[k], last) << "in tree order";
    last = cut.end[k];
    for (uint32_t i = cut.begin[k]; i < cut.end[k]; ++i) ++covered[i];
  }
  for (size_t i = 0; i < covered.size(); ++i) {
    ASSERT_LE(covered[i], 1);
    if (leaf_power(tree.lights[i]) > 0) {
      ASSERT_EQ(covered[i], 1);
    }
  }
}

}  // namespace halflight
