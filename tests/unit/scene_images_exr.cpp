// OpenEXR files of the kinds that only the library writes: half floats, tiles, several parts, deep pixels;
// and small files with large claims.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDeepFrameBuffer.h>
#include <OpenEXR/ImfDeepScanLineOutputPart.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <OpenEXR/ImfTiledOutputPart.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <array>
#include <functional>

#include "scene/image_files.h"
#include "support/exr_fixture.h"
#include "support/temporary_folder.h"

namespace halflight {
namespace {

namespace fs = std::filesystem;

constexpr int width = 70, height = 45;
constexpr const char* channel_names[] = {"R", "G", "B"};

/// Channel c of pixel x, y: whole numbers below 2048, which a half float holds.
float value_at(int c, int x, int y) { return static_cast<float>(600 * c + 4 * x + 6 * y); }

/// Pixels of one type, channel after channel, and the buffer that describes them.
template <class T>
struct Planes {
  std::array<std::vector<T>, 3> values;
  Imf::FrameBuffer buffer;

  explicit Planes(Imf::PixelType type) {
    for (int c = 0; c < 3; ++c) {
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) values[c].push_back(static_cast<T>(value_at(c, x, y)));
      buffer.insert(channel_names[c], Imf::Slice(type, reinterpret_cast<char*>(values[c].data()), sizeof(T),
                                                 sizeof(T) * width));
    }
  }
};

Imf::Header header_of(Imf::PixelType type, Imf::Compression compression = Imf::ZIP_COMPRESSION) {
  Imf::Header header(width, height);
  header.compression() = compression;
  for (const char* name : channel_names) header.channels().insert(name, Imf::Channel(type));
  return header;
}

void expect_picture(const ImageRgb& image, const std::string& what, float tolerance = 0) {
  ASSERT_EQ(image.width, width) << what;
  ASSERT_EQ(image.height, height) << what;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(image.at(x, y)[c], value_at(c, x, y), tolerance) << what << " " << x << " " << y;
}

TEST(ExrKinds, EveryCompressionOfHalfAndFloat) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.exr";
  for (const Imf::Compression compression :
       {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIPS_COMPRESSION, Imf::ZIP_COMPRESSION,
        Imf::PIZ_COMPRESSION, Imf::PXR24_COMPRESSION, Imf::B44_COMPRESSION, Imf::B44A_COMPRESSION,
        Imf::DWAA_COMPRESSION, Imf::DWAB_COMPRESSION}) {
    // B44 and DWA lose digits of halves.
    const bool lossy = compression >= Imf::B44_COMPRESSION;
    {
      Planes<Imath::half> planes(Imf::HALF);
      Imf::OutputFile file(path.c_str(), header_of(Imf::HALF, compression));
      file.setFrameBuffer(planes.buffer);
      file.writePixels(height);
    }
    expect_picture(read_image(path, {}), "half, compression " + std::to_string(compression), lossy ? 40 : 0);
    {
      Planes<float> planes(Imf::FLOAT);
      Imf::OutputFile file(path.c_str(), header_of(Imf::FLOAT, compression));
      file.setFrameBuffer(planes.buffer);
      file.writePixels(height);
    }
    expect_picture(read_image(path, {}), "float, compression " + std::to_string(compression), lossy ? 40 : 0);
  }
}

TEST(ExrKinds, WholeNumbersAndRisingOrFallingLines) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.exr";
  for (const Imf::LineOrder order : {Imf::INCREASING_Y, Imf::DECREASING_Y}) {
    {
      Planes<uint32_t> planes(Imf::UINT);
      Imf::Header header = header_of(Imf::UINT);
      header.lineOrder() = order;
      Imf::OutputFile file(path.c_str(), header);
      file.setFrameBuffer(planes.buffer);
      file.writePixels(height);
    }
    expect_picture(read_image(path, {}), "whole numbers");
  }
}

TEST(ExrKinds, TilesOfAnySizeAndTheFinestOfTheirLevels) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.exr";
  for (const auto& [tile_width, tile_height] : {std::pair{16u, 16u}, {7u, 11u}, {128u, 64u}, {70u, 1u}})
    for (const Imf::LevelMode mode : {Imf::ONE_LEVEL, Imf::MIPMAP_LEVELS}) {
      {
        Planes<float> planes(Imf::FLOAT);
        Imf::Header header = header_of(Imf::FLOAT);
        header.setTileDescription({tile_width, tile_height, mode});
        Imf::TiledOutputFile file(path.c_str(), header);
        file.setFrameBuffer(planes.buffer);
        for (int level = 0; level < file.numLevels(); ++level)
          file.writeTiles(0, file.numXTiles(level) - 1, 0, file.numYTiles(level) - 1, level);
      }
      expect_picture(read_image(path, {}), fmt::format("tiles {} x {}", tile_width, tile_height));
    }
}

