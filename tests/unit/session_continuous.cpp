// Techniques that are unbiased for the integral against the path tracer, which shares nothing with them but
// scene, BRDF and Embree; tile by tile, over independent seeds. Quick by default; with HALFLIGHT_FULL_TESTS
// set (./check --full) to a standard error of about 0.3 %, every case's line printed and written to the
// folder it names.
#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>

#include "scene/view_file.h"
#include "support/paired_tiles.h"

namespace halflight {
namespace {

constexpr double level = 0.01;

const std::string shared = HALFLIGHT_SHARED_DATA;

struct SceneCase {
  std::string name;
  std::string scene{};  ///< file, where the name is no built-in scene
  std::string view{};   ///< of tests/views.json
  std::string environment{};
  uint32_t effort = 2;  ///< of full runs: samples for a standard error of about 0.3 %, in units of 64
};

void PrintTo(const SceneCase& c, std::ostream* out) { *out << c.name; }

struct TechniqueCase {
  const char* id;
  uint32_t rounds;
  /// Whether all pixels of a round share their lights, and little else: then tiles err together, and their z
  /// do not spread as independent ones do.
  bool shares_lights = false;
  uint32_t samples = 1;  ///< of a round, in units of the run's: several look through positions of their own
};

class ContinuousTarget : public testing::TestWithParam<SceneCase> {
 protected:
  static inline double pooled_squares = 0;
  static inline size_t pooled_tiles = 0;

  /// Over all scenes there are tiles enough to say more of how z spreads.
  static void TearDownTestSuite() {
    if (!full() || pooled_tiles < 150) return;
    const double rms = std::sqrt(pooled_squares / static_cast<double>(pooled_tiles));
    std::printf("halflight over all scenes: RMS z %.3f of %zu tiles\n", rms, pooled_tiles);
    EXPECT_GT(rms, 0.9);
    EXPECT_LT(rms, 1.1);
  }

  static bool full() { return std::getenv("HALFLIGHT_FULL_TESTS") != nullptr; }

  static Scene load(const SceneCase& c, Messages& messages) {
    Scene scene = load_scene(c.scene.empty() ? c.name : c.scene, {}, messages);
    if (!c.view.empty()) apply_view(scene, read_view(HALFLIGHT_VIEWS, c.view), {}, messages);
    if (!c.environment.empty()) scene.environment = load_environment(c.environment, {}, messages);
    return scene;
  }
};

std::vector<TechniqueCase> techniques_to_compare(bool full) {
  if (!full) return {{"halflight", 8, false, 4}, {"mis", 32}};
  return {{"halflight", 32, false, 4}, {"mis", 64}, {"brdf", 96}, {"bidirectional", 32, true}};
}

TEST_P(ContinuousTarget, TilesHaveTheMeansOfThePathTracer) {
  const SceneCase& c = GetParam();
  if (!c.scene.empty() && !std::filesystem::exists(c.scene))
    GTEST_SKIP() << "the shared data is not beside this checkout";
  Messages messages;
  Scene scene = load(c, messages);
  RenderSettings settings;
  settings.technique = "path", settings.backend = Backend::none;
  settings.values.set("lights.count", full() ? "4000" : "1000");  // of a size with the picture
  Session session(std::move(scene), settings, messages);
  const Camera camera = session.camera();

  TileRun path_run;
  path_run.rounds = 1, path_run.samples = 64;
  if (full()) path_run.width = 96, path_run.height = 64, path_run.samples *= c.effort;
  const SeedMeans truth = run_seeds(session, camera, "path", path_run, 1000);
  for (const TechniqueCase& technique : techniques_to_compare(full())) {
    TileRun run = path_run;
    run.rounds = technique.rounds,
    run.samples = technique.samples * (full() ? std::max(2u, c.effort / 2) : 2);
    const TileVerdict verdict = compare_tiles(run_seeds(session, camera, technique.id, run, 1), truth);
    const std::string line = fmt::format(
        "{:<16} {:<14} {:>4} tiles  largest |z| {:.2f}  RMS z {:.3f}  mean {:+.3f} % ± {:.3f}  tile error "
        "{:.2f} % to {:.2f} %",
        c.name, technique.id, verdict.tiles, verdict.largest_z, verdict.rms(), 100 * verdict.mean_difference,
        100 * verdict.mean_error, 100 * verdict.median_error, 100 * verdict.largest_error);
    RecordProperty(technique.id, line);
    if (full()) std::printf("%s\n", line.c_str()), std::fflush(stdout);

    SCOPED_TRACE(line);
    ASSERT_GE(verdict.tiles, tile_count(run) / 4);
    EXPECT_LE(verdict.largest_z, two_sided_bound(sidak_level(level, verdict.tiles)));
    EXPECT_LE(std::abs(verdict.mean_difference), 0.002 + 3 * verdict.mean_error);
    const bool is_default = technique.id == std::string("halflight");
    if (is_default) pooled_squares += verdict.squares, pooled_tiles += verdict.tiles;
    EXPECT_LE(verdict.median_error, !full() ? 0.03 : is_default ? 0.004 : 0.02) << "too noisy to tell";
    // Σz² follows χ² with a degree a tile; too small a spread is as wrong as too large a one.
    if (technique.shares_lights) continue;
    const double tail = chi_square_tail(verdict.squares, static_cast<double>(verdict.tiles));
    EXPECT_GT(tail, 0.001);
    EXPECT_LT(tail, 0.999);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, ContinuousTarget,
    testing::Values(SceneCase{.name = "cornell"}, SceneCase{.name = "bedroom", .effort = 8},
                    SceneCase{.name = "spheres"}, SceneCase{.name = "box", .effort = 8},
                    SceneCase{.name = "statue"},
                    SceneCase{.name = "FlightHelmet",
                              .scene = shared + "/gltf/khronos/FlightHelmet/FlightHelmet.gltf",
                              .environment = shared + "/env/latlong-hdr/venice_sunset_1k.hdr",
                              .effort = 1},
                    SceneCase{.name = "SheenChair",
                              .scene = shared + "/gltf/khronos/SheenChair/SheenChair.gltf",
                              .environment = shared + "/env/latlong-hdr/potsdamer_platz_1k.hdr",
                              .effort = 1},
                    SceneCase{.name = "hotel_room",
                              .scene = shared + "/gltf/interiors/hotel-room/hotel-room.glb",
                              .view = "hotel-room",
                              .effort = 6},
                    SceneCase{.name = "LightsPunctualLamp",
                              .scene = shared + "/gltf/khronos/LightsPunctualLamp/LightsPunctualLamp.gltf",
                              .view = "LightsPunctualLamp",
                              .effort = 6}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace halflight
