// Strata of triangles and of the environment: what is drawn in one leads back to it, uniform in it, and
// together they are all there is.
#include <gtest/gtest.h>

#include <map>

#include "core/random.h"
#include "core/warp.h"
#include "lights/environment_cells.h"
#include "lights/triangle_cells.h"
#include "support/simple_scenes.h"
#include "support/statistics.h"

namespace halflight {
namespace {

// ---- Triangles ----

/// Triangles with weights, listed in order of their numbers.
struct Listed {
  Scene scene;
  std::vector<uint32_t> triangles;
  std::vector<double> weights;

  void add(Vec3 a, Vec3 b, Vec3 c, double weight) {
    const auto first = static_cast<uint32_t>(scene.vertices.size());
    for (const Vec3 p : {a, b, c}) scene.vertices.push_back({p, {0, 1, 0}, Vec4(0), {}, 0xffffffffu});
    triangles.push_back(static_cast<uint32_t>(scene.triangles.size()));
    scene.triangles.push_back(UVec3(0, 1, 2) + first);
    scene.triangle_material.push_back(0);
    weights.push_back(weight);
  }
  /// Its area as its weight.
  void add(Vec3 a, Vec3 b, Vec3 c) { add(a, b, c, 0.5 * glm::length(glm::cross(b - a, c - a))); }
  double area(uint32_t t) const { return 0.5 * static_cast<double>(glm::length(triangle_cross(scene, t))); }
};

Vec3 random_point(RandomStream& random) { return {random.next(), random.next(), random.next()}; }

void add_random(Listed& list, RandomStream& random, int count, float size) {
  for (int i = 0; i < count; ++i) {
    const Vec3 a = random_point(random);
    list.add(a, a + size * random_point(random), a + size * random_point(random));
  }
}

struct CellsCase {
  const char* name;
  uint32_t count;
  Listed (*make)();
};

void PrintTo(const CellsCase& c, std::ostream* out) { *out << c.name; }

Listed one_triangle() {
  Listed list;
  list.add({0, 0, 0}, {3, 0, 0}, {0, 2, 1});
  return list;
}

Listed small_triangles() {
  Listed list;
  RandomStream random(1, 2, 3);
  add_random(list, random, 3000, 0.1f);
  return list;
}

Listed large_among_small() {
  Listed list;
  RandomStream random(4, 5, 6);
  for (int i = 0; i < 6; ++i) {
    add_random(list, random, 100, 0.02f);
    add_random(list, random, 1, 1.0f + i);
  }
  return list;
}

Listed slivers() {
  Listed list;
  RandomStream random(7, 8, 9);
  for (int i = 0; i < 200; ++i) {
    const Vec3 a = random_point(random), along = random_point(random);
    list.add(a, a + along, a + 0.5f * along + std::pow(10.0f, -6 * random.next()) * random_point(random));
  }
  return list;
}

Listed areas_of_zero() {
  Listed list;
  RandomStream random(10, 11, 12);
  for (int i = 0; i < 50; ++i) {
    add_random(list, random, 3, 0.3f);
    const Vec3 a = random_point(random), b = random_point(random);
    list.add(a, a, a, 0.0);
    list.add(a, b, b, 0.01);  // what has no area may still have a weight
  }
  return list;
}

Listed weights_far_apart() {
  Listed list;
  RandomStream random(13, 14, 15);
  for (int i = 0; i < 400; ++i) {
    const Vec3 a = random_point(random);
    list.add(a, a + random_point(random), a + random_point(random), std::pow(10.0, 12 * random.next() - 6));
  }
  return list;
}

class TriangleCellsCase : public testing::TestWithParam<CellsCase> {
 protected:
  Listed list = GetParam().make();
  TriangleCells cells{list.scene, list.triangles, list.weights, GetParam().count};
  RandomStream random{16, 17, 18};

