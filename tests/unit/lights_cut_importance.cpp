#include <gtest/gtest.h>

#include "core/simd.h"
#include "core/warp.h"
#include "lights/cut_importance.h"
#include "support/random_lights.h"

namespace halflight {
namespace {

/// Arrays for one point's importances.
struct Buffers {
  std::vector<float> importance, guard, arriving;

  explicit Buffers(const Cut& cut)
      : importance(cut.padded_size()), guard(cut.padded_size()), arriving(cut.padded_size()) {}
  ClusterImportance spans() { return {importance, guard, arriving}; }
};

GBufferTexel texel_of(Brdf brdf, Vec3 position, Vec3 normal, Vec3 wo) {
  GBufferTexel texel;
  texel.position = position, texel.triangle = 0;
  texel.geometric_normal = texel.shading_normal = normal;
  texel.tangent = basis_around(normal).tangent;
  texel.wo = glm::normalize(wo);
  texel.brdf = brdf;
  return texel;
}

Brdf phong(float diffuse, float specular, float n) {
  return {BrdfModel::phong, Vec3(diffuse), Vec3(specular), 1, Vec2(n)};
}
Brdf ggx(float diffuse, float f0, Vec2 alpha) { return {BrdfModel::ggx, Vec3(diffuse), Vec3(f0), 1, alpha}; }

/// A cut with every lit leaf its own cluster.
Cut leaf_cut(const LightTree& tree) {
  CutSettings settings;
  settings.least = settings.most = 1u << 20;
  return illumination_cut(tree, settings);
}

TEST(SimdMath, ExponentialOfNegativeNumbers) {
  for (float x = 0; x > -86; x -= 0.0137f)
    ASSERT_NEAR(exp_negative(x) / std::exp(static_cast<double>(x)), 1, 1e-6);
  EXPECT_EQ(exp_negative(-1e30f), 0);
  EXPECT_EQ(exp_negative(-infinity), 0);
}

// For single lights nothing is filtered: importance is light × BRDF × cosine × solid angle itself.
TEST(CutImportance, OfSingleLightsIsTheirContribution) {
  const LightTree tree = build_light_tree(mixed_lights(500, 10, 1));
  const Cut cut = leaf_cut(tree);
  const struct {
    Brdf brdf;
    double tolerance;
  } cases[] = {{{BrdfModel::ggx, Vec3(0.5f), Vec3(0), 0, Vec2(1)}, 1e-4},
               {phong(0.3f, 0.4f, 20), 0.03},
               {phong(0.0f, 1.0f, 1000), 5e-3},
               {ggx(0, 0.9f, Vec2(0.3f)), 0.6}};  // without masking, and with the visible normals' density
  Buffers buffers(cut);
  for (const auto& [brdf, tolerance] : cases) {
    const GBufferTexel texel = texel_of(brdf, {3, 2, 4}, {0, 1, 0}, {0.3f, 1, 0.2f});
    analytic_importance(cut, texel, 0, buffers.spans());
    double sum = 0, difference = 0;
    for (uint32_t k = 0; k < cut.size; ++k) {
      const VirtualLight& light = tree.lights[cut.begin[k]];
      const Vec3 to = light.kind == LightKind::environment ? light.position : light.position - texel.position;
      const float r2 = glm::dot(to, to);
      const Vec3 wi = to / std::sqrt(r2);
      const float solid_angle =
          light.kind == LightKind::surface
              ? patch_solid_angle(light.measure, -glm::dot(light.normal, wi), r2, GeometryTerm::bounded)
          : light.kind == LightKind::punctual ? 1 / r2
                                              : light.measure;
      const double expected = luminance(light.radiance * evaluate(brdf, texel.basis(), texel.wo, wi)) *
                              std::max(0.0f, glm::dot(wi, texel.shading_normal)) * solid_angle /
                              cut.power_unit;
      sum += expected, difference += std::abs(buffers.importance[k] - expected);
    }
    EXPECT_LT(difference, tolerance * sum) << brdf.roughness.x << " " << static_cast<int>(brdf.model);
  }
}

// One distant cluster of many lights: its filtered lobe against the mean of f cos θ over its members.
TEST(CutImportance, FilteredLobesAreNearTheMeanOverTheCluster) {
  for (const float extent : {0.02f, 0.1f, 0.3f}) {
    for (const float away : {0.0f, 0.2f}) {
      std::vector<VirtualLight> lights;
      const Vec3 towards = glm::normalize(Vec3(-0.4f + away, 1, 0));
      const Basis around = basis_around(towards);
      RandomStream random(1, 1, 1);
      for (uint32_t i = 0; i < 4000; ++i) {
        const Vec2 d = extent * concentric_disk(random.next2());
        const Vec3 p = glm::normalize(around.to_world({d.x, d.y, 1}));
        lights.push_back({p, 1e-4f, -p, LightKind::environment, Vec3(1), i});
      }
      const LightTree tree = build_light_tree(lights);
      CutSettings one;
      one.least = one.most = 1;
      const Cut cut = illumination_cut(tree, one);
      Buffers buffers(cut);
      for (const Brdf& brdf : {phong(0, 1, 30), phong(0, 1, 1000), phong(0, 1, 100000), ggx(0, 1, Vec2(0.4f)),
                               ggx(0, 1, Vec2(0.05f)), ggx(0, 1, Vec2(0.02f, 0.3f)),
                               Brdf{BrdfModel::ashikhmin_shirley, Vec3(0), Vec3(1), 1, Vec2(100, 1000)}}) {
        const GBufferTexel texel = texel_of(brdf, Vec3(0), {0, 1, 0}, {0.4f, 1, 0});
        double mean = 0;
        for (const auto& light : lights)
          mean += luminance(evaluate(brdf, texel.basis(), texel.wo, light.position)) * light.position.y /
                  lights.size();
        analytic_importance(cut, texel, 0, buffers.spans());
        const double filtered = buffers.importance[0] / cut.power[0];
        // A prior: within a factor where the lobe meets the cluster, and never far below the truth.
        EXPECT_GT(filtered, mean / 6) << extent << " " << away << " " << brdf.roughness.x;
        if (away == 0) {
          EXPECT_LT(filtered, mean * 4) << extent << " " << brdf.roughness.x;
        }
      }
    }
  }
}

// One distant cluster seen by a diffuse point, from overhead to half below the horizon and nearly all.
TEST(CutImportance, CosineIsTheMeanOverTheCluster) {
  const float extent = 0.3f;
  for (const float height : {1.5f, 1.0f, 0.4f, 0.15f, 0.0f, -0.15f}) {
    std::vector<VirtualLight> lights;
    const Basis around = basis_around({std::cos(height), std::sin(height), 0});
    RandomStream random(1, 1, 1);
    for (uint32_t i = 0; i < 4000; ++i) {
      const Vec2 d = extent * concentric_disk(random.next2());
      const Vec3 p = glm::normalize(around.to_world({d.x, d.y, 1}));
      lights.push_back({p, 1e-4f, -p, LightKind::environment, Vec3(1), i});
    }
    CutSettings one;
    one.least = one.most = 1;
    const Cut cut = illumination_cut(build_light_tree(lights), one);
    Buffers buffers(cut);
    analytic_importance(cut, texel_of(ggx(1, 0, Vec2(1)), Vec3(0), {0, 1, 0}, {0, 1, 0}), 0, buffers.spans());
    double mean = 0;
    for (const auto& light : lights) mean += std::max(0.0f, light.position.y) / lights.size();
    const double cosine = buffers.importance[0] / cut.power[0] * pi;
    EXPECT_GT(cosine, 0.9 * mean) << height;
    EXPECT_LT(cosine, (height > extent ? 1.05 : 1.6) * mean) << height;
  }
}

TEST(CutImportance, GuardFollowsPowerAndDistance) {
  const LightTree tree = build_light_tree(mixed_lights(2000, 10, 2));
  const Cut cut = illumination_cut(tree, {});
  std::vector<float> guard(cut.padded_size());
  const Vec3 x(1, 2, 3);
  guard_importance(cut, x, guard);
  for (uint32_t k = 0; k < cut.size; ++k) {
    const Vec3 to = Vec3(cut.centre_x[k], cut.centre_y[k], cut.centre_z[k]) - x;
    const double expected = cut.kind[k] == LightKind::environment
                                ? cut.power[k]
                                : cut.power[k] / (glm::dot(to, to) + cut.radius[k] * cut.radius[k]);
    ASSERT_NEAR(guard[k], expected, 1e-4 * expected);
  }
}

/// With `faces_count`, of clusters that are found to face x: what those of mixed normals send is bounded by
/// their boxes, which turned ones fill badly.
void expect_no_false_zero(const std::vector<VirtualLight>& lights, bool faces_count) {
  const LightTree tree = build_light_tree(lights);
  CutSettings coarse;
  coarse.least = coarse.most = 12;
  const Cut cut = illumination_cut(tree, coarse);
  Buffers buffers(cut);
  RandomStream random(1, 2, 3);
  for (int point = 0; point < 200; ++point) {
    const Vec3 x = 10.0f * Vec3(random.next(), random.next(), random.next());
    const Vec3 n = uniform_sphere(random.next2());
    for (const Brdf& brdf : {phong(0.5f, 0.2f, 50), ggx(0.5f, 0.04f, Vec2(0.1f))}) {
      analytic_importance(cut, texel_of(brdf, x, n, n), 0, buffers.spans());
      for (uint32_t k = 0; k < cut.size; ++k) {
        ASSERT_TRUE(std::isfinite(buffers.importance[k]) && buffers.importance[k] >= 0);
        bool matters = false;
        for (uint32_t i = cut.begin[k]; i < cut.end[k]; ++i) {
          const VirtualLight& light = tree.lights[i];
          const Vec3 to = light.kind == LightKind::environment ? light.position : light.position - x;
          matters |= leaf_power(light) > 0 && glm::dot(to, n) > 0 &&
                     (light.kind != LightKind::surface || glm::dot(light.normal, to) < 0);
        }
        if (matters && (!faces_count || buffers.arriving[k] > 0)) {
          ASSERT_GT(buffers.importance[k], 0);
        }
      }
    }
  }
}

// Wherever a member of a cluster reaches x above the horizon, the cluster's importance is above 0.
TEST(CutImportance, NeverVanishesFalsely) {
  expect_no_false_zero(mixed_lights(3000, 10, 3), false);
  expect_no_false_zero(turned(mixed_lights(3000, 10, 3)), true);
}

// Lights of a point's own plane give it nothing, whichever way the plane is turned.
TEST(CutImportance, OfThePointsOwnPlaneIsNearNothing) {
  std::vector<VirtualLight> lights;
  RandomStream random(2, 2, 2);
  for (uint32_t i = 0; i < 4000; ++i)
    lights.push_back({{random.next(), 0, random.next()}, 1e-3f, {0, 1, 0}, LightKind::surface, Vec3(1), i});
  for (const std::vector<VirtualLight>& its_lights : {lights, turned(lights)}) {
    const Cut cut = illumination_cut(build_light_tree(its_lights), {});
    const VirtualLight& own = its_lights[2000];
    Buffers buffers(cut);
    const auto sum_from = [&](Vec3 x, Vec3 normal, const PointSpread& spread) {
      analytic_importance(cut, texel_of(ggx(1, 0, Vec2(1)), x, normal, normal), 0, buffers.spans(), spread);
      double sum = 0;
      for (uint32_t k = 0; k < cut.size; ++k) sum += buffers.importance[k];
      return sum;
    };
    PointSpread neighbours;
    neighbours.extent = Vec3(0.01f);
    for (const PointSpread& spread : {PointSpread(), neighbours})
      EXPECT_LT(sum_from(own.position, own.normal, spread),
                1e-2 * sum_from(own.position + 0.1f * own.normal, -own.normal, spread));
  }
}

TEST(CutImportance, IsFiniteInExtremePlaces) {
  const LightTree tree = build_light_tree(mixed_lights(300, 10, 4));
  const Cut cut = leaf_cut(tree);
  Buffers buffers(cut);
  for (const Vec3 x :
       {tree.lights[400].position, Vec3(1e6f), Vec3(0), tree.lights[400].position + Vec3(1e-7f)}) {
    for (const Brdf& brdf :
         {phong(0.5f, 0.5f, 1), phong(0, 1, 1e6f), ggx(0.5f, 0.04f, Vec2(1e-4f)), ggx(0, 1, Vec2(1)),
          Brdf{BrdfModel::ashikhmin_shirley, Vec3(0), Vec3(1), 1, Vec2(10, 1e5f)}}) {
      for (const Vec3 wo : {Vec3(0, 1, 0), Vec3(1, 1e-3f, 0)}) {
        analytic_importance(cut, texel_of(brdf, x, {0, 1, 0}, wo), 0.8f, buffers.spans());
        for (uint32_t k = 0; k < cut.size; ++k)
          ASSERT_TRUE(std::isfinite(buffers.importance[k]) && buffers.importance[k] >= 0 &&
                      buffers.guard[k] > 0);
      }
    }
  }
}

TEST(CutImportance, OfIlluminationIsTheSameInAnyUnit) {
  const auto lights = mixed_lights(1000, 10, 5);
  const Cut cut = illumination_cut(build_light_tree(lights), {});
  std::vector<float> shares(cut.padded_size());
  illumination_importance(cut, shares);
  auto scaled = lights;
  for (auto& light : scaled) {
    if (light.kind != LightKind::environment) light.position *= 1024.0f;
    if (light.kind == LightKind::surface) light.measure *= 1024.0f * 1024.0f;
    if (light.kind == LightKind::punctual) light.radiance *= 1024.0f * 1024.0f;
  }
  const Cut other = illumination_cut(build_light_tree(scaled), {});
  std::vector<float> other_shares(other.padded_size());
  illumination_importance(other, other_shares);
  ASSERT_EQ(cut.size, other.size);
  for (uint32_t k = 1; k < cut.size; ++k)
    ASSERT_NEAR(other_shares[k] / other_shares[0], shares[k] / shares[0], 1e-5 * shares[k] / shares[0]);
}

}  // namespace
}  // namespace halflight
