// The rasteriser against the rays on the built-in scenes: the same G-buffer, and the same punctual light but
// for the shadows' edges, which maps blur by a texel.
#include "lights/light_points.h"
#include "scene/load.h"
#include "trace/ray_gbuffer.h"
#include "unit/raster_scenes.h"

namespace halflight {
namespace {

using namespace test;

class RasterAndRays : public OnBackend {
 protected:
  static constexpr int width = 160, height = 120;

  /// The named built-in scene with a camera, and a point light and a wide spot inside it.
  static Scene make_scene(std::string_view name) {
    Scene scene;
    for (const BuiltInScene& built_in : built_in_scenes())
      if (built_in.name == name) scene = built_in.make();
    if (scene.triangles.empty()) return scene;
    Messages quiet;
    complete_camera(scene, quiet);
    const float size = scene.bounds.diagonal();
    PunctualLight lamp;
    lamp.position = scene.bounds.centre() + 0.1f * scene.bounds.extent() * Vec3(1, 2, -1);
    lamp.intensity = Vec3(size * size);
    PunctualLight spot = lamp;
    spot.kind = PunctualKind::spot;
    spot.position = scene.bounds.centre() + 0.3f * scene.bounds.extent() * Vec3(-1, 1, 1);
    spot.direction = glm::normalize(scene.bounds.centre() - spot.position);
    spot.up = basis_along(spot.direction, {0, 1, 0}).tangent;
    spot.outer_cone = 0.7f;
    scene.lights.insert(scene.lights.end(), {lamp, spot});
    return scene;
  }

  void compare_gbuffers(const Scene& scene, const GBuffer& raster, const GBuffer& rays) {
    const float size = scene.bounds.diagonal();
    size_t same = 0, close = 0;
    for (size_t i = 0; i < raster.pixel_count(); ++i) {
      const GBufferTexel &a = raster.texels[i], &b = rays.texels[i];
      if (a.triangle != b.triangle) continue;
      ++same;
      const auto near = [](Vec3 u, Vec3 v, float tolerance) {
        return max_component(glm::abs(u - v)) <= tolerance;
      };
      close += near(a.position, b.position, 1e-4f * size) &&
               near(a.geometric_normal, b.geometric_normal, 1e-4f) &&
               near(a.shading_normal, b.shading_normal, 2e-3f) && near(a.wo, b.wo, 1e-5f) &&
               near(a.brdf.diffuse, b.brdf.diffuse, 2e-3f) && near(a.brdf.specular, b.brdf.specular, 2e-3f) &&
               near(Vec3(a.brdf.roughness, a.brdf.f90), Vec3(b.brdf.roughness, b.brdf.f90), 2e-3f) &&
               near(a.emission, b.emission, 2e-3f * std::max(1.0f, max_component(b.emission)));
    }
    EXPECT_GE(static_cast<double>(same), 0.995 * static_cast<double>(raster.pixel_count()));
    EXPECT_GE(static_cast<double>(close), 0.999 * static_cast<double>(same));
  }

  /// Sums within 1 %, and `share` of the single values within 2 %.
  void compare_light(const std::vector<Vec3>& raster, const std::vector<Vec3>& rays, double share) {
    ASSERT_EQ(raster.size(), rays.size());
    Vec3d raster_sum(0), rays_sum(0);
    size_t lit = 0, close = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
      raster_sum += Vec3d(raster[i]), rays_sum += Vec3d(rays[i]);
      const float greatest = std::max(max_component(raster[i]), max_component(rays[i]));
      if (!(greatest > 0)) continue;
      ++lit;
      close += max_component(glm::abs(raster[i] - rays[i])) <= 0.02f * greatest;
    }
    EXPECT_GT(lit, rays.size() / 10);
    EXPECT_GE(static_cast<double>(close), share * static_cast<double>(lit));
    EXPECT_NEAR(glm::length(raster_sum) / glm::length(rays_sum), 1, 0.01);
  }

  void compare(std::string_view name) {
    Scene scene = make_scene(name);
    ASSERT_FALSE(scene.triangles.empty());
    const RayScene ray_scene(scene);
    RayCounters counters;
    Rasterizer raster(*context, scene, {}, messages);
    GBuffer by_raster, by_rays;
    by_raster.resize(width, height);
    by_rays.resize(width, height);
    const Camera& camera = scene.cameras.front();
    raster.draw_gbuffer(camera, Vec2(0.2f, -0.4f), 5, by_raster);
    trace_gbuffer(ray_scene, camera, Vec2(0.2f, -0.4f), 5, by_rays, counters);
    compare_gbuffers(scene, by_raster, by_rays);

    std::vector<Vec3> direct(by_raster.pixel_count(), Vec3(0)), traced = direct;
    raster.add_punctual(by_raster, direct);
    add_punctual_by_rays(ray_scene, by_raster, 0, traced, counters);
    compare_light(direct, traced, 0.95);

    LightPointSettings settings;
    settings.count = 4096;
    settings.repulsion_steps = 0;
    const std::vector<BouncePoint> points = spread_surface_points(scene, settings);
    ASSERT_EQ(points.size(), settings.count);
    const PointLighting punctual_only{true, false, false, 1, 0};
    // Many points lie in folds and between things, within a texel of a shadow's edge.
    compare_light(raster.light_points(points), irradiance_by_rays(ray_scene, points, punctual_only, counters),
                  0.85);
    EXPECT_EQ(counters.rejected, 0u);
  }
};
HALFLIGHT_ON_BACKENDS(RasterAndRays);

TEST_P(RasterAndRays, AgreeOnTheCornellBox) { compare("cornell"); }
TEST_P(RasterAndRays, AgreeOnTheBedroom) { compare("bedroom"); }

}  // namespace
}  // namespace halflight
