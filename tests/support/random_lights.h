// Made-up members of S, for tests of tree, cut and distributions.
#pragma once

#include <vector>

#include "core/random.h"
#include "core/warp.h"
#include "lights/virtual_light.h"

namespace halflight {

/// Lights on the six walls of a box of the given size, facing inwards, their radiance smooth along the walls,
/// one in `dark` unlit.
inline std::vector<VirtualLight> wall_lights(uint32_t count, float size, uint64_t seed, uint32_t dark = 5) {
  std::vector<VirtualLight> lights;
  RandomStream random(1, 2, seed);
  for (uint32_t i = 0; i < count; ++i) {
    const Vec2 u = random.next2();
    const uint32_t wall = i % 6, axis = wall / 2;
    Vec3 p, n(0);
    p[axis] = wall % 2 ? size : 0.0f;
    p[(axis + 1) % 3] = u.x * size, p[(axis + 2) % 3] = u.y * size;
    n[axis] = wall % 2 ? -1.0f : 1.0f;
    const float level = i % dark == 0 ? 0.0f : 1 + std::sin(5 * u.x + wall) * u.y;
    lights.push_back({p, 6 * size * size / count, n, LightKind::surface, level * Vec3(1, 0.8f, 0.6f), i});
  }
  return lights;
}

/// The same lights in a world that is turned against the axes.
inline std::vector<VirtualLight> turned(std::vector<VirtualLight> lights) {
  const Basis basis = basis_around(glm::normalize(Vec3(0.5f, 0.7f, -0.4f)));
  for (VirtualLight& light : lights)
    light.position = basis.to_world(light.position), light.normal = basis.to_world(light.normal);
  return lights;
}

/// Lights at infinity with one strong sun among them.
inline std::vector<VirtualLight> sky_lights(uint32_t count, float sun, uint64_t seed) {
  std::vector<VirtualLight> lights;
  RandomStream random(3, 4, seed);
  for (uint32_t i = 0; i < count; ++i) {
    const Vec3 d = uniform_sphere(random.next2());
    const float level = i == count / 3 ? sun : 0.5f + 0.5f * d.y;
    lights.push_back({d, 4 * pi / count, -d, LightKind::environment, Vec3(level), i});
  }
  return lights;
}

/// Point lights spread through a box.
inline std::vector<VirtualLight> lamp_lights(uint32_t count, float size, uint64_t seed) {
  std::vector<VirtualLight> lights;
  RandomStream random(5, 6, seed);
  for (uint32_t i = 0; i < count; ++i) {
    const Vec3 p = size * Vec3(random.next(), random.next(), random.next());
    lights.push_back({p, 1, {0, -1, 0}, LightKind::punctual, Vec3(random.next()), i});
  }
  return lights;
}

inline std::vector<VirtualLight> mixed_lights(uint32_t count, float size, uint64_t seed) {
  std::vector<VirtualLight> all = wall_lights(count, size, seed);
  for (const auto& more : {sky_lights(count, 1000, seed), lamp_lights(count / 10 + 1, size, seed)})
    all.insert(all.end(), more.begin(), more.end());
  return all;
}

}  // namespace halflight
