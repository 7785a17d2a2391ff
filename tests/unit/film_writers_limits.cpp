// Picture files at the ends of what their formats hold, and folders that may not be written into.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <functional>
#include <iterator>

#include "core/errors.h"
#include "core/random.h"
#include "film/image_writers.h"
#include "scene/image_files.h"
#include "support/temporary_folder.h"

namespace halflight {
namespace {

namespace fs = std::filesystem;

/// Radiances over many orders of magnitude, half of them in runs, with black among them.
ImageRgb varied_image(int width, int height) {
  ImageRgb image(width, height);
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    RandomStream random(i / 16 % 2 == 0 ? i / 16 : i, 0, 1);
    const float scale = std::exp2(60 * random.next() - 30);
    image.pixels[i] = i % 37 == 5 ? Vec3(0) : scale * Vec3(random.next(), random.next(), random.next());
  }
  return image;
}

/// The message of the Error that `act` throws, whose exit code is `code`.
std::string message_of(ExitCode code, const std::function<void()>& act) {
  try {
    act();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

constexpr int widths[] = {1, 2, 7, 8, 9, 127, 128, 129, 32767, 32768, 40000};

TEST(WriteExr, RoundTripsBitForBit) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.exr";
  for (const int width : widths) {
    const ImageRgb image = varied_image(width, 3);
    write_exr(path, image, {});
    const ImageRgb back = read_image(path, {});
    ASSERT_EQ(back.width, width);
    ASSERT_EQ(back.height, 3);
    EXPECT_EQ(back.pixels, image.pixels) << width;
  }
}

TEST(WriteRadiance, RoundTripsWithinItsSteps) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.hdr";
  for (const int width : widths) {
    const ImageRgb image = varied_image(width, 3);
    write_radiance(path, image, {});
    const ImageRgb back = read_image(path, {});
    ASSERT_EQ(back.width, width);
    ASSERT_EQ(back.height, 3);
    for (size_t i = 0; i < image.pixels.size(); ++i) {
      // The brightest channel has 128 to 255 steps; the reader takes the middle of one.
      const float step = max_component(image.pixels[i]) / 128;
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(back.pixels[i][c], image.pixels[i][c], 0.5001f * step) << width << ": " << i;
    }
  }
}

TEST(WriteRadiance, RunsAreShorterThanFlatPixels) {
  // 100 constant columns: each of four channels takes one run of two bytes.
  const ImageMetadata none;
  const auto size = [&](int width) { return radiance_bytes(ImageRgb(width, 1, Vec3(0.5f)), none).size(); };
  EXPECT_EQ(size(108) - size(100), 0u);
  EXPECT_EQ(size(128) - size(127), 4u * 2);  // a literal of one value beside the longest run
  EXPECT_EQ(size(7) - size(6), 4u);          // flat
}

TEST(WriteExr, RefusesMetadataTheFormatCannotHold) {
  ImageMetadata metadata;
  metadata.text["compression"] = "a standard attribute of another type";
  const std::string told =
      message_of(ExitCode::failure, [&] { exr_bytes(ImageRgb(2, 2, Vec3(1)), metadata); });
  EXPECT_NE(told.find("encoding an EXR failed"), std::string::npos) << told;
}

TEST(WriteRadiance, MetadataAreCommentsThatReadersSkip) {
  ImageMetadata metadata;
  metadata.text["scene"] = "first line\n\nEXPOSURE=7\r\n-Y 9 +X 9";
  metadata.numbers["seed"] = 3;
  const std::string bytes = radiance_bytes(ImageRgb(9, 2, Vec3(1)), metadata);
  EXPECT_NE(bytes.find("\n# scene: first line"), std::string::npos);
  EXPECT_NE(bytes.find("\n# seed: 3\n"), std::string::npos);
  const ImageRgb back =
      decode_radiance({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}, {}, "x");
  EXPECT_EQ(back.width, 9);
  EXPECT_NEAR(back.at(8, 1).x, 1, 0.005f);
}

TEST(WritePng, CutsKeywordsTheFormatHasNoRoomFor) {
  ImageMetadata metadata;
  metadata.text[std::string(100, 'k')] = "value";
  const std::string png = png_bytes({1, 1, {1, 2, 3, 255}}, metadata);
  EXPECT_NE(png.find("tEXt" + std::string(79, 'k') + '\0' + "value"), std::string::npos);
}

TEST(WritePng, RefusesMoreThanItsEncoderCounts) {
  ImageRgba8 image{1 << 14, (1 << 13) + 1, {}};  // a row above 2^29 bytes
  const std::string told = message_of(ExitCode::failure, [&] { png_bytes(image, {}); });
  EXPECT_NE(told.find("16384 x 8193 pixels are too many for a PNG"), std::string::npos) << told;
}

/// 0 where writing fails with exit code 1 and the reason.
int fails_with(const fs::path& path, const std::string& reason) {
  try {
    write_bytes_atomically(path, "new");
    return 10;
  } catch (const Error& error) {
    if (error.code() != ExitCode::failure) return 11;
    return std::string(error.what()) == path.string() + ": cannot write: " + reason ? 0 : 12;
  }
}

TEST(WriteAtomically, UnwritableFolderKeepsTheOldFile) {
  const TemporaryFolder folder;
  const fs::path path = folder.write("a", "old");
  chmod(path.c_str(), 0666);  // the file may be written, but no other beside it
  chmod(folder.path().c_str(), 0555);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    constexpr uid_t nobody = 65534;  // root may write everywhere
    if (geteuid() == 0 && seteuid(nobody) != 0) _exit(13);
    _exit(fails_with(path, "Permission denied"));
  }
  int status = -1;
  waitpid(child, &status, 0);
  chmod(folder.path().c_str(), 0755);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  const std::vector<uint8_t> left = read_file(path, 100);
  EXPECT_EQ(std::string(left.begin(), left.end()), "old");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1);
}

}  // namespace
}  // namespace halflight
