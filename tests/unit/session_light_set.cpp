// S, its tree and the cut are made for techniques that use them, and for no other.
#include <gtest/gtest.h>

#include "session.h"

namespace halflight {
namespace {

RenderSettings small(const std::string& technique, std::optional<Target> target) {
  RenderSettings settings;
  settings.technique = technique, settings.target = target;
  settings.width = 16, settings.height = 12;
  settings.backend = Backend::none;
  settings.values.set("lights.count", "512");
  return settings;
}

const PlanStage& stage(const Plan& plan, Stage wanted) {
  for (const PlanStage& s : plan.stages)
    if (s.stage == wanted) return s;
  throw std::runtime_error("no such stage");
}

void expect_left_out(Session& session) {
  for (int round = 0; round < 3; ++round) session.run_pass(4, 1, 0);
  EXPECT_EQ(session.stats().light_count, 0u);
  EXPECT_EQ(session.stats().cut_size, 0u);
  EXPECT_EQ(session.stats().seconds.lights, 0);
  EXPECT_EQ(session.frame().tree->lights.size(), 0u);
  EXPECT_EQ(session.frame().cut->size, 0u);
  EXPECT_FALSE(session.plan().light_set);
  for (const Stage left_out : {Stage::light_tree, Stage::cut, Stage::surface_points, Stage::emitter_points}) {
    EXPECT_FALSE(stage(session.plan(), left_out).runs) << stage_name(left_out);
    EXPECT_NE(stage(session.plan(), left_out).why.find("needs no S"), std::string::npos)
        << stage_name(left_out);
  }
  EXPECT_GT(session.film().mean_radiance().y, 0);
}

void expect_made(Session& session) {
  session.run_pass(4, 1, 0);
  EXPECT_GT(session.stats().light_count, 0u);
  EXPECT_GT(session.stats().cut_size, 0u);
  EXPECT_GT(session.stats().seconds.lights, 0);
  EXPECT_TRUE(stage(session.plan(), Stage::light_tree).runs);
}

TEST(LightSet, IsLeftOutForTechniquesThatFollowRays) {
  for (const auto& [id, target] : {std::pair<const char*, std::optional<Target>>{"mis", Target::continuous},
                                   {"brdf", Target::continuous},
                                   {"instant", std::nullopt}}) {
    SCOPED_TRACE(id);
    Messages messages;
    Session session(load_scene("cornell", {}, messages), small(id, target), messages);
    expect_left_out(session);
  }
}

TEST(LightSet, IsMadeForTechniquesThatDrawFromIt) {
  for (const auto& [id, target] : {std::pair{"mis", Target::discrete},
                                   {"brdf", Target::discrete},
                                   {"bidirectional", Target::continuous}}) {
    SCOPED_TRACE(id);
    Messages messages;
    Session session(load_scene("cornell", {}, messages), small(id, target), messages);
    expect_made(session);
  }
}

TEST(LightSet, ComesAndGoesWithTheTechnique) {
  Messages messages;
  Session session(load_scene("cornell", {}, messages), small("bidirectional", Target::continuous), messages);
  expect_made(session);
  session.set_settings(small("mis", Target::continuous));
  expect_left_out(session);
  session.set_settings(small("mis", Target::discrete));
  expect_made(session);
  session.set_settings(small("instant", std::nullopt));
  expect_left_out(session);
}

TEST(LightSet, EditedLightsReachTechniquesWithoutIt) {
  for (const char* id : {"mis", "brdf", "instant"}) {
    Messages messages;
    RenderSettings settings = small(id, std::nullopt);
    settings.target = Target::continuous;
    settings.light = LightSelection::indirect;
    Session session(load_scene("cornell", {}, messages), settings, messages);
    session.run_pass(64, 1, 0);
    const float before = session.film().mean_radiance().y;
    LightEdits edits = session.light_edits();
    for (Vec3& emission : edits.emission) emission *= 4.0f;
    session.edit_lights(edits);
    session.run_pass(64, 1, 0);
    EXPECT_NEAR(session.film().mean_radiance().y, 4 * before, 1e-3 * before) << id;
    for (Vec3& emission : edits.emission) emission = Vec3(0);
    session.edit_lights(edits);
    session.run_pass(4, 1, 0);
    EXPECT_EQ(session.film().mean_radiance(), Vec3(0)) << id;
  }
}

TEST(LightSet, EditedLampsLeaveWhatTheCameraSees) {
  Messages messages;
  Scene scene = load_scene("cornell", {}, messages);
  PunctualLight lamp;
  lamp.position = scene.bounds.centre(), lamp.intensity = Vec3(2);
  scene.lights.push_back(lamp);
  scene.lights.back().position.x += 0.1f;
  const RenderSettings settings = small("bidirectional", Target::discrete);
  Session edited(scene, settings, messages);
  edited.run_pass(4, 1, 0);
  const uint64_t drawn = edited.stats().stages[Stage::gbuffer].calls;
  LightEdits edits = edited.light_edits();
  edits.lights.back().intensity *= 3.0f;
  edited.edit_lights(edits);
  edited.run_pass(4, 1, 0);
  EXPECT_EQ(edited.stats().stages[Stage::gbuffer].calls, drawn);

  scene.lights.back().intensity *= 3.0f;
  Session opened(scene, settings, messages);
  opened.run_pass(4, 1, 0);
  EXPECT_EQ(edited.film().image().pixels, opened.film().image().pixels);

  // Emission is seen.
  for (Vec3& emission : edits.emission) emission *= 2.0f;
  edited.edit_lights(edits);
  edited.run_pass(4, 1, 0);
  EXPECT_EQ(edited.stats().stages[Stage::gbuffer].calls, drawn + 1);
}

}  // namespace
}  // namespace halflight
