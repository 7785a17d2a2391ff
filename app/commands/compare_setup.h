// Who races in which target, and what the options say of it.
#pragma once

#include <string>
#include <vector>

#include "options.h"
#include "report/race.h"

namespace halflight {

struct RaceEntry {
  std::string name;  ///< the technique's id, or the variant's own
  const TechniqueInfo* info;
  std::string why_preview;                                      ///< empty: it is ranked
  std::vector<std::pair<std::string, std::string>> settings{};  ///< other than the race's
};

struct RaceSetup {
  Target target;
  std::vector<RaceEntry> entries;
  std::vector<LeftOut> left_out;  ///< of `all`
  bool named = false;             ///< techniques were asked for by name: one that fails is an error
};

/// From --techniques, the variants beside them, and --target. Throws Error (exit code 2): an unknown name, a
/// technique named that cannot run in the target, budgets that do not increase or do not suit --equal.
RaceSetup set_up_race(const Options&);

}  // namespace halflight
