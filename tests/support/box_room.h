// A small closed room with a blocker, every kind of light, and a hand-made G-buffer: all a technique needs,
// with no file, camera or OpenGL behind it.
#pragma once

#include <memory>

#include "core/random.h"
#include "core/warp.h"
#include "support/random_lights.h"
#include "techniques/technique.h"

namespace halflight {

inline void add_quad(Scene& scene, Vec3 corner, Vec3 u, Vec3 v) {
  const auto first = static_cast<uint32_t>(scene.vertices.size());
  const Vec3 n = glm::normalize(glm::cross(u, v));
  for (const Vec3 p : {corner, corner + u, corner + u + v, corner + v})
    scene.vertices.push_back({p, n, Vec4(0), {Vec2(0), Vec2(0)}, 0xffffffffu});
  for (const UVec3 t : {UVec3(0, 1, 2), UVec3(0, 2, 3)}) {
    scene.triangles.push_back(t + first);
    scene.triangle_material.push_back(0);
  }
}

struct RoomOptions {
  float size = 4;   ///< edge of the room
  float light = 1;  ///< scales all radiances
  uint32_t wall_lights = 600, sky_lights = 300, lamps = 5;
  float sun = 200;  ///< radiance of the one strong direction
  CutSettings cut;
  Target target = Target::discrete;
};

/// Owns what a FrameView points to. Not movable: the rays share the scene's vertices.
struct Room {
  Scene scene;
  std::unique_ptr<RayScene> rays;
  LightTree tree;
  Cut cut;
  GBuffer gbuffer;
  std::vector<Vec3> base;
  SettingValues settings;
  FrameView frame;

  explicit Room(const RoomOptions& options, const std::vector<Brdf>& brdfs = {}, uint32_t copies = 1) {
    build_scene(options);
    build_lights(options);
    for (uint32_t copy = 0; copy < copies; ++copy)
      for (size_t i = 0; i < brdfs.size(); ++i) gbuffer.texels.push_back(texel(options, brdfs[i], i));
    gbuffer.width = static_cast<int>(brdfs.size()), gbuffer.height = static_cast<int>(copies);
    base.assign(gbuffer.texels.size(), Vec3(0));
    frame.scene = &scene, frame.rays = rays.get(), frame.gbuffer = &gbuffer;
    frame.tree = &tree, frame.cut = &cut, frame.settings = &settings, frame.base = &base;
    frame.target = options.target;
  }
  Room(const Room&) = delete;

  /// Sum over all of S at a pixel in double, one ray a light: what every unbiased technique must give on
  /// average.
  Vec3d exact(uint32_t pixel) const {
    const GBufferTexel& texel = gbuffer.texels[pixel];
    Vec3d sum(0);
    if (!texel.hit() || texel.brdf.black()) return sum;
    RayCounters counters;
    for (const VirtualLight& light : tree.lights) {
      const LightConnection link = connect(light, scene, texel.position, frame.geometry_term());
      const double cosine = glm::dot(texel.shading_normal, link.wi);
      if (cosine <= 0 || glm::dot(texel.geometric_normal, link.wi) <= 0) continue;
      const Vec3d f(evaluate(texel.brdf, texel.basis(), texel.wo, link.wi));
      ShadowRay ray = shadow_ray(scene, texel.position, texel.geometric_normal, link.wi, link.distance);
      rays->occluded({&ray, 1}, 0, counters);
      if (!ray.blocked()) sum += f * cosine * Vec3d(link.irradiance);
    }
    return sum;
  }

 private:
  void build_scene(const RoomOptions& options) {
    scene.materials.emplace_back();
    const float s = options.size;
    add_quad(scene, {0, 0, 0}, {0, 0, s}, {s, 0, 0});  // floor; the sky is seen through the missing ceiling
    add_quad(scene, {0, 0, 0}, {s, 0, 0}, {0, s, 0});
    add_quad(scene, {0, 0, s}, {0, s, 0}, {s, 0, 0});
    add_quad(scene, {0, 0, 0}, {0, s, 0}, {0, 0, s});
    add_quad(scene, {s, 0, 0}, {0, 0, s}, {0, s, 0});
    add_quad(scene, {0.3f * s, 0.45f * s, 0.3f * s}, {0, 0, 0.3f * s}, {0.4f * s, 0, 0});  // a table
    update_bounds(scene);
    RandomStream random(8, 8, 8);
    for (uint32_t i = 0; i < options.lamps; ++i) {
      PunctualLight lamp;
      lamp.position = s * (Vec3(0.1f, 0.6f, 0.1f) +
                           Vec3(0.8f, 0.3f, 0.8f) * Vec3(random.next(), random.next(), random.next()));
      lamp.intensity = options.light * s * s * 0.2f * Vec3(random.next(), random.next(), random.next());
      scene.lights.push_back(lamp);
    }
    rays = std::make_unique<RayScene>(scene);
  }

