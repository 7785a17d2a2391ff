// Sessions of `halflight` in small rooms.
#pragma once

#include "session.h"
#include "support/traced_rooms.h"

namespace halflight {

inline RenderSettings halflight_settings(int width, int height,
                                         const std::vector<std::pair<const char*, const char*>>& set = {}) {
  RenderSettings settings;
  settings.technique = "halflight", settings.target = Target::continuous, settings.backend = Backend::none;
  settings.width = width, settings.height = height;
  settings.values.set("lights.count", "2000");
  for (const auto& [key, value] : set) settings.values.set(key, value);
  return settings;
}

/// Environment with detail, an emitter of many triangles, and one bounce, seen by every model.
inline Scene lit_corner() {
  Scene scene = full_room();
  ImageRgb map(24, 12);
  RandomStream random(3, 1, 4);
  for (Vec3& texel : map.pixels) texel = Vec3(random.next() < 0.1f ? 20.0f : 0.2f);
  scene.environment = make_environment(map, "noise", EnvironmentLayout::latlong);
  scene.environment.rotation = 0.4f;
  for (int i = 0; i < 20; ++i)  // a string of small lamps: runs of emitters
    add_patch(scene, {0.2f + 0.03f * i, 0.9f, 0.2f}, {0, 0, 0.01f}, {0.01f, 0.002f * i, 0}, 2);
  scene.cameras = {look_at({0.9f, 0.6f, 1.8f}, {0.4f, 0.3f, 0.3f}, {0, 1, 0}, 0.7f)};
  return scene;
}

}  // namespace halflight
