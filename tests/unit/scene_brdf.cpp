// The BRDFs' values, densities and samplers against numerical integration and published numbers.
#include "scene/brdf.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "core/random.h"

using namespace halflight;

namespace {

constexpr Basis local_basis{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

Vec3 direction(double theta, double phi) {
  return Vec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
}

Brdf ggx(float alpha_t, float alpha_b, Vec3 diffuse, Vec3 f0, float f90 = 1) {
  return {BrdfModel::ggx, diffuse, f0, f90, {alpha_t, alpha_b}};
}
Brdf phong(float n, Vec3 diffuse, Vec3 specular) { return {BrdfModel::phong, diffuse, specular, 1, Vec2(n)}; }
Brdf ashikhmin(float nu, float nv, Vec3 diffuse, Vec3 specular) {
  return {BrdfModel::ashikhmin_shirley, diffuse, specular, 1, {nu, nv}};
}

struct Case {
  const char* name;
  Brdf brdf;
};

const std::vector<Case>& smooth_cases() {
  static const std::vector<Case> cases{
      {"phong 1", phong(1, Vec3(0.3f), Vec3(0.5f))},
      {"phong 100", phong(100, Vec3(0.3f, 0.1f, 0.2f), Vec3(0.5f))},
      {"phong, specular only", phong(20, Vec3(0), Vec3(0.9f))},
      {"phong, diffuse only", phong(20, Vec3(0.8f), Vec3(0))},
      {"ggx 1", ggx(1, 1, Vec3(0.5f), Vec3(0.04f))},
      {"ggx 0.5", ggx(0.5f, 0.5f, Vec3(0.5f, 0.7f, 0.1f), Vec3(0.04f))},
      {"ggx 0.2, metal", ggx(0.2f, 0.2f, Vec3(0), Vec3(0.9f, 0.6f, 0.2f))},
      {"ggx anisotropic", ggx(0.7f, 0.15f, Vec3(0.2f), Vec3(0.3f))},
      {"ggx, no Fresnel at all", ggx(0.4f, 0.4f, Vec3(0.6f), Vec3(0), 0)},
      {"ashikhmin-shirley 10/10", ashikhmin(10, 10, Vec3(0.4f), Vec3(0.3f))},
      {"ashikhmin-shirley 10/100", ashikhmin(10, 100, Vec3(0.4f), Vec3(0.05f))},
  };
  return cases;
}

constexpr std::array<double, 4> incidences{0.0, 0.6, 1.2, 1.5};

/// ∫ g(wi) dω over the upper hemisphere: midpoint rule, cells shrinking towards the horizon where lobes end.
template <class Integrand>
double integrate_hemisphere(Integrand&& g, int rows = 400, int columns = 400) {
  double sum = 0;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const double theta = pi / 2 * (row + 0.5) / rows, phi = 2 * M_PI * (column + 0.5) / columns;
      sum += g(direction(theta, phi)) * std::sin(theta);
    }
  }
  return sum * (M_PI / 2 / rows) * (2 * M_PI / columns);
}

double albedo(const Brdf& brdf, double theta_o) {
  const Vec3 wo = direction(theta_o, 0.3);
  return integrate_hemisphere([&](Vec3 wi) { return double(evaluate(brdf, local_basis, wo, wi).x) * wi.z; });
}

/// p-value of a χ² statistic by Wilson & Hilferty's cube root, exact enough at thousands of degrees of
/// freedom.
double chi_square_p_value(double statistic, double degrees) {
  const double k = 2 / (9 * degrees);
  const double z = (std::cbrt(statistic / degrees) - (1 - k)) / std::sqrt(k);
  return 0.5 * std::erfc(z / std::sqrt(2.0));
}

