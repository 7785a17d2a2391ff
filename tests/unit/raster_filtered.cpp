// Filtered importance sampling (GPU Gems 3, chapter 20): its maps, harmonics and mip level against what they
// stand for, the GPU against the same sums on the CPU, and the error against the number of samples.
#include "raster/filtered_environment.h"

#include "unit/raster_scenes.h"

namespace halflight {
namespace {

using namespace test;

constexpr double pi_d = 3.141592653589793;

Environment constant_environment(Vec3 radiance, int height = 64) {
  ImageRgb map(2 * height, height);
  std::fill(map.pixels.begin(), map.pixels.end(), radiance);
  return make_environment(std::move(map), "constant", EnvironmentLayout::latlong);
}

/// Radiance as a function of the direction.
template <class Radiance>
Environment environment_of(int height, Radiance radiance) {
  Environment environment = constant_environment(Vec3(0), height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < 2 * height; ++x)
      environment.map.at(x, y) =
          radiance(environment_direction(environment, (Vec2(x, y) + 0.5f) / Vec2(2 * height, height)));
  return environment;
}

Vec3 sphere_point(uint32_t i, uint32_t n) {
  const Vec2 u = hammersley(i, n);
  const float z = 1 - 2 * (u.x + 0.5f / static_cast<float>(n)), r = std::sqrt(std::max(0.0f, 1 - z * z));
  return {r * std::cos(2 * pi * u.y), r * std::sin(2 * pi * u.y), z};
}

TEST(ParaboloidMaps, RoundTripAndReach) {
  for (uint32_t i = 0; i < 2000; ++i) {
    const Vec3 d = sphere_point(i, 2000);
    const ParaboloidPoint point = paraboloid_point(d);
    EXPECT_EQ(point.map, d.z < 0 ? 1 : 0);
    // Table 20-2: the hemisphere fills a circle of radius 1/2b, so that b = 1.2 leaves a rim around it.
    EXPECT_LE(glm::length(point.st - 0.5f), 0.5f / 1.2f + 1e-6f);
    EXPECT_LT(glm::length(paraboloid_direction(point) - d), 2e-6f);
  }
  // Beyond its circle a map goes on into the other hemisphere.
  EXPECT_LT(paraboloid_direction({{0.99f, 0.99f}, 0}).z, 0);
  EXPECT_GT(paraboloid_direction({{0.99f, 0.99f}, 1}).z, 0);
}

TEST(ParaboloidMaps, DistortionIsTheJacobian) {
  // By finite differences, and by the area of the sphere (eq. 14).
  for (uint32_t i = 0; i < 200; ++i) {
    const Vec3 d = sphere_point(i, 200);
    const ParaboloidPoint p = paraboloid_point(d);
    constexpr float h = 1e-3f;
    const auto at = [&](float s, float t) { return Vec3d(paraboloid_direction({p.st + Vec2(s, t), p.map})); };
    const Vec3d ds = (at(h, 0) - at(-h, 0)) / (2.0 * h), dt = (at(0, h) - at(0, -h)) / (2.0 * h);
    EXPECT_NEAR(paraboloid_distortion(d) / glm::length(glm::cross(ds, dt)), 1, 1e-3);
  }
  constexpr int size = 512;
  double sum = 0;
  for (int i = 0; i < 2 * size * size; ++i) {
    const Vec2 st((static_cast<float>(i % size) + 0.5f) / size,
                  (static_cast<float>(i / size % size) + 0.5f) / size);
    const int map = i / (size * size);
    const Vec3 d = paraboloid_direction({st, map});
    if ((d.z < 0) == (map == 1)) sum += paraboloid_distortion(d) / (static_cast<double>(size) * size);
  }
  EXPECT_NEAR(sum, 4 * pi_d, 1e-3 * 4 * pi_d);
}

TEST(ParaboloidMaps, KeepTheEnvironmentsLight) {
  // A sun smaller than a texel of the maps, high and low, in a map much finer than they are.
  for (const Vec3 towards : {Vec3(0.3f, 0.2f, 0.9f), Vec3(0.9f, -0.3f, -0.1f)}) {
    const Vec3 sun = glm::normalize(towards);
    const Environment environment = environment_of(256, [&](Vec3 d) {
      return Vec3(1 + d.y, 1, 1) + (glm::dot(d, sun) > 0.9999f ? Vec3(3e4f) : Vec3(0));
    });
    Vec3d whole(0), mapped(0);
    for (int y = 0; y < environment.map.height; ++y)
      for (int x = 0; x < environment.map.width; ++x)
        whole += static_cast<double>(texel_solid_angle(environment, y)) * Vec3d(environment.map.at(x, y));
    constexpr int size = 64;
    const ParaboloidMaps maps = make_paraboloid_maps(environment, size);
    for (int map = 0; map < 2; ++map) {
      for (int i = 0; i < size * size; ++i) {
        const Vec3 d =
            paraboloid_direction({(Vec2(i % size, i / size) + 0.5f) / static_cast<float>(size), map});
        if ((d.z < 0) != (map == 1)) continue;
        mapped += static_cast<double>(paraboloid_distortion(d)) / (size * size) * Vec3d(maps.texels[map][i]);
      }
    }
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(mapped[c] / whole[c], 1, 0.03);
  }
}

TEST(FilteredLevel, CoversWhatTheSampleStandsFor) {
  // Eqs. 11 to 13: a texel of level l covers 4^l texels of solid angle d/(w h); a sample stands for 1/(N p).
  for (const float pdf : {0.01f, 0.3f, 40.0f}) {
    for (const uint32_t n : {1u, 40u}) {
      for (const float z : {0.0f, 0.6f, -1.0f}) {
        const Vec3 u(std::sqrt(1 - z * z), 0, z);
        const double texel = paraboloid_distortion(u) / (256.0 * 256.0), stands_for = 1 / (n * double{pdf});
        const double level = filtered_level(256, n, pdf, paraboloid_distortion(u), 0);
        EXPECT_NEAR(std::pow(4, level) * texel / stands_for, 1, 1e-4);
        EXPECT_NEAR(filtered_level(256, n, pdf, paraboloid_distortion(u), 1), level + 1, 1e-5);
      }
    }
  }
  EXPECT_EQ(filtered_level(256, 40, 1e9f, 4, 0), 0);  // finer than the maps
}

TEST(SphericalHarmonics, LambertOfAConstantIsPi) {
  const auto kernel = zonal_convolution(lambert_kernel);
  // Ramamoorthi & Hanrahan 2001, eq. 8.
  EXPECT_NEAR(kernel[0], pi_d, 1e-5);
  EXPECT_NEAR(kernel[1], 2 * pi_d / 3, 1e-5);
  EXPECT_NEAR(kernel[2], pi_d / 4, 1e-5);
  const auto irradiance = convolve(project_radiance(constant_environment({1, 2, 3})), kernel);
  for (uint32_t i = 0; i < 50; ++i) {
    const auto basis = harmonics_at(sphere_point(i, 50));
    Vec3d e(0);
    for (size_t k = 0; k < basis.size(); ++k) e += irradiance[k] * static_cast<double>(basis[k]);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(e[c] / (c + 1), pi_d, 1e-3);
  }
}

TEST(SphericalHarmonics, ConvolutionOfASmoothSkyIsTheIntegral) {
  // Of degree 2 at most, so that nine coefficients hold all of it.
  const Environment environment = environment_of(128, [](Vec3 d) {
    return Vec3(2 + d.x - 0.5f * d.y, 1 + d.x * d.y + d.z * d.z, 3 + d.y * d.z - d.x * d.x + d.z);
  });
  for (auto* kernel : {lambert_kernel, ashikhmin_kernel}) {
    const auto harmonics = convolve(project_radiance(environment), zonal_convolution(kernel));
    for (uint32_t i = 0; i < 20; ++i) {
      const Vec3 n = sphere_point(i, 20);
      const auto basis = harmonics_at(n);
      Vec3d sum(0), integral(0);
      for (size_t k = 0; k < basis.size(); ++k) sum += harmonics[k] * static_cast<double>(basis[k]);
      constexpr uint32_t steps = 20000;
      for (uint32_t j = 0; j < steps; ++j) {
        const Vec3 d = sphere_point(j, steps);
        const double cosine = glm::dot(n, d);
        if (cosine <= 0) continue;
        integral += kernel(cosine) * 4 * pi_d / steps * Vec3d(environment_radiance(environment, d));
      }
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c] / integral[c], 1, 4e-3);
    }
  }
}

