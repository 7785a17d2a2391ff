// Readers of .hdr and .exr: what well-formed files of every kind hold.
#include <gtest/gtest.h>

#include <cmath>

#include "film/image_writers.h"
#include "scene/image_files.h"
#include "support/exr_fixture.h"
#include "support/temporary_folder.h"

namespace halflight {
namespace {

namespace fs = std::filesystem;

const fs::path data = HALFLIGHT_SHARED_DATA;

ImageRgb radiance(const std::string& text) {
  return decode_radiance({reinterpret_cast<const uint8_t*>(text.data()), text.size()}, {}, "made.hdr");
}

ImageRgb exr(const std::string& text) {
  return decode_exr({reinterpret_cast<const uint8_t*>(text.data()), text.size()}, {}, "made.exr");
}

/// A pixel whose channels are r, g, b sixteenths.
std::string pixel(int r, int g, int b) {
  return {static_cast<char>(r), static_cast<char>(g), static_cast<char>(b), static_cast<char>(128 + 4)};
}

/// The value of a mantissa of `pixel`: the middle of its interval, 2^(e − 136) each.
float value(int mantissa) { return (static_cast<float>(mantissa) + 0.5f) / 16; }

const std::string plain_header = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n";

TEST(Radiance, ReadsFlatPixels) {
  const ImageRgb image = radiance(plain_header + "-Y 1 +X 2\n" + pixel(16, 32, 48) + pixel(160, 0, 255));
  ASSERT_EQ(image.width, 2);
  ASSERT_EQ(image.height, 1);
  EXPECT_EQ(image.at(0, 0), Vec3(value(16), value(32), value(48)));
  EXPECT_EQ(image.at(1, 0), Vec3(value(160), value(0), value(255)));
}

TEST(Radiance, ExponentsAtTheEnds) {
  const auto one = [](char e) {
    return radiance(plain_header + "-Y 1 +X 1\n" + std::string("\xff\x80\x40", 3) + e);
  };
  EXPECT_EQ(one('\0').at(0, 0), Vec3(0));  // exponent 0 is black whatever the mantissas
  const Vec3 brightest = one('\xff').at(0, 0);
  EXPECT_TRUE(is_finite(brightest));
  EXPECT_FLOAT_EQ(brightest.x, std::ldexp(255.5f, 255 - 136));
  EXPECT_GT(one('\1').at(0, 0).x, 0);
}

TEST(Radiance, HeaderVariables) {
  const std::string body = "-Y 1 +X 1\n" + pixel(16, 32, 64);
  const Vec3 plain(value(16), value(32), value(64));
  const auto header = [&](const std::string& lines) {
    return radiance("#?RADIANCE\n" + lines + "\n" + body).at(0, 0);
  };
  EXPECT_EQ(header(""), plain);  // FORMAT is optional
  EXPECT_EQ(header("EXPOSURE=4\n"), plain / 4.0f);
  EXPECT_EQ(header("EXPOSURE=4\nEXPOSURE= 0.5\n"), plain / 2.0f);  // several multiply
  EXPECT_EQ(header("COLORCORR=2 4 8\n"), plain / Vec3(2, 4, 8));
  EXPECT_EQ(header("# EXPOSURE=9\nrpict -vta -x 512\nVIEW= -vta\nGAMMA=1\nPIXASPECT=1.0\n"), plain);
  EXPECT_EQ(header("FORMAT= 32-bit_rle_rgbe\r\n"), plain);
  EXPECT_EQ(radiance("#?RGBE\n\n" + body).at(0, 0), plain);
}

TEST(Radiance, TinyExposuresStayFinite) {
  for (const char* format : {"rgbe", "xyze"}) {
    const ImageRgb image =
        radiance(fmt::format("#?RADIANCE\nFORMAT=32-bit_rle_{}\nEXPOSURE=1e-300\n\n-Y 1 +X 1\n", format) +
                 "\xff\xff\xff\xff");
    EXPECT_TRUE(is_finite(image.at(0, 0))) << format;  // no difference of infinities either
    EXPECT_GT(image.at(0, 0).y, 1e38f) << format;
  }
}

TEST(Radiance, XyzeBecomesRgb) {
  // D65 white, X = 0.9505 Y, Z = 1.089 Y, is equal parts of the three primaries.
  const ImageRgb image =
      radiance("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 2\n" + pixel(190, 200, 218) + pixel(0, 0, 250));
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(image.at(0, 0)[c], value(200), 0.01f * value(200)) << c;
  EXPECT_GT(image.at(1, 0).z, value(250));  // Z alone is out of gamut: cut at 0
  EXPECT_EQ(image.at(1, 0).x, 0);
}

/// A picture of 3 columns and 2 rows whose mantissas are 16 (1 + x) + 100 y, written in each order of axes.
TEST(Radiance, AllOrdersOfAxes) {
  for (const bool column_major : {false, true})
    for (const bool right : {false, true})
      for (const bool up : {false, true}) {
        const std::string x_axis = std::string(right ? "+" : "-") + "X 3",
                          y_axis = std::string(up ? "+" : "-") + "Y 2";
        std::string text =
            plain_header + (column_major ? x_axis + " " + y_axis : y_axis + " " + x_axis) + "\n";
        const auto place = [&](int i, int j) {  // i-th along X, j-th along Y as the file has them
          const int x = right ? i : 2 - i, y = up ? 1 - j : j;
          return pixel(16 * (1 + x) + 100 * y, 0, 0);
        };
        if (column_major) {
          for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 2; ++j) text += place(i, j);
        } else {
          for (int j = 0; j < 2; ++j)
            for (int i = 0; i < 3; ++i) text += place(i, j);
        }
        const ImageRgb image = radiance(text);
        ASSERT_EQ(image.width, 3) << text;
        ASSERT_EQ(image.height, 2);
        for (int y = 0; y < 2; ++y)
          for (int x = 0; x < 3; ++x)
            EXPECT_EQ(image.at(x, y).x, value(16 * (1 + x) + 100 * y)) << x_axis << y_axis;
      }
}

TEST(Radiance, OldRunsRepeatThePixelBefore) {
  // One pixel, 2 + 256 · 1 repeats, another pixel: the second repeat in a row counts 256s.
  const std::string repeat2("\1\1\1\2", 4), repeat256("\1\1\1\1", 4);
  const ImageRgb image =
      radiance(plain_header + "-Y 1 +X 260\n" + pixel(16, 16, 16) + repeat2 + repeat256 + pixel(32, 0, 0));
  for (int x = 0; x < 259; ++x) ASSERT_EQ(image.at(x, 0).x, value(16)) << x;
  EXPECT_EQ(image.at(259, 0).x, value(32));
}

TEST(Radiance, LongConstantLinesOfOldRunsAreNoBomb) {
  std::string text = plain_header + "-Y 600 +X 20000\n";
  for (int y = 0; y < 600; ++y)  // 1 + 31 + 256 · 78
    text += pixel(16, 16, 16) + std::string("\1\1\1\x1f", 4) + std::string("\1\1\1\x4e", 4);
  const ImageRgb image = radiance(text);
  EXPECT_EQ(image.at(19999, 599).x, value(16));
}

TEST(Radiance, NewRunsMixWithFlatLines) {
  const std::string marked = {'\2', '\2', '\0', '\x8'};
  const std::string runs = std::string("\x88\x10", 2) + std::string("\x84\x20\x84\x30", 4) +
                           std::string("\x8\1\2\3\4\5\6\7\x8", 9) + std::string("\x88\x84", 2);
  std::string flat;
  for (int x = 0; x < 8; ++x) flat += pixel(100 + x, 0, 0);
  const ImageRgb image = radiance(plain_header + "-Y 2 +X 8\n" + marked + runs + flat);
  for (int x = 0; x < 8; ++x) {
    EXPECT_EQ(image.at(x, 0), Vec3(value(16), value(x < 4 ? 32 : 48), value(x + 1)));
    EXPECT_EQ(image.at(x, 1).x, value(100 + x));
  }
}

TEST(Exr, ReadsItsChannelsByName) {
  const ImageRgb image = exr(small_exr().bytes());
  ASSERT_EQ(image.width, 4);
  ASSERT_EQ(image.height, 2);
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 4; ++x) {
      const float v = static_cast<float>(10 * x + 100 * y);
      EXPECT_EQ(image.at(x, y), Vec3(v + 2, v + 1, v));
    }
}

