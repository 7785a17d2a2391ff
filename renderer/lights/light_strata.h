// Strata of all light that is drawn point by point: pieces of lit surfaces (a stratum a side), pieces of
// emitters, blocks of the environment, and each punctual light. They are fixed by geometry; a set holds one
// point uniform in each, and what a ray met leads back to its stratum (ESTIMATORS: "Continuous mode").
#pragma once

#include <functional>
#include <vector>

#include "lights/environment_cells.h"
#include "lights/light_points.h"
#include "lights/triangle_cells.h"

namespace halflight {

/// Kinds of light that strata are made for.
struct StrataKinds {
  bool environment = false, emitters = false, surfaces = false, punctual = false;
};

class LightStrata {
 public:
  static constexpr uint32_t none = TriangleCells::none;

  LightStrata() = default;
  /// About `count` strata for the environment, as many for surfaces, a quarter for emitters. Refers to the
  /// scene.
  LightStrata(const Scene&, const StrataKinds&, uint32_t count);

  uint32_t size() const { return end_; }
  size_t held_bytes() const {
    return environment_.held_bytes() + emitters_.held_bytes() + surfaces_.held_bytes();
  }
  uint32_t surface_count() const { return surfaces_.size(); }
  uint32_t emitters_begin() const { return emitters_begin_; }
  uint32_t surfaces_begin() const { return surfaces_begin_; }
  uint32_t punctual_begin() const { return surfaces_begin_ + 2 * surfaces_.size(); }

  /// Irradiance on both sides of each point of surfaces, front then back.
  using Irradiance = std::function<std::vector<Vec3>(const std::vector<BouncePoint>&)>;
  /// A set: member i lies in stratum i, radiance / density is an unbiased estimate of what the stratum sends.
  /// `measure` is 1 over the density of the point within its stratum, per area (at infinity, per solid
  /// angle).
  std::vector<VirtualLight> draw(uint64_t seed, const Irradiance&) const;

  /// The stratum of what a ray met, `none` where light samples never find it.
  uint32_t environment_stratum(glm::ivec2 texel) const;
  uint32_t emitter_stratum(SurfacePoint, bool front) const;
  uint32_t surface_stratum(SurfacePoint, bool front) const;
  /// `measure` of members there.
  float environment_measure(uint32_t stratum) const {
    return environment_.solid_angle(stratum - environment_begin_);
  }
  /// Mean radiance of an environment's stratum.
  Vec3 environment_mean(uint32_t stratum) const {
    return environment_.mean_radiance(stratum - environment_begin_) * scene_->environment.strength;
  }
  float emitter_measure(uint32_t triangle) const { return emitters_.measure(triangle); }
  float surface_measure(uint32_t triangle) const { return surfaces_.measure(triangle); }

 private:
  void draw_environment(uint64_t seed, std::vector<VirtualLight>&) const;
  void draw_emitters(uint64_t seed, std::vector<VirtualLight>&) const;
  void draw_surfaces(uint64_t seed, const Irradiance&, std::vector<VirtualLight>&) const;

  const Scene* scene_ = nullptr;
  EnvironmentCells environment_;
  TriangleCells emitters_, surfaces_;
  bool punctual_ = false;
  uint32_t environment_begin_ = 0, emitters_begin_ = 0, surfaces_begin_ = 0, end_ = 0;
};

}  // namespace halflight