TEST(SphericalHarmonics, FresnelTakesItsMeanUnderUniformLight) {
  const auto means = schlick_means();
  for (const size_t i : {0u, 3u, 10u, 31u}) {
    const float mu = static_cast<float>(i) / 31;
    const Vec3 wo(std::sqrt(1 - mu * mu), 0, mu);
    // White diffuse GGX with F0 = 0 and a reflectance of 1 at grazing angles: its diffuse part alone.
    double sum = 0;
    constexpr uint32_t steps = 100000;
    for (uint32_t j = 0; j < steps; ++j) {
      const Vec3 wi = sphere_point(j, steps);
      if (wi.z <= 0) continue;
      const double cos_half = glm::dot(glm::normalize(wo + wi), wi);
      sum += std::pow(1 - cos_half, 5) * wi.z / pi_d * 4 * pi_d / steps;
    }
    EXPECT_NEAR(means[i], sum, 0.01 * sum + 1e-5) << "cosine " << mu;
  }
}

// ---- The pass on the GPU ----

struct MirrorMaps {
  std::array<std::vector<std::vector<Vec4>>, 2> levels;  ///< by map, by level
  int size;

  explicit MirrorMaps(const ParaboloidMaps& maps) : size(maps.size) {
    for (int map = 0; map < 2; ++map) {
      levels[map].push_back(maps.texels[map]);
      for (int s = size / 2; s >= 1; s /= 2) {
        const std::vector<Vec4>& fine = levels[map].back();
        std::vector<Vec4> coarse;
        for (int i = 0; i < s * s; ++i) {
          const int at = 2 * (i / s) * 2 * s + 2 * (i % s);
          coarse.push_back(0.25f * (fine[at] + fine[at + 1] + fine[at + 2 * s] + fine[at + 2 * s + 1]));
        }
        levels[map].push_back(std::move(coarse));
      }
    }
  }

