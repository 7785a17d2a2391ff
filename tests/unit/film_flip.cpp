// LDR-FLIP against a slow evaluation of the paper's equations, with two-dimensional filters, in double.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>

#include "core/random.h"
#include "film/metrics.h"

namespace halflight {
namespace {

using Triple = std::array<double, 3>;
using Picture = std::vector<Triple>;

constexpr int width = 34, height = 27;
constexpr double pixels_a_degree = 67, pi_d = 3.14159265358979323846;

/// Linear sRGB to XYZ from the primaries' chromaticities and the white point (SMPTE RP 177), rather than from
/// a printed matrix.
Triple xyz_of(const Triple& rgb) {
  static const glm::dmat3 matrix = [] {
    const auto full = [](double x, double y) { return glm::dvec3(x / y, 1, (1 - x - y) / y); };
    const glm::dmat3 primaries(full(0.64, 0.33), full(0.30, 0.60), full(0.15, 0.06));
    const glm::dvec3 scale = glm::inverse(primaries) * full(0.3127, 0.3290);
    return glm::dmat3(primaries[0] * scale[0], primaries[1] * scale[1], primaries[2] * scale[2]);
  }();
  const glm::dvec3 v = matrix * glm::dvec3(rgb[0], rgb[1], rgb[2]);
  return {v.x, v.y, v.z};
}

const Triple white = xyz_of({1, 1, 1});

Triple ycxcz_of(const Triple& rgb) {
  const Triple c = xyz_of(rgb);
  const double x = c[0] / white[0], y = c[1] / white[1], z = c[2] / white[2];
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

/// The inverse, by Newton's method on a linear map: exact after one step from the columns.
Triple rgb_of_ycxcz(const Triple& target) {
  const Triple zero = ycxcz_of({0, 0, 0});
  glm::dmat3 jacobian;
  for (int c = 0; c < 3; ++c) {
    Triple unit{};
    unit[static_cast<size_t>(c)] = 1;
    const Triple column = ycxcz_of(unit);
    for (int r = 0; r < 3; ++r)
      jacobian[c][r] = column[static_cast<size_t>(r)] - zero[static_cast<size_t>(r)];
  }
  const glm::dvec3 rgb =
      glm::inverse(jacobian) * glm::dvec3(target[0] - zero[0], target[1] - zero[1], target[2] - zero[2]);
  return {rgb.x, rgb.y, rgb.z};
}

Triple hunt_lab_of(const Triple& rgb) {
  const auto f = [](double t) { return t > 216.0 / 24389 ? std::cbrt(t) : (24389.0 / 27 * t + 16) / 116; };
  const Triple c = xyz_of(rgb);
  const double x = f(c[0] / white[0]), y = f(c[1] / white[1]), z = f(c[2] / white[2]);
  const double l = 116 * y - 16;
  return {l, 0.01 * l * 500 * (x - y), 0.01 * l * 200 * (y - z)};
}

double hyab_of(const Triple& a, const Triple& b) {
  return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}

using Weight = std::function<double(int, int)>;

/// Σ weight(i, j) value(x + i, y + j) / (positive sum for positive weights, negative sum for negative ones).
double filtered(const std::function<double(int)>& value, int x, int y, int radius, const Weight& weight) {
  double positive = 0, negative = 0, sum_positive = 0, sum_negative = 0;
  for (int j = -radius; j <= radius; ++j)
    for (int i = -radius; i <= radius; ++i) {
      const double w = weight(i, j);
      const double v = value(std::clamp(y + j, 0, height - 1) * width + std::clamp(x + i, 0, width - 1));
      (w > 0 ? positive : negative) += std::abs(w);
      (w > 0 ? sum_positive : sum_negative) += w * v;
    }
  return sum_positive / positive + (negative > 0 ? sum_negative / negative : 0);
}

/// Contrast sensitivity in space: Σ a √(π/b) exp(−π² d²/b), d in degrees (section 4.1.1, table 1).
double sensitivity(int i, int j, std::initializer_list<std::pair<double, double>> terms) {
  const double d2 = (i * i + j * j) / (pixels_a_degree * pixels_a_degree);
  double sum = 0;
  for (const auto& [a, b] : terms) sum += a * std::sqrt(pi_d / b) * std::exp(-pi_d * pi_d * d2 / b);
  return sum;
}

Picture perceived(const Picture& ycxcz) {
  const int radius = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * pi_d * pi_d)) * pixels_a_degree));
  const Weight weights[] = {[](int i, int j) {
                              return sensitivity(i, j, {{1, 0.0047}});
                            },
                            [](int i, int j) {
                              return sensitivity(i, j, {{1, 0.0053}});
                            },
                            [](int i, int j) {
                              return sensitivity(i, j, {{34.1, 0.04}, {13.5, 0.025}});
                            }};
  Picture lab(ycxcz.size());
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      Triple c;
      for (size_t k = 0; k < 3; ++k)
        c[k] = filtered([&](int at) { return ycxcz[static_cast<size_t>(at)][k]; }, x, y, radius, weights[k]);
      Triple rgb = rgb_of_ycxcz(c);
      for (double& v : rgb) v = std::clamp(v, 0.0, 1.0);
      lab[static_cast<size_t>(y * width + x)] = hunt_lab_of(rgb);
    }
  return lab;
}

