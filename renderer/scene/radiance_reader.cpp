// Radiance pictures (Ward 1991; the format is described in Radiance's file format notes): header lines, a
// resolution line that also gives the order of axes, then scan lines flat or in one of two run-length forms.
#include <cstdlib>
#include <cstring>
#include <limits>
#include <optional>

#include "scene/image_files.h"

namespace halflight {

namespace {

/// The four bytes of a pixel: three mantissas and a shared exponent.
struct Rgbe {
  uint8_t r, g, b, e;
};

enum class ColorSpace { rgb, xyz };

struct Header {
  int width = 0, height = 0;
  bool column_major = false;            ///< the line starts with X: scan lines are columns
  bool flip_x = false, flip_y = false;  ///< against left to right, top to bottom
  ColorSpace space = ColorSpace::rgb;
  double exposure = 1;
  Vec3d color_correction{1};

  size_t line_length() const { return static_cast<size_t>(column_major ? height : width); }
  size_t line_count() const { return static_cast<size_t>(column_major ? width : height); }
};

class RadianceReader {
 public:
  RadianceReader(std::span<const uint8_t> bytes, const LoadLimits& limits, std::string_view file)
      : bytes_(bytes), limits_(limits), file_(file) {}

  ImageRgb read();

 private:
  [[noreturn]] void fail(std::string_view place, std::string_view reason) const {
    throw input_error(file_, place, reason);
  }
  std::optional<std::string> next_line();
  void read_header();
  void read_variable(const std::string& line);
  void read_resolution(const std::string& line);
  void read_scan_line(size_t line, std::vector<Rgbe>& out);
  void read_new_runs(const std::string& place, std::vector<Rgbe>& out);
  void read_old_runs(const std::string& place, std::vector<Rgbe>& out);
  Vec3 to_radiance(Rgbe) const;

  bool has(size_t count) const { return bytes_.size() - at_ >= count; }

