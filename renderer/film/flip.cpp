// LDR-FLIP (Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images"). Numbers and
// equations are the paper's; every filter is a sum of separable ones.
#include <cmath>
#include <vector>

#include "core/errors.h"
#include "core/parallel.h"
#include "film/metrics.h"

namespace halflight {

namespace {

constexpr float pixels_a_degree = 67;
constexpr float color_exponent = 0.7f, feature_exponent = 0.5f;  // q_c, q_f
constexpr float color_knee = 0.4f, color_knee_value = 0.95f;     // p_c, p_t
constexpr float feature_width_degrees = 0.082f;                  // w, of the edge and point detectors

using Plane = std::vector<float>;
using Kernel = std::vector<float>;  ///< taps −radius … radius

struct Size {
  int width, height;
};

/// Correlation with `kernel` along x or y; borders repeat.
Plane filter(const Plane& in, Size size, const Kernel& kernel, bool along_x) {
  Plane out(in.size());
  const int radius = static_cast<int>(kernel.size() / 2);
  parallel_for(0, static_cast<size_t>(size.height), 8, [&](size_t begin, size_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < size.width; ++x) {
        float sum = 0;
        for (int k = -radius; k <= radius; ++k) {
          const int i = along_x ? std::clamp(x + k, 0, size.width - 1) : x;
          const int j = along_x ? y : std::clamp(y + k, 0, size.height - 1);
          sum += kernel[static_cast<size_t>(k + radius)] * in[static_cast<size_t>(j) * size.width + i];
        }
        out[static_cast<size_t>(y) * size.width + x] = sum;
      }
    }
  });
  return out;
}

Kernel sampled(int radius, float (*value)(float x, float parameter), float parameter) {
  Kernel kernel;
  for (int k = -radius; k <= radius; ++k) kernel.push_back(value(static_cast<float>(k), parameter));
  return kernel;
}

float sum_of(const Kernel& kernel) {
  float sum = 0;
  for (float k : kernel) sum += k;
  return sum;
}

// ---- Contrast sensitivity (section 4.1) ----

/// One Gaussian of the sensitivity function, a exp(−b f²) in frequency, at `x` pixels.
float sensitivity_profile(float x, float b) { return std::exp(-square(pi * x / pixels_a_degree) / b); }

struct SensitivityTerm {
  float a, b;
};

Plane filter_channel(const Plane& in, Size size, std::initializer_list<SensitivityTerm> terms) {
  // All channels use the radius of the widest Gaussian, b = 0.04.
  const int radius = static_cast<int>(std::ceil(3 * std::sqrt(0.04f / (2 * pi * pi)) * pixels_a_degree));
  Plane out(in.size(), 0.0f);
  float total = 0;
  for (const SensitivityTerm term : terms) {
    const Kernel kernel = sampled(radius, sensitivity_profile, term.b);
    const float weight = term.a * std::sqrt(pi / term.b);
    total += weight * square(sum_of(kernel));
    const Plane part = filter(filter(in, size, kernel, true), size, kernel, false);
    for (size_t i = 0; i < out.size(); ++i) out[i] += weight * part[i];
  }
  for (float& v : out) v /= total;
  return out;
}

// ---- Colour spaces ----

const Vec3 white_d65(0.950428545f, 1.0f, 1.088900371f);

Vec3 to_xyz(Vec3 c) {
  return {0.41238656f * c.x + 0.35759149f * c.y + 0.18045049f * c.z,
          0.21263682f * c.x + 0.71518298f * c.y + 0.0721802f * c.z,
          0.01933062f * c.x + 0.11919716f * c.y + 0.95037259f * c.z};
}

Vec3 to_rgb(Vec3 c) {
  return {3.24100326f * c.x - 1.53739899f * c.y - 0.49861587f * c.z,
          -0.96922426f * c.x + 1.87592999f * c.y + 0.04155422f * c.z,
          0.05563942f * c.x - 0.2040112f * c.y + 1.05714898f * c.z};
}

/// Linear L*a*b*-like opponent space: convolution is meaningful in it.
Vec3 to_ycxcz(Vec3 rgb) {
  const Vec3 t = to_xyz(rgb) / white_d65;
  return {116 * t.y - 16, 500 * (t.x - t.y), 200 * (t.y - t.z)};
}

Vec3 from_ycxcz(Vec3 c) {
  const float y = (c.x + 16) / 116;
  return to_rgb(Vec3(c.y / 500 + y, y, y - c.z / 200) * white_d65);
}

/// CIE L*a*b*, chroma scaled by lightness (Hunt).
Vec3 hunt_lab(Vec3 rgb) {
  constexpr float delta = 6.0f / 29;
  const auto f = [](float t) {
    return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4.0f / 29;
  };
  const Vec3 t = to_xyz(rgb) / white_d65;
  const float lightness = 116 * f(t.y) - 16;
  return {lightness, 0.01f * lightness * 500 * (f(t.x) - f(t.y)),
          0.01f * lightness * 200 * (f(t.y) - f(t.z))};
}

