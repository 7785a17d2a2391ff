// A scene with rays and hand-made pixels, for techniques that follow rays: no camera or OpenGL behind it.
#pragma once

#include <memory>

#include "support/simple_scenes.h"
#include "support/statistics.h"
#include "techniques/technique.h"

namespace halflight {

/// A pixel that sees `position` from direction `wo`.
inline GBufferTexel seen_point(Vec3 position, Vec3 normal, const Brdf& brdf, Vec3 wo) {
  GBufferTexel texel;
  texel.triangle = 0;
  texel.position = position;
  texel.geometric_normal = texel.shading_normal = normal;
  texel.tangent = basis_around(normal).tangent;
  texel.wo = glm::normalize(wo);
  texel.brdf = brdf;
  return texel;
}

inline Brdf diffuse_brdf(Vec3 reflectance) { return {BrdfModel::phong, reflectance, Vec3(0), 1, Vec2(1)}; }

/// Owns what a FrameView points to. Not movable: the rays share the scene's vertices.
struct TracedScene {
  Scene scene;
  std::unique_ptr<RayScene> rays;
  GBuffer gbuffer;
  std::vector<Vec3> base;
  SettingValues settings;
  FrameView frame;

  explicit TracedScene(Scene made, std::vector<GBufferTexel> pixels, const LightKinds& kinds)
      : scene(std::move(made)), rays(std::make_unique<RayScene>(scene)) {
    gbuffer.width = static_cast<int>(pixels.size()), gbuffer.height = 1;
    gbuffer.texels = std::move(pixels);
    base.assign(gbuffer.texels.size(), Vec3(0));
    frame.scene = &scene, frame.rays = rays.get(), frame.gbuffer = &gbuffer;
    frame.settings = &settings, frame.base = &base;
    frame.target = Target::continuous;
    frame.kinds = kinds;
  }
  TracedScene(const TracedScene&) = delete;
};

/// A technique by name with settings "key=value".
inline std::unique_ptr<Technique> make_technique(TracedScene& s, std::string_view id,
                                                 const std::vector<std::string>& set = {}) {
  for (const std::string& assignment : set) {
    const size_t equals = assignment.find('=');
    s.settings.set(assignment.substr(0, equals), assignment.substr(equals + 1));
  }
  auto technique = find_technique(id).make();
  technique->prepare(s.frame);
  return technique;
}

/// One pass of `samples`, alone in its film.
inline std::vector<Vec3> one_pass(TracedScene& s, Technique& technique, uint32_t pass, uint32_t samples) {
  Film film(s.gbuffer.width, s.gbuffer.height);
  PassRequest request;
  request.pass = pass, request.samples = samples, request.half = static_cast<int>(pass & 1);
  technique.run_pass(s.frame, request, film);
  EXPECT_EQ(film.nan_samples(), 0u);
  std::vector<Vec3> result;
  for (uint32_t i = 0; i < s.gbuffer.texels.size(); ++i) result.push_back(film.radiance(i));
  return result;
}

/// Mean of each pixel's channel over independent passes, its variance in one pass, and how sure that variance
/// is.
struct PassMoments {
  std::vector<double> mean, variance, variance_error;
  double passes = 0;

  double error(size_t pixel) const { return std::sqrt(variance[pixel] / passes); }
};

inline PassMoments pass_moments(TracedScene& s, Technique& technique, uint32_t samples, uint32_t passes,
                                int channel = 1, uint32_t first_pass = 0) {
  const size_t pixels = s.gbuffer.texels.size();
  std::vector<std::vector<double>> values(pixels);
  for (uint32_t pass = 0; pass < passes; ++pass) {
    const std::vector<Vec3> picture = one_pass(s, technique, first_pass + pass, samples);
    for (size_t i = 0; i < pixels; ++i) values[i].push_back(picture[i][channel]);
  }
  PassMoments m;
  m.passes = passes;
  for (const std::vector<double>& v : values) {
    double mean = 0, second = 0, fourth = 0;
    for (const double x : v) mean += x / passes;
    for (const double x : v) {
      const double d2 = (x - mean) * (x - mean);
      second += d2 / (passes - 1.0), fourth += d2 * d2 / passes;
    }
    m.mean.push_back(mean);
    m.variance.push_back(second);
    m.variance_error.push_back(std::sqrt(std::max(0.0, fourth - second * second) / passes));
  }
  return m;
}

}  // namespace halflight