/// A deep part, then one without colour, then the picture: as compositors write them.
TEST(ExrKinds, TheFirstFlatPartWithColourIsThePicture) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.exr";
  for (const bool tiled : {false, true}) {
    Imf::Header deep = header_of(Imf::FLOAT, Imf::ZIPS_COMPRESSION), depth(width, height),
                color = header_of(Imf::FLOAT);
    deep.setName("deep"), depth.setName("depth"), color.setName("color");
    deep.setType(Imf::DEEPSCANLINE), depth.setType(Imf::SCANLINEIMAGE);
    color.setType(tiled ? Imf::TILEDIMAGE : Imf::SCANLINEIMAGE);
    if (tiled) color.setTileDescription({32, 32, Imf::ONE_LEVEL});
    depth.channels().insert("Z", Imf::Channel(Imf::FLOAT));
    const Imf::Header headers[] = {deep, depth, color};
    {
      Imf::MultiPartOutputFile file(path.c_str(), headers, 3);
      std::vector<unsigned> counts(width * height, 1);
      std::vector<float> sample(1, 99);
      std::vector<float*> pointers(width * height, sample.data());
      Imf::DeepFrameBuffer deep_buffer;
      deep_buffer.insertSampleCountSlice(Imf::Slice(Imf::UINT, reinterpret_cast<char*>(counts.data()),
                                                    sizeof(unsigned), sizeof(unsigned) * width));
      for (const char* name : channel_names)
        deep_buffer.insert(name, Imf::DeepSlice(Imf::FLOAT, reinterpret_cast<char*>(pointers.data()),
                                                sizeof(float*), sizeof(float*) * width, sizeof(float)));
      Imf::DeepScanLineOutputPart deep_part(file, 0);
      deep_part.setFrameBuffer(deep_buffer);
      deep_part.writePixels(height);

      Planes<float> planes(Imf::FLOAT);
      Imf::FrameBuffer z;
      z.insert("Z", planes.buffer["R"]);
      Imf::OutputPart depth_part(file, 1);
      depth_part.setFrameBuffer(z);
      depth_part.writePixels(height);
      if (tiled) {
        Imf::TiledOutputPart part(file, 2);
        part.setFrameBuffer(planes.buffer);
        part.writeTiles(0, part.numXTiles() - 1, 0, part.numYTiles() - 1);
      } else {
        Imf::OutputPart part(file, 2);
        part.setFrameBuffer(planes.buffer);
        part.writePixels(height);
      }
    }
    expect_picture(read_image(path, {}), tiled ? "tiled part" : "part of lines");
  }
}

struct Claim {
  const char* what;
  std::string bytes;
  const char* told;
};

/// Within the limit on pixels, but a few hundred bytes that would take gigabytes.
std::vector<Claim> large_claims() {
  constexpr int32_t wide = (1 << 24) - 1, side = 16383;
  std::vector<Claim> claims;
  const auto add = [&](const char* what, const char* told, const std::function<void(ExrFile&)>& change) {
    ExrFile file = small_exr();
    change(file);
    claims.push_back({what, file.header() + std::string(400, '\1'), told});
  };
  add("long lines", "truncated", [](ExrFile& f) { f.data = f.display = {0, 0, wide, 15}; });
  add("many lines", "truncated", [](ExrFile& f) { f.data = f.display = {0, 0, 15, wide}; });
  add("many short lines", "truncated", [](ExrFile& f) { f.data = f.display = {0, 0, side, side}; });
  add("long lines in blocks", "header: blocks of 16 lines", [](ExrFile& f) {
    f.data = f.display = {0, 0, wide, 15};
    f.compression = 3;
  });
  add("long lines of luminance and chroma", "luminance and chroma are read up to", [](ExrFile& f) {
    f.data = f.display = {0, 0, wide, 15};
    f.channels = {{"BY", 1, 2, 2}, {"RY", 1, 2, 2}, {"Y", 1}};
  });
  add("tiles of one pixel", "truncated", [](ExrFile& f) {
    f.data = f.display = {0, 0, side, side};
    f.version = 0x202;
    f.more = ExrFile::attribute("tiles", "tiledesc", little(1) + little(1) + '\0');
  });
  ExrFile file = small_exr();
  file.display = {0, 0, side, side};
  claims.push_back({"a large display window about little", file.bytes(),
                    "displayWindow: 16384 x 16384 pixels, of which only 4 x 2 are in the file"});
  return claims;
}

TEST(ExrClaims, AreRefusedBeforeMemoryIsTaken) {
  for (const Claim& claim : large_claims()) {
    const pid_t child = fork();  // its peak memory is its own
    ASSERT_GE(child, 0);
    if (child == 0) {
      bool told = false;
      try {
        decode_exr({reinterpret_cast<const uint8_t*>(claim.bytes.data()), claim.bytes.size()}, {}, "x.exr");
      } catch (const Error& error) {
        told = error.code() == ExitCode::bad_input &&
               std::string(error.what()).find(claim.told) != std::string::npos;
        if (!told) std::fprintf(stderr, "%s\n", error.what());
      }
      _exit(told ? 0 : 10);
    }
    int status = -1;
    rusage usage{};
    wait4(child, &status, 0, &usage);
    ASSERT_TRUE(WIFEXITED(status)) << claim.what;
    EXPECT_EQ(WEXITSTATUS(status), 0) << claim.what;
    EXPECT_LT(usage.ru_maxrss, 1 << 20) << claim.what;  // kilobytes
  }
}

TEST(ExrClaims, ASmallPictureInALargeDisplayIsFine) {
  ExrFile file = small_exr();
  file.display = {0, 0, 3839, 2159};
  const std::string bytes = file.bytes();
  const ImageRgb image =
      decode_exr({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}, {}, "x.exr");
  EXPECT_EQ(image.width, 3840);
  EXPECT_EQ(image.at(3, 1), Vec3(132, 131, 130));
  EXPECT_EQ(image.at(4, 1), Vec3(0));
}

}  // namespace
}  // namespace halflight
