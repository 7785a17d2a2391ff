// The shared pictures, good and bad: what another reader makes of the good ones, and what the bad ones may
// cost.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "core/stopwatch.h"
#include "scene/environment.h"
#include "scene/image_files.h"
#include "scene/load.h"

namespace halflight {
namespace {

namespace fs = std::filesystem;

const fs::path data = HALFLIGHT_SHARED_DATA;

/// Every .hdr and .exr below a folder, as names relative to it.
std::vector<std::string> pictures_in(const fs::path& folder) {
  std::vector<std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.path().extension() == ".hdr" || entry.path().extension() == ".exr")
      files.push_back(entry.path().lexically_relative(folder).string());
  std::sort(files.begin(), files.end());
  return files;
}

/// Means of the files' pixels, red, green and blue, and the product of the EXPOSURE lines, which that reader
/// leaves in the values: `oiiotool --stats` of OpenImageIO 2.4, but h_gradient.hdr, which it refuses.
struct Means {
  Vec3d rgb;
  double exposure = 1;
};

const std::map<std::string, Means> means = {
    {"angular/studio_small_03_angular_512.hdr", {{0.995198, 1.144332, 1.296170}}},
    {"angular/test.hdr", {{0.674533, 0.466776, 0.408735}, 2.720623e-02 * 4.676974e+01}},
    {"exr-variants/2by2.exr", {{0.5, 0.361755, 0.5}}},
    {"exr-variants/piz-bug-issue-100.exr", {{0.028571, 0.028571, 0.028571}}},
    {"hdr-variants/hdr-rgb-canarywharf.hdr", {{0.792167, 1.015747, 1.383927}}},
    {"hdr-variants/image1.hdr", {{0.453488, 0.448697, 0.414723}}},
    {"hdr-variants/rgbr4x4.hdr", {{2.502487, 0.274902, 0.265625}}},
    {"latlong-exr/interior.exr", {{1.082819, 0.955803, 0.813454}}},
    {"latlong-exr/studio.exr", {{0.229647, 0.259988, 0.278698}}},
    {"latlong-exr/sunset.exr", {{0.404053, 0.416061, 0.573106}}},
    {"latlong-hdr/dikhololo_night_1k.hdr", {{0.073240, 0.064551, 0.055490}}},
    {"latlong-hdr/empty_warehouse_01_1k.hdr", {{0.678437, 0.645270, 0.582782}}},
    {"latlong-hdr/potsdamer_platz_1k.hdr", {{0.682258, 0.671763, 0.788174}}},
    {"latlong-hdr/st_fagans_interior_1k.hdr", {{0.911697, 0.705161, 0.438925}}},
    {"latlong-hdr/std_env.hdr", {{0.644381, 0.644380, 0.644381}}},
    {"latlong-hdr/studio_small_03_1k.hdr", {{1.635955, 1.882326, 2.127459}}},
    {"latlong-hdr/venice_sunset_1k.hdr", {{0.404657, 0.416238, 0.573429}}},
    {"radiance-suite/mesh_cyl.hdr", {{0.095917, 0.083031, 0.067945}, 1.5}},
    {"radiance-suite/mirror_fish.hdr", {{0.168946, 0.160919, 0.150819}, 8}},
};

TEST(SharedPictures, HaveTheMeansThatAnotherReaderFinds) {
  if (!fs::exists(data)) GTEST_SKIP() << "no shared data beside the checkout";
  for (const auto& [name, expected] : means) {
    const ImageRgb image = read_image(data / "env" / name, {});
    Vec3d sum(0);
    double brightest = 0;
    for (const Vec3& pixel : image.pixels) {
      sum += Vec3d(pixel);
      brightest += max_component(pixel);
    }
    const double count = static_cast<double>(image.pixels.size());
    // Of RGBE, that reader takes the lower end of a step, we the middle; the brightest channel has at least
    // 128 steps.
    const double step = fs::path(name).extension() == ".hdr" ? brightest / count / 128 : 0;
    for (int c = 0; c < 3; ++c) {
      const double excess = sum[c] / count - expected.rgb[c] / expected.exposure;
      EXPECT_GE(excess, step / 5 - 2e-6) << name << " " << c;
      EXPECT_LE(excess, step / 2 + 2e-6) << name << " " << c;
    }
  }
}

TEST(SharedPictures, AllBecomeEnvironments) {
  if (!fs::exists(data)) GTEST_SKIP() << "no shared data beside the checkout";
  const std::vector<std::string> files = pictures_in(data / "env");
  EXPECT_GE(files.size(), 20u);
  for (const std::string& name : files) {
    Messages messages;
    const Environment environment = load_environment(data / "env" / name, {}, messages);
    double mean = 0;
    for (int y = 0; y < environment.map.height; ++y) {
      const double part = texel_solid_angle(environment, y) / (4.0 * pi);
      for (int x = 0; x < environment.map.width; ++x) mean += part * luminance(environment.map.at(x, y));
    }
    EXPECT_GT(mean, 0.01) << name;
    EXPECT_LT(mean, 10) << name;
    // Some have channels a little below 0: out of the gamut.
    EXPECT_LE(environment.bad_texels, environment.map.pixels.size() / 50) << name;
  }
}

/// The brightest texel of the sunset has a blue of −0.0003: it must not be taken for nothing.
TEST(SharedPictures, KeepASunJustOutsideTheGamut) {
  if (!fs::exists(data)) GTEST_SKIP() << "no shared data beside the checkout";
  Messages messages;
  const Environment sunset = load_environment(data / "env/latlong-exr/sunset.exr", {}, messages);
  Vec3 brightest(0);
  for (const Vec3& texel : sunset.map.pixels) brightest = glm::max(brightest, texel);
  EXPECT_EQ(brightest.x, 6520);
  EXPECT_EQ(sunset.bad_texels, 5u);
  EXPECT_EQ(messages.warnings.size(), 1u);
}

/// Each in a process of its own, which is killed when it takes longer than it may.
TEST(SharedDamagedPictures, EndInAPictureOrAnErrorAndTakeLittle) {
  if (!fs::exists(data)) GTEST_SKIP() << "no shared data beside the checkout";
  constexpr unsigned most_seconds = 10;
  constexpr long most_kilobytes = 2 << 20;
  const std::vector<std::string> files = pictures_in(data / "env-invalid");
  EXPECT_GE(files.size(), 80u);
  for (const std::string& name : files) {
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      alarm(most_seconds);
      try {
        Messages messages;
        load_environment(data / "env-invalid" / name, {}, messages);
      } catch (const Error& error) {
        _exit(static_cast<int>(error.code()));
      }
      _exit(0);
    }
    int status = -1;
    rusage usage{};
    wait4(child, &status, 0, &usage);
    ASSERT_TRUE(WIFEXITED(status)) << name << " ends with signal " << WTERMSIG(status);
    EXPECT_TRUE(WEXITSTATUS(status) == 0 || WEXITSTATUS(status) == 3) << name;
    EXPECT_LT(usage.ru_maxrss, most_kilobytes) << name;
  }
}

}  // namespace
}  // namespace halflight
