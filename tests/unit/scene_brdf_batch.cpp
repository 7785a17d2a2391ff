#include <gtest/gtest.h>

#include <vector>

#include "core/random.h"
#include "core/simd.h"
#include "core/warp.h"
#include "scene/brdf_batch.h"

namespace halflight {
namespace {

TEST(Simd, LogOfComplementKeepsItsDigits) {
  for (int i = 0; i < 4000; ++i) {
    const float x = std::pow(10.0f, -0.01f * static_cast<float>(i) * 0.7f) * 0.999999f;
    const double exact = std::log1p(-static_cast<double>(x));
    ASSERT_NEAR(log_of_complement(x) / exact, 1, 4e-7) << x;
  }
  EXPECT_EQ(log_of_complement(0), 0);
  EXPECT_TRUE(std::isfinite(log_of_complement(1)));
}

/// Directions near the mirror direction of wo and all over the hemisphere.
std::vector<Vec3> directions(Vec3 wo, float spread) {
  std::vector<Vec3> all;
  RandomStream random(1, 2, 3);
  while (all.size() < 256) {
    const Vec3 d = uniform_sphere(random.next2());
    const Vec3 w = all.size() % 2 ? d : glm::normalize(Vec3(-wo.x, -wo.y, wo.z) + spread * d);
    if (w.z > 1e-3f) all.push_back(w);
  }
  return all;
}

TEST(BrdfBatch, AgreesWithOneDirectionAtATime) {
  const Vec3 kd(0.5f, 0.3f, 0.1f), ks(0.2f, 0.4f, 0.6f);
  const std::vector<Brdf> brdfs{{BrdfModel::ggx, kd, ks, 1, Vec2(0.3f, 0.1f)},
                                {BrdfModel::ggx, kd, Vec3(0), 0, Vec2(1)},
                                {BrdfModel::phong, kd, ks, 1, Vec2(1)},
                                {BrdfModel::phong, kd, ks, 1, Vec2(100)},
                                {BrdfModel::phong, Vec3(0), ks, 1, Vec2(1e6f)},
                                {BrdfModel::phong, kd, Vec3(0), 1, Vec2(10)},
                                {BrdfModel::ashikhmin_shirley, kd, ks, 1, Vec2(1, 10)},
                                {BrdfModel::ashikhmin_shirley, kd, ks, 1, Vec2(10, 1e4f)},
                                {BrdfModel::ashikhmin_shirley, kd, Vec3(0), 1, Vec2(9)},
                                {}};
  const Basis basis{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (const Vec3 wo :
       {glm::normalize(Vec3(0.3f, -0.2f, 1)), glm::normalize(Vec3(2, 1, 0.1f)), Vec3(0, 0, 1)}) {
    for (const Brdf& brdf : brdfs) {
      const std::vector<Vec3> all = directions(wo, 2 / std::sqrt(brdf.roughness.x + 1));
      std::vector<float> x, y, z, red(all.size()), green(all.size()), blue(all.size());
      for (const Vec3 w : all) x.push_back(w.x), y.push_back(w.y), z.push_back(w.z);
      evaluate_batch(brdf, wo,
                     {x.data(), y.data(), z.data(), red.data(), green.data(), blue.data(), all.size()});
      const float peak = std::max(1.0f, brdf.roughness.x);
      for (size_t i = 0; i < all.size(); ++i) {
        const Vec3 f = evaluate(brdf, basis, wo, all[i]);
        // Far down a sharp lobe the exponent's rounding shows, where exp gives next to nothing.
        const float tolerance = 3e-5f, least = 1e-12f * peak;
        ASSERT_NEAR(red[i], f.x, tolerance * f.x + least);
        ASSERT_NEAR(green[i], f.y, tolerance * f.y + least);
        ASSERT_NEAR(blue[i], f.z, tolerance * f.z + least);
      }
    }
  }
}

TEST(BrdfBatch, DensitiesAreThoseOfOneDirectionAtATime) {
  const Vec3 kd(0.5f, 0.3f, 0.1f), ks(0.2f, 0.4f, 0.6f);
  std::vector<Brdf> brdfs{{BrdfModel::ggx, kd, Vec3(0), 0, Vec2(1)},
                          {BrdfModel::phong, kd, Vec3(0), 1, Vec2(10)},
                          {BrdfModel::ashikhmin_shirley, kd, Vec3(0), 1, Vec2(9)},
                          {}};
  for (const Vec3 diffuse : {kd, Vec3(0)}) {
    for (const float alpha : {0.0f, 1e-4f, 1e-3f, 0.01f, 0.1f, 0.5f, 1.0f}) {
      brdfs.push_back({BrdfModel::ggx, diffuse, ks, 1, Vec2(alpha)});
      brdfs.push_back({BrdfModel::ggx, diffuse, ks, 1, Vec2(alpha, 0.3f)});
      brdfs.push_back({BrdfModel::ggx, diffuse, ks, 1, Vec2(0.05f, alpha)});
    }
    for (const float n : {0.0f, 1.0f, 10.0f, 100.0f, 1e4f, 1e6f})
      brdfs.push_back({BrdfModel::phong, diffuse, ks, 1, Vec2(n)});
    for (const Vec2 n : {Vec2(0), Vec2(1, 10), Vec2(100), Vec2(10, 1e5f), Vec2(1e6f)})
      brdfs.push_back({BrdfModel::ashikhmin_shirley, diffuse, ks, 1, n});
  }
  const Basis basis{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (const Vec3 wo : {glm::normalize(Vec3(0.3f, -0.2f, 1)), glm::normalize(Vec3(2, 1, 0.1f)),
                        glm::normalize(Vec3(1, 0, 2e-3f)), Vec3(0, 0, 1)})
    for (const Brdf& brdf : brdfs) {
      // Half of them where the lobe is: drawn from it.
      std::vector<Vec3> all = directions(wo, 1);
      RandomStream random(4, 5, 6);
      for (size_t i = 0; i < all.size(); i += 2)
        if (const auto drawn = sample(brdf, basis, wo, random.next(), random.next2())) all[i] = drawn->wi;
      std::vector<float> x, y, z, density(all.size()), ignored(all.size());
      for (const Vec3 w : all) x.push_back(w.x), y.push_back(w.y), z.push_back(w.z);
      evaluate_batch(brdf, wo,
                     {x.data(), y.data(), z.data(), ignored.data(), ignored.data(), ignored.data(),
                      all.size(), density.data()});
      double most = 0;
      for (const Vec3 w : all)
        most = std::max(most, static_cast<double>(evaluate_with_pdf(brdf, basis, wo, w).pdf));
      for (size_t i = 0; i < all.size(); ++i) {
        const double pdf = evaluate_with_pdf(brdf, basis, wo, all[i]).pdf;
        ASSERT_NEAR(density[i], pdf, 3e-4 * pdf + 1e-12 * most)
            << static_cast<int>(brdf.model) << " " << brdf.roughness.x << " " << brdf.roughness.y;
      }
    }
}

}  // namespace
}  // namespace halflight