/// χ² of draws against a density over bins of (cos θ, φ); draws that fail have the leftover probability.
/// Densities are integrated with `sub`² midpoints a bin.
template <class Draw, class Density>
double chi_square_test(Draw&& draw, Density&& density, int draws, int sub) {
  constexpr int rows = 80, columns = 160;
  std::vector<double> expected(rows * columns + 1, 0), observed(rows * columns + 1, 0);
  double inside = 0;
  for (int bin = 0; bin < rows * columns; ++bin) {
    const int row = bin / columns, column = bin % columns;
    for (int s = 0; s < sub * sub; ++s) {
      const double theta = M_PI / 2 * (row + (s / sub + 0.5) / sub) / rows;
      const double phi = 2 * M_PI * (column + (s % sub + 0.5) / sub) / columns;
      expected[bin] += density(direction(theta, phi)) * std::sin(theta);
    }
    expected[bin] *= M_PI / 2 / rows * 2 * M_PI / columns / (sub * sub) * draws;
    inside += expected[bin];
  }
  expected.back() = std::max(0.0, draws - inside);
  RandomStream random(1, 2, 3);
  for (int i = 0; i < draws; ++i) {
    const std::optional<Vec3> wi = draw(random);
    if (!wi) {
      ++observed.back();
      continue;
    }
    const int row = std::min(rows - 1, int(std::acos(std::min(1.0f, wi->z)) / (M_PI / 2) * rows));
    const double phi = std::atan2(wi->y, wi->x);
    const int column = std::min(columns - 1, int((phi < 0 ? phi + 2 * M_PI : phi) / (2 * M_PI) * columns));
    ++observed[row * columns + column];
  }
  // Bins are pooled until each expects enough for the normal limit.
  double statistic = 0, pooled_expected = 0, pooled_observed = 0;
  int used = 0;
  for (size_t bin = 0; bin < expected.size(); ++bin) {
    pooled_expected += expected[bin], pooled_observed += observed[bin];
    if (pooled_expected < 10) continue;
    statistic += square(float(pooled_observed - pooled_expected)) / pooled_expected;
    pooled_expected = pooled_observed = 0;
    ++used;
  }
  if (pooled_expected + pooled_observed > 0) {
    statistic += square(float(pooled_observed - pooled_expected)) / std::max(pooled_expected, 1.0);
    ++used;
  }
  return chi_square_p_value(statistic, std::max(1, used - 1));
}

/// Share of draws that `sample` turns down, on a regular grid of random numbers.
double failure_share(const Brdf& brdf, Vec3 wo) {
  constexpr int n = 24, lobes = 50;
  int failed = 0;
  for (int i = 0; i < n * n * lobes; ++i) {
    RandomStream random(i, 0, 5);
    const float choose = (i % lobes + 0.5f) / lobes;
    const Vec2 u = (Vec2(i / lobes % n, i / lobes / n) + random.next2()) / float(n);
    failed += !sample(brdf, local_basis, wo, choose, u);
  }
  return double(failed) / (n * n * lobes);
}

}  // namespace

TEST(SceneBrdf, density_integrates_to_the_share_of_draws_that_succeed) {
  for (const Case& c : smooth_cases()) {
    for (double theta : incidences) {
      const Vec3 wo = direction(theta, 0.7);
      const double integral = integrate_hemisphere([&](Vec3 wi) { return pdf(c.brdf, local_basis, wo, wi); });
      EXPECT_NEAR(integral + failure_share(c.brdf, wo), 1, 6e-3) << c.name << " at " << theta;
    }
  }
}

TEST(SceneBrdf, chi_square_of_the_mixture) {
  int tests = 0;
  for (const Case& c : smooth_cases()) tests += c.brdf.black() ? 0 : 1;
  for (const Case& c : smooth_cases()) {
    const Vec3 wo = direction(1.0, 0.7);
    const double p = chi_square_test(
        [&](RandomStream& random) -> std::optional<Vec3> {
          const float choose = random.next();
          const auto s = sample(c.brdf, local_basis, wo, choose, random.next2());
          return s ? std::optional<Vec3>(s->wi) : std::nullopt;
        },
        [&](Vec3 wi) { return pdf(c.brdf, local_basis, wo, wi); }, 1000000, 4);
    EXPECT_GT(p, 0.01 / tests) << c.name;
  }
}

