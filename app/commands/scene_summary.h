// What is in a scene, for people and for programs.
#pragma once

#include <string>

#include "commands/json_output.h"
#include "scene/scene.h"

namespace halflight {

std::string scene_text(const Scene&);
Json scene_json(const Scene&);

}  // namespace halflight