TEST(Exr, TakesLayersAndLuminance) {
  ExrFile file = small_exr();
  file.channels = {{"View.Combined.B"}, {"View.Combined.G"}, {"View.Combined.R"}};
  EXPECT_EQ(exr(file.bytes()).at(1, 0), Vec3(12, 11, 10));
  file.channels = {{"A"}, {"Y"}, {"Z"}};
  EXPECT_EQ(exr(file.bytes()).at(1, 1), Vec3(111));
}

TEST(Exr, ShowsTheDisplayWindow) {
  ExrFile file = small_exr();
  file.data = {5, 7, 8, 8};
  file.display = {6, 6, 7, 8};  // cuts a column on both sides, adds a line above
  const ImageRgb image = exr(file.bytes());
  ASSERT_EQ(image.width, 2);
  ASSERT_EQ(image.height, 3);
  EXPECT_EQ(image.at(0, 0), Vec3(0));
  EXPECT_EQ(image.at(0, 1), Vec3(12, 11, 10));
  EXPECT_EQ(image.at(1, 2), Vec3(122, 121, 120));
  file.data = {-5, -7, -2, -6};
  file.display = file.data;
  EXPECT_EQ(exr(file.bytes()).at(3, 1), Vec3(132, 131, 130));
}

TEST(Exr, ReconstructsLuminanceAndChroma) {
  // Constant Y with RY = BY = 0 is grey; RY = (R − Y)/Y.
  ExrFile file;
  file.data = file.display = {-4, 2, 3, 9};
  file.channels = {{"BY", 2, 2, 2}, {"RY", 2, 2, 2}, {"Y", 2}};
  std::string body, table;
  const std::string head = file.header();
  for (int y = 2; y <= 9; ++y) {
    std::string line;
    if (y % 2 == 0)
      for (int i = 0; i < 8; ++i) line += little(i < 4 ? 0.0f : 0.5f);  // BY, then RY
    for (int x = 0; x < 8; ++x) line += little(2.0f);
    table += little(static_cast<uint64_t>(head.size() + 64 + body.size()));
    body += little(y) + little(static_cast<int32_t>(line.size())) + line;
  }
  const ImageRgb image = exr(head + table + body);
  ASSERT_EQ(image.width, 8);
  // R = (1 + RY) Y, B = Y, and G from Y = 0.2126 R + 0.7152 G + 0.0722 B.
  const float green = (2 - 0.2126f * 3 - 0.0722f * 2) / 0.7152f;
  for (const Vec3& p : image.pixels) {
    EXPECT_NEAR(p.x, 3, 0.01f);
    EXPECT_NEAR(p.y, green, 0.01f);
    EXPECT_NEAR(p.z, 2, 0.01f);
  }
}

