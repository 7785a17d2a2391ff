// Picture files: what is written reads back the same, and failures leave nothing behind.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <thread>

#include "core/errors.h"
#include "core/random.h"
#include "film/image_writers.h"
#include "film/tonemap.h"
#include "scene/image_files.h"
#include "support/temporary_folder.h"

namespace halflight {
namespace {

namespace fs = std::filesystem;

/// Values over many orders of magnitude, with constant stretches.
ImageRgb sample_image(int width, int height) {
  ImageRgb image(width, height);
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    RandomStream random(i, 0, 1);
    const float scale = std::exp2(40 * random.next() - 20);
    image.pixels[i] =
        i % 40 < 20 ? Vec3(0.25f, 1, 4) : scale * Vec3(random.next(), random.next(), random.next());
  }
  return image;
}

ImageMetadata sample_metadata() {
  ImageMetadata metadata;
  metadata.text = {{"scene", "bedroom"}, {"note", "zwei Zeilen:\nWände"}};
  metadata.numbers = {{"spp", 32}, {"seconds", 1.5}};
  metadata.matrices["worldToCamera"] = glm::translate(Mat4(1), Vec3(1, 2, 3));
  return metadata;
}

size_t files_in(const fs::path& folder) {
  return static_cast<size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

/// Exit code and message of a write that fails.
std::pair<ExitCode, std::string> failure_of(const std::function<void()>& write) {
  try {
    write();
  } catch (const Error& error) {
    return {error.code(), error.what()};
  }
  return {ExitCode::ok, ""};
}

TEST(ExrWriter, KeepsPixelsLayersAndMetadata) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.exr";
  const ImageRgb image = sample_image(37, 23);
  ImageMetadata metadata = sample_metadata();
  ImageLayer normals{"N", {"X", "Y", "Z"}, {}};
  for (size_t i = 0; i < image.pixels.size() * 3; ++i) normals.values.push_back(static_cast<float>(i));
  metadata.layers = {normals, {"Depth", {"V"}, std::vector<float>(image.pixels.size(), 7)}};
  write_exr(path, image, metadata);

  EXPECT_EQ(read_image(path, {}).pixels, image.pixels);
  EXPECT_EQ(files_in(folder.path()), 1u);
  Imf::InputFile file(path.c_str());
  const Imf::Header& header = file.header();
  EXPECT_EQ(header.typedAttribute<Imf::StringAttribute>("scene").value(), "bedroom");
  EXPECT_EQ(header.typedAttribute<Imf::DoubleAttribute>("spp").value(), 32);
  // Row vectors from the left: p · M. The translation stands in the last row.
  const Imath::M44f matrix = header.typedAttribute<Imf::M44fAttribute>("worldToCamera").value();
  EXPECT_EQ(Imath::V3f(0) * matrix, Imath::V3f(1, 2, 3));
  EXPECT_EQ(header.channels()["R"].type, Imf::FLOAT);
  ASSERT_NE(header.channels().findChannel("Depth.V"), nullptr);
  std::vector<float> y(image.pixels.size());
  Imf::FrameBuffer buffer;
  buffer.insert("N.Y", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(y.data()), 4, 4 * 37));
  file.setFrameBuffer(buffer);
  file.readPixels(0, 22);
  for (size_t i = 0; i < y.size(); ++i) ASSERT_EQ(y[i], static_cast<float>(3 * i + 1));
}

TEST(RadianceWriter, KeepsPixelsToTheirPrecision) {
  for (const int width : {5, 8, 200, 1000}) {  // below 8 pixels: flat
    const ImageRgb image = sample_image(width, 9);
    const std::string bytes = radiance_bytes(image, sample_metadata());
    const ImageRgb back =
        decode_radiance({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}, {}, "x");
    ASSERT_EQ(back.width, width);
    for (size_t i = 0; i < image.pixels.size(); ++i)
      for (int c = 0; c < 3; ++c)
        // Truncated to 1/256 of the power of two above the brightest channel, read as the middle.
        ASSERT_NEAR(back.pixels[i][c], image.pixels[i][c], max_component(image.pixels[i]) * 1.001f / 256)
            << i;
    EXPECT_NE(bytes.find("# note: zwei Zeilen: Wände\n"), std::string::npos);
    EXPECT_NE(bytes.find("# spp: 32\n"), std::string::npos);
    EXPECT_NE(bytes.find("\nFORMAT=32-bit_rle_rgbe\n\n-Y 9 +X "), std::string::npos);
  }
}

