// Pixels that draw from one distribution: who they are, and that nothing any of them sees is lost.
#include <gtest/gtest.h>

#include <algorithm>

#include "lights/cut_importance.h"
#include "support/box_room.h"
#include "support/statistics.h"
#include "techniques/shared_distribution.h"

namespace halflight {
namespace {

const Brdf satin{BrdfModel::ggx, Vec3(0.5f, 0.4f, 0.3f), Vec3(0.04f), 1, Vec2(0.5f)};

GBufferTexel texel_at(Vec3 position, Vec3 normal, const Brdf& brdf) {
  GBufferTexel texel;
  texel.triangle = 0;
  texel.position = position;
  texel.geometric_normal = Vec3(0, 1, 0), texel.shading_normal = glm::normalize(normal);
  texel.tangent = basis_around(texel.shading_normal).tangent;
  texel.wo = glm::normalize(Vec3(0.3f, 1, 0.2f));
  texel.brdf = brdf;
  return texel;
}

/// A patch of the floor that begins at one wall, its shading normals bent a little.
void see_floor(Room& room, int width, int height, const Brdf& brdf) {
  GBuffer& gbuffer = room.gbuffer;
  gbuffer.resize(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      gbuffer.texels[static_cast<size_t>(y) * width + x] =
          texel_at({0.02f + 0.05f * x, 0, 1.5f + 0.05f * y}, {0.01f * x, 1, 0.01f * y}, brdf);
  room.base.assign(gbuffer.texels.size(), Vec3(0));
}

bool serves(const GBufferTexel& one, const GBufferTexel& other) { return alike(one, other, 0.99f); }

TEST(DistributionLeaders, AreTheSameInWhateverOrderTheyAreAskedFor) {
  GBuffer gbuffer;
  gbuffer.resize(10, 7);  // blocks at the edges are cut off
  RandomStream random(1, 2, 3);
  Brdf rough = satin;
  rough.roughness = Vec2(1);
  for (uint32_t i = 0; i < gbuffer.texels.size(); ++i) {
    const float kind = random.next();
    GBufferTexel& texel = gbuffer.texels[i];
    texel = texel_at({i % 10, 0, i / 10}, kind < 0.4f ? Vec3(0, 1, 0) : Vec3(1, 1, 0),
                     kind < 0.7f ? satin : rough);
    if (kind > 0.9f) texel.triangle = no_triangle;
  }
  DistributionLeaders in_turn(gbuffer), backwards(gbuffer);
  const auto count = static_cast<uint32_t>(gbuffer.texels.size());
  std::vector<uint32_t> leader(count);
  for (uint32_t i = 0; i < count; ++i) leader[i] = in_turn.of(i, serves);
  uint32_t followers = 0;
  for (uint32_t i = count; i-- > 0;) {
    EXPECT_EQ(backwards.of(i, serves), leader[i]);
    EXPECT_EQ(leader[leader[i]], leader[i]);
    EXPECT_EQ(in_turn.block_of(leader[i]), in_turn.block_of(i));
    if (reflects(gbuffer.texels[i])) {
      EXPECT_TRUE(serves(gbuffer.texels[leader[i]], gbuffer.texels[i]));
    } else {
      EXPECT_EQ(leader[i], i);
    }
    followers += leader[i] != i;
  }
  EXPECT_GT(followers, count / 3);
}

TEST(SharedPoint, HasEveryClusterThatOneOfItsPointsHas) {
  Brdf mirror_like = satin, phong{BrdfModel::phong, Vec3(0.2f), Vec3(0.5f), 1, Vec2(30)};
  mirror_like.roughness = Vec2(0.2f);
  for (const Brdf& brdf :
       {satin, mirror_like, phong, Brdf{BrdfModel::ggx, Vec3(0.5f), Vec3(0), 0, Vec2(1)}}) {
    RoomOptions options;
    options.cut.least = options.cut.most = 500;
    Room room(options);
    see_floor(room, 8, 8, brdf);
    DistributionLeaders leaders(room.gbuffer);
    const size_t size = room.cut.padded_size();
    std::vector<float> shared(size), own(size), guard(size), arriving(size);
    uint32_t lost_without = 0;
    for (uint32_t pixel = 0; pixel < 64; ++pixel) {
      const uint32_t leader = leaders.of(pixel, serves);
      const SharedPoint point = leaders.shared(leader);
      EXPECT_LT(std::abs(glm::dot(point.texel.tangent, point.texel.shading_normal)), 1e-6f);
      const GBufferTexel& texel = room.gbuffer.texels[pixel];
      analytic_importance(room.cut, texel, 0, {own, guard, arriving});
      analytic_importance(room.cut, point.texel, 0, {shared, guard, arriving}, point.spread);
      for (uint32_t k = 0; k < room.cut.size; ++k)
        ASSERT_TRUE(own[k] == 0 || shared[k] > 0) << "pixel " << pixel << ", cluster " << k;
      analytic_importance(room.cut, point.texel, 0, {shared, guard, arriving});
      for (uint32_t k = 0; k < room.cut.size; ++k) lost_without += own[k] > 0 && shared[k] == 0;
    }
    EXPECT_GT(lost_without, 0u) << "a patch that asks nothing of the spread";
  }
}

TEST(SharedDistribution, NeighboursDrawFromOneAndEachMeanIsItsExactSum) {
  RoomOptions options;
  options.sun = 20;
  Room room(options);
  see_floor(room, 8, 4, satin);
  const auto technique = find_technique("bidirectional").make();
  technique->prepare(room.frame);
  const auto probabilities = [&](uint32_t pixel) {
    PassRequest request;
    request.samples = 4;
    return technique->inspect(room.frame, request, pixel)->probability;
  };
  EXPECT_EQ(probabilities(0), probabilities(27));  // the first block
  EXPECT_NE(probabilities(0), probabilities(4));
  room.settings.set("bidirectional.share", "never");
  EXPECT_NE(probabilities(0), probabilities(27));
  room.settings.set("bidirectional.share", "always");

  constexpr uint32_t passes = 4000, pixels = 32;
  std::vector<double> mean(pixels), square_mean(pixels);
  for (uint32_t pass = 0; pass < passes; ++pass) {
    Film film(room.gbuffer.width, room.gbuffer.height);
    PassRequest request;
    request.pass = pass, request.samples = 32;
    technique->run_pass(room.frame, request, film);
    for (uint32_t i = 0; i < pixels; ++i) {
      const double value = luminance(film.radiance(i));
      mean[i] += value / passes, square_mean[i] += value * value / passes;
    }
  }
  const double bound = two_sided_bound(sidak_level(0.01, pixels));
  for (uint32_t i = 0; i < pixels; ++i) {
    const Vec3d exact = room.exact(i);
    const double truth = 0.2126 * exact.x + 0.7152 * exact.y + 0.0722 * exact.z;
    const double error = std::sqrt((square_mean[i] - mean[i] * mean[i]) / (passes - 1));
    EXPECT_NEAR(mean[i], truth, bound * error + 1e-5 * truth) << "pixel " << i;
    EXPECT_LT(error, 0.005 * truth) << "too noisy to tell";
  }
}

}  // namespace
}  // namespace halflight
