// What `halflight stress` found, as a table for people, JSON for programs and a page that opens from disk.
#pragma once

#include "commands/json_output.h"
#include "report/race.h"
#include "stress/stress_case.h"

namespace halflight {

struct StressReport {
  std::vector<StressResult> results;
  Facts machine;
  double seconds = 0;
  bool quick = false, complete = true;

  size_t count(StressVerdict) const;
};

/// The exit code: 5 where something falls short.
ExitCode stress_exit_code(const StressReport&);

/// {cases: [{id, name, technique, expected, measured, verdict}], …}.
Json stress_json(const StressReport&);
std::string stress_page(const StressReport&);
/// A row each, and what falls short with its reason below.
std::string stress_table(const StressReport&);
/// Cases with what is expected of them.
std::string stress_list();

}  // namespace halflight
