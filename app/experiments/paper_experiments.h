// The experiments' functions, one a figure; registry.cpp lists them.
#pragma once

#include "experiments/experiment.h"

namespace halflight {

void run_wa_fig3(const ExperimentRun&, ExperimentReport&, Facts& machine);
void run_wa_fig4(const ExperimentRun&, ExperimentReport&, Facts& machine);
void run_wa_fig5(const ExperimentRun&, ExperimentReport&, Facts& machine);
void run_wa_fig8(const ExperimentRun&, ExperimentReport&, Facts& machine);
void run_krivanek(const ExperimentRun&, ExperimentReport&, Facts& machine);
void run_gems_pictures(const ExperimentRun&, ExperimentReport&, Facts& machine);
void run_gems_error(const ExperimentRun&, ExperimentReport&, Facts& machine);
void run_gems_time(const ExperimentRun&, ExperimentReport&, Facts& machine);
void run_pharr_fig2(const ExperimentRun&, ExperimentReport&, Facts& machine);
void run_ingredients(const ExperimentRun&, ExperimentReport&, Facts& machine);
void run_continuous(const ExperimentRun&, ExperimentReport&, Facts& machine);
void run_plan_gain(const ExperimentRun&, ExperimentReport&, Facts& machine);

}  // namespace halflight
