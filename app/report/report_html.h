// report.html: a race for people.
#pragma once

#include "report/analysis.h"

namespace halflight {

/// One file; pictures are named by their paths beside it.
std::string race_html(const Race&, const Analysis&);

}  // namespace halflight
