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

// Blocks of 4×4 in the first, of 16×16 in the second; pixels that lie apart where nothing is shared.
TEST(Subsets, AllOfThemAreOneWholePass) {
  Messages messages;
  for (const auto& [technique, width, height] :
       {std::tuple("bidirectional", 50, 35), std::tuple("bidirectional", 300, 260),
        std::tuple("mis", 50, 35)}) {
    Session session(load_scene("cornell", {}, messages), settings_of(technique, width, height), messages);
    EXPECT_EQ(session.neighbours_share(), std::string_view(technique) == "bidirectional");
    session.run_pass(3, 1, 0);
    const std::vector<Vec3> whole = session.film().image().pixels;
    session.start_over();
    size_t pixels = 0;
    for (uint32_t subset = 0; subset < Session::subsets; ++subset) pixels += session.run_subset(3, subset);
    EXPECT_EQ(pixels, session.film().image().pixels.size());
    for (uint32_t i = 0; i < pixels; ++i) ASSERT_EQ(session.film().samples(i), 3u) << technique << " " << i;
    EXPECT_TRUE(session.film().image().pixels == whole) << technique << " " << width;
  }
}

}  // namespace
}  // namespace halflight
