// A technique of the GPU in a session: OpenGL is made for it where nothing else asks for it, and not without
// leave.
#include <gtest/gtest.h>

#include "session.h"

namespace halflight {
namespace {

RenderSettings small(const std::string& technique, Backend backend) {
  RenderSettings settings;
  settings.technique = technique;
  settings.width = 32, settings.height = 24;
  settings.backend = backend;
  settings.values.set("lights.count", "512");
  return settings;
}

bool has_gl() {
  try {
    GlContext::make_headless(Backend::automatic);
    return true;
  } catch (const Error&) {
    return false;
  }
}

Session open(const char* scene, const RenderSettings& settings, Messages& messages) {
  return Session(load_scene(scene, {}, messages), settings, messages);
}

const PlanStage* stage(const Plan& plan, Stage wanted) {
  for (const PlanStage& s : plan.stages)
    if (s.stage == wanted) return &s;
  return nullptr;
}

TEST(FilteredSession, IsRefusedWithoutABackEnd) {
  Messages messages;
  const Scene scene = load_scene("glossy-sphere", {}, messages);
  try {
    Session session(scene, small("filtered", Backend::none), messages);
    ADD_FAILURE() << "opened";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::no_gl);
    EXPECT_NE(std::string(error.what()).find("filtered"), std::string::npos);
  }
  // A session that is open goes on as it was.
  Session session(scene, small("bidirectional", Backend::none), messages);
  EXPECT_THROW(session.set_settings(small("filtered", Backend::none)), Error);
  EXPECT_EQ(session.settings().technique, "bidirectional");
  session.run_pass(4, 1, 0);
  EXPECT_GT(session.film().mean_radiance().y, 0);
}

TEST(FilteredSession, OpensOpenGlWhenSwitchedToAndLetsItRestAfterwards) {
  if (!has_gl()) GTEST_SKIP() << "no OpenGL on this machine";
  Messages messages;
  Session session = open("glossy-sphere", small("bidirectional", Backend::automatic), messages);
  session.run_pass(4, 1, 0);
  const bool gl_before = session.gl().has_value();
  const std::vector<Vec3> before = session.film().image().pixels;

  session.set_settings(small("filtered", Backend::automatic));
  EXPECT_EQ(session.round_samples(1000), 1000u);
  session.run_pass(40, 1, 0);
  ASSERT_TRUE(session.gl());
  EXPECT_TRUE(session.frame().raster);
  EXPECT_GT(session.stats().seconds.gpu, 0);
  EXPECT_EQ(session.stats().light_count, 0u);
  EXPECT_EQ(session.film().mean_samples(), 40);
  EXPECT_LT(session.estimated_relmse(), 0);
  EXPECT_FALSE(session.plan().redraws);
  const PlanStage* gpu = stage(session.plan(), Stage::gpu_environment);
  ASSERT_TRUE(gpu);
  EXPECT_TRUE(gpu->runs);
  EXPECT_NE(gpu->why.find("shadows"), std::string::npos);
  const std::vector<Vec3> filtered = session.film().image().pixels;

  // By subsets, and again after another technique: the same bits.
  session.restart();
  for (uint32_t offset = 0; offset < 16; ++offset) session.run_pass(40, 4, offset);
  EXPECT_EQ(session.film().image().pixels, filtered);
  session.set_settings(small("bidirectional", Backend::automatic));
  session.run_pass(4, 1, 0);
  EXPECT_EQ(session.gl().has_value(), gl_before);
  EXPECT_EQ(session.frame().raster != nullptr, gl_before);
  EXPECT_EQ(session.film().image().pixels, before);
  EXPECT_FALSE(stage(session.plan(), Stage::gpu_environment));
  session.set_settings(small("filtered", Backend::automatic));
  session.run_pass(40, 1, 0);
  EXPECT_EQ(session.film().image().pixels, filtered);
}

TEST(FilteredSession, FollowsSettingsAndEdits) {
  if (!has_gl()) GTEST_SKIP() << "no OpenGL on this machine";
  Messages messages;
  RenderSettings settings = small("filtered", Backend::automatic);
  Session session = open("glossy-sphere", settings, messages);
  const auto picture = [&] {
    session.run_pass(16, 1, 0);
    return session.film().image().pixels;
  };
  const std::vector<Vec3> first = picture();
  for (const auto& [key, value] :
       {std::pair{"filtered.filter", "off"}, {"filtered.bias", "3"}, {"filtered.map-size", "64"}}) {
    RenderSettings other = settings;
    other.values.set(key, value);
    session.set_settings(other);
    EXPECT_NE(picture(), first) << key;
  }
  session.set_settings(settings);
  EXPECT_EQ(picture(), first);

  // Light twice as strong is twice as much, the environment that is seen included; turned, it is another
  // picture.
  LightEdits edits = session.light_edits();
  edits.environment_strength *= 2;
  session.edit_lights(edits);
  const std::vector<Vec3> twice = picture();
  for (size_t i = 0; i < first.size(); ++i) EXPECT_NEAR(twice[i].y, 2 * first[i].y, 1e-5f * twice[i].y);
  edits.environment_rotation += 1;
  session.edit_lights(edits);
  EXPECT_NE(picture(), twice);

  // Asked for indirect light only, it has none to give.
  settings.light = LightSelection::indirect;
  session.set_settings(settings);
  for (const Vec3& pixel : picture()) EXPECT_EQ(max_component(pixel), 0);
}

TEST(FilteredSession, AStopLeavesTheFilmAsItWas) {
  if (!has_gl()) GTEST_SKIP() << "no OpenGL on this machine";
  Messages messages;
  Session session = open("glossy-sphere", small("filtered", Backend::automatic), messages);
  std::stop_source stop;
  stop.request_stop();
  session.run_pass(40, 1, 0, stop.get_token());
  EXPECT_EQ(session.film().mean_samples(), 0);
}

}  // namespace
}  // namespace halflight
