// Whole pictures do not hang on the units of length and light, nor on where the world's origin lies, under
// any technique: every power of two in lengths and radiances is a power of two in the picture, up to
// rounding.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "session.h"
#include "support/simple_scenes.h"

namespace halflight {
namespace {

/// A corner with a block, under every kind of light. All corners have coordinates of few bits, for any
/// `offset` of few bits: moving the world rounds none of them.
Scene every_light(float size, int lamps) {
  Scene scene;
  scene.materials.push_back(diffuse_material(Vec3(0.6f, 0.5f, 0.4f)));
  Material glossy = diffuse_material(Vec3(0.2f));
  glossy.phong_specular = Vec3(0.4f), glossy.exponents = Vec2(20);
  scene.materials.push_back(glossy);
  Material shining = diffuse_material(Vec3(0));
  shining.emission = Vec3(4, 5, 6);
  scene.materials.push_back(shining);
  const float s = size / 4;
  add_patch(scene, {-2 * s, 0, 2 * s}, {4 * s, 0, 0}, {0, 0, -4 * s});
  add_patch(scene, {-2 * s, 0, -2 * s}, {4 * s, 0, 0}, {0, 2 * s, 0}, 1);
  add_patch(scene, {-s, s, 0}, {0.5f * s, 0, 0}, {0, 0, -s}, 1);
  add_patch(scene, {s, 2 * s, -s}, {0.5f * s, 0, 0}, {0, 0, s}, 2);
  ImageRgb map(32, 16, Vec3(0.5f));
  map.at(5, 4) = Vec3(20, 18, 15);
  scene.environment = make_environment(std::move(map), "sky", EnvironmentLayout::latlong);
  for (int i = 0; i < lamps; ++i) {
    PunctualLight lamp;
    lamp.position = s * Vec3(0.25f * static_cast<float>(i - lamps / 2), 1.5f, 1);
    lamp.intensity = Vec3(s * s / static_cast<float>(lamps));
    scene.lights.push_back(lamp);
  }
  Camera camera;
  camera.position = s * Vec3(0.5f, 1.75f, 4);
  camera.back = glm::normalize(Vec3(0.1f, 0.3f, 1));
  camera.right = glm::normalize(glm::cross(Vec3(0, 1, 0), camera.back));
  camera.up = glm::cross(camera.back, camera.right);
  scene.cameras.push_back(camera);
  return scene;
}

void scale(Scene& scene, float length, float light) {
  for (Vertex& vertex : scene.vertices) vertex.position *= length;
  for (Material& material : scene.materials) material.emission *= light;
  for (PunctualLight& lamp : scene.lights)
    lamp.position *= length, lamp.intensity = lamp.intensity * length * length * light;
  for (Vec3& texel : scene.environment.map.pixels) texel *= light;
  for (Camera& camera : scene.cameras) camera.position *= length;
  update_bounds(scene);
}

void move(Scene& scene, Vec3 by) {
  for (Vertex& vertex : scene.vertices) vertex.position += by;
  for (PunctualLight& lamp : scene.lights) lamp.position += by;
  for (Camera& camera : scene.cameras) camera.position += by;
  update_bounds(scene);
}

struct Case {
  std::string_view technique;
  std::optional<Target> target;
  int lamps;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.technique; }

/// Every technique of the registry that needs no OpenGL, in each of its targets; with a handful of lamps, and
/// with more.
std::vector<Case> cases() {
  std::vector<Case> all;
  for (const TechniqueInfo& info : techniques()) {
    if (info.device == Device::gpu) continue;
    for (const int lamps : {2, 12}) {
      if (info.target == TargetSupport::own) all.push_back({info.id, {}, lamps});
      if (info.target == TargetSupport::discrete || info.target == TargetSupport::both)
        all.push_back({info.id, Target::discrete, lamps});
      if (info.target == TargetSupport::continuous || info.target == TargetSupport::both)
        all.push_back({info.id, Target::continuous, lamps});
    }
  }
  return all;
}

class Invariance : public testing::TestWithParam<Case> {
 protected:
  static std::vector<Vec3> picture(const Scene& scene, uint64_t seed = 0, int rounds = 2) {
    const Case& c = GetParam();
    RenderSettings settings;
    settings.technique = c.technique, settings.target = c.target, settings.seed = seed;
    settings.width = 32, settings.height = 24, settings.backend = Backend::none;
    settings.values.set("lights.count", "256");
    Messages messages;
    Session session(scene, settings, messages);
    for (int round = 0; round < rounds; ++round) session.run_pass(8, 1, 0);
    EXPECT_EQ(session.film().nan_samples(), 0u);
    EXPECT_EQ(session.stats().rays.rejected, 0u);
    return session.film().image().pixels;
  }
};

TEST_P(Invariance, OfLengthsAndRadiances) {
  const std::vector<Vec3> reference = picture(every_light(4, GetParam().lamps));
  double mean = 0;
  for (const Vec3& pixel : reference) mean += luminance(pixel) / static_cast<double>(reference.size());
  ASSERT_GT(mean, 0.1);
  for (const auto& [length, light] : {std::pair{-20, 0}, {20, 0}, {0, -20}, {0, 20}, {20, -20}}) {
    SCOPED_TRACE(fmt::format("lengths 2^{}, light 2^{}", length, light));
    Scene scene = every_light(4, GetParam().lamps);
    scale(scene, std::ldexp(1.0f, length), std::ldexp(1.0f, light));
    const std::vector<Vec3> scaled = picture(scene);
    for (size_t i = 0; i < scaled.size(); ++i)
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(std::ldexp(static_cast<double>(scaled[i][c]), -light), reference[i][c],
                    1e-4 * std::max<double>(reference[i][c], mean))
            << "pixel " << i;
  }
}

double mean_luminance(const std::vector<Vec3>& picture) {
  double sum = 0;
  for (const Vec3& pixel : picture) sum += luminance(pixel) / static_cast<double>(picture.size());
  return sum;
}

/// A room of 2^14 units, 1e6 away: a float's step there is 2^-4, 4e-6 of the room, and rays start 2.4 units
/// (2^-19 + 2^-21 of 1e6), 1.5e-4 of the room, off a surface. Such a step at edges and contacts turns a ray
/// in a few thousand, and no more: 0.3 % of the mean. Where positions round another way, so do the trees that
/// are built over them, and the same random numbers draw other lights: beyond that 0.3 % means differ by
/// their noise, and only by it.
TEST_P(Invariance, AWorldFarAwayLosesOnlyTheResolutionOfFloats) {
  const Scene scene = every_light(16384, GetParam().lamps);
  Scene far = scene;
  move(far, Vec3(1e6f, -1e6f, 1e6f));
  const bool exact = find_technique(GetParam().technique).exact;
  const int seeds = exact ? 1 : 24;
  double mean = 0, sum = 0, squares = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    const std::vector<Vec3> near_picture = picture(scene, static_cast<uint64_t>(seed)),
                            far_picture = picture(far, static_cast<uint64_t>(seed));
    const double level = mean_luminance(near_picture), difference = mean_luminance(far_picture) - level;
    mean += level / seeds, sum += difference / seeds, squares += difference * difference / seeds;
    if (!exact) continue;
    size_t apart = 0;
    for (size_t i = 0; i < near_picture.size(); ++i)
      apart += std::abs(luminance(far_picture[i]) - luminance(near_picture[i])) >
               0.02 * luminance(near_picture[i]);
    EXPECT_LE(static_cast<double>(apart), 0.01 * static_cast<double>(near_picture.size()));
  }
  ASSERT_GT(mean, 0);
  const double error = exact ? 0 : std::sqrt(std::max(0.0, squares - sum * sum) / (seeds - 1));
  EXPECT_LT(error, 0.01 * mean) << "too noisy to tell";
  EXPECT_LT(std::abs(sum), 0.003 * mean + 4 * error) << "noise " << error / mean;
}

INSTANTIATE_TEST_SUITE_P(Techniques, Invariance, testing::ValuesIn(cases()), [](const auto& test) {
  std::string name(test.param.technique);
  std::replace(name.begin(), name.end(), '-', '_');
  return fmt::format("{}_{}_{}_lamps", name, test.param.target ? target_name(*test.param.target) : "own",
                     test.param.lamps);
});

}  // namespace
}  // namespace halflight
