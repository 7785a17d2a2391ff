// report.json: a race and what follows from it, for programs.
#pragma once

#include <nlohmann/json.hpp>

#include "report/analysis.h"

namespace halflight {

nlohmann::ordered_json race_json(const Race&, const Analysis&);

}  // namespace halflight
