#include "scene/built_in_scenes.h"

#include "scene/load.h"

namespace halflight {

const std::vector<BuiltInScene>& built_in_scenes() {
  static const std::vector<BuiltInScene> scenes = {
      {"bedroom", "a furnished bedroom at night, lit by one lamp that shines at the ceiling (95K triangles)",
       make_bedroom},
      {"cornell", "the Cornell box by its published measurements, one emissive quad", make_cornell},
  };
  return scenes;
}

}  // namespace halflight
