// Every technique that claims to be unbiased for the sum over S, against `reference` on whole scenes, tile by
// tile.
#include <gtest/gtest.h>

#include <filesystem>

#include "session.h"
#include "support/statistics.h"

namespace halflight {
namespace {

constexpr int width = 64, height = 48, tile_side = 16;
constexpr size_t columns = width / tile_side, tile_count = columns * (height / tile_side);
constexpr uint32_t samples_a_pass = 32;
constexpr double level = 0.01;

/// Mean luminance of each tile.
std::vector<double> tile_means(const Film& film) {
  std::vector<double> means(tile_count);
  for (uint32_t i = 0; i < width * height; ++i) {
    const size_t tile = i / width / tile_side * columns + i % width / tile_side;
    means[tile] += luminance(film.radiance(i)) / (tile_side * tile_side);
  }
  return means;
}

/// Running mean and variance of the tiles over passes.
struct TileStatistics {
  double passes = 0;
  std::vector<double> sum = std::vector<double>(tile_count), squares = sum;

  void add(const std::vector<double>& means) {
    ++passes;
    for (size_t t = 0; t < tile_count; ++t) sum[t] += means[t], squares[t] += means[t] * means[t];
  }
  double mean(size_t t) const { return sum[t] / passes; }
  double variance_of_pass(size_t t) const {
    return std::max(0.0, squares[t] / passes - mean(t) * mean(t)) * passes / (passes - 1);
  }
};

class Runs {
 public:
  Runs(Session& session, const std::string& id)
      : frame_(session.frame()), technique_(find_technique(id).make()) {
    technique_->prepare(frame_);
  }
  /// Independent passes [first, first + count), each into a film of its own.
  TileStatistics run(uint32_t first, uint32_t count) {
    TileStatistics statistics;
    for (uint32_t pass = first; pass < first + count; ++pass) {
      Film film(width, height);
      PassRequest request;
      request.pass = pass, request.samples = samples_a_pass;
      technique_->run_pass(frame_, request, film);
      statistics.add(tile_means(film));
    }
    return statistics;
  }

 private:
  FrameView frame_;
  std::unique_ptr<Technique> technique_;
};

RenderSettings settings_of(LightSelection light) {
  RenderSettings settings;
  settings.technique = default_discrete_technique;
  settings.width = width, settings.height = height, settings.light = light, settings.backend = Backend::none;
  settings.values.set("lights.count", "1000");
  settings.values.set("cut.least", "300");
  return settings;
}

/// Largest half-width of a tile's interval that is worth a verdict, relative to the tile: the default
/// technique's must be narrow; the others' tails may keep theirs wider.
double widest_interval(std::string_view id) { return id == "bidirectional" ? 0.007 : 0.1; }

/// Squares of z over all techniques and scenes of this process.
struct PooledTiles {
  double squares = 0;
  size_t tiles = 0;
};

/// All tiles within Šidák's bound, and z spread as a standard normal.
void expect_same_mean(Session& session, const std::string& id, const std::vector<double>& exact,
                      PooledTiles& pooled) {
  constexpr uint32_t pilot_passes = 24, fewest = 40, most = 160;
  Runs runs(session, id);
  const TileStatistics pilot = runs.run(1'000'000, pilot_passes);
  const double bound = two_sided_bound(sidak_level(level, tile_count));
  double wanted = fewest;
  for (size_t t = 0; t < tile_count; ++t) {
    if (exact[t] > 0)
      wanted = std::max(wanted, 1.2 * pilot.variance_of_pass(t) * square(bound / (0.005 * exact[t])));
  }
  const auto passes = static_cast<uint32_t>(std::min<double>(wanted, most));
  const TileStatistics result = runs.run(0, passes);

  double squares = 0;
  size_t noisy = 0;
  for (size_t t = 0; t < tile_count; ++t) {
    // Sums in floats on the way.
    const double rounding = 1e-5 * exact[t];
    const double deviation = std::sqrt(result.variance_of_pass(t) / passes + rounding * rounding);
    EXPECT_LE(std::abs(result.mean(t) - exact[t]), bound * deviation) << id << ", tile " << t;
    EXPECT_LE(bound * deviation, widest_interval(id) * exact[t]) << id << ", tile " << t;
    if (result.variance_of_pass(t) / passes < 25 * rounding * rounding)
      continue;  // background, or nearly exact
    const double z = normal_of_student((result.mean(t) - exact[t]) / deviation, passes - 1.0);
    squares += square(z);
    ++noisy;
  }
  ASSERT_GE(noisy, tile_count / 4);
  // Σz² follows χ² with a degree a tile; too small a spread is as wrong as too large a one.
  const double tail = chi_square_tail(squares, noisy);
  EXPECT_GT(tail, 0.001) << id;
  EXPECT_LT(tail, 0.999) << id;
  pooled.squares += squares, pooled.tiles += noisy;
}

struct SceneCase {
  std::string name, scene;
  LightSelection light;
};

void PrintTo(const SceneCase& c, std::ostream* out) { *out << c.name; }

class UnbiasedScenes : public testing::TestWithParam<SceneCase> {
 protected:
  static inline PooledTiles pooled;

  /// Over all scenes (./check --full) there are tiles enough for the bound that ESTIMATORS sets.
  static void TearDownTestSuite() {
    if (pooled.tiles < 250) return;
    const double rms = std::sqrt(pooled.squares / static_cast<double>(pooled.tiles));
    std::printf("all techniques and scenes: RMS z %.3f of %zu tiles\n", rms, pooled.tiles);
    EXPECT_GT(rms, 0.9);
    EXPECT_LT(rms, 1.1);
  }
};

TEST_P(UnbiasedScenes, MeansAreTheReferences) {
  const SceneCase& c = GetParam();
  if (c.scene.find('/') != std::string::npos && !std::filesystem::exists(c.scene))
    GTEST_SKIP() << "the shared data is not beside this checkout";
  Messages messages;
  Session session(load_scene(c.scene, {}, messages), settings_of(c.light), messages);
  const std::vector<double> exact = [&] {
    Runs reference(session, "reference");
    const TileStatistics once = reference.run(0, 1);
    std::vector<double> means;
    for (size_t t = 0; t < tile_count; ++t) means.push_back(once.mean(t));
    return means;
  }();
  for (const TechniqueInfo& info : techniques()) {
    const bool discrete = info.target == TargetSupport::discrete || info.target == TargetSupport::both;
    if (info.bias == Bias::unbiased && discrete && info.id != "reference")
      expect_same_mean(session, std::string(info.id), exact, pooled);
  }
}

const std::string shared = HALFLIGHT_SHARED_DATA;

INSTANTIATE_TEST_SUITE_P(
    Scenes, UnbiasedScenes,
    testing::Values(SceneCase{"cornell", "cornell", LightSelection::all},
                    SceneCase{"bedroom", "bedroom", LightSelection::indirect},
                    SceneCase{"hotel_room", shared + "/gltf/interiors/hotel-room/hotel-room.glb",
                              LightSelection::all},
                    SceneCase{"flight_helmet_sky", shared + "/gltf/khronos/FlightHelmet/FlightHelmet.gltf",
                              LightSelection::all}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace halflight
