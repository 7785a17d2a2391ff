#include <array>

#include "experiments/paper_experiments.h"

namespace halflight {

std::span<const Experiment> experiments() {
  static constexpr std::array registry{
      Experiment{"wa-fig3", "Wang & Åkerlund 2009, figure 3",
                 "where the samples of three techniques fall on the sphere", run_wa_fig3},
      Experiment{"wa-fig4", "Wang & Åkerlund 2009, figure 4", "the five scenes: cut size, samples, time",
                 run_wa_fig4},
      Experiment{"wa-fig5", "Wang & Åkerlund 2009, figures 5 to 7",
                 "illumination, BRDF, SIR and bidirectional at equal time on the five scenes", run_wa_fig5},
      Experiment{"wa-fig8", "Wang & Åkerlund 2009, figure 8",
                 "SIR against bidirectional, 800 candidates and clusters", run_wa_fig8},
      Experiment{"krivanek", "Křivánek, environment maps and multiple importance sampling",
                 "three estimators over exponent × environment, against the Veach–Guibas bound",
                 run_krivanek},
      Experiment{"gems-fig20-5", "GPU Gems 3, chapter 20, figure 20-5",
                 "40 samples with and without filtering", run_gems_pictures},
      Experiment{"gems-fig20-8", "GPU Gems 3, chapter 20, figure 20-8", "error against the number of samples",
                 run_gems_error},
      Experiment{"gems-fig20-9", "GPU Gems 3, chapter 20, figure 20-9", "time against the number of samples",
                 run_gems_time},
      Experiment{"pharr-fig2", "Pharr, instant global illumination, figure 2",
                 "1, 16 and 256 sets of light paths", run_pharr_fig2},
      Experiment{"continuous", "our own",
                 "halflight against the others in the continuous target, scene by scene", run_continuous},
      Experiment{"ingredients", "our own", "what each ingredient of halflight buys on each scene",
                 run_ingredients},
      Experiment{"plan", "our own", "what leaving out the stages that a scene does not need saves",
                 run_plan_gain},
  };
  return registry;
}

}  // namespace halflight