  void build_lights(const RoomOptions& options) {
    std::vector<VirtualLight> lights = wall_lights(options.wall_lights, options.size, 1);
    const auto sky = sky_lights(options.sky_lights, options.sun, 2);
    lights.insert(lights.end(), sky.begin(), sky.end());
    for (VirtualLight& light : lights) light.radiance *= options.light;
    for (uint32_t i = 0; i < scene.lights.size(); ++i)
      lights.push_back(
          {scene.lights[i].position, 1, {0, -1, 0}, LightKind::punctual, scene.lights[i].intensity, i});
    tree = build_light_tree(std::move(lights));
    cut = illumination_cut(tree, options.cut);
  }

  static GBufferTexel texel(const RoomOptions& options, const Brdf& brdf, size_t index) {
    RandomStream random(index, 3, 4);
    GBufferTexel t;
    t.triangle = 0;
    const Vec2 u = random.next2();
    const bool wall = index % 3 == 2;
    const Vec3 n = wall ? Vec3(0, 0, 1) : Vec3(0, 1, 0);
    t.position = options.size * (wall ? Vec3(0.1f + 0.8f * u.x, 0.1f + 0.8f * u.y, 0)
                                      : Vec3(0.1f + 0.8f * u.x, 0, 0.1f + 0.8f * u.y));
    t.geometric_normal = n;
    t.shading_normal = index % 4 == 3 ? glm::normalize(n + Vec3(0.3f, 0, 0)) : n;
    t.tangent = basis_around(t.shading_normal).tangent;
    Vec3 wo;
    do wo = uniform_sphere(random.next2());
    while (glm::dot(wo, t.shading_normal) < 0.2f || glm::dot(wo, n) < 0.1f);
    t.wo = wo;
    t.brdf = brdf;
    return t;
  }
};

/// A spread of materials whose noise a test can afford.
inline std::vector<Brdf> mild_brdfs() {
  return {{BrdfModel::ggx, Vec3(0.6f, 0.5f, 0.4f), Vec3(0.04f), 1, Vec2(0.5f)},
          {BrdfModel::phong, Vec3(0.5f), Vec3(0.3f), 1, Vec2(10)},
          {BrdfModel::ggx, Vec3(0), Vec3(0.9f, 0.7f, 0.3f), 1, Vec2(0.4f)},
          {BrdfModel::ashikhmin_shirley, Vec3(0.3f), Vec3(0.4f), 1, Vec2(10, 20)},
          {BrdfModel::ggx, Vec3(0.8f), Vec3(0), 0, Vec2(1)},
          {BrdfModel::phong, Vec3(0), Vec3(0.8f), 1, Vec2(40)}};
}

/// Sharp and degenerate ones, for contracts that hold exactly.
inline std::vector<Brdf> hard_brdfs() {
  return {{BrdfModel::phong, Vec3(0), Vec3(1), 1, Vec2(1)},
          {BrdfModel::phong, Vec3(0), Vec3(1), 1, Vec2(1e4f)},
          {BrdfModel::phong, Vec3(0.2f), Vec3(0.5f), 1, Vec2(1e6f)},
          {BrdfModel::ggx, Vec3(0), Vec3(1), 1, Vec2(1e-4f)},
          {BrdfModel::ggx, Vec3(0.5f), Vec3(0.04f), 1, Vec2(1)},
          {BrdfModel::ashikhmin_shirley, Vec3(0.1f), Vec3(0.9f), 1, Vec2(10, 1e5f)},
          {BrdfModel::ggx, Vec3(0, 0, 0.5f), Vec3(0), 0, Vec2(1)}};
}

}  // namespace halflight