  Vec3 bilinear(ParaboloidPoint p, int level) const {
    const int s = size >> level;
    const Vec2 at = p.st * static_cast<float>(s) - 0.5f, low = glm::floor(at), f = at - low;
    Vec4 sum(0);
    for (int tap = 0; tap < 4; ++tap) {
      const int x = std::clamp(static_cast<int>(low.x) + tap % 2, 0, s - 1);
      const int y = std::clamp(static_cast<int>(low.y) + tap / 2, 0, s - 1);
      sum += levels[p.map][level][y * s + x] * ((tap % 2 ? f.x : 1 - f.x) * (tap / 2 ? f.y : 1 - f.y));
    }
    return Vec3(sum);
  }

  Vec3 trilinear(ParaboloidPoint p, float level) const {
    const float l = std::clamp(level, 0.0f, static_cast<float>(levels[0].size() - 1));
    const int low = static_cast<int>(l), high = std::min(low + 1, static_cast<int>(levels[0].size() - 1));
    return glm::mix(bilinear(p, low), bilinear(p, high), l - static_cast<float>(low));
  }
};

/// The direction in the environment map's frame.
Vec3 map_direction(const Environment& environment, Vec3 d) {
  Environment unturned = environment;
  unturned.rotation = 0;
  return environment_direction(unturned, environment_uv(environment, d));
}

/// Specular samples of one pixel: calls `visit(direction, density, f cos / pdf)`.
template <class Visit>
void sample_specular_lobe(const GBufferTexel& texel, uint32_t n, Visit visit) {
  Brdf specular = texel.brdf;
  specular.diffuse = Vec3(0);
  const Basis basis = texel.basis();
  for (uint32_t i = 0; i < n; ++i) {
    const Vec2 xi = hammersley(i, n);
    // The first coordinate goes with the polar angle (eqs. 7 and 8).
    const Vec2 u = specular.model == BrdfModel::phong ? xi : Vec2(xi.y, xi.x);
    const auto wi = sample_specular(specular, basis, texel.wo, u);
    if (!wi) continue;
    const float density = specular_pdf(specular, basis, texel.wo, *wi);
    if (!(density > 0)) continue;
    const Vec3 f = evaluate(specular, basis, texel.wo, *wi);
    visit(*wi, density, f * (glm::dot(*wi, texel.shading_normal) / density));
  }
}

Vec3 mirror_specular(const GBufferTexel& texel, const Environment& environment, const MirrorMaps& maps,
                     const FilteredRequest& request) {
  Vec3d sum(0);
  sample_specular_lobe(texel, request.samples, [&](Vec3 wi, float density, Vec3 weight) {
    const Vec3 u = map_direction(environment, wi);
    const float level = request.filter ? filtered_level(maps.size, request.samples, density,
                                                        paraboloid_distortion(u), request.bias)
                                       : 0;
    sum += Vec3d(weight * maps.trilinear(paraboloid_point(u), level));
  });
  return Vec3(sum) * (environment.strength / static_cast<float>(request.samples));
}

