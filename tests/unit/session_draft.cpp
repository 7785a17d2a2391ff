// Drafts: the picture that stands in while something moves.
#include <gtest/gtest.h>

#include "film/metrics.h"
#include "film/preview.h"
#include "session.h"

namespace halflight {
namespace {

RenderSettings small(const std::string& technique) {
  RenderSettings settings;
  settings.technique = technique;
  settings.width = 32, settings.height = 24;
  settings.backend = Backend::none;
  settings.values.set("lights.count", "6000");
  return settings;
}

ImageRgb picture_of(Session& session) {
  session.run_pass(16, 1, 0);
  return session.film().image();
}

TEST(Draft, ShowsTheSameLightFromFewerPoints) {
  Messages messages;
  for (const char* id : {"halflight", "bidirectional", "mis", "light-bvh"}) {
    Session session(load_scene("cornell", {}, messages), small(id), messages);
    session.set_draft(true);
    ASSERT_TRUE(session.drafting()) << id;
    const ImageRgb draft = picture_of(session);
    EXPECT_LE(session.stats().light_count, 2 * 4096 + 4096u) << id;
    EXPECT_EQ(session.settings(), small(id)) << id;
    session.set_draft(false);
    EXPECT_FALSE(session.drafting()) << id;
    EXPECT_EQ(session.film().mean_samples(), 0) << id << ": a draft's samples are no part of the picture";
    // A draft sees pixel centres: so small a picture is not the same along every edge.
    EXPECT_LT(measure_error(draft, picture_of(session)).flip, 0.2) << id;
  }
}

TEST(Draft, LeavesWhatThePictureHasMade) {
  Messages messages;
  Session session(load_scene("cornell", {}, messages), small("halflight"), messages);
  picture_of(session);
  const SessionStats made = session.stats();
  ASSERT_GT(made.stages[Stage::pilot_set].calls, 0u);
  session.set_draft(true);
  picture_of(session);
  session.set_draft(false);
  picture_of(session);
  // Two pictures of one session, the second with the pilot of the first.
  Session other(load_scene("cornell", {}, messages), small("halflight"), messages);
  picture_of(other);
  EXPECT_EQ(measure_error(session.film().image(), other.film().image()).rmse, 0);
  EXPECT_EQ(session.stats().stages[Stage::pilot_set].calls, 0u) << "counted since the stage came back";
}

// Settings that change while a small draft stands make the draft whole again before it is drawn.
TEST(Draft, ASmallOneLeavesNothingBehindWhenSettingsChange) {
  Messages messages;
  RenderSettings settings = small("bidirectional");
  settings.target = Target::discrete;
  Session session(load_scene("cornell", {}, messages), settings, messages);
  session.set_draft(true, 0.5f);
  picture_of(session);
  settings.seed = 1;
  session.set_settings(settings);
  session.set_draft(false);
  const ImageRgb picture = picture_of(session);
  Session other(load_scene("cornell", {}, messages), settings, messages);
  EXPECT_TRUE(picture.pixels == picture_of(other).pixels);
  for (uint32_t i = 0; i < picture.pixels.size(); ++i) ASSERT_EQ(session.film().samples(i), 16u);
}

TEST(Draft, MayBeSmallerThanThePicture) {
  Messages messages;
  Session session(load_scene("cornell", {}, messages), small("halflight"), messages);
  session.set_draft(true, 0.5f);
  const ImageRgb draft = picture_of(session);
  EXPECT_EQ(draft.width, 16);
  EXPECT_EQ(draft.height, 12);
  EXPECT_EQ(session.gbuffer().width, 16);
  session.set_draft(true, 0.25f);
  EXPECT_EQ(picture_of(session).width, 8) << "another size without a picture between them";
  session.set_draft(false);
  const ImageRgb picture = picture_of(session);
  ASSERT_EQ(picture.width, 32);
  EXPECT_LT(measure_error(resized(draft, 32, 24), picture).flip, 0.3);
  // Nothing of the drafts is left in the picture.
  Session other(load_scene("cornell", {}, messages), small("halflight"), messages);
  EXPECT_EQ(measure_error(picture, picture_of(other)).rmse, 0);
}

TEST(Draft, LightsAndCameraReachBoth) {
  Messages messages;
  Session session(load_scene("cornell", {}, messages), small("halflight"), messages);
  const auto mean = [&](bool draft) {
    session.set_draft(draft);
    picture_of(session);
    return session.film().mean_radiance().y;
  };
  const double picture = mean(false), draft = mean(true);
  LightEdits edits = session.light_edits();
  for (Vec3& emission : edits.emission) emission *= 4.0f;
  for (PunctualLight& light : edits.lights) light.intensity *= 4.0f;
  session.edit_lights(edits);
  EXPECT_NEAR(mean(true) / draft, 4, 0.2);
  EXPECT_NEAR(mean(false) / picture, 4, 0.2);

  Camera away = session.camera();
  away.position += 100.0f * session.scene().bounds.diagonal() * away.back;
  away.back = -away.back, away.right = -away.right;
  session.set_draft(true);
  session.set_camera(away);
  for (const bool of_draft : {true, false}) EXPECT_EQ(mean(of_draft), 0) << of_draft;
}

TEST(Draft, IsLeftOutWhereATechniqueHasNone) {
  Messages messages;
  for (const char* id : {"path", "reference"}) {
    Session session(load_scene("cornell", {}, messages), small(id), messages);
    EXPECT_FALSE(session.has_draft()) << id;
    session.set_draft(true);
    EXPECT_FALSE(session.drafting()) << id;
  }
  // Settings that have none end one.
  Session session(load_scene("cornell", {}, messages), small("halflight"), messages);
  session.set_draft(true);
  session.set_settings(small("path"));
  EXPECT_FALSE(session.drafting());
  EXPECT_GT(luminance(picture_of(session).at(16, 12)), 0);
}

}  // namespace
}  // namespace halflight
