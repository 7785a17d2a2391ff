// `halflight`: what it has learned is forgotten when it must be, and no setting moves the mean.
#include <gtest/gtest.h>

#include "core/parallel.h"
#include "support/halflight_rooms.h"

namespace halflight {
namespace {

// ---- Pictures ----

std::vector<Vec3> rounds(Session& session, int count, uint32_t samples = 3) {
  for (int i = 0; i < count; ++i) session.run_pass(samples, 1, 0);
  EXPECT_EQ(session.film().nan_samples(), 0u);
  return session.film().image().pixels;
}

/// Without writing thousands of pixels where they differ.
bool same(const std::vector<Vec3>& a, const std::vector<Vec3>& b) { return a == b; }

std::vector<Vec3> picture_of_new_session(int count, uint32_t samples = 3) {
  Messages messages;
  Session session(lit_corner(), halflight_settings(48, 33), messages);
  return rounds(session, count, samples);
}

TEST(Halflight, SameBitsForAnyNumberOfThreads) {
  for (const uint32_t samples : {3u, 17u}) {  // one position in the pixel, and four
    set_thread_count(1);
    const std::vector<Vec3> one = picture_of_new_session(4, samples);
    set_thread_count(2);
    EXPECT_TRUE(same(picture_of_new_session(4, samples), one));
    set_thread_count(5);
    EXPECT_TRUE(same(picture_of_new_session(4, samples), one));
  }
  set_thread_count(0);
}

// Which pixels share a distribution hangs on which are visited together; without sharing nothing does.
TEST(Halflight, SubsetsOfPixelsMakeAWholePass) {
  Messages messages;
  const RenderSettings settings = halflight_settings(48, 33, {{"halflight.share", "0"}});
  Session at_once(lit_corner(), settings, messages);
  const std::vector<Vec3> whole = rounds(at_once, 3, 9);
  for (const uint32_t stride : {2u, 4u}) {
    Session session(lit_corner(), settings, messages);
    for (int round = 0; round < 3; ++round)
      for (uint32_t offset = 0; offset < stride * stride; ++offset) session.run_pass(9, stride, offset);
    EXPECT_TRUE(same(session.film().image().pixels, whole)) << stride;
  }
}

TEST(Halflight, ARestartForgetsAllThatWasLearned) {
  const std::vector<Vec3> fresh = picture_of_new_session(3);
  for (const int before : {1, 2, 5}) {
    Messages messages;
    Session session(lit_corner(), halflight_settings(48, 33), messages);
    rounds(session, before);
    session.restart();
    EXPECT_TRUE(same(rounds(session, 3), fresh)) << "after " << before << " rounds";
    session.start_over();
    EXPECT_TRUE(same(rounds(session, 3), fresh)) << "started over";
  }
}

TEST(Halflight, ARestartWithOtherSamplesDrawsItsOwnSet) {
  const std::vector<Vec3> fresh = picture_of_new_session(2, 64);
  Messages messages;
  Session session(lit_corner(), halflight_settings(48, 33), messages);
  rounds(session, 1, 1);
  session.restart();
  EXPECT_TRUE(same(rounds(session, 2, 64), fresh));
}

TEST(Halflight, AnotherCameraLearnsItsOwn) {
  const Scene scene = lit_corner();
  Scene turned = scene;
  turned.cameras = {look_at({0.3f, 0.9f, 1.5f}, {0.6f, 0.1f, 0.3f}, {0, 1, 0}, 0.7f)};
  Messages messages;
  Session fresh(turned, halflight_settings(48, 33), messages);
  const std::vector<Vec3> expected = rounds(fresh, 3);
  for (const int before : {1, 3}) {
    Session session(scene, halflight_settings(48, 33), messages);
    rounds(session, before);
    session.set_camera(turned.cameras[0]);
    EXPECT_TRUE(same(rounds(session, 3), expected)) << "after " << before << " rounds";
  }
}

TEST(Halflight, EditsOfLightAreSeen) {
  Messages messages;
  Session session(lit_corner(), halflight_settings(48, 33), messages);
  rounds(session, 2);
  LightEdits edits = session.light_edits();
  edits.environment_rotation += 1, edits.emission[2] *= 3.0f;
  session.edit_lights(edits);
  Scene scene = lit_corner();
  scene.environment.rotation += 1, scene.materials[2].emission *= 3.0f;
  Session fresh(scene, halflight_settings(48, 33), messages);
  EXPECT_TRUE(same(rounds(session, 2), rounds(fresh, 2)));
}

/// The corner's pixels after some passes, all lengths and all light scaled.
std::vector<Vec3> scaled_corner(float length, float light, int passes = 3) {
  Scene scene = full_room();
  for (Vertex& vertex : scene.vertices) vertex.position *= length;
  for (PunctualLight& lamp : scene.lights)
    lamp.position *= length, lamp.intensity = lamp.intensity * length * length * light;
  for (Vec3& texel : scene.environment.map.pixels) texel *= light;
  for (Material& material : scene.materials) material.emission *= light;
  update_bounds(scene);
  std::vector<GBufferTexel> pixels = corner_pixels();
  for (GBufferTexel& texel : pixels) texel.position *= length;
  TracedScene s(std::move(scene), std::move(pixels), all_kinds);
  const auto technique = make_technique(s, "halflight", {"lights.count=200"});
  std::vector<Vec3> picture;
  for (int pass = 0; pass < passes; ++pass)
    picture = one_pass(s, *technique, static_cast<uint32_t>(pass), 16);
  return picture;
}

TEST(Halflight, ScalesWithLengthAndLight) {
  const std::vector<Vec3> as_it_is = scaled_corner(1, 1);
  for (const auto& [length, light] :
       {std::pair{-20, 0}, {20, 0}, {0, -20}, {0, 20}, {20, -20}, {0, -90}, {0, 90}}) {
    const std::vector<Vec3> scaled = scaled_corner(std::ldexp(1.0f, length), std::ldexp(1.0f, light));
    for (size_t i = 0; i < scaled.size(); ++i)
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(std::ldexp(scaled[i][c], -light), as_it_is[i][c], 1e-4 * as_it_is[i][c])
            << length << " " << light << " " << i;
  }
}

TEST(Halflight, NoLightIsBlack) {
  for (const LightKinds kinds : {LightKinds{}, all_kinds}) {
    TracedScene s(floor_scene(2), corner_pixels(), kinds);
    const auto technique = make_technique(s, "halflight");
    for (uint32_t pass = 0; pass < 3; ++pass)
      for (const Vec3 value : one_pass(s, *technique, pass, 8)) EXPECT_EQ(value, Vec3(0));
  }
}

TEST(Halflight, StopsWhenAskedAndGoesOnAsIfNothingHappened) {
  Messages messages;
  Session session(lit_corner(), halflight_settings(48, 33), messages);
  rounds(session, 1);
  std::stop_source source;
  source.request_stop();
  session.run_pass(3, 1, 0, source.get_token());
  session.restart();
  EXPECT_TRUE(same(rounds(session, 3), picture_of_new_session(3)));
}

// ---- No setting moves the mean ----

struct SettingsCase {
  const char* name;
  std::vector<std::string> set;
  uint32_t samples = 16, passes = 800;
  double widest = 0.01;  ///< relative standard error that is worth a verdict
};

void PrintTo(const SettingsCase& c, std::ostream* out) { *out << c.name; }

class HalflightSettings : public testing::TestWithParam<SettingsCase> {
 protected:
  /// The truth: `mis`, which shares neither strata nor cut.
  static const PassMoments& truth() {
    static const PassMoments moments = [] {
      TracedScene s(full_room(), corner_pixels(), all_kinds);
      const auto mis = make_technique(s, "mis");
      return pass_moments(s, *mis, 64, 6000);
    }();
    return moments;
  }
};

TEST_P(HalflightSettings, KeepTheMean) {
  TracedScene s(full_room(), corner_pixels(), all_kinds);
  const auto technique = make_technique(s, "halflight", GetParam().set);
  const PassMoments found = pass_moments(s, *technique, GetParam().samples, GetParam().passes);
  const double bound = two_sided_bound(sidak_level(0.001, found.mean.size()));
  for (size_t i = 0; i < found.mean.size(); ++i) {
    const double error = std::hypot(found.error(i), truth().error(i));
    EXPECT_NEAR(found.mean[i], truth().mean[i], bound * error + 1e-5 * truth().mean[i]) << i;
    EXPECT_LT(error, GetParam().widest * truth().mean[i]) << i << ": too noisy to tell";
  }
}

INSTANTIATE_TEST_SUITE_P(
    Extremes, HalflightSettings,
    testing::Values(
        SettingsCase{"as_it_is", {"lights.count=100"}},
        SettingsCase{"light_samples_alone",
                     {"lights.count=100", "halflight.brdf-share=0", "halflight.specular-share=0"}},
        SettingsCase{"brdf_rays_alone",
                     {"lights.count=100", "halflight.brdf-share=1", "halflight.specular-share=1"},
                     16,
                     800,
                     0.02},
        SettingsCase{"half_of_each", {"lights.count=100", "halflight.brdf-share=0.5"}, 16, 2000},
        SettingsCase{"one_sample", {"lights.count=100"}, 1, 3000, 0.02},
        SettingsCase{"two_samples", {"lights.count=100"}, 2, 2000, 0.02},
        SettingsCase{"no_visibility", {"lights.count=100", "halflight.visibility=0"}},
        SettingsCase{"one_stratum", {"lights.count=1"}, 32, 6000, 0.03},
        SettingsCase{"cut_of_one", {"lights.count=100", "cut.least=1", "cut.most=1"}},
        SettingsCase{"cut_of_all", {"lights.count=100", "cut.least=100000", "cut.most=100000"}},
        SettingsCase{"guard_alone", {"lights.count=100", "halflight.alpha=1"}, 16, 800, 0.02},
        SettingsCase{"no_guard", {"lights.count=100", "halflight.alpha=0"}},
        SettingsCase{"points_lit_well", {"lights.count=100", "halflight.light-rays=32"}, 16, 300, 0.02}),
    [](const auto& test) { return std::string(test.param.name); });

// Rays do not find punctual light: a lobe too narrow for light samples of anything else still reflects it.
TEST(Halflight, MirrorsShowPunctualLight) {
  Scene scene = floor_scene(2, Vec3(0));
  const Vec3 mirrored = glm::normalize(Vec3(-0.6f, 0.8f, 0.01f));
  for (int i = 0; i < 9; ++i) {
    PunctualLight light;
    light.position = (1 + 0.1f * static_cast<float>(i)) * mirrored, light.intensity = Vec3(1e-4f);
    scene.lights.push_back(light);
  }
  for (const float alpha : {0.3f, 5e-4f}) {
    const GBufferTexel texel =
        seen_point({0, 0, 0}, {0, 1, 0}, {BrdfModel::ggx, Vec3(0), Vec3(1), 1, Vec2(alpha)},
                   glm::normalize(Vec3(0.6f, 0.8f, -0.01f)));
    for (const LightKinds kinds :
         {LightKinds{false, false, false, true}, LightKinds{false, false, true, true}})
      for (const char* share : {"0.125", "1"}) {
        TracedScene s(scene, {texel}, kinds);
        double truth = 0;
        for (const PunctualLight& light : scene.lights) {
          const LightConnection link = connect_punctual(light, scene, texel.position);
          truth += evaluate(texel.brdf, texel.basis(), texel.wo, link.wi).y *
                   glm::dot(texel.shading_normal, link.wi) * link.irradiance.y;
        }
        const auto technique =
            make_technique(s, "halflight",
                           {"lights.count=10", std::string("halflight.brdf-share=") + share,
                            std::string("halflight.specular-share=") + share});
        const PassMoments found = pass_moments(s, *technique, 16, 200);
        EXPECT_GT(truth, 0);
        EXPECT_NEAR(found.mean[0], truth, 4 * found.error(0) + 1e-3 * truth)
            << "alpha " << alpha << ", share " << share << ", surfaces " << kinds.surfaces;
      }
  }
}

// Where the pilot's point fell, a stratum may be black: what it holds is found all the same, by light samples
// too.
TEST(Halflight, LightThePilotMissedIsFound) {
  Scene scene = floor_scene(2, Vec3(0));
  ImageRgb map(64, 32, Vec3(0));
  RandomStream random(9, 9, 9);
  for (Vec3& texel : map.pixels) texel = random.next() < 0.3f ? Vec3(2) : Vec3(0);
  scene.environment = make_environment(map, "stars", EnvironmentLayout::latlong);
  const GBufferTexel texel =
      seen_point({0, 0, 0}, {0, 1, 0}, diffuse_brdf(Vec3(0.8f)), glm::normalize(Vec3(0.6f, 0.8f, 0)));
  double truth = 0;
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x)
      for (int i = 0; i < 16; ++i)
        for (int j = 0; j < 16; ++j) {
          const Vec2 uv = (Vec2(x, y) + (Vec2(i, j) + 0.5f) / 16.0f) / Vec2(map.width, map.height);
          const Vec3 wi = environment_direction(scene.environment, uv);
          const double omega = 2 * pi * pi / (64.0 * 32 * 256) * std::sin(pi * uv.y);
          truth += 0.8 / pi * std::max(0.0f, wi.y) * map.at(x, y).y * omega;
        }
  for (const char* share : {"0.125", "0"}) {
    TracedScene s(scene, {texel}, {true, false, false, false});
    const auto technique =
        make_technique(s, "halflight", {"lights.count=60", std::string("halflight.brdf-share=") + share});
    const PassMoments found = pass_moments(s, *technique, 16, 4000);
    EXPECT_LT(found.error(0), 0.01 * truth);
    EXPECT_NEAR(found.mean[0], truth, 4 * found.error(0) + 2e-3 * truth) << share;
  }
}

// The same of an emitter that shines in spots.
TEST(Halflight, EmittersThatShineInSpotsAreFoundWhole) {
  Scene scene = floor_scene(2, Vec3(0));
  Material spotted = diffuse_material(Vec3(0));
  spotted.emission = Vec3(4);
  ImageRgba8 spots{16, 16, std::vector<uint8_t>(4 * 256, 255)};
  for (size_t i = 0; i < 256; ++i)
    for (size_t c = 0; c < 3; ++c) spots.bytes[4 * i + c] = (i / 16 + i) % 4 == 0 ? 255 : 0;
  scene.images.push_back(spots);
  Texture texture;
  texture.nearest = true;
  scene.textures.push_back(texture);
  spotted.emission_texture.texture = 0;
  scene.materials.push_back(spotted);
  add_patch(scene, {-0.5f, 1, -0.5f}, {1, 0, 0}, {0, 0, 1}, 1);
  const GBufferTexel texel =
      seen_point({0, 0, 0}, {0, 1, 0}, diffuse_brdf(Vec3(0.8f)), glm::normalize(Vec3(0.6f, 0.8f, 0)));
  TracedScene truth_scene(scene, {texel}, {false, true, false, false});
  const auto mis = make_technique(truth_scene, "mis");
  const PassMoments truth = pass_moments(truth_scene, *mis, 256, 1000);
  for (const char* share : {"0.5", "0.125", "0"}) {
    TracedScene s(scene, {texel}, {false, true, false, false});
    const auto technique =
        make_technique(s, "halflight", {"lights.count=100", std::string("halflight.brdf-share=") + share});
    const PassMoments found = pass_moments(s, *technique, 16, 6000);
    EXPECT_NEAR(found.mean[0], truth.mean[0], 4 * std::hypot(found.error(0), truth.error(0))) << share;
    EXPECT_LT(found.error(0), 0.1 * truth.mean[0]) << share;
  }
}

}  // namespace
}  // namespace halflight