/// Unshadowed light of what the diffuse lobe reflects, integrated over the environment.
Vec3 integrated_diffuse(const GBufferTexel& texel, const Environment& environment) {
  Vec3d sum(0);
  constexpr uint32_t steps = 4000;
  Brdf matte = texel.brdf, specular = texel.brdf;
  specular.diffuse = Vec3(0);
  for (uint32_t i = 0; i < steps; ++i) {
    const Vec3 d = sphere_point(i, steps);
    const float cosine = glm::dot(d, texel.shading_normal);
    if (cosine <= 0) continue;
    const Vec3 f =
        evaluate(matte, texel.basis(), texel.wo, d) - evaluate(specular, texel.basis(), texel.wo, d);
    sum += Vec3d(f * environment_radiance(environment, d) * (cosine * 4 * pi / steps));
  }
  return Vec3(sum);
}

Material specular_material(BrdfModel model, Vec2 shape) {
  Material m;
  m.model = model;
  m.base_color = Vec4(0.5f, 0.4f, 0.3f, 1);
  m.metallic = 0.5f, m.roughness = shape.x;
  m.diffuse = Vec3(0.3f, 0.2f, 0.1f), m.phong_specular = Vec3(0.5f, 0.6f, 0.7f);
  m.exponents = shape;
  return m;
}

class Filtered : public OnBackend {
 protected:
  static constexpr int width = 40, height = 30, map_size = 128;

  /// A row of spheres, one a material.
  static Scene spheres(const std::vector<Material>& materials) {
    Scene scene;
    scene.materials = materials;
    for (size_t i = 0; i < materials.size(); ++i)
      add_sphere(scene, Vec3(2.2f * static_cast<float>(i), 0, 0), 1, 24, static_cast<uint32_t>(i));
    update_bounds(scene);
    Camera camera;
    camera.position = Vec3(1.1f * static_cast<float>(materials.size() - 1), 0.8f, 5);
    camera.projection = Projection::orthographic;
    camera.half_height = 0.75f * (1.1f * static_cast<float>(materials.size()));
    scene.cameras = {camera};
    scene.environment = built_in_sky();
    return scene;
  }

  /// Draws the scene and makes the maps.
  std::unique_ptr<Rasterizer> draw(const Scene& scene) {
    auto raster = std::make_unique<Rasterizer>(*context, scene, RasterSettings{}, messages);
    gbuffer.resize(width, height);
    raster->draw_gbuffer(scene.cameras.front(), Vec2(0), 0, gbuffer);
    raster->prepare_filtered(map_size);
    return raster;
  }

  std::vector<Vec3> light(Rasterizer& raster, const FilteredRequest& request) {
    FilteredResult result = raster.filtered_light(gbuffer, request);
    EXPECT_TRUE(result.finished);
    EXPECT_GT(result.gpu_seconds, 0);
    EXPECT_LT(result.gpu_seconds, 60);
    return result.radiance;
  }

  GBuffer gbuffer;
};
HALFLIGHT_ON_BACKENDS(Filtered);

TEST_P(Filtered, SpecularIsTheSameSumOnTheCpu) {
  std::vector<Material> materials{specular_material(BrdfModel::phong, Vec2(30)),
                                  specular_material(BrdfModel::ashikhmin_shirley, Vec2(20, 100)),
                                  specular_material(BrdfModel::ggx, Vec2(0.5f))};
  for (Material& m : materials) m.diffuse = Vec3(0), m.base_color = Vec4(1), m.metallic = 1;
  Scene scene = spheres(materials);
  scene.environment.rotation = 0.9f, scene.environment.strength = 2.5f;
  const MirrorMaps maps(make_paraboloid_maps(scene.environment, map_size));
  const auto raster = draw(scene);
  for (const FilteredRequest& request :
       {FilteredRequest{40, true, 1.0f}, FilteredRequest{7, true, -0.5f}, FilteredRequest{16, false, 1.0f}}) {
    const std::vector<Vec3> lit = light(*raster, request);
    ASSERT_EQ(lit.size(), gbuffer.pixel_count());
    size_t hits = 0;
    for (size_t i = 0; i < lit.size(); ++i) {
      const GBufferTexel& texel = gbuffer.texels[i];
      if (!texel.hit()) {
        EXPECT_EQ(max_component(lit[i]), 0);
        continue;
      }
      ++hits;
      const Vec3 mirror = mirror_specular(texel, scene.environment, maps, request);
      // Drivers may weigh texels with 8 bits.
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(lit[i][c], mirror[c], 0.01f * mirror[c] + 1e-3f)
            << "pixel " << i << ", N " << request.samples;
    }
    EXPECT_GT(hits, 300u);
  }
}

