// Which stages of a frame a scene needs, decided once from facts, with the reason of each.
#pragma once

#include <string>
#include <vector>

#include "techniques/light_stage.h"
#include "techniques/technique.h"

namespace halflight {

/// One stage of a frame: whether this scene needs it, and why.
struct PlanStage {
  Stage stage;
  bool runs;
  std::string why;
};

/// What the scene holds, as far as the plan asks.
struct SceneNeeds {
  bool surfaces = false;     ///< something that reflects
  bool environment = false;  ///< a map with light in it
  size_t punctual = 0;
  size_t emitters = 0;    ///< triangles
  bool specular = false;  ///< a material with a specular lobe
  bool alpha = false;     ///< masks or blends in the way of rays
  size_t animations = 0;
  double at_seconds = 0;  ///< the moment they are posed at

  bool lit() const { return environment || emitters > 0 || punctual > 0; }
};

SceneNeeds scene_needs(const Scene&);

/// Up to this many punctual lights are shown by shadow maps (or a ray each); more become members of S.
inline constexpr size_t handful_of_lights = 8;

/// What is to be drawn, and by what.
struct PlanRequest {
  const TechniqueInfo& technique;
  Target target;
  LightSelection light;
  const SettingValues& settings;
  std::string raster;       ///< how the G-buffer is made ("OpenGL (egl, llvmpipe …)"), empty for rays
  std::string why_backend;  ///< the reason
  /// Stages that run although the scene does not need them, to measure what leaving them out saves. None
  /// changes what the picture converges to.
  StageSet forced{};
  bool pixel_centres = false;  ///< the pixel grid stays where it is
};

struct Plan {
  std::vector<PlanStage> stages;  ///< those that the technique may have at all
  StageSet runs;                  ///< of them
  LightKinds kinds;               ///< what the technique finds: S holds these, or rays do
  LightKinds set_kinds;           ///< what S is made of: those, and black ones that are forced
  CutMaking cut = CutMaking::none;
  bool gbuffer = true;           ///< what the camera sees is found before the technique runs
  bool light_set = false;        ///< S and its tree are made for the frame
  bool show_emission = true;     ///< L_e is in the picture
  bool direct_punctual = false;  ///< D_punctual is found for each pixel outside S
  bool shadow_maps = false;      ///< punctual light by shadow maps; otherwise by rays
  bool redraws = false;          ///< each round has a set S of its own
  bool antialiased = false;      ///< and a pixel grid of its own
};

Plan make_plan(const SceneNeeds&, const PlanRequest&);

}  // namespace halflight
