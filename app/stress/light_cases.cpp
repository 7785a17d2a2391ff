// Cases 13–20, 23 and 30: light at its strongest, faintest, smallest and most alike; and lamps added to the
// list.
#include "scene/camera.h"
#include "stress/stress_families.h"
#include "stress/stress_scenes.h"
#include "stress/stress_stage.h"

namespace halflight {

namespace {

const std::string mean_bound = "the mean of picture, channels and tiles is the truth";
const Material grey = matte(Vec3(0.5f));

void only_direct(RenderSettings& settings) { settings.light = LightSelection::direct; }

StressCase strong_sun() {
  StressCase c{"13", "sun-1e6",
               "an open Phong floor (n = 20) under a sky of 0.1 with 1e6 in one texel of 2048",
               mean_bound + "; the sun is a member of S, not an average with its neighbours", [] {
                 return open_floor(phong(Vec3(0.3f), Vec3(0.4f), 20),
                                   sky_with_suns(Vec3(0.1f), {{40, 7, Vec3(1e6f)}}));
               }};
  c.exemptions = {
      {"brdf", Expected::tails, "blind to the light: one ray in thousands meets the sun", Target::continuous},
      {"brdf", Expected::tails, "blind to the light: the sun is drawn as often as any direction",
       Target::discrete}};
  // The sky is 4e-5 of the light, and where it stands in one cluster with the sun, it is drawn in the sun's
  // place once in a thousand pixels: runs without are too bright by that.
  c.tolerance = 1e-3;
  c.interval = 0.06;
  return c;
}

StressCase two_suns() {
  StressCase c{
      "14", "two-suns", "two suns of 1e4, one hidden by a wall from all that is seen",
      mean_bound + "; the hidden one costs samples, not energy", [] {
        Scene scene = open_floor(phong(Vec3(0.4f), Vec3(0.3f), 50),
                                 sky_with_suns(Vec3(0.1f), {{32, 12, Vec3(1e4f)}, {48, 6, Vec3(1e4f)}}));
        add_sheet(scene, {-4, 0.3f, -2.2f}, {8, 0, 0}, {0, 6, 0}, add_material(scene, matte(Vec3(0.5f))));
        return scene;
      }};
  c.exemptions = {{"brdf", Expected::tails, "blind to the light: few samples meet the suns"}};
  return c;
}

StressCase constant_sky() {
  StressCase c{"15", "constant-sky", "an open matte floor of albedo 0.5 under an even sky of radiance 2",
               "every pixel is 0.5 · 2 = 1: the integral of a constant, within 1e-3",
               [] { return open_floor(grey, even_sky(Vec3(2))); }};
  c.constant_truth = Vec3(1);
  c.set = only_direct;
  c.targets = {Target::continuous};
  c.tolerance = 1e-3;
  return c;
}

/// As above, against brute force over the same S.
StressCase constant_sky_discrete() {
  StressCase c = constant_sky();
  c.id = "15b", c.name = "constant-sky-discrete";
  c.bound = mean_bound + " of the same S, where all points are alike";
  c.constant_truth.reset();
  c.targets = {Target::discrete};
  return c;
}

StressCase all_black() {
  StressCase c{
      "16", "all-black", "a floor under a sky of zeros and a lamp that emits nothing",
      "0 exactly: no distribution has a sum to divide by", [] {
        Scene scene = open_floor(grey, even_sky(Vec3(0)));
        add_sheet(scene, {-0.2f, 1.5f, 0}, {0.4f, 0, 0}, {0, 0, 0.4f}, add_material(scene, glowing(Vec3(0))));
        return scene;
      }};
  c.constant_truth = Vec3(0);
  return c;
}

StressCase one_lit_point() {
  StressCase c{
      "17", "one-lit-point",
      "indirect light of a spot that lights a few of the 65,536 surface points of S, 32,768 on each side",
      mean_bound + "; P(i) follows Φ_i, so that the lit ones are found among the dark", [] {
        Scene scene = open_floor(grey, Environment());
        add_sheet(scene, {-1.5f, 0.2f, -2.2f}, {3, 0, 0}, {0, 2, 0}, add_material(scene, matte(Vec3(0.7f))));
        PunctualLight spot = point_light({0, 1.2f, -1.2f}, Vec3(1000));
        spot.kind = PunctualKind::spot;
        spot.direction = {0, 0, -1};
        spot.outer_cone = 0.018f, spot.inner_cone = 0.017f;
        scene.lights.push_back(spot);
        return scene;
      }};
  c.set = [](RenderSettings& settings) {
    settings.light = LightSelection::indirect;
    settings.values.set("lights.count", "32768");
  };
  c.targets = {Target::discrete};
  c.exemptions = {
      {"brdf", Expected::tails, "blind to the light: the lit points are few among tens of thousands"}};
  return c;
}

StressCase pure_colours() {
  StressCase c{"18", "pure-colours", "three lamps of pure red, green and blue over a floor with a red lobe",
               mean_bound + " in each channel: luminance weighs blue with 0.07, and makes no P zero", [] {
                 Scene scene = open_floor(phong(Vec3(0.4f), Vec3(0.5f, 0, 0), 30), Environment());
                 const Vec3 colours[] = {{10, 0, 0}, {0, 10, 0}, {0, 0, 10}};
                 for (int i = 0; i < 3; ++i)
                   add_sheet(scene, {-1 + 0.7f * static_cast<float>(i), 1.1f, -0.2f}, {0.4f, 0, 0},
                             {0, 0, 0.4f}, add_material(scene, glowing(colours[i])));
                 return scene;
               }};
  c.exemptions = {{"brdf", Expected::tails, "blind to the light", Target::continuous}};
  c.interval = 0.1;
  return c;
}

StressCase extreme_radiance(std::string id, std::string name, float factor) {
  return {id, name, fmt::format("the studio with all light {:g} times as strong", factor),
          mean_bound + "; powers are summed in double, in units of their largest",
          [=] { return scaled_radiance(studio(phong(Vec3(0.3f), Vec3(0.4f), 30)), factor); }};
}

StressCase coincident_lights() {
  return {"23", "coincident-lights", "24 point lights at two places, twelve in each",
          mean_bound + "; the tree splits what has no extent, and none is lost", [] {
            Scene scene = open_floor(phong(Vec3(0.4f), Vec3(0.4f), 20), Environment());
            for (int i = 0; i < 24; ++i)
              scene.lights.push_back(point_light(i % 2 ? Vec3(0.4f, 0.9f, -0.3f) : Vec3(-0.5f, 0.7f, 0.2f),
                                                 Vec3(0.1f + 0.02f * static_cast<float>(i))));
            return scene;
          }};
}

StressCase flat_clusters() {
  return {"30", "flat-clusters",
          "144 point lights on a grid in one axis-aligned plane over an axis-aligned floor",
          mean_bound + "; boxes without thickness hold what lies in them", [] {
            Scene scene = open_floor(phong(Vec3(0.4f), Vec3(0.4f), 20), Environment());
            for (int i = 0; i < 144; ++i)
              scene.lights.push_back(point_light({-0.9f + 0.16f * static_cast<float>(i % 12), 0.75f,
                                                  -0.9f + 0.16f * static_cast<float>(i / 12)},
                                                 Vec3(0.02f)));
            return scene;
          }};
}

StressCase many_suns() {
  return {
      "A1", "many-suns",
      "twelve directional lights, more than shadow maps serve, over a Phong floor (n = 20)",
      mean_bound + "; they have no extent that a BRDF ray could meet, and are members of S with a direction",
      [] {
        Scene scene = open_floor(phong(Vec3(0.4f), Vec3(0.4f), 20), Environment());
        for (int i = 0; i < 12; ++i) {
          PunctualLight sun = point_light(Vec3(0), Vec3(0.5f + 0.1f * static_cast<float>(i)));
          sun.kind = PunctualKind::directional;
          const float angle = 0.5f * static_cast<float>(i);
          sun.direction = glm::normalize(Vec3(std::cos(angle), -1.2f, std::sin(angle)));
          scene.lights.push_back(sun);
        }
        return scene;
      }};
}

/// Directional lights are distant, but no part of the map.
StressCase suns_and_sky() {
  StressCase c = many_suns();
  c.id = "A11", c.name = "suns-and-sky";
  c.inputs = "the same under a sky with a sun of its own";
  c.scene = [] {
    Scene scene = many_suns().scene();
    scene.environment = sky_with_suns(Vec3(0.4f, 0.5f, 0.6f), {{20, 8, Vec3(200)}});
    return scene;
  };
  c.exemptions = {{"brdf", Expected::tails, "blind to the light: suns are drawn as seldom as any direction"}};
  return c;
}

StressCase tiny_lamp() {
  StressCase c{"A2", "tiny-lamp", "the studio with a second lamp of 1e-4 × 1e-4, as strong as the first",
               mean_bound + "; every emitter has points of its own, however small", [] {
                 Scene scene = studio(phong(Vec3(0.3f), Vec3(0.3f), 30));
                 add_sheet(scene, {-0.5f, 0.9f, 0.2f}, {1e-4f, 0, 0}, {0, 0, 1e-4f},
                           add_material(scene, glowing(Vec3(0.24e8f * 5))));
                 return scene;
               }};
  c.exemptions = {{"brdf", Expected::tails, "blind to the light: no BRDF ray meets so small a lamp"}};
  return c;
}

StressCase sliver_lamp() {
  StressCase c{"A3", "sliver-lamp", "a lamp 1.6 long and 1e-5 wide over a floor",
               mean_bound + "; areas of needles are known to their last digits", [] {
                 Scene scene = open_floor(phong(Vec3(0.4f), Vec3(0.3f), 20), even_sky(Vec3(0.05f)));
                 add_sheet(scene, {-0.8f, 0.8f, -0.4f}, {1.6f, 0, 0.3f}, {0, 0, 1e-5f},
                           add_material(scene, glowing(Vec3(3e5f))));
                 return scene;
               }};
  c.exemptions = {{"brdf", Expected::tails, "blind to the light: no BRDF ray meets so thin a lamp"}};
  return c;
}

StressCase instant_is_biased() {
  StressCase c{
      "A4", "near-light-faded", "a floor strip 0.02 from a lit wall, indirect light only",
      "virtual lights nearer than 0.03 of the scene's diagonal fade: less than 0.6 of the truth is left", [] {
        Scene scene;
        add_sheet(scene, {0, 0, 1}, {2, 0, 0}, {0, 0, -2}, add_material(scene, matte(Vec3(0.5f))));
        add_sheet(scene, {0, 0, 1}, {0, 0, -2}, {0, 1, 0}, add_material(scene, matte(Vec3(0.2f))));
        scene.lights = {point_light({1.2f, 0.4f, 0}, Vec3(1))};
        scene.cameras = {look_at({0.5f, 0.5f, 0.01f}, {0.02f, 0, 0}, {0, 1, 0}, 0.02f)};
        return scene;
      }};
  c.set = [](RenderSettings& settings) { settings.light = LightSelection::indirect; };
  c.targets = {Target::continuous};
  c.biased_too = true;
  c.exemptions = {{"*", Expected::left_out, "case 21 tries it on corners"},
                  {"instant", Expected::bias, "light within its minimum distance fades away", {}, 0, 0.6}};
  return c;
}

}  // namespace

void add_light_cases(StressCases& cases) {
  cases.push_back(strong_sun());
  cases.push_back(two_suns());
  cases.push_back(constant_sky());
  cases.push_back(constant_sky_discrete());
  cases.push_back(all_black());
  cases.push_back(one_lit_point());
  cases.push_back(pure_colours());
  cases.push_back(extreme_radiance("19", "radiance-1e-30", 1e-30f));
  cases.push_back(extreme_radiance("20", "radiance-1e30", 1e30f));
  cases.push_back(coincident_lights());
  cases.push_back(flat_clusters());
  cases.push_back(many_suns());
  cases.push_back(suns_and_sky());
  cases.push_back(tiny_lamp());
  cases.push_back(sliver_lamp());
  cases.push_back(instant_is_biased());
}

}  // namespace halflight