TEST(SceneBrdf, chi_square_of_the_specular_lobe_alone) {
  const std::vector<Case> cases{{"phong 30", phong(30, Vec3(0.5f), Vec3(0.4f))},
                                {"ggx 0.3", ggx(0.3f, 0.3f, Vec3(0.5f), Vec3(0.04f))},
                                {"ggx anisotropic", ggx(0.2f, 0.6f, Vec3(0.5f), Vec3(0.04f))},
                                {"ashikhmin-shirley", ashikhmin(40, 10, Vec3(0.5f), Vec3(0.2f))}};
  for (const Case& c : cases) {
    for (double theta : {0.3, 1.4}) {
      const Vec3 wo = direction(theta, 2.0);
      const double p = chi_square_test(
          [&](RandomStream& random) { return sample_specular(c.brdf, local_basis, wo, random.next2()); },
          [&](Vec3 wi) { return specular_pdf(c.brdf, local_basis, wo, wi); }, 300000, 4);
      EXPECT_GT(p, 0.01 / 8) << c.name << " at " << theta;
    }
  }
}

/// ∂w/∂u of the specular sampler by central differences of fourth order.
std::optional<Vec3d> sampler_derivative(const Brdf& brdf, Vec3 wo, Vec2 u, Vec2 axis) {
  constexpr float step = 0.01f;
  std::array<Vec3d, 4> w;
  constexpr std::array<float, 4> offsets{-2, -1, 1, 2};
  for (int i = 0; i < 4; ++i) {
    const auto drawn = sample_specular(brdf, local_basis, wo, u + offsets[i] * step * axis);
    if (!drawn) return std::nullopt;
    w[i] = *drawn;
  }
  return (8.0 * (w[2] - w[1]) - (w[3] - w[0])) / (12.0 * step);
}

// The sampler as a map from the unit square to the sphere: |∂w/∂u × ∂w/∂v| is 1/pdf, also for lobes too
// narrow for bins.
TEST(SceneBrdf, jacobian_of_the_specular_sampler_is_one_over_its_density) {
  struct NarrowCase : Case {
    double tolerance;  // float directions limit how finely the sharpest lobes can be differentiated
  };
  const Vec3 black(0), white(1);
  const std::vector<NarrowCase> cases{
      {{"phong 1", phong(1, black, white)}, 0.01},
      {{"phong 1e2", phong(1e2f, black, white)}, 0.01},
      {{"phong 1e4", phong(1e4f, black, white)}, 0.01},
      {{"phong 1e6", phong(1e6f, black, white)}, 0.03},
      {{"ggx 1", ggx(1, 1, black, white)}, 0.01},
      {{"ggx 0.1", ggx(0.1f, 0.1f, black, white)}, 0.01},
      {{"ggx 1e-2", ggx(1e-2f, 1e-2f, black, white)}, 0.01},
      {{"ggx 1e-3", ggx(1e-3f, 1e-3f, black, white)}, 0.02},
      {{"ggx 1e-4", ggx(1e-4f, 1e-4f, black, white)}, 0.15},
      {{"ggx 0.5/1e-2", ggx(0.5f, 1e-2f, black, white)}, 0.01},
      {{"ashikhmin-shirley 10/1e5", ashikhmin(10, 1e5f, black, white)}, 0.02}};
  for (const NarrowCase& c : cases) {
    for (double theta : {0.1, 0.8, 1.3}) {
      const Vec3 wo = direction(theta, 0.9);
      int compared = 0;
      for (const Vec2 u : {Vec2(0.2f, 0.3f), Vec2(0.45f, 0.6f), Vec2(0.61f, 0.1f), Vec2(0.85f, 0.5f)}) {
        const auto centre = sample_specular(c.brdf, local_basis, wo, u);
        const auto along_u = sampler_derivative(c.brdf, wo, u, {1, 0});
        const auto along_v = sampler_derivative(c.brdf, wo, u, {0, 1});
        if (!(centre && along_u && along_v)) continue;
        const double area = glm::length(glm::cross(*along_u, *along_v));
        EXPECT_NEAR(area * specular_pdf(c.brdf, local_basis, wo, *centre), 1, c.tolerance)
            << c.name << " at " << theta;
        ++compared;
      }
      EXPECT_GT(compared, 0) << c.name << " at " << theta;
    }
  }
}