/// HyAB: lightness apart, chroma Euclidean.
float hyab(Vec3 a, Vec3 b) { return std::abs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z); }

/// Section 4.1.4: most of the range goes to small differences.
float redistribute(float difference) {
  static const float most = std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), color_exponent);
  const float knee = color_knee * most, value = std::pow(difference, color_exponent);
  if (value < knee) return color_knee_value / knee * value;
  return color_knee_value + (value - knee) / (most - knee) * (1 - color_knee_value);
}

// ---- Pictures ----

struct Planes {
  Plane y, cx, cz;
};

Planes split(const ImageRgb& image, float exposure) {
  Planes planes;
  for (const Vec3& pixel : image.pixels) {
    const Vec3 shown = glm::clamp(is_finite(pixel) ? pixel * exposure : Vec3(0), 0.0f, 1.0f);
    const Vec3 c = to_ycxcz(shown);
    planes.y.push_back(c.x), planes.cx.push_back(c.y), planes.cz.push_back(c.z);
  }
  return planes;
}

std::vector<Vec3> perceived(const Planes& planes, Size size) {
  const Plane y = filter_channel(planes.y, size, {{1, 0.0047f}});
  const Plane cx = filter_channel(planes.cx, size, {{1, 0.0053f}});
  const Plane cz = filter_channel(planes.cz, size, {{34.1f, 0.04f}, {13.5f, 0.025f}});
  std::vector<Vec3> lab(y.size());
  for (size_t i = 0; i < lab.size(); ++i)
    lab[i] = hunt_lab(glm::clamp(from_ycxcz({y[i], cx[i], cz[i]}), 0.0f, 1.0f));
  return lab;
}

// ---- Edges and points (section 4.2) ----

float gaussian(float x, float sigma) { return std::exp(-x * x / (2 * sigma * sigma)); }
float gaussian_slope(float x, float sigma) { return -x * gaussian(x, sigma); }
float gaussian_curvature(float x, float sigma) { return (square(x / sigma) - 1) * gaussian(x, sigma); }

/// Positive taps scaled to add to 1, negative ones to −1.
Kernel balanced(Kernel kernel) {
  float positive = 0, negative = 0;
  for (float k : kernel) (k > 0 ? positive : negative) += std::abs(k);
  for (float& k : kernel) k /= k > 0 ? positive : negative;
  return kernel;
}

Plane feature_strength(const Plane& lightness, Size size, float (*profile)(float, float)) {
  const float sigma = 0.5f * feature_width_degrees * pixels_a_degree;
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  Kernel smooth = sampled(radius, gaussian, sigma);
  const float sum = sum_of(smooth);
  for (float& k : smooth) k /= sum;
  const Kernel across = balanced(sampled(radius, profile, sigma));
  const Plane dx = filter(filter(lightness, size, across, true), size, smooth, false);
  const Plane dy = filter(filter(lightness, size, smooth, true), size, across, false);
  Plane strength(dx.size());
  for (size_t i = 0; i < strength.size(); ++i) strength[i] = std::hypot(dx[i], dy[i]);
  return strength;
}

}  // namespace

std::vector<float> flip_map(const ImageRgb& image, const ImageRgb& reference, float exposure_ev) {
  HALFLIGHT_CHECK(image.width == reference.width && image.height == reference.height);
  const Size size{image.width, image.height};
  const float exposure = std::exp2(exposure_ev);
  Planes a = split(image, exposure), b = split(reference, exposure);
  const std::vector<Vec3> lab_a = perceived(a, size), lab_b = perceived(b, size);

  for (Plane* y : {&a.y, &b.y})
    for (float& v : *y) v = (v + 16) / 116;  // lightness in [0, 1]
  const Plane edges_a = feature_strength(a.y, size, gaussian_slope),
              edges_b = feature_strength(b.y, size, gaussian_slope);
  const Plane points_a = feature_strength(a.y, size, gaussian_curvature),
              points_b = feature_strength(b.y, size, gaussian_curvature);

  std::vector<float> flip(image.pixels.size());
  for (size_t i = 0; i < flip.size(); ++i) {
    const float color = redistribute(hyab(lab_a[i], lab_b[i]));
    const float feature = std::max(std::abs(edges_a[i] - edges_b[i]), std::abs(points_a[i] - points_b[i]));
    const float weight = std::pow(feature / std::sqrt(2.0f), feature_exponent);
    flip[i] = std::clamp(std::pow(color, 1 - weight), 0.0f, 1.0f);
  }
  return flip;
}

}  // namespace halflight
