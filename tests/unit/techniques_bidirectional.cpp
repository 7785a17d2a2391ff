#include <gtest/gtest.h>

#include "support/box_room.h"
#include "support/statistics.h"

namespace halflight {
namespace {

/// Mean over many passes of one pixel under distant light alone, against the exact sum.
double expected_over_true(Room& room, uint32_t passes) {
  const auto technique = find_technique("bidirectional").make();
  technique->prepare(room.frame);
  Film film(room.gbuffer.width, room.gbuffer.height);
  for (uint32_t pass = 0; pass < passes; ++pass) {
    PassRequest request;
    request.pass = pass, request.samples = 32;
    technique->run_pass(room.frame, request, film);
  }
  double mean = 0;
  for (uint32_t i = 0; i < room.gbuffer.texels.size(); ++i)
    mean += film.radiance(i).y / room.gbuffer.texels.size();
  return mean / room.exact(0).y;
}

/// A sun in a faint sky at the flank of a Phong lobe of exponent 10 with no diffuse part: counting rays
/// seldom meet its cluster, and as printed it then has probability 0.
struct SunOnALobe {
  RoomOptions options;
  std::vector<Brdf> brdf{{BrdfModel::phong, Vec3(0), Vec3(1), 1, Vec2(10)}};

  SunOnALobe() {
    options.wall_lights = 0, options.lamps = 0, options.sky_lights = 8000, options.sun = 0;
    options.cut.least = 300, options.cut.most = 1000;
  }
  std::unique_ptr<Room> room() const {
    auto made = std::make_unique<Room>(options, brdf, 64);
    GBufferTexel texel = made->gbuffer.texels[0];
    texel.position = options.size * Vec3(0.5f, 0, 0.9f);
    texel.geometric_normal = texel.shading_normal = {0, 1, 0};
    texel.tangent = {1, 0, 0};
    texel.wo = glm::normalize(Vec3(0, 1, 0.2f));
    for (auto& t : made->gbuffer.texels) t = texel;
    // The sun: one direction well inside the sky, 0.4 rad off the mirror direction.
    std::vector<VirtualLight> lights = sky_lights(options.sky_lights, 0, 2);
    const Vec3 sun = glm::normalize(Vec3(0.45f, 1, 0.1f));
    auto nearest = std::max_element(lights.begin(), lights.end(), [&](const auto& a, const auto& b) {
      return glm::dot(a.position, sun) < glm::dot(b.position, sun);
    });
    for (auto& light : lights) light.radiance *= 1e-3f;
    nearest->radiance = Vec3(1e4f);
    made->tree = build_light_tree(lights);
    made->cut = illumination_cut(made->tree, options.cut);
    return made;
  }
};

TEST(Bidirectional, PrintedFormLosesASunThatNoRayMeets) {
  auto room = SunOnALobe().room();
  room->settings.set("bidirectional.form", "printed");
  EXPECT_LT(expected_over_true(*room, 100), 0.9);
}

TEST(Bidirectional, RepairedFormKeepsIt) {
  auto room = SunOnALobe().room();
  EXPECT_NEAR(expected_over_true(*room, 100), 1, 0.02);
}

// Counting makes a sharp lobe's noise smaller than the analytic estimate alone does.
TEST(Bidirectional, CountingHelpsSharpLobes) {
  const auto noise = [](const char* rays) {
    RoomOptions options;
    options.wall_lights = 6000, options.lamps = 0, options.sky_lights = 1000;
    Room room(options, {{BrdfModel::phong, Vec3(0), Vec3(1), 1, Vec2(3000)}}, 200);
    room.settings.set("bidirectional.brdf-samples", rays);
    const auto technique = find_technique("bidirectional").make();
    technique->prepare(room.frame);
    Film film(room.gbuffer.width, room.gbuffer.height);
    PassRequest request;
    request.samples = 32;
    technique->run_pass(room.frame, request, film);
    double sum = 0;
    const double truth = room.exact(0).y;
    for (uint32_t i = 0; i < room.gbuffer.texels.size(); ++i)
      sum += std::pow(film.radiance(i).y / truth - 1, 2);
    return sum / room.gbuffer.texels.size();
  };
  EXPECT_LT(noise("64"), noise("0"));
}

TEST(Bidirectional, BeatsIlluminationWhereTheBrdfMatters) {
  const auto noise = [](const char* id) {
    Room room({}, {{BrdfModel::phong, Vec3(0.1f), Vec3(0.8f), 1, Vec2(60)}}, 400);
    const auto technique = find_technique(id).make();
    technique->prepare(room.frame);
    Film film(room.gbuffer.width, room.gbuffer.height);
    PassRequest request;
    request.samples = 32;
    technique->run_pass(room.frame, request, film);
    double sum = 0;
    const double truth = room.exact(0).y;
    for (uint32_t i = 0; i < room.gbuffer.texels.size(); ++i)
      sum += std::pow(film.radiance(i).y / truth - 1, 2);
    return sum / room.gbuffer.texels.size();
  };
  EXPECT_LT(2 * noise("bidirectional"), noise("illumination"));
}

}  // namespace
}  // namespace halflight
