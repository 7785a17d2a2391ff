#include "lights/light_strata.h"

#include "core/parallel.h"
#include "core/random.h"
#include "lights/emitters.h"
#include "lights/surface_strata.h"

namespace halflight {

namespace {

constexpr size_t grain = 1024;

std::vector<double> areas_of(const Scene& scene, std::span<const uint32_t> triangles) {
  std::vector<double> areas;
  for (const uint32_t t : triangles)
    areas.push_back(0.5 * static_cast<double>(glm::length(triangle_cross(scene, t))));
  return areas;
}

VirtualLight light_of_side(const Scene& scene, SurfacePoint point, bool front) {
  VirtualLight light;
  light.position = surface_position(scene, point);
  light.normal = glm::normalize(triangle_cross(scene, point.triangle)) * (front ? 1.0f : -1.0f);
  light.source = point.triangle;
  return light;
}

}  // namespace

LightStrata::LightStrata(const Scene& scene, const StrataKinds& kinds, uint32_t count)
    : scene_(&scene), punctual_(kinds.punctual) {
  if (kinds.environment) environment_ = EnvironmentCells(scene.environment, count);
  if (kinds.emitters) {
    std::vector<uint32_t> triangles;
    std::vector<double> powers;
    for (const EmissiveTriangle& emitter : emissive_triangles(scene)) {
      triangles.push_back(emitter.triangle);
      powers.push_back(emitter.power);
    }
    emitters_ = TriangleCells(scene, triangles, powers, std::max(1u, count / 4));
  }
  if (kinds.surfaces) {
    const std::vector<uint32_t> triangles = reflecting_triangles(scene);
    surfaces_ = TriangleCells(scene, triangles, areas_of(scene, triangles), count);
  }
  emitters_begin_ = environment_begin_ + environment_.size();
  surfaces_begin_ = emitters_begin_ + 2 * emitters_.size();
  end_ = surfaces_begin_ + 2 * surfaces_.size();
  if (punctual_) end_ += static_cast<uint32_t>(scene.lights.size());
}

void LightStrata::draw_environment(uint64_t seed, std::vector<VirtualLight>& lights) const {
  const Environment& environment = scene_->environment;
  parallel_for(0, environment_.size(), grain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const auto cell = static_cast<uint32_t>(i);
      VirtualLight& light = lights[environment_begin_ + i];
      light.kind = LightKind::environment;
      light.position = environment_.draw(environment, cell, RandomStream(i, 0, seed).next2());
      light.normal = -light.position;
      light.measure = environment_.solid_angle(cell);
      light.radiance = environment_radiance(environment, light.position);
      light.source = cell;
    }
  });
}

void LightStrata::draw_emitters(uint64_t seed, std::vector<VirtualLight>& lights) const {
  parallel_for(0, emitters_.size(), grain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      RandomStream random(i, 1, seed);
      const float choose = random.next();
      const SurfacePoint point = emitters_.draw(static_cast<uint32_t>(i), choose, random.next2());
      for (const int side : {0, 1}) {
        VirtualLight light = light_of_side(*scene_, point, side == 0);
        light.kind = LightKind::emitter;
        light.measure = emitters_.measure(point.triangle);
        light.radiance = covered_emission(*scene_, point, side == 0 ? 1 : -1);
        lights[emitters_begin_ + 2 * i + static_cast<size_t>(side)] = light;
      }
    }
  });
}

void LightStrata::draw_surfaces(uint64_t seed, const Irradiance& irradiance,
                                std::vector<VirtualLight>& lights) const {
  if (surfaces_.size() == 0) return;
  std::vector<BouncePoint> points(surfaces_.size());
  parallel_for(0, points.size(), grain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      RandomStream random(i, 2, seed);
      const float choose = random.next();
      BouncePoint& point = points[i];
      point.surface = surfaces_.draw(static_cast<uint32_t>(i), choose, random.next2());
      const VirtualLight front = light_of_side(*scene_, point.surface, true);
      point.position = front.position, point.normal = front.normal;
      point.area = surfaces_.measure(point.surface.triangle);
      point.albedo = covered_albedo(*scene_, point.surface);
    }
  });
  const std::vector<VirtualLight> returned = bounce_lights(points, irradiance(points));
  std::copy(returned.begin(), returned.end(), lights.begin() + surfaces_begin_);
}

std::vector<VirtualLight> LightStrata::draw(uint64_t seed, const Irradiance& irradiance) const {
  std::vector<VirtualLight> lights(end_);
  draw_environment(seed, lights);
  draw_emitters(seed, lights);
  draw_surfaces(seed, irradiance, lights);
  if (punctual_) {
    const std::vector<VirtualLight> punctual = punctual_points(*scene_);
    std::copy(punctual.begin(), punctual.end(), lights.end() - static_cast<ptrdiff_t>(punctual.size()));
  }
  return lights;
}

uint32_t LightStrata::environment_stratum(glm::ivec2 texel) const {
  return environment_.size() == 0 ? none : environment_begin_ + environment_.cell_of(texel);
}

uint32_t LightStrata::emitter_stratum(SurfacePoint point, bool front) const {
  const uint32_t cell = emitters_.cell_of(point);
  return cell == none ? none : emitters_begin_ + 2 * cell + (front ? 0 : 1);
}

uint32_t LightStrata::surface_stratum(SurfacePoint point, bool front) const {
  const uint32_t cell = surfaces_.cell_of(point);
  return cell == none ? none : surfaces_begin_ + 2 * cell + (front ? 0 : 1);
}

}  // namespace halflight
