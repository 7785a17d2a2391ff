#include "core/random.h"
#include "core/warp.h"
#include "trace/ray_gbuffer.h"

namespace halflight {

namespace {

constexpr int probe_rays = 256;
constexpr float enclosed_below = 0.2f;  ///< share of the rays that escape from where a room ends

/// Whether something lights the scene, or nothing in it waits for light (unlit surfaces show as they are).
bool has_any_light(const Scene& scene) {
  const auto lit = [](const PunctualLight& light) { return max_component(light.intensity) > 0; };
  if (std::any_of(scene.lights.begin(), scene.lights.end(), lit)) return true;
  if (scene.environment.present()) return true;
  bool all_unlit = !scene.triangles.empty();
  for (const uint32_t index : scene.triangle_material) {
    const Material& material = scene.materials[index];
    if (material.emissive() && !material.unlit) return true;
    all_unlit = all_unlit && material.unlit;
  }
  return all_unlit;
}

/// What a sphere of rays from a point meets: the share that escapes, and the mean distance of those that do
/// not.
struct Surroundings {
  float escaping = 1, mean_distance = 0;
};

Surroundings look_around(const RayScene& rays, Vec3 eye) {
  RayCounters ignored;
  int hits = 0;
  double distance = 0;
  for (int i = 0; i < probe_rays; ++i) {
    RandomStream random(static_cast<uint64_t>(i), 0, 0x70726f6265ull);
    const Vec2 u = random.next2();
    const Vec3 direction = uniform_sphere({(static_cast<float>(i) + u.x) / probe_rays, u.y});
    RayHit hit;
    if (!rays.intersect(eye, direction, 0, infinity, 0, hit, ignored)) continue;
    ++hits;
    distance += hit.distance;
  }
  return {1 - static_cast<float>(hits) / probe_rays, hits > 0 ? static_cast<float>(distance / hits) : 0};
}

/// A little below the ceiling over the middle of what the camera sees, or over the camera where that is
/// blocked.
Vec3 ceiling_place(const RayScene& rays, const Camera& camera, float reach) {
  RayCounters ignored;
  RayHit hit;
  const Vec3 forward = -camera.back;
  const float free =
      rays.intersect(camera.position, forward, 0, infinity, 0, hit, ignored) ? hit.distance : 2 * reach;
  for (const float share : {0.5f, 0.25f, 0.0f}) {
    const Vec3 below = camera.position + forward * (share * free);
    if (!rays.intersect(below, {0, 1, 0}, 0, infinity, 0, hit, ignored)) continue;
    const Vec3 place = below + Vec3(0, 0.85f * hit.distance, 0);
    if (look_around(rays, place).mean_distance > 0.25f * reach) return place;
  }
  return camera.position;
}

}  // namespace

void complete_lights(Scene& scene, const RayScene& rays, Messages& messages) {
  if (has_any_light(scene)) return;
  if (!scene.triangles.empty() && !scene.cameras.empty()) {
    const Surroundings around = look_around(rays, scene.cameras.front().position);
    if (around.escaping < enclosed_below) {
      PunctualLight lamp;
      lamp.name = "added lamp";
      lamp.position = ceiling_place(rays, scene.cameras.front(), around.mean_distance);
      // About π/2 of irradiance at the room's typical distance: a white wall there shows half of white.
      lamp.intensity = Vec3(1.0f, 0.93f, 0.82f) * (0.5f * pi * square(around.mean_distance));
      scene.lights.push_back(lamp);
      scene.facts.added_lamp = true;
      messages.warn("the scene has no light: added a lamp below the ceiling");
      return;
    }
  }
  scene.environment = built_in_sky();
  scene.facts.added_sky = true;
  messages.warn("the scene has no light: added the built-in sky");
}

}  // namespace halflight