TEST(SceneBrdf, albedos_of_the_literature) {
  EXPECT_NEAR(albedo(ashikhmin(10, 10, Vec3(0), Vec3(1)), 0.1), 0.696, 1e-3);
  EXPECT_NEAR(albedo(ashikhmin(10, 10, Vec3(0), Vec3(1)), 1.2), 0.582, 1e-3);
  EXPECT_NEAR(albedo(ggx(0.5f, 0.5f, Vec3(0), Vec3(1)), 0.2), 0.687, 1e-3);
  EXPECT_NEAR(albedo(ggx(0.5f, 0.5f, Vec3(0), Vec3(1)), 1.0), 0.693, 1e-3);
  EXPECT_NEAR(albedo(ggx(0.5f, 0.5f, Vec3(0), Vec3(1)), 1.5), 0.889, 1e-3);
  EXPECT_NEAR(albedo(phong(100, Vec3(0), Vec3(1)), 0.0), 1.000, 1e-3);
  EXPECT_NEAR(albedo(phong(100, Vec3(0), Vec3(1)), 1.0), 0.540, 1e-3);
  EXPECT_NEAR(albedo(phong(100, Vec3(0), Vec3(1)), 1.5), 0.085, 1e-3);
}

TEST(SceneBrdf, ashikhmin_shirley_diffuse_term_is_normalised) {
  // With k_s = 0 there is no specular lobe: what remains is R_d (1 − (1 − cos θ_o/2)⁵).
  for (double theta : {0.0, 0.6, 1.3}) {
    const double expected = 0.5 * (1 - std::pow(1 - 0.5 * std::cos(theta), 5));
    EXPECT_NEAR(albedo(ashikhmin(10, 10, Vec3(0.5f), Vec3(0)), theta), expected, 1e-4);
  }
}

TEST(SceneBrdf, ggx_of_a_white_metal_never_gains_energy) {
  for (float alpha : {0.05f, 0.2f, 0.5f, 1.0f}) {
    for (double theta : {0.0, 0.5, 1.0, 1.3, 1.5, 1.56}) {
      EXPECT_LE(albedo(ggx(alpha, alpha, Vec3(0), Vec3(1)), theta), alpha < 0.1f ? 1.02 : 1.001)
          << alpha << theta;
    }
  }
  EXPECT_LE(albedo(ggx(0.5f, 0.5f, Vec3(1), Vec3(0.04f)), 0.3), 1.0);
}

/// Both estimators of BRDF sampling: the whole mixture, and the chosen lobe alone (Křivánek §2.4).
class FurnaceWeights : public testing::TestWithParam<decltype(&sample)> {};

