// Pictures made subset by subset, as timed ones and the window make them.
#include <gtest/gtest.h>

#include "session.h"

namespace halflight {
namespace {

RenderSettings settings_of(const std::string& technique, int width, int height) {
  RenderSettings settings;
  settings.technique = technique, settings.target = Target::discrete;
  settings.width = width, settings.height = height;
  settings.backend = Backend::none;
  settings.values.set("lights.count", "1000");
  return settings;
}

/// Runs a round subset by subset, and expects each pixel to have its samples, once.
void run_round_in_subsets(Session& session, uint32_t samples) {
  const double before = session.film().mean_samples();
  size_t pixels = 0;
  const uint32_t count = session.subset_count();
  for (uint32_t subset = 0; subset < count; ++subset) pixels += session.run_subset(samples, subset);
  EXPECT_EQ(pixels, session.film().image().pixels.size());
  for (uint32_t i = 0; i < pixels; ++i) ASSERT_EQ(session.film().samples(i), before + samples) << i;
}

// Pixels that lie apart where nothing is shared; blocks of 4×4 or, in larger pictures, of 16×16 where it is.
TEST(Subsets, AllOfThemAreOneWholePass) {
  Messages messages;
  for (const auto& [technique, width, height] :
       {std::tuple("bidirectional", 50, 35), std::tuple("bidirectional", 300, 260),
        std::tuple("bidirectional", 2, 1), std::tuple("mis", 50, 35), std::tuple("mis", 3, 2)}) {
    Session session(load_scene("cornell", {}, messages), settings_of(technique, width, height), messages);
    for (int round = 0; round < 2; ++round) session.run_pass(3, 1, 0);
    const std::vector<Vec3> whole = session.film().image().pixels;
    session.start_over();
    for (int round = 0; round < 2; ++round) run_round_in_subsets(session, 3);
    EXPECT_TRUE(session.film().image().pixels == whole) << technique << " " << width;
  }
}

TEST(Subsets, TheFirstOfAFilmLeavesNoPixelWithoutANeighbour) {
  Messages messages;
  for (const char* technique : {"bidirectional", "mis"}) {
    Session session(load_scene("cornell", {}, messages), settings_of(technique, 50, 35), messages);
    session.run_subset(2, 0);
    for (uint32_t y = 0; y < 35; y += 4)
      for (uint32_t x = 0; x < 50; x += 4) ASSERT_EQ(session.film().samples(y * 50 + x), 2u) << technique;
  }
}

TEST(Visits, GiveEachPixelItsOwnNumber) {
  Messages messages;
  for (const TechniqueInfo& info : techniques()) {
    const bool discrete = info.target == TargetSupport::both || info.target == TargetSupport::discrete;
    if (!discrete || info.exact) continue;
    Session session(load_scene("cornell", {}, messages), settings_of(std::string(info.id), 50, 35), messages);
    std::vector<uint16_t> visits(50 * 35);
    for (size_t i = 0; i < visits.size(); ++i) visits[i] = std::array<uint16_t, 4>{0, 1, 2, 7}[i % 4];
    session.run_visits(7, visits);
    const Film& film = session.film();
    for (uint32_t i = 0; i < visits.size(); ++i) {
      ASSERT_EQ(film.samples(i), visits[i]) << info.id << " " << i;
      if (visits[i] == 0) {
        ASSERT_EQ(film.radiance(i), Vec3(0)) << info.id;
      }
    }
  }
}

}  // namespace
}  // namespace halflight