TEST(ReadImage, GoesByContentNotByEnding) {
  const TemporaryFolder folder;
  EXPECT_EQ(read_image(folder.write("a.hdr", small_exr().bytes()), {}).width, 4);
  EXPECT_EQ(read_image(folder.write("a.exr", plain_header + "-Y 1 +X 1\n" + pixel(1, 2, 1)), {}).width, 1);
  ImageRgba8 shown{2, 1, {255, 0, 128, 255, 10, 11, 12, 255}};
  const ImageRgb image = read_image(folder.write("a", png_bytes(shown, {})), {});
  EXPECT_NEAR(image.at(0, 0).z, std::pow((128 / 255.0 + 0.055) / 1.055, 2.4), 1e-6);  // sRGB decoded
  EXPECT_NEAR(image.at(1, 0).x, 10 / 255.0 / 12.92, 1e-7);
}

TEST(ReadFile, SaysWhyItCannot) {
  const TemporaryFolder folder;
  const auto outcome = [](const fs::path& path, uint64_t limit) -> std::string {
    try {
      read_file(path, limit);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::bad_input);
      return error.what();
    }
    return "";
  };
  const fs::path file = folder.write("ten", "0123456789");
  EXPECT_EQ(read_file(file, 10).size(), 10u);
  EXPECT_NE(outcome(file, 9).find("ten: 10 bytes exceed the limit of 9"), std::string::npos);
  EXPECT_NE(outcome(folder.path() / "none", 9).find("no such file"), std::string::npos);
  EXPECT_NE(outcome(folder.path(), 9).find("it is a folder"), std::string::npos);
  EXPECT_NE(outcome(file / "below", 9), "");
  EXPECT_NE(outcome("/dev/zero", 1000).find("more than the limit of 1000 bytes"), std::string::npos);
}

/// Every legitimate picture beside the checkout, its size as other readers report it.
TEST(SharedImages, AllAreRead) {
  if (!fs::exists(data)) GTEST_SKIP() << "no shared data beside the checkout";
  const std::tuple<const char*, int, int> files[] = {{"env/latlong-hdr/venice_sunset_1k.hdr", 1024, 512},
                                                     {"env/latlong-hdr/std_env.hdr", 1500, 750},
                                                     {"env/latlong-exr/interior.exr", 1024, 512},
                                                     {"env/latlong-exr/studio.exr", 1024, 512},
                                                     {"env/latlong-exr/sunset.exr", 1024, 512},
                                                     {"env/angular/test.hdr", 544, 544},
                                                     {"env/radiance-suite/h_gradient.hdr", 128, 128},
                                                     {"env/radiance-suite/mirror_fish.hdr", 128, 124},
                                                     {"env/radiance-suite/mesh_cyl.hdr", 128, 26},
                                                     {"env/hdr-variants/image1.hdr", 128, 85},
                                                     {"env/hdr-variants/rgbr4x4.hdr", 4, 4},
                                                     {"env/hdr-variants/hdr-rgb-canarywharf.hdr", 768, 768},
                                                     {"env/exr-variants/2by2.exr", 2, 2},
                                                     {"env/exr-variants/piz-bug-issue-100.exr", 35, 1}};
  for (const auto& [name, width, height] : files) {
    const ImageRgb image = read_image(data / name, {});
    EXPECT_EQ(image.width, width) << name;
    EXPECT_EQ(image.height, height) << name;
    double sum = 0;
    for (const Vec3& p : image.pixels) sum += std::abs(p.x) + std::abs(p.y) + std::abs(p.z);
    EXPECT_TRUE(std::isfinite(sum) && sum > 0) << name;
  }
}

}  // namespace
}  // namespace halflight
