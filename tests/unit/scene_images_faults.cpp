// Malformed .hdr and .exr files, made here, each with what must become of it.
#include <gtest/gtest.h>

#include <functional>

#include "core/random.h"
#include "film/image_writers.h"
#include "scene/image_files.h"
#include "support/exr_fixture.h"
#include "support/temporary_folder.h"

namespace halflight {
namespace {

struct Fault {
  const char* what;
  std::string bytes;
  const char* told;  ///< part of the message; empty: the file is read
};

std::string pixels(int count) {
  std::string text;
  for (int i = 0; i < count; ++i) text += {'\x40', '\x20', static_cast<char>(16 + i % 64), '\x80'};
  return text;
}

std::string hdr(const std::string& header, const std::string& resolution, const std::string& body) {
  return "#?RADIANCE\n" + header + "\n" + resolution + "\n" + body;
}

const std::string format = "FORMAT=32-bit_rle_rgbe\n";
const std::string marked8 = {'\2', '\2', '\0', '\x8'};

std::vector<Fault> radiance_faults() {
  const std::string run8 = "\x88\x10", line8 = marked8 + run8 + run8 + run8 + run8;
  return {
      {"nothing behind the mark", "#?RADIANCE\n", "header: ends before the blank line"},
      {"header without end", "#?RADIANCE\n" + format, "header: ends before the blank line"},
      {"a header line without end", "#?RADIANCE\n" + std::string(100000, 'x'),
       "header: ends before the blank line"},
      {"no resolution line", "#?RADIANCE\n\n", "resolution line: missing"},
      {"resolution without newline", "#?RADIANCE\n\n-Y 1 +X 1", "resolution line: missing"},
      {"no picture's format", hdr("FORMAT=ascii\n", "-Y 1 +X 1", pixels(1)), "FORMAT ascii is not a picture"},
      {"exposure 0", hdr("EXPOSURE=0\n", "-Y 1 +X 1", pixels(1)), "EXPOSURE is not a positive number"},
      {"exposure of letters", hdr("EXPOSURE=bright\n", "-Y 1 +X 1", pixels(1)),
       "EXPOSURE is not a positive number"},
      {"exposure infinite", hdr("EXPOSURE=inf\n", "-Y 1 +X 1", pixels(1)),
       "EXPOSURE is not a positive number"},
      {"exposure tiny", hdr("EXPOSURE=1e-300\n", "-Y 1 +X 1", pixels(1)), ""},
      {"exposures whose product is 0", hdr("EXPOSURE=1e-200\nEXPOSURE=1e-200\n", "-Y 1 +X 1", pixels(1)),
       "the product of the EXPOSURE lines is no number"},
      {"colour corrections whose product is infinite",
       hdr("COLORCORR=1 1e200 1\nCOLORCORR=1 1e200 1\n", "-Y 1 +X 1", pixels(1)),
       "the product of the COLORCORR lines is no number"},
      {"two colour corrections", hdr("COLORCORR=1 2\n", "-Y 1 +X 1", pixels(1)), "COLORCORR is not three"},
      {"no sizes", hdr(format, "-Y +X", pixels(1)), "is not of the form"},
      {"same axis twice", hdr(format, "-Y 1 +Y 1", pixels(1)), "is not of the form"},
      {"a third size", hdr(format, "-Y 1 +X 1 +Z 1", pixels(1)), "is not of the form"},
      {"0 x 0", hdr(format, "-Y 0 +X 0", ""), "0 x 0 is no picture size"},
      {"negative size", hdr(format, "-Y 1 +X -5", pixels(1)), "-5 x 1 is no picture size"},
      {"size beyond 64 bits", hdr(format, "-Y 99999999999999999999 +X 1", pixels(1)), "is no picture size"},
      {"40000 x 40000", hdr(format, "-Y 40000 +X 40000", pixels(1)), "exceed --limit-image-pixels"},
      {"a claim the file cannot hold", hdr(format, "-Y 16000 +X 16000", pixels(100)), "bytes cannot hold"},
      {"a line of 2^27", hdr(format, "-Y 1 +X 134217728", pixels(1)), "bytes cannot hold"},
      {"flat pixels cut short", hdr(format, "-Y 3 +X 4", pixels(11)), "scan line 2: truncated"},
      {"flat pixels cut inside one", hdr(format, "-Y 1 +X 4", pixels(4).substr(0, 15)),
       "scan line 0: truncated"},
      {"first pixel is a repeat", hdr(format, "-Y 1 +X 4", "\1\1\1\3" + pixels(3)),
       "a repeat with nothing to repeat"},
      {"repeat past the end", hdr(format, "-Y 1 +X 4", pixels(1) + "\1\1\1\4"),
       "goes past the end of the line"},
      {"repeats shifted away",
       hdr(format, "-Y 1 +X 4",
           pixels(1) + std::string(5 * 4, '\1')
                           .replace(3, 1, 1, '\0')
                           .replace(7, 1, 1, '\0')
                           .replace(11, 1, 1, '\0')
                           .replace(15, 1, 1, '\0')
                           .replace(19, 1, 1, '\0')),
       "a repeat with nothing to repeat"},
      {"new runs, good", hdr(format, "-Y 1 +X 8", line8), ""},
      {"new runs of another length", hdr(format, "-Y 1 +X 9", line8 + pixels(9)),
       "its length is not the picture's"},
      {"new runs cut short", hdr(format, "-Y 2 +X 8", line8 + line8.substr(0, 9)), "scan line 1: truncated"},
      {"a run past the line's end", hdr(format, "-Y 1 +X 8", marked8 + "\x89\x10" + run8 + run8 + run8),
       "scan line 0: a run goes past the end"},
      {"literals past the line's end", hdr(format, "-Y 1 +X 8", marked8 + "\x09" + std::string(40, 'x')),
       "scan line 0: a run goes past the end"},
      {"literals cut short", hdr(format, "-Y 1 +X 8", marked8 + "\x08" + "abc"), "scan line 0: truncated"},
      {"a run of length 0", hdr(format, "-Y 1 +X 8", marked8 + std::string(30, '\0')), "a run of length 0"},
  };
}

ExrFile with(std::function<void(ExrFile&)> change) {
  ExrFile file = small_exr();
  change(file);
  return file;
}

/// A header with an attribute more, of any size it claims.
std::string attribute(const std::string& name, const std::string& type, const std::string& value,
                      int32_t size) {
  return with([&](ExrFile& f) { f.more = name + '\0' + type + '\0' + little(size) + value; }).header();
}

std::vector<Fault> exr_faults() {
  const auto windows = [](ExrWindow window) {
    return with([&](ExrFile& f) { f.data = f.display = window; }).header() + std::string(64, '\0');
  };
  const std::string good = small_exr().bytes();
  std::string wrong_table = good;
  for (size_t i = 0; i < 8; ++i) wrong_table[small_exr().header().size() + i] = '\x7f';
  const std::string tiles =
      ExrFile::attribute("tiles", "tiledesc", little(uint32_t{1} << 20) + little(uint32_t{1} << 20) + '\0');
  const float nan = std::numeric_limits<float>::quiet_NaN();
  return {
      {"good", good, ""},
      {"values that are not finite",
       with([&](ExrFile& f) { f.pixels[3] = nan, f.pixels[5] = infinity; }).bytes(), ""},
      {"mark alone", good.substr(0, 4), "header: truncated"},
      {"header cut short", good.substr(0, 100), "truncated"},
      {"no table of offsets", small_exr().header(), "OpenEXR: "},
      {"pixels cut short", good.substr(0, good.size() - 10), "OpenEXR: "},
      {"offsets that lead nowhere", wrong_table, "OpenEXR: "},
      {"version 3", with([](ExrFile& f) { f.version = 3; }).bytes(), "OpenEXR: "},
      {"0 wide", windows({5, 0, 4, 0}), "dataWindow: 0 x 1 is no picture size"},
      {"40000 x 40000", windows({0, 0, 39999, 39999}),
       "dataWindow: 40000 x 40000 pixels exceed --limit-image-pixels"},
      {"sizes that wrap", windows({-2147483647, 0, 2147483647, 0}),
       "dataWindow: 4294967295 x 1 pixels: sides end at"},
      {"a claim the file cannot hold", windows({0, 0, 15999, 15999}), "OpenEXR: "},
      {"display window enormous", with([](ExrFile& f) {
                                    f.display = {0, 0, 99999, 99999};
                                  }).bytes(),
       "displayWindow: "},
      {"display window elsewhere", with([](ExrFile& f) {
                                     f.display = {100, 100, 103, 101};
                                   }).bytes(),
       "dataWindow: lies outside the display window"},
      {"no colour", with([](ExrFile& f) {
                      f.channels = {{"A"}, {"Z"}, {"id"}};
                    }).bytes(),
       "no flat part with R, G and B"},
      {"red alone", with([](ExrFile& f) {
                      f.channels = {{"R"}, {"S"}, {"T"}};
                    }).bytes(),
       "no flat part with R, G and B"},
      {"subsampled colour", with([](ExrFile& f) { f.channels[0].x_sampling = 2; }).bytes(),
       "channel B: subsampled"},
      {"sampling 0", with([](ExrFile& f) { f.channels[0].x_sampling = 0; }).bytes(), "OpenEXR: "},
      {"pixels of no type", with([](ExrFile& f) { f.channels[0].type = 9; }).bytes(), "made.exr: "},
      {"compression of no kind", with([](ExrFile& f) { f.compression = 77; }).bytes(), "OpenEXR: "},
      {"deep", with([](ExrFile& f) {
                 f.version = 0x802;
                 f.more = ExrFile::attribute("type", "string", "deepscanline") +
                          ExrFile::attribute("version", "int", little(1)) +
                          ExrFile::attribute("chunkCount", "int", little(2)) +
                          ExrFile::attribute("maxSamplesPerPixel", "int", little(1)) +
                          ExrFile::attribute("name", "string", "x");
               }).bytes(),
       "made.exr: "},
      {"tiles of 2^20 squared", with([&](ExrFile& f) { f.version = 0x202, f.more = tiles; }).bytes(),
       "made.exr: "},
      {"an attribute of 2 GiB", attribute("a", "string", "", 0x7fffffff),
       "a: truncated: needs 2147483647 bytes"},
      {"an attribute of negative size", attribute("a", "string", "", -1), "a: -1 bytes are no size"},
      {"a text of 2 GiB among texts", attribute("a", "stringvector", little(0x7fffffff), 4),
       "a: a text goes past"},
      {"a preview of 2^60 pixels", attribute("preview", "preview", little(1 << 30) + little(1 << 30), 8),
       "preview: its size"},
      {"a name without end", with([](ExrFile& f) { f.more = std::string(400, 'n'); }).header(),
       "a name without end"},
      {"a table of 2^31 blocks", attribute("chunkCount", "int", little(0x7fffffff), 4),
       "chunkCount: 2147483647 blocks do not fit"},
  };
}

/// What reading gives: the message, or nothing; exit code 3 always.
std::string outcome(const std::string& bytes, const LoadLimits& limits, bool is_exr) {
  const std::span<const uint8_t> span{reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()};
  try {
    const ImageRgb image =
        is_exr ? decode_exr(span, limits, "made.exr") : decode_radiance(span, limits, "made.hdr");
    EXPECT_EQ(image.pixels.size(), static_cast<size_t>(image.width) * static_cast<size_t>(image.height));
    EXPECT_GT(image.pixels.size(), 0u);
    return "";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::bad_input);
    const std::string text = error.what();
    EXPECT_EQ(text.rfind(is_exr ? "made.exr: " : "made.hdr: ", 0), 0u) << text;
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    return text;
  }
}

void expect_faults(const std::vector<Fault>& faults, bool is_exr) {
  for (const Fault& fault : faults) {
    const std::string told = outcome(fault.bytes, {}, is_exr);
    if (*fault.told == '\0')
      EXPECT_EQ(told, "") << fault.what;
    else
      EXPECT_NE(told.find(fault.told), std::string::npos) << fault.what << ": " << told;
  }
}

TEST(MalformedRadiance, EachHasItsOutcome) { expect_faults(radiance_faults(), false); }

TEST(MalformedExr, EachHasItsOutcome) { expect_faults(exr_faults(), true); }

ImageRgb noise(int width, int height) {
  ImageRgb image(width, height);
  RandomStream random(1, 1, 1);
  // Half of it constant, so that runs and literals both occur.
  for (size_t i = 0; i < image.pixels.size(); ++i)
    image.pixels[i] = i % 32 < 16 ? Vec3(0.5f) : Vec3(random.next(), random.next(), 10 * random.next());
  return image;
}

TEST(MalformedRadiance, EveryTruncationIsAnError) {
  const std::string good = radiance_bytes(noise(32, 3), {});
  ASSERT_EQ(outcome(good, {}, false), "");
  for (size_t size = 0; size < good.size(); ++size)
    ASSERT_NE(outcome(good.substr(0, size), {}, false), "") << size;
}

TEST(MalformedExr, EveryTruncationIsAnError) {
  const std::string good = exr_bytes(noise(32, 40), {});
  ASSERT_EQ(outcome(good, {}, true), "");
  for (size_t size = 0; size < good.size(); size += size < 600 ? 7 : 53)
    ASSERT_NE(outcome(good.substr(0, size), {}, true), "") << size;
}

/// Any bytes: a picture or an error, within the limits. The sanitizers watch.
TEST(MalformedImages, RandomDamageIsAPictureOrAnError) {
  LoadLimits limits;
  limits.image_pixels = 1 << 20;
  const std::string files[] = {radiance_bytes(noise(40, 6), {}), exr_bytes(noise(40, 20), {}),
                               small_exr().bytes()};
  size_t read = 0, refused = 0;
  for (uint64_t i = 0; i < 3000; ++i) {
    RandomStream random(i, 0, 7);
    const size_t which = i % 3;
    std::string bytes = files[which];
    for (int changes = 1 + static_cast<int>(4 * random.next()); changes > 0; --changes) {
      // Headers more often than pixels.
      const float u = random.next();
      const size_t reach = u < 0.7f ? std::min<size_t>(bytes.size(), 420) : bytes.size();
      bytes[static_cast<size_t>(random.next() * static_cast<float>(reach))] =
          static_cast<char>(256 * random.next());
    }
    ++(outcome(bytes, limits, which > 0).empty() ? read : refused);
  }
  EXPECT_GT(read, 300u);
  EXPECT_GT(refused, 300u);
}

TEST(ReadImage, RefusesWhatIsNoPicture) {
  const TemporaryFolder folder;
  const auto told = [&](const std::string& bytes) -> std::string {
    try {
      read_image(folder.write("x.hdr", bytes), {});
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::bad_input);
      return error.what();
    }
    return "";
  };
  EXPECT_NE(told("").find("x.hdr: the file is empty"), std::string::npos);
  EXPECT_NE(told("hello").find("x.hdr: not Radiance, OpenEXR, PNG, JPEG or WebP"), std::string::npos);
  EXPECT_NE(told("\x89PNG\r\n\x1a\n").find("x.hdr: "), std::string::npos);
}

}  // namespace
}  // namespace halflight