/// ‖(d/dx, d/dy)‖ of the achromatic channel: first derivatives of a Gaussian for edges, second for points
/// (section 4.2).
double feature(const Picture& ycxcz, int x, int y, bool edge) {
  const double sigma = 0.5 * 0.082 * pixels_a_degree;
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  const auto weight = [&](int along, int across) {
    const double g = std::exp(-(along * along + across * across) / (2 * sigma * sigma));
    return edge ? -along * g : (along * along / (sigma * sigma) - 1) * g;
  };
  const auto lightness = [&](int at) { return (ycxcz[static_cast<size_t>(at)][0] + 16) / 116; };
  return std::hypot(filtered(lightness, x, y, radius, weight),
                    filtered(lightness, x, y, radius, [&](int i, int j) { return weight(j, i); }));
}

Picture ycxcz_picture(const ImageRgb& image) {
  Picture picture;
  for (const Vec3& p : image.pixels) picture.push_back(ycxcz_of({p.x, p.y, p.z}));
  return picture;
}

TEST(Flip, AgreesWithASlowEvaluationOfThePaper) {
  ImageRgb a(width, height), b(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      RandomStream random(static_cast<uint64_t>(y * width + x), 0, 1);
      const Vec3 base(0.5f + 0.4f * std::sin(0.4f * static_cast<float>(x)), x > 20 ? 0.8f : 0.1f,
                      0.02f * static_cast<float>(y));
      a.at(x, y) = base;
      b.at(x, y) = glm::clamp(
          base + (y < 12 ? 0.3f : 0.02f) * (Vec3(random.next(), random.next(), random.next()) - 0.5f), 0.0f,
          1.0f);
    }
  const std::vector<float> flip = flip_map(a, b);

  const Picture ya = ycxcz_picture(a), yb = ycxcz_picture(b), lab_a = perceived(ya), lab_b = perceived(yb);
  const double most = std::pow(hyab_of(hunt_lab_of({0, 1, 0}), hunt_lab_of({0, 0, 1})), 0.7);
  double largest = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const size_t i = static_cast<size_t>(y * width + x);
      const double d = std::pow(hyab_of(lab_a[i], lab_b[i]), 0.7);
      const double color =
          d < 0.4 * most ? 0.95 * d / (0.4 * most) : 0.95 + 0.05 * (d - 0.4 * most) / (0.6 * most);
      const double features = std::max(std::abs(feature(ya, x, y, true) - feature(yb, x, y, true)),
                                       std::abs(feature(ya, x, y, false) - feature(yb, x, y, false)));
      const double expected = std::pow(color, 1 - std::sqrt(features / std::sqrt(2.0)));
      ASSERT_NEAR(flip[i], expected, 1e-3) << x << " " << y;
      largest = std::max(largest, expected);
    }
  EXPECT_GT(largest, 0.1);
}

}  // namespace
}  // namespace halflight
