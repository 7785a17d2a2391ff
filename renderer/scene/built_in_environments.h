// Environments that are computed instead of read: from one value all around to a handful of tiny suns.
#pragma once

#include <string_view>
#include <vector>

#include "scene/environment.h"

namespace halflight {

/// Name, one line of description, and the maker of a latitude-longitude map, 512 × 256, linear.
struct BuiltInEnvironment {
  std::string_view name, description;
  Environment (*make)();
};

/// All of them, by name. `load_environment` takes a name for a file that does not exist.
const std::vector<BuiltInEnvironment>& built_in_environments();

/// The one of that name; an unknown name is exit code 2.
Environment make_built_in_environment(std::string_view name);

}  // namespace halflight
