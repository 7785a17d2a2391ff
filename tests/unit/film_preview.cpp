#include <gtest/gtest.h>

#include "film/preview.h"

namespace halflight {
namespace {

constexpr int width = 32, height = 24;

/// Two walls that meet at x = 16, one of them in a checker of two albedos; light 1 on the left and 3 on the
/// right.
struct Corner {
  GBuffer gbuffer;
  std::vector<Vec3> base;
  ImageRgb truth{width, height};

  Corner() {
    gbuffer.resize(width, height);
    base.assign(gbuffer.pixel_count(), Vec3(0.25f));
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const size_t i = static_cast<size_t>(y) * width + x;
        const bool left = x < 16;
        GBufferTexel& texel = gbuffer.texels[i];
        texel.triangle = 0;
        texel.material = left ? 0 : 1;
        texel.position = left ? Vec3(x - 16, y, 0) : Vec3(0, y, x - 16);
        texel.geometric_normal = texel.shading_normal = left ? Vec3(0, 0, 1) : Vec3(-1, 0, 0);
        texel.brdf = {BrdfModel::phong, Vec3(left && (x + y) % 2 == 0 ? 0.1f : 0.6f), Vec3(0), 0, Vec3(1)};
        truth.pixels[i] = base[i] + bounce_albedo(texel.brdf) * (left ? 1.0f : 3.0f);
      }
  }

  Film sampled(int stride) const {
    Film film(width, height);
    for (int y = 0; y < height; y += stride)
      for (int x = 0; x < width; x += stride) {
        const auto i = static_cast<uint32_t>(y * width + x);
        film.add(i, 0, truth.pixels[i], 1);
      }
    return film;
  }
};

TEST(Preview, KeepsEdgesAndTextures) {
  const Corner corner;
  for (const int stride : {4, 2}) {
    const ImageRgb picture = preview_picture(corner.sampled(stride), corner.gbuffer, corner.base);
    for (size_t i = 0; i < picture.pixels.size(); ++i)
      EXPECT_NEAR(picture.pixels[i].x, corner.truth.pixels[i].x, 0.03f * corner.truth.pixels[i].x)
          << i % width << " " << i / width;
  }
}

TEST(Preview, IsTheFilmOnceEveryPixelHasSamples) {
  const Corner corner;
  Film film = corner.sampled(1);
  film.add(100, 0, Vec3(7), 1);
  const ImageRgb picture = preview_picture(film, corner.gbuffer, corner.base);
  for (uint32_t i = 0; i < picture.pixels.size(); ++i) EXPECT_EQ(picture.pixels[i], film.radiance(i));
}

TEST(Preview, DoesWithoutAGBuffer) {
  const Corner corner;
  const Film film = corner.sampled(4);
  const ImageRgb picture = preview_picture(film, GBuffer{}, {});
  EXPECT_EQ(picture.pixels[width + 1], film.radiance(0));
}

TEST(Resized, KeepsPlacesAndMeans) {
  ImageRgb ramp(8, 6);
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 8; ++x) ramp.at(x, y) = Vec3(x, y, 2);
  EXPECT_EQ(resized(ramp, 8, 6).pixels, ramp.pixels);
  const ImageRgb large = resized(ramp, 24, 12);
  for (int y = 2; y < 10; ++y)
    for (int x = 3; x < 21; ++x) {
      EXPECT_NEAR(large.at(x, y).x, (x + 0.5) / 3 - 0.5, 1e-5);
      EXPECT_NEAR(large.at(x, y).y, (y + 0.5) / 2 - 0.5, 1e-5);
      EXPECT_EQ(large.at(x, y).z, 2);
    }
  EXPECT_EQ(large.at(0, 0), Vec3(0, 0, 2)) << "the edge goes on";
  EXPECT_EQ(large.at(23, 11), Vec3(7, 5, 2));
}

}  // namespace
}  // namespace halflight
