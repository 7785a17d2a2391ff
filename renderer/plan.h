// Which stages of a frame a scene needs, decided once from facts, with the reason of each.
#pragma once

#include <string>
#include <vector>

#include "techniques/light_stage.h"
#include "techniques/technique.h"

namespace halflight {

/// One stage of a frame: whether this scene needs it, and why.
struct PlanStage {
  std::string stage;
  bool runs;
  std::string why;
};

/// What the scene holds, as far as the plan asks.
struct SceneNeeds {
  bool surfaces = false;     ///< something that reflects
  bool environment = false;  ///< a map with light in it
  size_t punctual = 0;
  bool emitters = false;
  bool specular = false;     ///< a material with a specular lobe
  bool alpha = false;        ///< masks or blends in the way of rays

  bool lit() const { return environment || emitters || punctual > 0; }
};

SceneNeeds scene_needs(const Scene&);

/// Up to this many punctual lights are shown by shadow maps (or a ray each); more become members of S.
inline constexpr size_t handful_of_lights = 8;

struct Plan {
  std::vector<PlanStage> stages;
  LightKinds kinds;              ///< what the technique finds: S holds these, or rays do
  bool gbuffer = true;           ///< what the camera sees is found before the technique runs
  bool light_set = false;        ///< S, its tree and the cut are made
  bool show_emission = true;     ///< L_e is in the picture
  bool direct_punctual = false;  ///< D_punctual is found for each pixel outside S
  bool shadow_maps = false;      ///< punctual light by shadow maps; otherwise by rays
  bool antialiased = false;      ///< the pixel grid moves between rounds and S is redrawn
};

/// `raster` tells how the G-buffer is made ("OpenGL (egl, llvmpipe …)"), empty for rays; `why_backend` the reason.
Plan make_plan(const SceneNeeds&, const TechniqueInfo&, Target, LightSelection, const std::string& raster,
               const std::string& why_backend);

}  // namespace halflight