TEST(RadianceWriter, SurvivesTheEndsOfTheRange) {
  ImageRgb image(9, 1);
  const float values[] = {
      1e-30f, 6e-39f, 1e-37f, 3e38f, 1e30f, -1, infinity, std::numeric_limits<float>::quiet_NaN(), 0};
  for (int x = 0; x < 9; ++x) image.at(x, 0) = Vec3(values[x], values[x] / 2, 0);
  const std::string bytes = radiance_bytes(image, {});
  const ImageRgb back =
      decode_radiance({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}, {}, "x");
  for (const int x : {0, 2, 4}) {
    EXPECT_NEAR(back.at(x, 0).x, values[x], 0.01f * values[x]);
    EXPECT_NEAR(back.at(x, 0).y, values[x] / 2, 0.01f * values[x]);
  }
  EXPECT_GT(back.at(3, 0).x, 1e38f);  // clipped at the format's largest
  EXPECT_LT(back.at(1, 0).x, 1e-38f);
  for (const int x : {5, 6, 7, 8}) EXPECT_EQ(back.at(x, 0), Vec3(0)) << x;
}

uint32_t big_endian_at(const std::string& bytes, size_t at) {
  uint32_t value = 0;
  for (size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<uint8_t>(bytes[at + i]);
  return value;
}

/// CRC-32 (ISO 3309) by long division, a bit at a time.
uint32_t slow_crc(const std::string& bytes) {
  uint32_t remainder = 0xffffffffu;
  for (const char c : bytes)
    for (int bit = 0; bit < 8; ++bit) {
      const bool carry = ((remainder ^ (static_cast<uint8_t>(c) >> bit)) & 1) != 0;
      remainder = remainder >> 1 ^ (carry ? 0xedb88320u : 0u);
    }
  return ~remainder;
}

TEST(PngWriter, HasWholeChunksWithTextAndReadsBack) {
  ImageRgba8 image{3, 2, {}};
  for (int i = 0; i < 24; ++i) image.bytes.push_back(static_cast<uint8_t>(i % 4 == 3 ? 255 : 10 * i));
  const std::string png = png_bytes(image, sample_metadata());
  std::vector<std::string> kinds;
  size_t at = 8;
  while (at < png.size()) {
    const uint32_t length = big_endian_at(png, at);
    ASSERT_LE(at + 12 + length, png.size());
    kinds.push_back(png.substr(at + 4, 4));
    EXPECT_EQ(big_endian_at(png, at + 8 + length), slow_crc(png.substr(at + 4, 4 + length))) << kinds.back();
    at += 12 + length;
  }
  EXPECT_EQ(kinds.front(), "IHDR");
  EXPECT_EQ(kinds.back(), "IEND");
  EXPECT_EQ(slow_crc("123456789"), 0xcbf43926u);  // the check value of the catalogue of CRCs
  EXPECT_NE(png.find(std::string("tEXtscene\0bedroom", 17)), std::string::npos);
  // UTF-8 has a chunk of its own kind.
  EXPECT_NE(png.find(std::string("iTXtnote\0\0\0\0\0zwei", 17)), std::string::npos);
  const ImageRgba8 back =
      decode_ldr({reinterpret_cast<const uint8_t*>(png.data()), png.size()}, {}, "x.png", "");
  EXPECT_EQ(back.width, 3);
  EXPECT_EQ(back.bytes, image.bytes);
}

TEST(WriteImage, ChoosesByTheEnding) {
  const TemporaryFolder folder;
  const ImageRgb image(9, 4, Vec3(0.25f));
  for (const char* name : {"a.exr", "a.hdr", "a.png", "b.EXR", "b.Png"})
    write_image(folder.path() / name, image, {}, {});
  EXPECT_EQ(read_image(folder.path() / "b.EXR", {}).at(0, 0), Vec3(0.25f));
  EXPECT_NEAR(read_image(folder.path() / "a.hdr", {}).at(0, 0).x, 0.25f, 0.001f);
  EXPECT_NEAR(read_image(folder.path() / "a.png", {}).at(0, 0).x, 0.25f, 0.003f);
  write_image(folder.path() / "c.png", image, {1, "linear"}, {});  // exposure only shows in 8 bits
  EXPECT_NEAR(read_image(folder.path() / "c.png", {}).at(0, 0).x, 0.5f, 0.003f);
  const auto [code, told] = failure_of([&] { write_image(folder.path() / "a.jpg", image, {}, {}); });
  EXPECT_EQ(code, ExitCode::usage);
  EXPECT_NE(told.find(".exr, .hdr, .png"), std::string::npos) << told;
  EXPECT_EQ(failure_of([&] { write_image(folder.path() / "a", image, {}, {}); }).first, ExitCode::usage);
  EXPECT_EQ(failure_of([&] {
              write_image(folder.path() / "a.png", image, {0, "sepia"}, {});
            }).first,
            ExitCode::usage);
  EXPECT_EQ(files_in(folder.path()), 6u);
}

TEST(AtomicWrite, ReplacesWholeAndKeepsLinks) {
  const TemporaryFolder folder;
  const fs::path target = folder.write("target", "before"), link = folder.path() / "link";
  fs::create_symlink("target", link);
  write_bytes_atomically(link, "after");
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(read_file(target, 100).size(), 5u);
  write_text_atomically(target, "");
  EXPECT_EQ(fs::file_size(target), 0u);
  EXPECT_EQ(files_in(folder.path()), 2u);
  // As other programs' files: what the mask allows.
  const mode_t mask = umask(022);
  umask(mask);
  write_text_atomically(folder.path() / "new", "x");
  EXPECT_EQ(static_cast<unsigned>(fs::status(folder.path() / "new").permissions()), 0666u & ~mask);
}

TEST(AtomicWrite, FailuresNameTheReason) {
  const TemporaryFolder folder;
  const auto expect = [&](const fs::path& path, const std::string& reason) {
    const auto [code, told] = failure_of([&] { write_text_atomically(path, "x"); });
    EXPECT_EQ(code, ExitCode::failure) << path;
    EXPECT_NE(told.find(path.string() + ": cannot write: "), std::string::npos) << told;
    EXPECT_NE(told.find(reason), std::string::npos) << told;
  };
  expect(folder.path(), "it is a folder");
  expect(folder.path() / "none" / "x.png", "No such file");
  expect(folder.write("file", "") / "x.png", "Not a directory");
  if (fs::exists("/dev/full")) {
    expect("/dev/full", "No space left");
    const fs::path full = folder.path() / "full.exr";
    fs::create_symlink("/dev/full", full);
    for (const char* name : {"full.exr", "full.hdr", "full.png"}) {
      const fs::path path = folder.path() / name;
      if (path != full) fs::create_symlink("/dev/full", path);
      const auto [code, told] = failure_of([&] { write_image(path, ImageRgb(9, 4), {}, {}); });
      EXPECT_EQ(code, ExitCode::failure);
      EXPECT_NE(told.find("No space left"), std::string::npos) << told;
    }
  }
}

TEST(AtomicWrite, AFullDiskLeavesTheOldFileAndNothingElse) {
  const TemporaryFolder folder;
  const fs::path path = folder.write("a.exr", "the old picture");
  // A limit on file sizes stands for the full disk.
  signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{20000, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  const ImageRgb image = sample_image(200, 200);
  const auto failed = failure_of([&] { write_exr(path, image, {}); });
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_EQ(failed.first, ExitCode::failure);
  EXPECT_NE(failed.second.find("a.exr: cannot write: File too large"), std::string::npos) << failed.second;
  EXPECT_EQ(fs::file_size(path), 15u);
  EXPECT_EQ(files_in(folder.path()), 1u);
}

TEST(AtomicWrite, GoesStraightIntoAPipe) {
  const TemporaryFolder folder;
  const fs::path pipe = folder.path() / "pipe.exr";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  ImageRgb back;
  std::thread reader([&] { back = read_image(pipe, {}); });
  const ImageRgb image = sample_image(200, 100);
  write_image(pipe, image, {}, {});
  reader.join();
  EXPECT_EQ(back.pixels, image.pixels);
  EXPECT_TRUE(fs::is_fifo(pipe));
}

}  // namespace
}  // namespace halflight