TEST_P(FurnaceWeights, average_to_the_albedo) {
  for (const Case& c : smooth_cases()) {
    for (double theta : {0.2, 1.2}) {
      const Vec3 wo = direction(theta, 0.3);
      constexpr int n = 100000;
      double sum = 0, squares = 0;
      RandomStream random(7, 8, 9);
      for (int i = 0; i < n; ++i) {
        const float choose = random.next();
        const auto s = GetParam()(c.brdf, local_basis, wo, choose, random.next2());
        const double weight = s ? double(s->f.x) * s->wi.z / s->pdf : 0.0;
        sum += weight, squares += weight * weight;
      }
      const double mean = sum / n, error = std::sqrt(std::max(0.0, squares / n - mean * mean) / n);
      EXPECT_NEAR(mean, albedo(c.brdf, theta), 4.5 * error + 1e-4) << c.name << " at " << theta;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(SceneBrdf, FurnaceWeights, testing::Values(&sample, &sample_chosen_lobe));

TEST(SceneBrdf, chosen_lobe_carries_that_lobe_alone) {
  // By Křivánek's words: a diffuse draw has ρd/π over P ρd's density, a specular one the lobe's term over P'
  // its own.
  const Brdf brdf = phong(30, Vec3(0.3f), Vec3(0.5f));
  const Vec3 wo = direction(0.7, 0.2);
  const float p = specular_probability(brdf, local_basis, wo);
  RandomStream random(4, 4, 4);
  for (int i = 0; i < 1000; ++i) {
    const float choose = random.next();
    const auto s = sample_chosen_lobe(brdf, local_basis, wo, choose, random.next2());
    if (!s) continue;
    if (choose < p) {
      ASSERT_NEAR(s->f.x / s->pdf, 0.5f * 32 / 31 / p, 1e-4f);
    } else {
      ASSERT_NEAR(s->f.x, 0.3f / pi, 1e-6f);
      ASSERT_NEAR(s->pdf, (1 - p) * s->wi.z / pi, 1e-6f);
    }
  }
}

TEST(SceneBrdf, weights_are_bounded) {
  const std::vector<Case> cases{{"ggx 1e-4", ggx(1e-4f, 1e-4f, Vec3(0), Vec3(1))},
                                {"ggx 0.3", ggx(0.3f, 0.3f, Vec3(0), Vec3(1))},
                                {"ggx 1", ggx(1, 1, Vec3(0), Vec3(1))},
                                {"ggx 0.9/0.01", ggx(0.9f, 0.01f, Vec3(0), Vec3(1))},
                                {"ashikhmin-shirley 10/1e5", ashikhmin(10, 1e5f, Vec3(0), Vec3(1))}};
  for (const Case& c : cases) {
    for (double theta : {0.0, 0.5, 1.2, 1.5, 1.57}) {
      const Vec3 wo = direction(theta, 0.4);
      RandomStream random(1, 1, 1);
      for (int i = 0; i < 20000; ++i) {
        const auto s = sample(c.brdf, local_basis, wo, 0.5f, random.next2());
        if (!s) continue;
        ASSERT_TRUE(std::isfinite(s->pdf) && is_finite(s->f)) << c.name;
        ASSERT_LE(s->f.x * s->wi.z / s->pdf, 1 + 1e-4f) << c.name << " at " << theta;
      }
    }
  }
}

TEST(SceneBrdf, sharp_lobes_keep_their_moments) {
  // Walter et al. 2007: the median slope tan θ_h of GGX seen head-on is α; for Phong E[1 − cos α] = 1/(n +
  // 2).
  const Vec3 up(0, 0, 1);
  const Brdf mirror = ggx(1e-4f, 1e-4f, Vec3(0), Vec3(1));
  const Brdf sharp = phong(1e6f, Vec3(0), Vec3(1));
  RandomStream random(4, 5, 6);
  constexpr int n = 100000;
  int below = 0;
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    const auto g = sample_specular(mirror, local_basis, up, random.next2());
    if (g) {
      const Vec3 h = *g + up;
      below += std::sqrt(h.x * h.x + h.y * h.y) / h.z < 1e-4f;
    }
    const auto p = sample_specular(sharp, local_basis, up, random.next2());
    ASSERT_TRUE(p.has_value());
    sum += 0.5 * glm::dot(Vec3d(*p) - Vec3d(up), Vec3d(*p) - Vec3d(up));
  }
  EXPECT_NEAR(double(below) / n, 0.5, 0.01);
  EXPECT_NEAR(sum / n * (1e6 + 2), 1, 0.02);
}

TEST(SceneBrdf, reciprocity) {
  RandomStream random(2, 2, 2);
  for (const Case& c : smooth_cases()) {
    for (int i = 0; i < 1000; ++i) {
      const Vec2 a = random.next2(), b = random.next2();
      const Vec3 wo = direction(1.5 * a.x, 6.28 * a.y), wi = direction(1.5 * b.x, 6.28 * b.y);
      const Vec3 there = evaluate(c.brdf, local_basis, wo, wi), back = evaluate(c.brdf, local_basis, wi, wo);
      ASSERT_NEAR(there.x, back.x, 1e-4f * (there.x + back.x)) << c.name;
      ASSERT_GE(there.x, 0);
    }
  }
}

TEST(SceneBrdf, sample_agrees_with_pdf_and_evaluate_in_any_basis) {
  RandomStream random(3, 3, 3);
  std::vector<Case> cases = smooth_cases();
  cases.push_back({"ggx 1e-4", ggx(1e-4f, 1e-4f, Vec3(0.5f), Vec3(0.04f))});
  cases.push_back({"phong 1e6", phong(1e6f, Vec3(0.5f), Vec3(0.4f))});
  for (const Case& c : cases) {
    const Basis basis = basis_along(glm::normalize(Vec3(0.3f, -0.8f, 0.5f)), {1, 0, 0});
    for (int i = 0; i < 2000; ++i) {
      const Vec2 a = random.next2();
      const Vec3 wo = basis.to_world(direction(1.55 * a.x, 6.28 * a.y));
      const float choose = random.next();
      const auto s = sample(c.brdf, basis, wo, choose, random.next2());
      if (!s) continue;
      ASSERT_NEAR(glm::length(s->wi), 1, 1e-6f);
      ASSERT_FLOAT_EQ(s->pdf, pdf(c.brdf, basis, wo, s->wi)) << c.name;
      ASSERT_FLOAT_EQ(s->f.x, evaluate(c.brdf, basis, wo, s->wi).x) << c.name;
      const BrdfValue both = evaluate_with_pdf(c.brdf, basis, wo, s->wi);
      ASSERT_EQ(both.f, evaluate(c.brdf, basis, wo, s->wi)) << c.name;
      ASSERT_FLOAT_EQ(both.pdf, pdf(c.brdf, basis, wo, s->wi)) << c.name;
      const float p = specular_probability(c.brdf, basis, wo);
      const float mixture =
          p * specular_pdf(c.brdf, basis, wo, s->wi) + (1 - p) * glm::dot(s->wi, basis.normal) / pi;
      ASSERT_NEAR(s->pdf, mixture, 1e-5f * mixture) << c.name;
    }
  }
}

TEST(SceneBrdf, horizon_and_missing_lobes) {
  const Vec3 up = direction(0.4, 0), below = direction(2.0, 1);
  const Brdf both = ggx(0.3f, 0.3f, Vec3(0.5f), Vec3(0.04f));
  EXPECT_EQ(evaluate(both, local_basis, below, up), Vec3(0));
  EXPECT_EQ(evaluate(both, local_basis, up, below), Vec3(0));
  EXPECT_EQ(pdf(both, local_basis, up, below), 0);
  EXPECT_FALSE(sample(both, local_basis, below, 0.5f, {0.5f, 0.5f}));

  EXPECT_EQ(specular_probability(phong(10, Vec3(0.5f), Vec3(0)), local_basis, up), 0);
  EXPECT_EQ(specular_probability(phong(10, Vec3(0), Vec3(0.5f)), local_basis, up), 1);
  const float faint = specular_probability(phong(10, Vec3(0.5f), Vec3(1e-20f)), local_basis, up);
  EXPECT_GT(faint, 0);
  // A black diffuse channel pair and white Fresnel at grazing angles leave both lobes in play.
  const float grazing = specular_probability(ggx(0.01f, 0.01f, Vec3(0.5f, 0, 0), Vec3(1, 1, 0.9f)),
                                             local_basis, direction(1.57, 0));
  EXPECT_LT(grazing, 1);
  EXPECT_FALSE(sample(Brdf{}, local_basis, up, 0.5f, {0.5f, 0.5f}));
  EXPECT_EQ(pdf(Brdf{}, local_basis, up, up), 0);
  EXPECT_EQ(evaluate(Brdf{}, local_basis, up, up), Vec3(0));
}

TEST(SceneBrdf, bounce_albedo_is_the_reflectance_at_normal_incidence) {
  EXPECT_NEAR(bounce_albedo(phong(10, Vec3(0.3f), Vec3(0.4f))).x, 0.7f, 1e-6f);
  EXPECT_NEAR(bounce_albedo(phong(10, Vec3(0.8f), Vec3(0.4f))).x, 1, 1e-6f);
  EXPECT_NEAR(bounce_albedo(ggx(0.05f, 0.05f, Vec3(0.5f), Vec3(0.04f))).x,
              albedo(ggx(0.05f, 0.05f, Vec3(0.5f), Vec3(0.04f)), 0), 0.01);
  EXPECT_EQ(bounce_albedo(Brdf{}), Vec3(0));
}
