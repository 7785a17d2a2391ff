#include "commands/open_scene.h"

#include <unistd.h>

#include <algorithm>
#include <charconv>

#include "core/stopwatch.h"
#include "core/timeline.h"
#include "scene/view_file.h"

namespace halflight {

namespace {

void apply_environment(Scene& scene, const Options& options, Messages& messages) {
  if (options.environment)
    scene.environment = open_environment(*options.environment, options.load.limits, messages);
  if (!scene.environment.present() && (options.environment_rotation || options.environment_strength))
    messages.warn("there is no environment to turn or strengthen; --environment gives one");
  if (options.environment_rotation) scene.environment.rotation = *options.environment_rotation;
  if (options.environment_strength) scene.environment.strength = *options.environment_strength;
}

/// A picture that cannot fit is refused with a reason, where the system would end the program without one.
void check_memory(const RenderSettings& settings) {
  const double bytes_a_pixel =
      sizeof(GBufferTexel) + 2 * (sizeof(Vec3d) + sizeof(uint32_t)) + 3 * sizeof(Vec3);
  const double needed = bytes_a_pixel * settings.width * settings.height;
  const double machine =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  if (needed > machine)
    throw Error(ExitCode::failure,
                fmt::format("--size {}x{} needs about {:.0f} GB of memory, the machine has {:.0f}",
                            settings.width, settings.height, needed / 1e9, machine / 1e9));
}

}  // namespace

size_t find_camera(const Scene& scene, const std::string& name_or_index) {
  std::vector<std::string> names;
  for (const Camera& camera : scene.cameras) names.push_back(camera.name);
  const auto named = std::find(names.begin(), names.end(), name_or_index);
  if (named != names.end()) return static_cast<size_t>(named - names.begin());
  size_t index = 0;
  const char* end = name_or_index.data() + name_or_index.size();
  if (const auto parsed = std::from_chars(name_or_index.data(), end, index);
      parsed.ec == std::errc() && parsed.ptr == end) {
    if (index < names.size()) return index;
    throw usage_error(
        fmt::format("camera {} does not exist; the scene has {}, counted from 0", index, names.size()));
  }
  throw unknown_name("camera", name_or_index, names);
}

OpenedScene open_scene(const Options& options, Messages& messages) {
  const TimelineScope scope("load");
  check_memory(options.render);
  Stopwatch watch;
  OpenedScene opened;
  messages.strict = options.strict;

  // The view comes first: it may name the scene.
  View view;
  if (!options.view.empty()) view = read_view(options.view, options.load.limits);
  const std::string name = view.scene && !options.scene_given ? view.scene->string() : options.scene;
  opened.scene = load_scene(name, options.load, messages);
  if (options.environment && view.environment) view.environment->file.reset();
  apply_view(opened.scene, view, options.load.limits, messages);
  apply_environment(opened.scene, options, messages);

  opened.display.tonemap = options.tonemap;
  opened.display.ev = options.ev.value_or(view.ev.value_or(0.0f));
  if (!options.camera.empty()) {
    const size_t index = find_camera(opened.scene, options.camera);
    const auto chosen = opened.scene.cameras.begin() + static_cast<ptrdiff_t>(index);
    std::rotate(opened.scene.cameras.begin(), chosen, chosen + 1);
  }
  opened.seconds = watch.seconds();
  return opened;
}

}  // namespace halflight
