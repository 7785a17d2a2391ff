// Cases 32–42: light sets, cuts and samples of the least and the greatest number, and light that changes or
// is no number.
#include <limits>

#include "scene/camera.h"
#include "stress/stress_families.h"
#include "stress/stress_scenes.h"
#include "stress/stress_stage.h"

namespace halflight {

namespace {

const std::string mean_bound = "the mean of picture, channels and tiles is the truth";
const std::string studio_text = "the studio with a Phong floor, n = 30";

Scene tested_studio() { return studio(phong(Vec3(0.3f), Vec3(0.4f), 30)); }

StressCase studio_case(std::string id, std::string name, std::string what, std::string why,
                       std::vector<std::pair<std::string, std::string>> set) {
  StressCase c{id, name, studio_text + "; " + what, mean_bound + "; " + why, tested_studio};
  c.set = [=](RenderSettings& settings) {
    for (const auto& [key, value] : set) settings.values.set(key, value);
  };
  return c;
}

StressCase one_light() {
  StressCase c{
      "32", "one-light", "direct light of a sky for which S has one member, a sun in a dark sky",
      mean_bound + "; one light leaves nothing to chance, and P = 1", [] {
        return open_floor(phong(Vec3(0.3f), Vec3(0.4f), 20), sky_with_suns(Vec3(0), {{40, 7, Vec3(1000)}}));
      }};
  c.set = [](RenderSettings& settings) {
    settings.light = LightSelection::direct;
    settings.values.set("lights.count", "1");
  };
  c.exemptions = {
      {"brdf", Expected::tails, "blind to the light: few BRDF rays meet the sun", Target::continuous}};
  c.exemptions.push_back(
      {"halflight", Expected::tails, "one stratum is the whole sky, its point anywhere in it"});
  return c;
}

StressCase million_lights() {
  StressCase c = studio_case(
      "33", "million-lights", "500,000 points of each kind: over a million members of S; 8 × 6 pixels",
      "indices, sums and searches hold a million",
      {{"lights.count", "500000"}, {"lights.samples", "1"}, {"lights.repulsion", "0"}});
  c.width = 8, c.height = 6;
  c.samples = 256;
  c.interval = 0.12;
  c.targets = {Target::discrete};
  return c;
}

StressCase edited_light() {
  StressCase c{
      "41", "edited-lights", studio_text + "; between frames a lamp is moved and doubled, and the sky turned",
      "the picture of a new session with those lights, up to rounding: nothing of before is left", [] {
        Scene scene = tested_studio();
        scene.lights = {point_light({-0.5f, 0.6f, 0.3f}, Vec3(0.5f))};
        return scene;
      }};
  c.truth_scene = [] {
    Scene scene = tested_studio();
    scene.lights = {point_light({0.6f, 0.5f, -0.2f}, Vec3(1))};
    scene.environment.rotation = 1;
    for (Material& material : scene.materials) material.emission *= 2.0f;
    return scene;
  };
  c.tolerance = 1e-5;
  c.biased_too = true;
  c.check = check_edited_lights;
  return c;
}

/// A map as a file may hold it: 24 texels that are no radiance.
ImageRgb spoilt_map() {
  ImageRgb map(32, 16, Vec3(0.4f, 0.5f, 0.7f));
  map.at(20, 4) = Vec3(30);
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  const Vec3 bad[] = {{nan, 1, 1}, {1, -5, 2}, {infinity, 0, 0}, {-1, -1, -1}};
  for (int i = 0; i < 24; ++i) map.at((7 * i) % 32, 2 + i % 6) = bad[i % 4];
  return map;
}

/// What the rules make of it: no number is 0, a negative channel is 0 and the others stay.
ImageRgb mended_map() {
  ImageRgb map = spoilt_map();
  for (Vec3& texel : map.pixels) texel = is_finite(texel) ? glm::max(texel, 0.0f) : Vec3(0);
  return map;
}

StressCase spoilt_texels() {
  StressCase c{"42", "bad-texels", "an open floor under a sky with NaN, infinite and negative texels",
               "the truth is of the map with 0 in their place; each is counted when the map is read, and no "
               "sample is bad",
               [] {
                 Environment sky = make_environment(spoilt_map(), "spoilt", EnvironmentLayout::latlong);
                 const auto is_bad = [](Vec3 t) { return !is_finite(t) || std::min({t.x, t.y, t.z}) < 0; };
                 const ImageRgb map = spoilt_map();
                 const auto bad = std::count_if(map.pixels.begin(), map.pixels.end(), is_bad);
                 if (sky.bad_texels != static_cast<size_t>(bad))
                   throw Error(
                       ExitCode::comparison_failed,
                       fmt::format("case 42: {} bad texels were counted, there are {}", sky.bad_texels, bad));
                 return open_floor(phong(Vec3(0.4f), Vec3(0.3f), 20), sky);
               }};
  c.truth_scene = [] {
    Environment sky;
    sky.map = mended_map();
    return open_floor(phong(Vec3(0.4f), Vec3(0.3f), 20), sky);
  };
  return c;
}

StressCase counted_nan() {
  StressCase c{
      "A10", "counted-nan", "a surface in view whose radiance is set to NaN behind the loaders' back",
      "its pixels are counted as samples that are no number, the first is told, and the picture stays finite",
      [] {
        Scene scene = tested_studio();
        Material screen;
        screen.unlit = true;
        screen.base_color = Vec4(std::numeric_limits<float>::quiet_NaN());
        add_sheet(scene, {-0.3f, 0.2f, -0.3f}, {0.3f, 0, 0}, {0, 0.3f, 0}, add_material(scene, screen));
        return scene;
      }};
  c.check = check_counted_nans;
  c.biased_too = true;
  return c;
}

}  // namespace

void add_sampling_cases(StressCases& cases) {
  cases.push_back(one_light());
  cases.push_back(million_lights());
  cases.push_back(studio_case("34", "cut-of-one", "a cut of one cluster a kind",
                              "the leaves' share is all there is", {{"cut.least", "1"}, {"cut.most", "1"}}));
  cases.back().interval = 0.12;
  cases.push_back(studio_case("35", "cut-of-all", "a cut of single lights",
                              "clusters without an extent are lights",
                              {{"cut.least", "100000"}, {"cut.most", "100000"}, {"cut.error", "0"}}));
  StressCase one =
      studio_case("36", "one-sample", "one sample a pixel", "strata of one sample are all there is", {});
  one.samples = 1;
  one.interval = 0.15;
  cases.push_back(one);
  StressCase odd =
      studio_case("37", "37-samples", "37 samples a pixel", "no number of samples is special", {});
  odd.samples = 37;
  cases.push_back(odd);
  cases.push_back(studio_case("38", "sigma-0", "σ = 1e-30, as near to 0 as the setting goes (0 turns it off)",
                              "every node with an error is split, up to the greatest number",
                              {{"cut.sigma", "1e-30"}}));
  cases.push_back(studio_case("38b", "sigma-inf", "σ = 1e30", "nothing is split beyond the least number",
                              {{"cut.sigma", "1e30"}}));
  cases.back().interval = 0.07;
  StressCase blind = studio_case("39", "no-brdf-rays", "N_ρ = 0", "the analytic lobe stands alone",
                                 {{"bidirectional.brdf-samples", "0"}, {"brdf.brdf-samples", "0"}});
  blind.exemptions = {{"*", Expected::left_out, "it has no such setting"},
                      {"bidirectional", Expected::truth},
                      {"brdf", Expected::truth},
                      {"mis", Expected::truth}};
  cases.push_back(blind);
  StressCase pixel =
      studio_case("40", "one-pixel", "a picture of one pixel", "tiles, strides and halves hold it", {});
  pixel.width = pixel.height = 1;
  pixel.interval = 0.25;
  pixel.samples = 512;
  cases.push_back(pixel);
  cases.push_back(edited_light());
  cases.push_back(spoilt_texels());
  cases.push_back(counted_nan());
}

}  // namespace halflight