  std::span<const uint8_t> bytes_;
  const LoadLimits& limits_;
  std::string_view file_;
  size_t at_ = 0;
  Header header_;
};

std::optional<std::string> RadianceReader::next_line() {
  constexpr size_t longest = 65536;
  const size_t end = std::min(bytes_.size(), at_ + longest);
  for (size_t i = at_; i < end; ++i) {
    if (bytes_[i] != '\n') continue;
    std::string line(bytes_.begin() + static_cast<ptrdiff_t>(at_),
                     bytes_.begin() + static_cast<ptrdiff_t>(i));
    if (!line.empty() && line.back() == '\r') line.pop_back();
    at_ = i + 1;
    return line;
  }
  return {};
}

void RadianceReader::read_variable(const std::string& line) {
  const auto value_of = [&](std::string_view key) -> const char* {
    return line.compare(0, key.size(), key) == 0 ? line.c_str() + key.size() : nullptr;
  };
  if (const char* format = value_of("FORMAT=")) {
    const std::string name = format + std::strspn(format, " ");
    if (name.starts_with("32-bit_rle_rgbe"))
      header_.space = ColorSpace::rgb;
    else if (name.starts_with("32-bit_rle_xyze"))
      header_.space = ColorSpace::xyz;
    else
      fail("header", fmt::format("FORMAT {} is not a picture", name));
  } else if (const char* exposure = value_of("EXPOSURE=")) {
    const double value = std::strtod(exposure, nullptr);
    if (!(value > 0) || !std::isfinite(value)) fail("header", "EXPOSURE is not a positive number");
    header_.exposure *= value;  // several lines multiply
    if (!(header_.exposure > 0) || !std::isfinite(header_.exposure))
      fail("header", "the product of the EXPOSURE lines is no number");
  } else if (const char* correction = value_of("COLORCORR=")) {
    char* next = const_cast<char*>(correction);
    for (int c = 0; c < 3; ++c) {
      const double value = std::strtod(next, &next);
      if (!(value > 0) || !std::isfinite(value)) fail("header", "COLORCORR is not three positive numbers");
      double& product = header_.color_correction[c];
      product *= value;
      if (!(product > 0) || !std::isfinite(product))
        fail("header", "the product of the COLORCORR lines is no number");
    }
  }
}

void RadianceReader::read_resolution(const std::string& line) {
  char sign[2] = {}, axis[2] = {};
  long long size[2] = {};
  char rest = 0;
  const int found = std::sscanf(line.c_str(), " %c%c %lld %c%c %lld %c", &sign[0], &axis[0], &size[0],
                                &sign[1], &axis[1], &size[1], &rest);
  const auto sign_ok = [](char c) { return c == '+' || c == '-'; };
  const bool axes_ok = (axis[0] == 'Y' && axis[1] == 'X') || (axis[0] == 'X' && axis[1] == 'Y');
  if (found != 6 || !sign_ok(sign[0]) || !sign_ok(sign[1]) || !axes_ok)
    fail("resolution line", fmt::format("'{}' is not of the form -Y HEIGHT +X WIDTH", line.substr(0, 60)));
  header_.column_major = axis[0] == 'X';
  const int x = header_.column_major ? 0 : 1, y = 1 - x;
  if (size[x] <= 0 || size[y] <= 0 || size[x] > 1 << 30 || size[y] > 1 << 30)
    fail("resolution line", fmt::format("{} x {} is no picture size", size[x], size[y]));
  header_.flip_x = sign[x] == '-';
  header_.flip_y = sign[y] == '+';  // Y grows upwards: -Y is from the top
  const uint64_t pixels = static_cast<uint64_t>(size[x]) * static_cast<uint64_t>(size[y]);
  if (pixels > limits_.image_pixels)
    fail("resolution line", fmt::format("{} x {} pixels exceed --limit-image-pixels {}", size[x], size[y],
                                        limits_.image_pixels));
  header_.width = static_cast<int>(size[x]), header_.height = static_cast<int>(size[y]);
}

void RadianceReader::read_header() {
  std::optional<std::string> line = next_line();
  if (!line || !line->starts_with("#?")) fail("header", "does not begin with #?");
  while ((line = next_line()) && !line->empty()) {
    if (line->front() != '#') read_variable(*line);
  }
  if (!line) fail("header", "ends before the blank line");
  line = next_line();
  if (!line) fail("resolution line", "missing");
  read_resolution(*line);
  // A size that the file cannot fill is refused before memory for it is taken. The shortest line is one pixel
  // and old repeats of it, which cover up to 255, 255 · 256, … more in four bytes each.
  uint64_t least_bytes = 4, covered = 1;
  for (uint64_t repeat = 255; covered < header_.line_length(); repeat <<= 8) {
    covered += repeat;
    least_bytes += 4;
  }
  if (bytes_.size() - at_ < least_bytes * header_.line_count())
    fail("pixels", fmt::format("truncated: {} bytes cannot hold {} x {} pixels", bytes_.size() - at_,
                               header_.width, header_.height));
}

void RadianceReader::read_new_runs(const std::string& place, std::vector<Rgbe>& out) {
  const size_t length = out.size();
  for (int channel = 0; channel < 4; ++channel) {
    for (size_t x = 0; x < length;) {
      if (!has(2)) fail(place, "truncated");
      const uint8_t count = bytes_[at_++];
      const bool run = count > 128;
      const size_t n = run ? count - 128u : count;
      if (n == 0) fail(place, "a run of length 0");
      if (n > length - x) fail(place, "a run goes past the end of the line");
      if (!run && !has(n)) fail(place, "truncated");
      for (size_t i = 0; i < n; ++i) (&out[x + i].r)[channel] = bytes_[run ? at_ : at_ + i];
      at_ += run ? 1 : n;
      x += n;
    }
  }
}

void RadianceReader::read_old_runs(const std::string& place, std::vector<Rgbe>& out) {
  int shift = 0;
  for (size_t x = 0; x < out.size();) {
    if (!has(4)) fail(place, "truncated");
    const Rgbe pixel{bytes_[at_], bytes_[at_ + 1], bytes_[at_ + 2], bytes_[at_ + 3]};
    at_ += 4;
    if (pixel.r == 1 && pixel.g == 1 &&
        pixel.b == 1) {  // repeat the pixel before; consecutive ones give higher bytes
      const size_t n = static_cast<size_t>(pixel.e) << shift;
      if (x == 0 || shift > 24) fail(place, "a repeat with nothing to repeat");
      if (n > out.size() - x) fail(place, "a run goes past the end of the line");
      std::fill_n(out.begin() + static_cast<ptrdiff_t>(x), n, out[x - 1]);
      x += n;
      shift += 8;
    } else {
      out[x++] = pixel;
      shift = 0;
    }
  }
}

void RadianceReader::read_scan_line(size_t line, std::vector<Rgbe>& out) {
  const std::string place = fmt::format("scan line {}", line);
  const size_t length = out.size();
  const bool marked = length >= 8 && length < 32768 && has(4) && bytes_[at_] == 2 && bytes_[at_ + 1] == 2 &&
                      (bytes_[at_ + 2] & 0x80) == 0;
  if (!marked) return read_old_runs(place, out);
  if ((static_cast<size_t>(bytes_[at_ + 2]) << 8 | bytes_[at_ + 3]) != length)
    fail(place, "its length is not the picture's");
  at_ += 4;
  read_new_runs(place, out);
}

Vec3 RadianceReader::to_radiance(Rgbe p) const {
  if (p.e == 0) return Vec3(0);
  // The middle of the interval each mantissa stands for, as Radiance's own readers take it.
  const double scale = std::ldexp(1.0, p.e - (128 + 8)) / header_.exposure;
  const Vec3d brightest(std::numeric_limits<float>::max());
  Vec3d c = glm::min(Vec3d(p.r + 0.5, p.g + 0.5, p.b + 0.5) * scale / header_.color_correction, brightest);
  if (header_.space == ColorSpace::xyz) {
    // CIE XYZ to linear Rec. 709 primaries, D65 white (IEC 61966-2-1).
    c = {3.2404542 * c.x - 1.5371385 * c.y - 0.4985314 * c.z,
         -0.9692660 * c.x + 1.8760108 * c.y + 0.0415560 * c.z,
         0.0556434 * c.x - 0.2040259 * c.y + 1.0572252 * c.z};
    c = glm::max(c, Vec3d(0));  // out of gamut
  }
  return Vec3(glm::min(c, brightest));
}

ImageRgb RadianceReader::read() {
  read_header();
  ImageRgb image(header_.width, header_.height);
  std::vector<Rgbe> scan_line(header_.line_length());
  for (size_t line = 0; line < header_.line_count(); ++line) {
    read_scan_line(line, scan_line);
    for (size_t i = 0; i < scan_line.size(); ++i) {
      const int along = static_cast<int>(i), down = static_cast<int>(line);
      const int x = header_.column_major ? down : along, y = header_.column_major ? along : down;
      image.at(header_.flip_x ? image.width - 1 - x : x, header_.flip_y ? image.height - 1 - y : y) =
          to_radiance(scan_line[i]);
    }
  }
  return image;
}

}  // namespace

ImageRgb decode_radiance(std::span<const uint8_t> bytes, const LoadLimits& limits, std::string_view file) {
  return RadianceReader(bytes, limits, file).read();
}

}  // namespace halflight
