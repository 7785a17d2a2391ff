#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "viewer/render_thread.h"

namespace halflight {
namespace {

using namespace std::chrono_literals;

RenderSettings small_picture() {
  RenderSettings settings;
  settings.width = 48, settings.height = 36;
  settings.backend = Backend::none;
  settings.values.set("lights.count", "512");
  return settings;
}

SceneLoader built_in(const char* name) {
  return [name](Messages& messages, DisplaySettings&) { return load_scene(name, {}, messages); };
}

/// Waits until `done` of the latest snapshot; null after a minute.
std::shared_ptr<const Snapshot> wait_for(RenderThread& thread,
                                         const std::function<bool(const Snapshot&)>& done) {
  for (int i = 0; i < 6000; ++i) {
    const auto snapshot = thread.latest();
    if (snapshot && done(*snapshot)) return snapshot;
    std::this_thread::sleep_for(10ms);
  }
  return nullptr;
}

std::optional<RenderThread::Notice> wait_for_error(RenderThread& thread) {
  for (int i = 0; i < 6000; ++i) {
    if (auto notice = thread.next_notice(); notice && notice->error) return notice;
    std::this_thread::sleep_for(10ms);
  }
  return {};
}

TEST(DraftScale, FollowsWhatDraftsCost) {
  EXPECT_EQ(next_draft_scale(0.01, 1, 1), 1);
  EXPECT_EQ(next_draft_scale(1e3, 1, 1), 0.25f) << "there is a smallest";
  // Cost goes with the pixels: whatever a draft of the full size takes, the next is there in time.
  for (double full = 0.05; full < 1; full *= 1.3) {
    const float scale = next_draft_scale(full, 1, 1);
    EXPECT_LE(full * scale * scale, 0.09) << full;
    EXPECT_EQ(next_draft_scale(full * scale * scale, scale, scale), scale)
        << "and the one after it as large: " << full;
  }
  // Two frames about as slow do not change it to and fro.
  EXPECT_EQ(next_draft_scale(0.089, 1, 0.875f), 0.875f);
  EXPECT_EQ(next_draft_scale(0.05, 1, 0.875f), 1);
}

TEST(RenderThread, ConvergesToTheLimitAndRests) {
  RenderThread thread(built_in("cornell"), small_picture(), {}, 40);
  const auto done = wait_for(thread, [](const Snapshot& s) { return s.converged; });
  ASSERT_TRUE(done);
  EXPECT_EQ(done->mean_samples, 40) << "whole rounds, and no sample too many";
  EXPECT_GT(done->estimated_relmse, 0);
  EXPECT_GT(luminance(done->picture.at(24, 18)), 0);
  std::this_thread::sleep_for(100ms);
  EXPECT_EQ(thread.latest()->mean_samples, done->mean_samples);
}

// Where some pixels come before all others.
TEST(RenderThread, ConvergesToTheLimitWhereNeighboursShare) {
  RenderSettings settings = small_picture();
  settings.technique = "bidirectional", settings.target = Target::discrete;
  RenderThread thread(built_in("cornell"), settings, {}, 40);
  const auto done = wait_for(thread, [](const Snapshot& s) { return s.converged; });
  ASSERT_TRUE(done);
  EXPECT_EQ(done->mean_samples, 40);
}

TEST(RenderThread, ABadFileLeavesTheOldScene) {
  RenderThread thread(built_in("cornell"), small_picture(), {}, 100000);
  ASSERT_TRUE(wait_for(thread, [](const Snapshot& s) { return s.mean_samples > 0; }));
  thread.open(
      [](Messages&, DisplaySettings&) -> Scene { throw input_error("room.gltf", "meshes[0]", "broken"); });
  const auto notice = wait_for_error(thread);
  ASSERT_TRUE(notice);
  EXPECT_EQ(notice->text, "room.gltf: meshes[0]: broken");
  const auto before = thread.latest();
  ASSERT_TRUE(wait_for(thread, [&](const Snapshot& s) { return s.mean_samples > before->mean_samples; }))
      << "the old scene no longer converges";
  EXPECT_EQ(thread.latest()->scene_number, before->scene_number);
  EXPECT_NO_THROW(thread.rethrow_if_nothing_opened());
}

TEST(RenderThread, NothingOpenedRethrowsTheReason) {
  RenderThread thread([](Messages&, DisplaySettings&) -> Scene { throw usage_error("no such scene"); },
                      small_picture(), {}, 8);
  ASSERT_TRUE(wait_for_error(thread));
  EXPECT_THROW(thread.rethrow_if_nothing_opened(), Error);
  EXPECT_FALSE(thread.latest());
}

TEST(RenderThread, ChangesStartThePictureAgain) {
  RenderThread thread(built_in("cornell"), small_picture(), {}, 100000);
  const auto first = wait_for(thread, [](const Snapshot& s) { return s.mean_samples > 12; });
  ASSERT_TRUE(first);

  RenderSettings settings = small_picture();
  settings.technique = "illumination";
  thread.set_settings(settings);
  ASSERT_TRUE(wait_for(thread, [](const Snapshot& s) { return s.technique == "illumination"; }));

  Camera camera = first->opened->cameras.front();
  camera.position += 0.1f * camera.right;
  ASSERT_TRUE(wait_for(thread, [](const Snapshot& s) { return s.mean_samples > 200; }));
  const double before = thread.latest()->mean_samples;
  thread.set_camera(camera);
  EXPECT_TRUE(wait_for(thread, [&](const Snapshot& s) { return s.mean_samples < before; }));

  // Switching the only lamp off leaves nothing but black.
  LightEdits dark = first->opened->lights;
  for (Vec3& emission : dark.emission) emission = Vec3(0);
  for (PunctualLight& light : dark.lights) light.intensity = Vec3(0);
  thread.edit_lights(dark);
  EXPECT_TRUE(wait_for(thread, [&](const Snapshot& s) {
    return std::all_of(s.picture.pixels.begin(), s.picture.pixels.end(),
                       [](Vec3 p) { return max_component(p) == 0; });
  }));
}

TEST(RenderThread, EndsWhileAPassIsInFlight) {
  RenderSettings settings = small_picture();
  settings.width = 640, settings.height = 480;
  for (int i = 0; i < 3; ++i) {
    RenderThread thread(built_in("cornell"), settings, {}, 100000);
    std::this_thread::sleep_for(std::chrono::milliseconds(40 * i));
  }
}

}  // namespace
}  // namespace halflight
