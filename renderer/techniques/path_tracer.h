// One camera path: light that the camera sees, direct light, and light by way of further surfaces.
#pragma once

#include "scene/camera.h"
#include "techniques/path_lights.h"
#include "techniques/technique.h"

namespace halflight {

/// What a surface that is not seen by the camera itself returns.
enum class PathModel {
  lambert,  ///< bounce_albedo/π in all directions, about the geometric normal
  whole     ///< its whole BRDF, as the camera would see it
};

struct PathSettings {
  int bounces = 1;  ///< surfaces at most between the one that is seen and a light
  PathModel model = PathModel::lambert;
  LightSelection light = LightSelection::all;

  /// Whether light that comes by way of `bounces` more surfaces is in the picture.
  bool wants(int through) const {
    return through == 0 ? light != LightSelection::indirect : light != LightSelection::direct;
  }
  bool shows_emission() const { return light != LightSelection::indirect; }
  /// Surfaces a path goes by way of: none where only direct light is asked for.
  int last() const { return light == LightSelection::direct ? 0 : bounces; }
};

/// The scene's lights; made once for a scene and its lights, read by all threads.
struct PathLights {
  PathEnvironment environment;
  PathEmitters emitters;
  PathPunctuals punctual;

  explicit PathLights(const Scene& scene)
      : environment(scene.environment), emitters(scene), punctual(scene) {}
};

/// One thread's tracer.
class PathTracer {
 public:
  PathTracer(const RayScene& rays, const PathLights& lights, const PathSettings& settings,
             const std::function<void(std::span<const ShadowRay>)>& watch_rays);

  /// Radiance that comes to the camera along a ray; its mean over random numbers is the picture. Masks and
  /// blends hide as `alpha_seed` says all along the path.
  Vec3d trace(const CameraRay&, uint32_t alpha_seed, RandomStream&);

  const RayCounters& counters() const { return counters_; }
  uint64_t useful_rays() const { return useful_rays_; }
  uint64_t brdf_rays() const { return brdf_rays_; }

 private:
  /// A surface point that reflects light back along a path.
  struct Vertex {
    Vec3 position, geometric_normal, wo;  ///< the normal is on the side of wo
    Basis basis;                          ///< about the shading normal
    Brdf brdf;
  };

  /// A direction drawn at a vertex: f cos θ / p, and what the ray along it met.
  struct Continuation {
    Vec3 wi;
    double pdf;
    Vec3d reflected;
    std::optional<RayHit> hit;
  };

  static Vertex vertex_seen(const GBufferTexel&);
  Vertex vertex_met(const RayHit&, Vec3 wo) const;
  Vec3d sample_lights(const Vertex&, RandomStream&);
  void add_light(const Vertex&, const PathLightSample&);
  void add_punctual(const Vertex&, const PathPunctual&);
  void add_ray(const Vertex&, Vec3 wi, float distance, Vec3d value);
  std::optional<Continuation> draw(const Vertex&, RandomStream&);
  Vec3d light_met(const Vertex&, const Continuation&) const;

  const RayScene& rays_;
  const Scene& scene_;
  const PathLights& lights_;
  PathSettings settings_;
  const std::function<void(std::span<const ShadowRay>)>& watch_rays_;
  uint32_t alpha_seed_ = 0;

  std::vector<PathPunctual> punctual_;
  std::vector<ShadowRay> shadow_rays_;
  std::vector<Vec3d> values_;  ///< one a shadow ray: what arrives if nothing is in its way
  RayCounters counters_;
  uint64_t useful_rays_ = 0, brdf_rays_ = 0;
};

}  // namespace halflight
