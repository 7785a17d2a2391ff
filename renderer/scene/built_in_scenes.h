// Makers of the built-in scenes, one file each; `built_in_scenes` (scene/load.h) lists them.
#pragma once

#include "scene/scene.h"

namespace halflight {

Scene make_cornell();
Scene make_bedroom();
Scene make_box();
Scene make_plate();
Scene make_hall();
Scene make_glossy_sphere();
Scene make_bumpy_statue();
Scene make_spheres();
Scene make_car();
Scene make_statue();

}  // namespace halflight