  /// Cells on each listed triangle that has one.
  std::map<uint32_t, std::vector<uint32_t>> triangles_of_cells() {
    std::map<uint32_t, std::vector<uint32_t>> found;
    for (uint32_t cell = 0; cell < cells.size(); ++cell) {
      std::vector<uint32_t>& of_cell = found[cell];
      for (int i = 0; i < 4096; ++i) {
        const uint32_t t = cells.draw(cell, static_cast<float>(i) / 4096, {0.5f, 0.5f}).triangle;
        if (of_cell.empty() || of_cell.back() != t) of_cell.push_back(t);
      }
    }
    return found;
  }
};

TEST_P(TriangleCellsCase, WhatIsDrawnLeadsBack) {
  ASSERT_GT(cells.size(), 0u);
  // A point drawn on a piece's edge may round to the neighbour's side.
  size_t draws = 0, astray = 0;
  for (uint32_t cell = 0; cell < cells.size(); ++cell)
    for (int i = 0; i < 64; ++i, ++draws) {
      const SurfacePoint point = cells.draw(cell, random.next(), random.next2());
      ASSERT_LT(point.triangle, list.scene.triangles.size());
      ASSERT_GE(point.barycentric.x, 0);
      ASSERT_GE(point.barycentric.y, 0);
      ASSERT_LE(point.barycentric.x + point.barycentric.y, 1 + 1e-6f);
      astray += cells.cell_of(point) != cell;
    }
  EXPECT_LE(static_cast<double>(astray), 2e-5 * static_cast<double>(draws) + 1);
}

TEST_P(TriangleCellsCase, CornersOfTheUnitSquareStayOnTheirTriangle) {
  const float last = std::nextafter(1.0f, 0.0f);
  for (uint32_t cell = 0; cell < cells.size(); ++cell)
    for (const float choose : {0.0f, last})
      for (const Vec2 u : {Vec2(0, 0), Vec2(last, 0), Vec2(0, last), Vec2(last, last)}) {
        const SurfacePoint point = cells.draw(cell, choose, u);
        const uint32_t found = cells.cell_of(point);
        ASSERT_LT(found, cells.size());
        const SurfacePoint inside = cells.draw(found, choose, {0.5f, 0.5f});
        // A corner belongs to any piece around it, but to one of the same triangle or run.
        ASSERT_TRUE(inside.triangle == point.triangle || found == cell);
      }
}

TEST_P(TriangleCellsCase, CellsAddToTheWholeArea) {
  std::map<uint32_t, double> weight_of_cell;
  std::map<uint32_t, size_t> pieces;
  const auto of_cells = triangles_of_cells();
  for (size_t i = 0; i < list.triangles.size(); ++i) {
    const uint32_t t = list.triangles[i], cell = cells.cell_of({t, {0.25f, 0.25f}});
    ASSERT_EQ(cell == TriangleCells::none, list.weights[i] == 0);
    if (cell != TriangleCells::none) weight_of_cell[cell] += list.weights[i];
  }
  for (const auto& [cell, triangles] : of_cells)
    if (triangles.size() == 1) ++pieces[triangles[0]];
  double total = 0, sum = 0;
  for (size_t i = 0; i < list.triangles.size(); ++i) {
    const uint32_t t = list.triangles[i], cell = cells.cell_of({t, {0.25f, 0.25f}});
    total += list.weights[i] > 0 ? list.area(t) : 0;
    if (cell == TriangleCells::none) {
      EXPECT_EQ(cells.measure(t), 0);
      continue;
    }
    // The mean of 1/density over draws in the cell is the cell's area: k² pieces of a triangle, or a member's
    // share of its run.
    const double share =
        pieces[t] > 1 ? static_cast<double>(pieces[t]) : list.weights[i] / weight_of_cell[cell];
    EXPECT_NEAR(share * cells.measure(t), list.area(t), 1e-6 * list.area(t)) << i;
    sum += share * cells.measure(t);
  }
  EXPECT_NEAR(sum, total, 1e-6 * total);
}

TEST_P(TriangleCellsCase, MembersOfARunAreDrawnByWeight) {
  size_t tested = 0;
  for (const auto& [cell, triangles] : triangles_of_cells()) {
    if (triangles.size() < 2 || ++tested > 40) continue;
    std::map<uint32_t, double> drawn;
    constexpr int draws = 4000;
    for (int i = 0; i < draws; ++i) drawn[cells.draw(cell, random.next(), random.next2()).triangle] += 1;
    std::vector<double> observed, expected;
    double total = 0;
    for (size_t i = 0; i < list.triangles.size(); ++i)
      if (cells.cell_of({list.triangles[i], {0.25f, 0.25f}}) == cell) {
        observed.push_back(drawn[list.triangles[i]]), expected.push_back(list.weights[i]);
        total += list.weights[i];
      }
    for (double& e : expected) e *= draws / total;
    EXPECT_GT(chi_square_p(observed, expected), sidak_level(1e-3, 40)) << cell;
  }
}

/// Which of m² pieces of equal area a point lies in, when every edge of the triangle is cut in m.
std::pair<int, int> place_in_grid(Vec2 barycentric, int m, bool& inverted) {
  const double x = static_cast<double>(barycentric.x) * m, y = static_cast<double>(barycentric.y) * m;
  const int i = std::min(static_cast<int>(x), m - 1), j = std::min(static_cast<int>(y), m - 1 - i);
  inverted = (x - i) + (y - j) > 1;
  return {i, j};
}

TEST_P(TriangleCellsCase, DrawsAreUniformInTheirPiece) {
  // Cut four times finer than the cells are, each piece holds 16 of the finer ones, all alike.
  const auto of_cells = triangles_of_cells();
  std::map<uint32_t, std::vector<uint32_t>> pieces;
  for (const auto& [cell, triangles] : of_cells)
    if (triangles.size() == 1) pieces[triangles[0]].push_back(cell);
  size_t tested = 0;
  for (const auto& [t, its_cells] : pieces) {
    const int k = static_cast<int>(std::lround(std::sqrt(its_cells.size())));
    ASSERT_EQ(static_cast<size_t>(k) * k, its_cells.size());
    for (size_t n = 0; n < its_cells.size() && tested < 64; n += 1 + its_cells.size() / 8, ++tested) {
      std::map<std::tuple<int, int, bool>, double> counts;
      constexpr double draws = 3200;
      for (int i = 0; i < draws; ++i) {
        bool inverted = false;
        const auto [x, y] = place_in_grid(cells.draw(its_cells[n], random.next(), random.next2()).barycentric,
                                          4 * k, inverted);
        counts[{x, y, inverted}] += 1;
      }
      std::vector<double> observed;
      double stray = 0;
      for (const auto& [place, count] : counts) {
        if (count > 5)
          observed.push_back(count);
        else
          stray += count;  // over the edge by a rounding
      }
      EXPECT_LE(stray, 3);
      ASSERT_EQ(observed.size(), 16u);
      EXPECT_GT(chi_square_p(observed, std::vector<double>(16, draws / 16)), sidak_level(1e-3, 64));
    }
  }
}

TEST_P(TriangleCellsCase, WeighedByMeasureDrawsIntegrate) {
  // A member of a run that is drawn once in a million times has an error no affordable number of draws can
  // tell; `CellsAddToTheWholeArea` holds for those too.
  if (GetParam().make == weights_far_apart) GTEST_SKIP() << "tails too long";
  // ∫ b₁, b₁², b₁ b₂ over a triangle: A/3, A/6, A/12; lopsided weights per triangle tell them apart.
  double truth[3] = {}, found[3] = {}, variance[3] = {};
  const auto part = [](uint32_t t) { return 1.0 + t % 7; };
  for (size_t i = 0; i < list.triangles.size(); ++i) {
    if (!(list.weights[i] > 0)) continue;
    const uint32_t t = list.triangles[i];
    truth[0] += part(t) * list.area(t) / 3, truth[1] += part(t) * list.area(t) / 6;
    truth[2] += part(t) * list.area(t) / 12;
  }
  const int draws = static_cast<int>(200000 / cells.size()) + 2;
  for (uint32_t cell = 0; cell < cells.size(); ++cell) {
    double sum[3] = {}, squares[3] = {};
    for (int i = 0; i < draws; ++i) {
      const SurfacePoint p = cells.draw(cell, random.next(), random.next2());
      const double b = p.barycentric.x, c = p.barycentric.y, m = part(p.triangle) * cells.measure(p.triangle);
      const double values[3] = {m * b, m * b * b, m * b * c};
      for (int k = 0; k < 3; ++k) sum[k] += values[k], squares[k] += values[k] * values[k];
    }
    for (int k = 0; k < 3; ++k) {
      const double mean = sum[k] / draws;
      found[k] += mean;
      variance[k] += std::max(0.0, squares[k] / draws - mean * mean) / (draws - 1);
    }
  }
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(found[k], truth[k], 4 * std::sqrt(variance[k]) + 1e-6 * truth[k]) << k;
}

INSTANTIATE_TEST_SUITE_P(Lists, TriangleCellsCase,
                         testing::Values(CellsCase{"one_whole", 1, one_triangle},
                                         CellsCase{"one_in_a_thousand_pieces", 1000, one_triangle},
                                         CellsCase{"runs", 100, small_triangles},
                                         CellsCase{"one_cell_for_all", 1, small_triangles},
                                         CellsCase{"a_cell_each", 3000, small_triangles},
                                         CellsCase{"large_among_small", 500, large_among_small},
                                         CellsCase{"slivers", 300, slivers},
                                         CellsCase{"areas_of_zero", 100, areas_of_zero},
                                         CellsCase{"weights_far_apart", 300, weights_far_apart}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(TriangleCells, NothingToDivide) {
  const Listed list = one_triangle();
  for (const TriangleCells& cells : {TriangleCells(), TriangleCells(list.scene, {}, {}, 10),
                                     TriangleCells(list.scene, list.triangles, std::vector<double>{0}, 10),
                                     TriangleCells(list.scene, list.triangles, list.weights, 0)}) {
    EXPECT_EQ(cells.size(), 0u);
    EXPECT_EQ(cells.cell_of({0, {0.3f, 0.3f}}), TriangleCells::none);
    EXPECT_EQ(cells.measure(0), 0);
  }
}

TEST(TriangleCells, HoldAboutEqualShares) {
  for (const auto make : {small_triangles, large_among_small}) {
    const Listed list = make();
    const TriangleCells cells(list.scene, list.triangles, list.weights, 400);
    EXPECT_GT(cells.size(), 200u);
    EXPECT_LT(cells.size(), 900u);
  }
}

// ---- Environment ----

struct MapCase {
  const char* name;
  int width, height;
  uint32_t count;
  bool black = false;
};

void PrintTo(const MapCase& c, std::ostream* out) { *out << c.name; }

Environment noisy_map(const MapCase& c) {
  ImageRgb map(c.width, c.height);
  RandomStream random(1, 2, 3);
  for (Vec3& texel : map.pixels)
    texel = c.black                ? Vec3(0)
            : random.next() < 0.1f ? 50.0f * random_point(random)
                                   : 0.3f * random_point(random);
  return make_environment(map, "noise", EnvironmentLayout::latlong);
}

class EnvironmentCellsCase : public testing::TestWithParam<MapCase> {
 protected:
  Environment environment = noisy_map(GetParam());
  EnvironmentCells cells{environment, GetParam().count};
  RandomStream random{4, 5, 6};

  Vec2 texel_size() const { return Vec2(1) / Vec2(environment.map.width, environment.map.height); }
  Vec3 texel_centre(int x, int y) const {
    return environment_direction(environment, (Vec2(x, y) + 0.5f) * texel_size());
  }
  size_t texel_of(Vec3 direction) const {
    const ImageRgb& map = environment.map;
    const Vec2 uv = environment_uv(environment, direction);
    const int x = std::min(static_cast<int>(uv.x * static_cast<float>(map.width)), map.width - 1),
              y = std::min(static_cast<int>(uv.y * static_cast<float>(map.height)), map.height - 1);
    return static_cast<size_t>(y * map.width + x);
  }
};

TEST_P(EnvironmentCellsCase, WhatIsDrawnLeadsBackWhateverTheRotation) {
  ASSERT_GE(cells.size(), 1u);
  ASSERT_LE(cells.size(), GetParam().count);
  for (const float rotation : {0.0f, 0.9f, -3.0f, 100.0f}) {
    environment.rotation = rotation;
    // A direction within rounding of a texel's edge may be looked up on its other side.
    size_t draws = 0, astray = 0;
    for (uint32_t cell = 0; cell < cells.size(); ++cell)
      for (int i = 0; i < 200; ++i, ++draws) {
        const Vec3 direction = cells.draw(environment, cell, random.next2());
        ASSERT_NEAR(glm::length(direction), 1, 1e-6);
        const uint32_t found = cells.cell_of(environment, direction);
        ASSERT_LT(found, cells.size());
        astray += found != cell;
      }
    EXPECT_LE(static_cast<double>(astray), 1e-4 * static_cast<double>(draws)) << rotation;
  }
}

TEST_P(EnvironmentCellsCase, EdgesOfTheUnitSquareAreDirections) {
  const float last = std::nextafter(1.0f, 0.0f);
  for (uint32_t cell = 0; cell < cells.size(); ++cell)
    for (const Vec2 u : {Vec2(0, 0), Vec2(last, 0), Vec2(0, last), Vec2(last, last)}) {
      const Vec3 direction = cells.draw(environment, cell, u);
      ASSERT_NEAR(glm::length(direction), 1, 1e-6);
      ASSERT_LT(cells.cell_of(environment, direction), cells.size());
    }
}

TEST_P(EnvironmentCellsCase, SolidAnglesAndMeansAddToTheMaps) {
  double solid_angle = 0;
  Vec3d light(0), truth(0);
  for (uint32_t cell = 0; cell < cells.size(); ++cell) {
    solid_angle += static_cast<double>(cells.solid_angle(cell));
    light += Vec3d(cells.mean_radiance(cell)) * static_cast<double>(cells.solid_angle(cell));
  }
  const ImageRgb& map = environment.map;
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x)
      truth += Vec3d(map.at(x, y)) * static_cast<double>(texel_solid_angle(environment, y));
  EXPECT_NEAR(solid_angle, 4 * static_cast<double>(pi), 2e-5);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(light[c], truth[c], 2e-5 * truth[c]);
}

TEST_P(EnvironmentCellsCase, EachTexelBelongsToOneCellOfItsMean) {
  const ImageRgb& map = environment.map;
  std::vector<double> solid_angle(cells.size());
  std::vector<Vec3d> light(cells.size(), Vec3d(0));
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      const uint32_t cell = cells.cell_of(environment, texel_centre(x, y));
      const double omega = texel_solid_angle(environment, y);
      solid_angle[cell] += omega, light[cell] += Vec3d(map.at(x, y)) * omega;
    }
  for (uint32_t cell = 0; cell < cells.size(); ++cell) {
    ASSERT_NEAR(cells.solid_angle(cell), solid_angle[cell], 1e-5 * solid_angle[cell]);
    for (int c = 0; c < 3; ++c)
      ASSERT_NEAR(cells.mean_radiance(cell)[c] * solid_angle[cell], light[cell][c], 1e-5 * light[cell][c]);
  }
}

TEST_P(EnvironmentCellsCase, DrawsAreUniformBySolidAngle) {
  environment.rotation = 2.2f;
  const ImageRgb& map = environment.map;
  std::vector<double> solid_angle(map.pixels.size());
  for (size_t i = 0; i < solid_angle.size(); ++i)
    solid_angle[i] = texel_solid_angle(environment, static_cast<int>(i) / map.width);
  const size_t step = 1 + cells.size() / 30;
  for (uint32_t cell = 0; cell < cells.size(); cell += static_cast<uint32_t>(step)) {
    // Halves of texels in both directions, equal by solid angle.
    constexpr int draws = 20000;
    std::vector<double> observed(4 * solid_angle.size()), expected(observed.size());
    for (int y = 0; y < map.height; ++y)
      for (int x = 0; x < map.width; ++x) {
        const size_t texel = static_cast<size_t>(y * map.width + x);
        if (cells.cell_of(environment, texel_centre(x, y)) != cell) continue;
        for (size_t part = 0; part < 4; ++part)
          expected[4 * texel + part] = draws * solid_angle[texel] / cells.solid_angle(cell) / 4;
      }
    for (int i = 0; i < draws; ++i) {
      const Vec3 direction = cells.draw(environment, cell, random.next2());
      const size_t texel = texel_of(direction);
      const Vec2 uv = environment_uv(environment, direction);
      const int y = static_cast<int>(texel) / map.width;
      const double across = uv.x * map.width, top = std::cos(pi * y / map.height),
                   low = std::cos(pi * (y + 1) / map.height);
      const bool right = across - std::floor(across) >= 0.5;
      const bool lower = static_cast<double>(direction.y) < 0.5 * (top + low);
      if (expected[4 * texel] > 0) observed[4 * texel + (right ? 1 : 0) + (lower ? 2 : 0)] += 1;
    }
    EXPECT_GT(chi_square_p(observed, expected), sidak_level(1e-3, 30)) << cell;
  }
}

TEST_P(EnvironmentCellsCase, DrawsSeeTheMeanOfTheirCell) {
  environment.rotation = -1.3f, environment.strength = 2.5f;
  for (uint32_t cell = 0; cell < cells.size(); cell += 1 + cells.size() / 30) {
    constexpr int draws = 4000;
    double sum = 0, squares = 0;
    for (int i = 0; i < draws; ++i) {
      const double value = environment_radiance(environment, cells.draw(environment, cell, random.next2())).y;
      sum += value, squares += value * value;
    }
    const double mean = sum / draws, truth = 2.5 * static_cast<double>(cells.mean_radiance(cell).y);
    const double error = std::sqrt(std::max(0.0, squares / draws - mean * mean) / draws);
    EXPECT_NEAR(mean, truth, 4.2 * error + 2e-3 * truth) << cell;
  }
}

INSTANTIATE_TEST_SUITE_P(Maps, EnvironmentCellsCase,
                         testing::Values(MapCase{"one_texel", 1, 1, 100}, MapCase{"odd_and_tall", 3, 5, 7},
                                         MapCase{"odd_and_tall_in_texels", 3, 5, 1000},
                                         MapCase{"seven_by_four", 7, 4, 13}, MapCase{"one_cell", 32, 16, 1},
                                         MapCase{"few_cells", 32, 16, 20}, MapCase{"many_cells", 64, 32, 700},
                                         MapCase{"all_texels", 16, 8, 5000},
                                         MapCase{"black", 32, 16, 100, true}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(EnvironmentCells, ASunOfOneTexelIsACellOfItsOwn) {
  for (const float sun : {100.0f, 1e6f, 1e30f})
    for (const auto& [x, y] : {std::pair{20, 5}, {0, 0}, {63, 31}, {32, 16}}) {
      ImageRgb map(64, 32, Vec3(0.1f));
      map.at(x, y) = Vec3(sun);
      Environment environment = make_environment(map, "sun", EnvironmentLayout::latlong);
      const EnvironmentCells cells(environment, 64);
      environment.rotation = 1;
      const Vec3 direction = environment_direction(
          environment, {(static_cast<float>(x) + 0.5f) / 64, (static_cast<float>(y) + 0.5f) / 32});
      const uint32_t cell = cells.cell_of(environment, direction);
      EXPECT_FLOAT_EQ(cells.solid_angle(cell), texel_solid_angle(environment, y));
      EXPECT_FLOAT_EQ(cells.mean_radiance(cell).x, sun);
    }
}

TEST(EnvironmentCells, NothingToDivide) {
  EXPECT_EQ(EnvironmentCells().size(), 0u);
  EXPECT_EQ(EnvironmentCells(Environment{}, 100).size(), 0u);
  EXPECT_EQ(EnvironmentCells(constant_environment(Vec3(1)), 0).size(), 0u);
  // Even light is divided all the same, for what it lights differs.
  EXPECT_GT(EnvironmentCells(constant_environment(Vec3(1)), 100).size(), 60u);
}

}  // namespace
}  // namespace halflight
