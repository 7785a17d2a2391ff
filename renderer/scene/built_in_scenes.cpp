#include "scene/built_in_scenes.h"

#include "scene/load.h"

namespace halflight {

const std::vector<BuiltInScene>& built_in_scenes() {
  static const std::vector<BuiltInScene> scenes = {
      {"bedroom", "a furnished bedroom at night, lit by one lamp that shines at the ceiling (95K triangles)",
       make_bedroom},
      {"box", "glossy and matt things in an open box, lit by a slide thrown on one side (20K triangles)",
       make_box},
      {"bumpy-statue", "a hare of hammered bronze under an environment (66K triangles)", make_bumpy_statue},
      {"car", "a rounded coupe of about 1960 in a hall lit through its roof (32K triangles)", make_car},
      {"cornell", "the Cornell box by its published measurements, one emissive quad", make_cornell},
      {"glossy-sphere", "one glossy sphere under an environment", make_glossy_sphere},
      {"hall", "a vaulted hall at evening, lit mostly by what its vault and floor reflect (94K triangles)",
       make_hall},
      {"plate", "a brushed plate of anisotropic Phong before a wall with a projected sunset (1K triangles)",
       make_plate},
      {"spheres", "eight spheres of modified Phong, exponents from 1 to 3000, in a studio (34K triangles)",
       make_spheres},
      {"statue", "a glossy marble cupbearer under an environment; made for --size 480x640 (64K triangles)",
       make_statue},
  };
  return scenes;
}

}  // namespace halflight
