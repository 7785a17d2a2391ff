// The plan against counters: a stage that is out is never called and holds nothing, one that is in is called.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <set>

#include "session.h"
#include "support/simple_scenes.h"

namespace halflight {
namespace {

// ---- Scenes that need different stages ----

Camera camera_above(float height, float distance) {
  Camera camera;
  camera.position = {0, height, distance};
  camera.back = glm::normalize(camera.position);
  camera.right = {1, 0, 0};
  camera.up = glm::cross(camera.back, camera.right);
  return camera;
}

/// A floor and a wall behind it.
Scene corner(const Material& material) {
  Scene scene;
  scene.materials.push_back(material);
  add_patch(scene, {-2, 0, 2}, {4, 0, 0}, {0, 0, -4});
  add_patch(scene, {-2, 0, -2}, {4, 0, 0}, {0, 2, 0});
  scene.cameras.push_back(camera_above(1.5f, 3));
  return scene;
}

Material grey() { return diffuse_material(Vec3(0.5f)); }

Material glossy() {
  Material material;
  material.base_color = Vec4(0.8f, 0.8f, 0.8f, 1);
  material.metallic = 1, material.roughness = 0.05f;
  return material;
}

PunctualLight lamp(float x) {
  PunctualLight light;
  light.position = {x, 1.5f, 0.5f};
  light.intensity = Vec3(2);
  return light;
}

Scene under_sky(const Material& material) {
  Scene scene = corner(material);
  scene.environment = constant_environment(Vec3(1));
  return scene;
}

Scene with_lamps(int count) {
  Scene scene = corner(grey());
  for (int i = 0; i < count; ++i) scene.lights.push_back(lamp(0.1f * static_cast<float>(i)));
  return scene;
}

Scene with_emitter() {
  Scene scene = corner(grey());
  scene.materials.push_back(grey());
  scene.materials.back().emission = Vec3(5);
  add_patch(scene, {-0.5f, 1.8f, -0.5f}, {1, 0, 0}, {0, 0, 1}, 1);
  return scene;
}

/// A pane that is half there, in the camera's way and the light's.
Scene with_mask() {
  Scene scene = under_sky(grey());
  Material pane = grey();
  pane.base_color.w = 0.5f;
  pane.alpha_mode = AlphaMode::blend;
  scene.materials.push_back(pane);
  add_patch(scene, {-1, 0.2f, 1}, {2, 0, 0}, {0, 2, 0}, 1);
  return scene;
}

Scene nothing_reflects() {
  Scene scene = under_sky(grey());
  scene.materials[0].unlit = true;
  return scene;
}

Scene all_kinds() {
  Scene scene = with_emitter();
  scene.materials[0] = glossy();
  scene.environment = constant_environment(Vec3(0.5f));
  for (int i = 0; i < 12; ++i) scene.lights.push_back(lamp(0.1f * static_cast<float>(i)));
  return scene;
}

struct SceneCase {
  const char* name;
  Scene scene;
};

std::vector<SceneCase> scenes() {
  return {{"sky", under_sky(grey())},    {"glossy sky", under_sky(glossy())}, {"a lamp", with_lamps(1)},
          {"12 lamps", with_lamps(12)},  {"emitter", with_emitter()},         {"mask", with_mask()},
          {"unlit", nothing_reflects()}, {"all kinds", all_kinds()}};
}

RenderSettings small(std::string_view technique, std::optional<Target> target, LightSelection light) {
  RenderSettings settings;
  settings.technique = technique, settings.target = target, settings.light = light;
  settings.width = 24, settings.height = 16;
  settings.backend = Backend::none;
  settings.values.set("lights.count", "256");
  return settings;
}

/// Every technique in each of its targets.
template <class F>
void for_each_technique(const F& f) {
  for (const TechniqueInfo& info : techniques()) {
    for (const Target target : {Target::discrete, Target::continuous}) {
      if (info.device == Device::gpu) continue;
      const bool own = info.target == TargetSupport::own;
      try {
        choose_target(info, target);
      } catch (const Error&) {
        continue;
      }
      f(info, own ? std::nullopt : std::optional(target));
    }
  }
}

constexpr std::array selections{LightSelection::all, LightSelection::direct, LightSelection::indirect};

/// The contract.
void expect_counters_follow_the_plan(const Session& session) {
  const SessionStats& stats = session.stats();
  for (size_t i = 0; i < stage_count; ++i) {
    const auto stage = static_cast<Stage>(i);
    const StageCounter& counter = stats.stages[stage];
    if (session.plan().runs.has(stage)) {
      EXPECT_GT(counter.calls, 0u) << stage_name(stage) << " is in";
    } else {
      EXPECT_EQ(counter.calls, 0u) << stage_name(stage) << " is out";
      EXPECT_EQ(counter.bytes, 0u) << stage_name(stage) << " is out";
      EXPECT_EQ(counter.seconds, 0.0) << stage_name(stage) << " is out";
    }
  }
}

void two_rounds(Session& session) {
  for (int round = 0; round < 2; ++round) session.run_pass(8, 1, 0);
}

TEST(Plan, CountersFollowItForEveryTechniqueTargetAndSelection) {
  size_t in = 0, out = 0;
  for (const SceneCase& c : scenes()) {
    Messages messages;
    for_each_technique([&](const TechniqueInfo& info, std::optional<Target> target) {
      for (const LightSelection light : selections) {
        SCOPED_TRACE(fmt::format("{}, {}, {}, light {}", c.name, info.id,
                                 target ? target_name(*target) : "own", static_cast<int>(light)));
        Session session(c.scene, small(info.id, target, light), messages);
        two_rounds(session);
        expect_counters_follow_the_plan(session);
        for (const PlanStage& stage : session.plan().stages) ++(stage.runs ? in : out);
      }
    });
  }
  EXPECT_GT(in, 1000u);
  EXPECT_GT(out, 1000u);
}

TEST(Plan, CountersFollowItWhenOneSessionGoesThroughAll) {
  for (const SceneCase& c : {SceneCase{"all kinds", all_kinds()}, SceneCase{"a lamp", with_lamps(1)}}) {
    Messages messages;
    Session session(c.scene, small("bidirectional", std::nullopt, LightSelection::all), messages);
    for_each_technique([&](const TechniqueInfo& info, std::optional<Target> target) {
      for (const LightSelection light : selections) {
        SCOPED_TRACE(fmt::format("{}, {}, {}", c.name, info.id, static_cast<int>(light)));
        session.set_settings(small(info.id, target, light));
        two_rounds(session);
        expect_counters_follow_the_plan(session);
      }
    });
  }
}

TEST(Plan, CountersFollowItWhenLightsChange) {
  for (const char* id : {"bidirectional", "halflight"}) {
    SCOPED_TRACE(id);
    Messages messages;
    Session session(all_kinds(), small(id, std::nullopt, LightSelection::all), messages);
    two_rounds(session);
    expect_counters_follow_the_plan(session);
    EXPECT_TRUE(session.plan().runs.has(Stage::punctual_points));
    EXPECT_TRUE(session.plan().runs.has(Stage::emitter_points));

    LightEdits edits = session.light_edits();
    edits.lights.resize(2), edits.environment_strength = 0;
    session.edit_lights(edits);
    two_rounds(session);
    expect_counters_follow_the_plan(session);
    EXPECT_FALSE(session.plan().runs.has(Stage::punctual_points));
    EXPECT_FALSE(session.plan().runs.has(Stage::environment_points));
    EXPECT_TRUE(session.plan().runs.has(Stage::direct_punctual));

    edits.lights.clear();
    for (Vec3& emission : edits.emission) emission = Vec3(0);
    session.edit_lights(edits);
    two_rounds(session);
    expect_counters_follow_the_plan(session);
    EXPECT_FALSE(session.plan().runs.has(Stage::light_tree));
    EXPECT_EQ(session.film().mean_radiance(), Vec3(0));
  }
}

// ---- What facts lead to ----

Plan plan_of(const Scene& scene, std::string_view technique, LightSelection light = LightSelection::all,
             const std::vector<std::pair<std::string, std::string>>& set = {}) {
  SettingValues values;
  for (const auto& [key, value] : set) values.set(key, value);
  const TechniqueInfo& info = find_technique(technique);
  return make_plan(scene_needs(scene), {info, choose_target(info, {}), light, values, "", "a test"});
}

TEST(Plan, LeavesOutWhatTheSceneDoesNotHave) {
  const auto out = [](const Plan& plan, Stage stage) { return !plan.runs.has(stage); };
  EXPECT_TRUE(out(plan_of(with_lamps(1), "bidirectional"), Stage::environment_points));
  EXPECT_TRUE(out(plan_of(under_sky(grey()), "bidirectional"), Stage::direct_punctual));
  EXPECT_TRUE(out(plan_of(under_sky(grey()), "bidirectional"), Stage::counted_brdf_rays));
  EXPECT_FALSE(out(plan_of(under_sky(glossy()), "bidirectional"), Stage::counted_brdf_rays));
  EXPECT_TRUE(out(plan_of(under_sky(grey()), "bidirectional"), Stage::alpha_filter));
  EXPECT_FALSE(out(plan_of(with_mask(), "bidirectional"), Stage::alpha_filter));
  EXPECT_TRUE(out(plan_of(under_sky(grey()), "light-bvh"), Stage::cut));

  // BRDF rays of halflight: for lobes and for light that may be near, and for nothing else.
  EXPECT_TRUE(out(plan_of(under_sky(grey()), "halflight", LightSelection::direct), Stage::traced_brdf_rays));
  EXPECT_FALSE(
      out(plan_of(under_sky(glossy()), "halflight", LightSelection::direct), Stage::traced_brdf_rays));
  EXPECT_FALSE(out(plan_of(under_sky(grey()), "halflight"), Stage::traced_brdf_rays));
  EXPECT_TRUE(out(plan_of(under_sky(grey()), "halflight", LightSelection::direct), Stage::pilot_set));
  EXPECT_FALSE(out(plan_of(under_sky(grey()), "halflight"), Stage::pilot_set));
  EXPECT_TRUE(
      out(plan_of(under_sky(grey()), "halflight", LightSelection::all, {{"halflight.visibility", "0"}}),
          Stage::learned_visibility));

  // Clusters can only be near where light is.
  EXPECT_TRUE(out(plan_of(under_sky(grey()), "bidirectional", LightSelection::direct), Stage::near_clusters));
  EXPECT_FALSE(out(plan_of(with_emitter(), "bidirectional", LightSelection::direct), Stage::near_clusters));

  // Few lights are their own clusters.
  const Plan few = plan_of(with_lamps(12), "bidirectional", LightSelection::direct);
  EXPECT_TRUE(out(few, Stage::cut));
  EXPECT_TRUE(out(few, Stage::near_clusters));
  EXPECT_FALSE(out(few, Stage::light_tree));
  EXPECT_EQ(few.cut, CutMaking::leaves);
  EXPECT_EQ(plan_of(with_lamps(100), "bidirectional", LightSelection::direct).cut, CutMaking::refined);
}

TEST(Plan, MovesOnlyWhatIsAnimated) {
  Scene scene = under_sky(grey());
  EXPECT_FALSE(plan_of(scene, "halflight").runs.has(Stage::animation));
  scene.facts.animations = 2, scene.facts.at_seconds = 1.5;
  const Plan plan = plan_of(scene, "halflight");
  EXPECT_TRUE(plan.runs.has(Stage::animation));
  EXPECT_NE(plan.stages.front().why.find("2 animations posed at 1.5 s"), std::string::npos);
}

TEST(Plan, GivesAReasonForEachStageOnce) {
  for (const SceneCase& c : scenes())
    for_each_technique([&](const TechniqueInfo& info, std::optional<Target>) {
      std::set<Stage> seen;
      for (const PlanStage& stage : plan_of(c.scene, info.id).stages) {
        EXPECT_FALSE(stage.why.empty());
        EXPECT_TRUE(seen.insert(stage.stage).second) << stage_name(stage.stage);
      }
    });
}

// ---- What is left out changes no picture ----

std::vector<Vec3> picture(const Scene& scene, RenderSettings settings, StageSet forced) {
  Messages messages;
  settings.forced = forced;
  Session session(scene, settings, messages);
  two_rounds(session);
  return session.film().image().pixels;
}

void expect_same_bits(const Scene& scene, const RenderSettings& settings,
                      std::initializer_list<Stage> stages) {
  const TechniqueInfo& info = find_technique(settings.technique);
  const Plan plan = make_plan(scene_needs(scene), {info, choose_target(info, settings.target), settings.light,
                                                   settings.values, "", "a test"});
  StageSet forced;
  for (const Stage stage : stages) {
    EXPECT_FALSE(plan.runs.has(stage))
        << stage_name(stage) << " is no stage that " << info.id << " leaves out";
    forced.add(stage);
  }
  EXPECT_EQ(picture(scene, settings, {}), picture(scene, settings, forced)) << stage_name(*stages.begin());
}

TEST(Plan, ForcedStagesChangeNoPicture) {
  const auto of = [](const char* id, Target target, LightSelection light) {
    return small(id, target, light);
  };
  expect_same_bits(under_sky(grey()), of("bidirectional", Target::discrete, LightSelection::all),
                   {Stage::alpha_filter});
  expect_same_bits(under_sky(grey()), of("mis", Target::continuous, LightSelection::all),
                   {Stage::surface_points, Stage::environment_points, Stage::light_tree, Stage::cut});
  expect_same_bits(with_lamps(12), of("bidirectional", Target::discrete, LightSelection::direct),
                   {Stage::cut});
  expect_same_bits(under_sky(grey()), of("light-bvh", Target::discrete, LightSelection::all), {Stage::cut});
  expect_same_bits(under_sky(grey()), of("bidirectional", Target::discrete, LightSelection::direct),
                   {Stage::near_clusters});
  expect_same_bits(under_sky(grey()), of("bidirectional", Target::discrete, LightSelection::direct),
                   {Stage::surface_points});
  expect_same_bits(under_sky(grey()), of("path", Target::continuous, LightSelection::all), {Stage::gbuffer});
  expect_same_bits(under_sky(grey()), of("bidirectional", Target::discrete, LightSelection::all),
                   {Stage::antialiasing});
}

/// Without BRDF rays halflight has the same mean on a diffuse scene under distant light.
TEST(Plan, SparedBrdfRaysKeepTheMean) {
  Scene scene = under_sky(grey());
  scene.environment.map.at(10, 5) = Vec3(300);  // a sun beside the sky
  RenderSettings settings = small("halflight", {}, LightSelection::direct);
  Messages messages;
  Session session(scene, settings, messages);
  ASSERT_FALSE(session.plan().runs.has(Stage::traced_brdf_rays));
  const auto mean_and_error = [&](StageSet forced) {
    double sum = 0, squares = 0;
    constexpr int seeds = 24;
    for (int seed = 0; seed < seeds; ++seed) {
      settings.seed = static_cast<uint64_t>(seed), settings.forced = forced;
      session.set_settings(settings);
      session.start_over();
      for (int round = 0; round < 4; ++round) session.run_pass(8, 1, 0);
      const double mean = luminance(session.film().mean_radiance());
      sum += mean / seeds, squares += mean * mean / seeds;
    }
    return std::pair(sum, std::sqrt(std::max(0.0, squares - sum * sum) / (seeds - 1)));
  };
  const auto [without, error] = mean_and_error({});
  const auto [with, other_error] = mean_and_error(StageSet().add(Stage::traced_brdf_rays));
  EXPECT_LT(std::hypot(error, other_error), 0.003 * with) << "too noisy to tell";
  EXPECT_NEAR(without, with, 4 * std::hypot(error, other_error));
}

TEST(Plan, PixelCentresAreTheDiscreteTargetsOwn) {
  Messages messages;
  const Scene scene = with_mask();
  RenderSettings discrete = small("bidirectional", Target::discrete, LightSelection::all),
                 centres = small("halflight", Target::continuous, LightSelection::all);
  centres.pixel_centres = true;
  Session session(scene, discrete, messages);
  const auto draws = [&] { return session.stats().stages[Stage::environment_points].calls; };
  const std::vector<GBufferTexel> seen = session.frame().gbuffer->texels;
  session.set_settings(centres);
  const uint64_t draws_before = draws();
  for (int round = 0; round < 3; ++round) {
    session.run_pass(8, 1, 0);
    for (size_t i = 0; i < seen.size(); ++i)
      ASSERT_EQ(session.frame().gbuffer->texels[i].position, seen[i].position) << i;
  }
  expect_counters_follow_the_plan(session);
  EXPECT_EQ(draws() - draws_before, 3u) << "light is drawn afresh all the same";
  centres.pixel_centres = false;
  session.set_settings(centres);
  session.run_pass(8, 1, 0);
  EXPECT_NE(session.frame().gbuffer->texels[200].position, seen[200].position);
}

// ---- With OpenGL ----

TEST(Plan, CountersFollowItOnOpenGl) {
  const auto on_gl = [](std::string_view id, Target target, LightSelection light) {
    RenderSettings settings = small(
        id, find_technique(id).target == TargetSupport::own ? std::nullopt : std::optional(target), light);
    settings.backend = Backend::egl;
    return settings;
  };
  Messages messages;
  std::unique_ptr<Session> session;
  try {
    session = std::make_unique<Session>(
        with_lamps(2), on_gl("bidirectional", Target::discrete, LightSelection::all), messages);
  } catch (const Error&) {
    GTEST_SKIP() << "no EGL on this machine";
  }
  two_rounds(*session);
  expect_counters_follow_the_plan(*session);
  EXPECT_TRUE(session->plan().runs.has(Stage::shadow_maps));
  EXPECT_GE(session->stats().stages[Stage::shadow_maps].bytes, 2u * 6 * 1024 * 1024 * 4);
  for (const auto& [id, target] : {std::pair{"bidirectional", Target::continuous},
                                   {"filtered", Target::continuous},
                                   {"path", Target::continuous},
                                   {"mis", Target::discrete}}) {
    SCOPED_TRACE(id);
    session->set_settings(on_gl(id, target, LightSelection::direct));
    two_rounds(*session);
    expect_counters_follow_the_plan(*session);
  }
  // More lights than OpenGL has room for shadow maps need none.
  Session many(with_lamps(1000), on_gl("bidirectional", Target::discrete, LightSelection::direct), messages);
  two_rounds(many);
  expect_counters_follow_the_plan(many);
  EXPECT_TRUE(many.gl());
  EXPECT_FALSE(many.plan().runs.has(Stage::shadow_maps));
  Session sky(under_sky(glossy()), on_gl("filtered", Target::continuous, LightSelection::all), messages);
  two_rounds(sky);
  expect_counters_follow_the_plan(sky);
  EXPECT_GT(sky.stats().stages[Stage::gpu_environment].bytes, 0u);
}

}  // namespace
}  // namespace halflight
