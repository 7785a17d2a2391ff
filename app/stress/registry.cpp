#include <algorithm>
#include <charconv>

#include "stress/stress_families.h"

namespace halflight {

namespace {

/// Its number, and those that were added behind.
int place_in_list(const StressCase& c) {
  constexpr int added = 1000;
  int number = 0;
  const bool is_added = c.id.front() == 'A';
  std::from_chars(c.id.data() + (is_added ? 1 : 0), c.id.data() + c.id.size(), number);
  return number + (is_added ? added : 0);
}

}  // namespace

const std::vector<StressCase>& stress_cases() {
  static const StressCases cases = [] {
    StressCases all;
    add_material_cases(all);
    add_light_cases(all);
    add_geometry_cases(all);
    add_sampling_cases(all);
    std::stable_sort(all.begin(), all.end(), [](const StressCase& a, const StressCase& b) {
      return place_in_list(a) < place_in_list(b);
    });
    return all;
  }();
  return cases;
}

}  // namespace halflight