TEST_P(Filtered, SubsetsAndDiffuseLight) {
  std::vector<Material> materials{specular_material(BrdfModel::phong, Vec2(30)),
                                  specular_material(BrdfModel::ashikhmin_shirley, Vec2(20, 100)),
                                  specular_material(BrdfModel::ggx, Vec2(0.5f))};
  Scene scene = spheres(materials);
  scene.environment =
      environment_of(64, [](Vec3 d) { return Vec3(2 + d.x - 0.5f * d.y, 2 + d.y, 3 + d.y * d.z - d.x); });
  scene.environment.rotation = 2.0f, scene.environment.strength = 0.5f;
  const MirrorMaps maps(make_paraboloid_maps(scene.environment, map_size));
  const auto raster = draw(scene);
  FilteredRequest request{24, true, 1.0f};
  const std::vector<Vec3> whole = light(*raster, request);
  for (size_t i = 0; i < whole.size(); i += 3) {
    const GBufferTexel& texel = gbuffer.texels[i];
    if (!texel.hit()) continue;
    const Vec3 mirror = mirror_specular(texel, scene.environment, maps, request) +
                        integrated_diffuse(texel, scene.environment);
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(whole[i][c] / mirror[c], 1, 0.03) << "pixel " << i;
  }
  for (const uint32_t stride : {2u, 4u}) {
    request.stride = stride;
    request.offset = stride + 1;
    const std::vector<Vec3> subset = light(*raster, request);
    const int columns = (width - 1 + static_cast<int>(stride) - 1) / static_cast<int>(stride);
    ASSERT_GT(subset.size(), 0u);
    for (size_t i = 0; i < subset.size(); ++i) {
      const size_t x = 1 + stride * (i % columns), y = 1 + stride * (i / columns);
      EXPECT_EQ(subset[i], whole[y * width + x]);
    }
  }
}

TEST_P(Filtered, ErrorFallsWithSamplesAndWithTheFilter) {
  Material phong = specular_material(BrdfModel::phong, Vec2(100));
  phong.diffuse = Vec3(0);  // harmonics have an error of their own
  Scene scene = spheres({phong});
  // Small windows in a dim room: what single samples hit or miss.
  scene.environment = environment_of(128, [](Vec3 d) {
    const float around = std::atan2(d.x, d.z) * 7 / pi, up = d.y * 4;
    const bool window = around - std::floor(around) < 0.1f && up - std::floor(up) < 0.15f;
    return window ? Vec3(200, 150, 100) : Vec3(0.3f, 0.3f, 0.4f);
  });
  const auto raster = draw(scene);
  std::vector<Vec3d> truth;
  // relMSE of the whole picture.
  const auto error = [&](uint32_t samples, bool filter) {
    const std::vector<Vec3> lit = light(*raster, {samples, filter, 1.0f});
    if (truth.empty()) {
      constexpr uint32_t many = 1 << 14;
      truth.resize(lit.size(), Vec3d(0));
      parallel_for(0, truth.size(), 4, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i)
          if (gbuffer.texels[i].hit())
            sample_specular_lobe(gbuffer.texels[i], many, [&](Vec3 wi, float, Vec3 weight) {
              truth[i] += Vec3d(weight * environment_radiance(scene.environment, wi)) * (1.0 / many);
            });
      });
    }
    double squares = 0, mean = 0;
    for (const Vec3d& value : truth)
      mean += (value.x + value.y + value.z) / (3.0 * static_cast<double>(truth.size()));
    for (size_t i = 0; i < lit.size(); ++i)
      for (int c = 0; c < 3; ++c)
        squares +=
            std::pow(lit[i][c] - truth[i][c], 2) / (std::pow(truth[i][c], 2) + std::pow(0.01 * mean, 2));
    return squares / (3.0 * static_cast<double>(lit.size()));
  };
  const double at_10 = error(10, true), at_40 = error(40, true), at_160 = error(160, true);
  const double unfiltered = error(40, false);
  RecordProperty("errors", fmt::format("{} {} {} off {}", at_10, at_40, at_160, unfiltered));
  EXPECT_LT(at_40, 0.5 * at_10);
  EXPECT_LT(at_160, 0.5 * at_40);
  EXPECT_LT(at_40, 0.7 * unfiltered);
}

}  // namespace
}  // namespace halflight
