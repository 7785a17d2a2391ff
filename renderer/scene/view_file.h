// `--view FILE[#NAME]`: a camera, lights, an environment and an exposure for a scene, as JSON
// (docs/views.md).
#pragma once

#include <filesystem>
#include <optional>

#include "scene/load.h"

namespace halflight {

struct ViewEnvironment {
  std::optional<std::filesystem::path> file;  ///< nothing: the scene's own
  std::optional<float> rotation;              ///< radians, as in Environment
  std::optional<float> strength;
};

/// What a view says; paths are resolved against the folder of its file.
struct View {
  std::optional<std::filesystem::path> scene;  ///< an entry of a collection may name the scene it is made for
  std::optional<Camera> camera;
  std::vector<PunctualLight> lights;  ///< added to the scene's; `picture` indexes `slides`
  std::vector<std::filesystem::path> slides;
  std::optional<ViewEnvironment> environment;
  std::optional<float> ev;
};

/// Reads a view, or from a collection ({"views": {NAME: {…}}}) the entry `name`; a collection of one needs no
/// name. Throws Error: exit code 3 naming the file and the place in it, 2 for a name it does not hold.
View read_view(const std::filesystem::path&, const std::string& name, const LoadLimits& = {});

/// The same from FILE or FILE#NAME.
View read_view(const std::string& file_and_name, const LoadLimits& = {});

/// Puts the view's camera first, adds its lights and sets the environment, reading the pictures it names
/// (throws as the readers do). The exposure is the caller's to use.
void apply_view(Scene&, const View&, const LoadLimits&, Messages&);

}  // namespace halflight
