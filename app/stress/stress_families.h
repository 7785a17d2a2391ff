// Each family's file appends its cases.
#pragma once

#include "stress/stress_case.h"

namespace halflight {

using StressCases = std::vector<StressCase>;

void add_material_cases(StressCases&);  ///< 1–12
void add_light_cases(StressCases&);     ///< 13–20, 23 and the added lamps
void add_geometry_cases(StressCases&);  ///< 21, 22, 24–31 and the added scales
void add_sampling_cases(StressCases&);  ///< 32–42 and the added NaN

}  // namespace halflight
