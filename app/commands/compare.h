// A comparison as a step of something larger: `halflight compare` runs one, experiments run several.
#pragma once

#include "commands/compare_race.h"
#include "console.h"
#include "interruption.h"
#include "options.h"
#include "progress.h"

namespace halflight {

/// What long work reports to and is stopped by.
struct Workbench {
  Interruption& interruption;
  Progress& progress;
  WarningPrinter& warnings;
};

/// Races the techniques that the options name and writes the report into `options.output`. Interrupted before
/// the first run was complete, it writes nothing and the race has no complete run.
Race compare_techniques(const Options&, const Workbench&);

/// Whether some run of the race came to its end.
bool any_complete(const Race&);

}  // namespace halflight
