// Cases 21, 22, 24–29, 31: surfaces that touch, hide, degenerate, or lie far away; and scales added to the
// list.
#include "scene/camera.h"
#include "stress/stress_families.h"
#include "stress/stress_scenes.h"
#include "stress/stress_stage.h"

namespace halflight {

namespace {

const std::string mean_bound = "the mean of picture, channels and tiles is the truth";
const std::string light_alone = "light samples alone weigh 1/r² without a bound";

Scene tested_studio() { return studio(phong(Vec3(0.3f), Vec3(0.4f), 30)); }

void only_indirect(RenderSettings& settings) { settings.light = LightSelection::indirect; }

/// A floor and a lit wall that meet at the origin; the camera sees a patch of floor `distance` from the wall.
Scene corner(float distance) {
  Scene scene;
  scene.facts.source = "stress";
  add_sheet(scene, {0, 0, 0.5f}, {1, 0, 0}, {0, 0, -1}, add_material(scene, matte(Vec3(0.5f))));
  add_sheet(scene, {0, 0, 0.5f}, {0, 0, -1}, {0, 1, 0}, add_material(scene, matte(Vec3(0.5f))));
  scene.lights = {point_light({0.9f, 0.6f, 0.1f}, Vec3(1))};
  Camera camera = look_at({distance, 0.5f, 0}, {distance, 0, 0}, {0, 0, -1}, 1);
  camera.projection = Projection::orthographic;
  camera.half_height = 0.2f * distance;
  scene.cameras = {camera};
  return scene;
}

std::vector<Exemption> light_samples_alone() {
  std::vector<Exemption> list;
  for (const char* id :
       {"illumination", "single-point", "sir", "light-bvh", "stochastic-lightcuts", "bidirectional"})
    list.push_back({id, Expected::tails, light_alone, Target::continuous});
  return list;
}

StressCase corner_case(std::string id, float distance) {
  StressCase c{id, fmt::format("corner-{:g}", distance),
               fmt::format("indirect light on a floor {:g} from a lit wall that it meets", distance),
               mean_bound + "; in the continuous target BRDF rays bound what a sample weighs near the wall",
               [=] { return corner(distance); }};
  c.set = only_indirect;
  c.exemptions = light_samples_alone();
  // Of the points of S few stand near enough to send much: most of the sum is seldom drawn.
  c.exemptions.push_back({"*", Expected::tails,
                          "most of the sum comes from few points, which are seldom drawn", Target::discrete});
  c.interval = 0.1;
  return c;
}

StressCase corner_growth() {
  StressCase c{"21e", "corner-growth", "relative variance × samples in the corner at 0.0004 against 0.05",
               "grows at most 20 times where light samples and BRDF rays stand under one balance heuristic, "
               "or rays stand "
               "alone (light samples alone: 17,000 times in an experiment)",
               [] { return corner(0.0004f); }};
  c.truth_scene = [] { return corner(0.05f); };
  c.set = only_indirect;
  c.targets = {Target::continuous};
  c.check = [](StressStage& stage, const Contestant& who) { return check_variance_growth(stage, who, 20); };
  c.exemptions = {{"*", Expected::left_out, light_alone + ": cases 21 a–d show it"},
                  {"mis", Expected::truth},
                  {"brdf", Expected::truth},
                  {"halflight", Expected::truth},
                  {"path", Expected::truth}};

  return c;
}

StressCase on_a_light() {
  StressCase c{"22", "on-a-light", "every pixel sees a point within 1e-5 of a virtual light of S",
               mean_bound + "; the bounded geometry term gives a patch a hemisphere at most, and 0/0 nowhere",
               tested_studio};
  c.set = only_indirect;
  c.targets = {Target::discrete};
  c.adjust = [](Session& session) {
    const FrameView frame = session.frame();
    const auto& lights = frame.tree->lights;
    const auto on_floor = std::find_if(lights.begin(), lights.end(), [](const VirtualLight& light) {
      return light.kind == LightKind::surface && light.normal.y > 0.9f && leaf_power(light) > 0 &&
             std::abs(light.position.x) < 0.7f && std::abs(light.position.z) < 0.7f &&
             light.position.y < 0.01f;
    });
    HALFLIGHT_CHECK(on_floor != lights.end());
    const Vec3 x = on_floor->position;
    session.set_camera(look_at(x + Vec3(0.1f, 0.3f, 0.2f), x, {0, 1, 0}, 2e-5f));
  };
  return c;
}

StressCase scaled_case(std::string id, std::string name, float factor) {
  return {id, name, fmt::format("the studio {:g} times as large", factor),
          mean_bound + "; nothing assumes metres", [=] { return scaled_lengths(tested_studio(), factor); }};
}

/// 2^14 units across: at 1e6 a float's last place is 0.06 there.
StressCase far_away() {
  constexpr float size = 8192;
  StressCase c{
      "26", "origin-offset-1e6", "the studio, 16,384 units across, moved by 1e6 along each axis",
      "the truth is that of the studio where it was: what is lost is a float's last place, and the length by "
      "which rays start off a surface, 3 units of 16,384",
      [=] { return moved(scaled_lengths(tested_studio(), size), Vec3(1e6f)); }};
  c.truth_scene = [=] { return scaled_lengths(tested_studio(), size); };
  c.targets = {Target::continuous};
  c.tolerance = 5e-3;
  return c;
}

StressCase far_away_discrete() {
  StressCase c = far_away();
  c.id = "26b", c.name = "origin-offset-1e6-discrete";
  c.bound = mean_bound + " of the S that lies there";
  c.truth_scene = nullptr;
  c.targets = {Target::discrete};
  c.tolerance = 1e-3;
  return c;
}

/// A closed box about the camera and a part of the floor, its walls facing in and out.
void add_box(Scene& scene, Vec3 low, Vec3 high, uint32_t material) {
  const Vec3 size = high - low;
  place(scene, box_mesh(size), material, move(0.5f * (low + high)));
  update_bounds(scene);
}

StressCase all_occluded() {
  StressCase c{"27", "all-occluded",
               "a lamp, a sky and lit surfaces, all outside the opaque box that is seen from inside",
               "below 1e-6 where the lamp has 6: every ray ends at the box, at its edges too; what lies in "
               "one plane sees "
               "itself under cosines of a float's last place, 1e-7",
               [] {
                 Scene scene = studio(matte(Vec3(0.5f)));
                 add_box(scene, {-0.31f, 0.013f, -0.27f}, {0.29f, 0.4f, 0.33f},
                         add_material(scene, matte(Vec3(0.5f))));
                 scene.cameras = {look_at({0.05f, 0.3f, 0.25f}, {-0.1f, 0.05f, -0.2f}, {0, 1, 0}, 1.4f)};
                 return scene;
               }};
  c.tolerance = 1e-6;
  c.constant_truth = Vec3(0);
  return c;
}

StressCase closed_box() {
  StressCase c{"29", "closed-box", "a closed box under an even sky of 100, nothing else",
               "below 1e-6 where the sky has 100: it is a light of S, and none of it arrives; what lies in "
               "one plane sees itself "
               "under cosines of a float's last place, 1e-7",
               [] {
                 Scene scene;
                 add_box(scene, Vec3(-1), Vec3(1), add_material(scene, phong(Vec3(0.4f), Vec3(0.3f), 20)));
                 scene.environment = even_sky(Vec3(100));
                 scene.cameras = {look_at({0.5f, 0.6f, 0.7f}, {-0.3f, -0.8f, -0.2f}, {0, 1, 0}, 1.2f)};
                 return scene;
               }};
  c.tolerance = 1e-6;
  c.constant_truth = Vec3(0);
  return c;
}

StressCase slit() {
  StressCase c{"28", "slit-1e-3",
               "a floor under a roof with a slit of 1e-3 × 2, 0.25 above it, and an even sky",
               mean_bound + "; a share of 1e-3 of the light arrives, and what finds it weighs much", [] {
                 Scene scene = open_floor(matte(Vec3(0.6f)), even_sky(Vec3(100)));
                 const uint32_t roof = add_material(scene, matte(Vec3(0)));
                 add_sheet(scene, {0.0005f, 0.25f, 2}, {4, 0, 0}, {0, 0, -4}, roof);
                 add_sheet(scene, {-4.0005f, 0.25f, 2}, {4, 0, 0}, {0, 0, -4}, roof);
                 scene.cameras = {look_at({0.1f, 0.2f, 0.3f}, {0, 0, 0}, {0, 1, 0}, 0.5f)};
                 return scene;
               }};
  c.set = [](RenderSettings& settings) {
    settings.light = LightSelection::direct;
    settings.values.set("lights.count", "2048");
  };
  c.exemptions = {
      {"*", Expected::tails, "nothing knows where the slit is: one sample in a thousand arrives"}};
  return c;
}

StressCase degenerate() {
  StressCase c{
      "31", "degenerate-triangles", "the studio with 64 triangles without an area added, lamps among them",
      "the truth is the studio's without them: no area, no light, no normal to divide by", [] {
        Scene scene = tested_studio();
        const auto first = static_cast<uint32_t>(scene.vertices.size());
        for (int i = 0; i < 64; ++i) {
          const Vec3 p(0.1f * static_cast<float>(i % 8) - 0.4f, 0.3f, 0.05f * static_cast<float>(i / 8));
          Vertex vertex = scene.vertices.front();
          for (const float t : {0.0f, 0.0f, i % 2 ? 0.3f : 0.0f}) {
            vertex.position = p + Vec3(t, t, 0);
            scene.vertices.push_back(vertex);
          }
          const auto at = first + 3 * static_cast<uint32_t>(i);
          scene.triangles.push_back({at, at + 1, at + 2});
          scene.triangle_material.push_back(i % 3 == 0 ? 2u : 0u);
        }
        update_bounds(scene);
        return scene;
      }};
  c.truth_scene = tested_studio;
  c.targets = {Target::continuous};
  return c;
}

StressCase degenerate_discrete() {
  StressCase c = degenerate();
  c.id = "31b", c.name = "degenerate-triangles-discrete";
  c.bound = mean_bound + " of the same S";
  c.truth_scene = nullptr;
  c.targets = {Target::discrete};
  return c;
}

/// The studio changed by `change`, against itself with the same random numbers.
StressCase invariance(std::string id, std::string name, std::string what, double factor,
                      std::function<Scene(Scene)> change) {
  StressCase c{id, name, what,
               "the same picture, factor included, up to rounding: a power of two rounds nothing",
               [=] { return change(tested_studio()); }};
  c.truth_scene = tested_studio;
  c.tolerance = 1e-4;
  c.check = [=](StressStage& stage, const Contestant& who) { return check_same_picture(stage, who, factor); };
  c.biased_too = true;
  return c;
}

StressCase curtain() {
  StressCase c{
      "A9", "half-curtain", "the studio behind a curtain of alpha 0.5 between lamp and floor",
      mean_bound + "; over its seeds a blend lets half of the light through", [] {
        Scene scene = tested_studio();
        Material veil = matte(Vec3(0.2f));
        veil.base_color.a = 0.5f;
        veil.alpha_mode = AlphaMode::blend;
        add_sheet(scene, {-1.2f, 0.9f, 0.5f}, {2.4f, 0, 0}, {0, 0, -1.5f}, add_material(scene, veil));
        return scene;
      }};
  return c;
}

}  // namespace

void add_geometry_cases(StressCases& cases) {
  int letter = 0;
  for (const float distance : {1e-2f, 1e-3f, 1e-4f, 1e-5f})
    cases.push_back(corner_case(fmt::format("21{}", static_cast<char>('a' + letter++)), distance));
  cases.push_back(corner_growth());
  cases.push_back(on_a_light());
  cases.push_back(scaled_case("24", "scene-1e-6", 1e-6f));
  cases.push_back(scaled_case("25", "scene-1e6", 1e6f));
  cases.push_back(far_away());
  cases.push_back(far_away_discrete());
  cases.push_back(all_occluded());
  cases.push_back(slit());
  cases.push_back(closed_box());
  cases.push_back(degenerate());
  cases.push_back(degenerate_discrete());
  for (const int exponent : {-20, 20}) {
    const float factor = std::ldexp(1.0f, exponent);
    const char* sign = exponent < 0 ? "-" : "";
    cases.push_back(invariance(exponent < 0 ? "A5" : "A6", fmt::format("lengths-2^{}20", sign),
                               fmt::format("the studio with all lengths times 2^{}", exponent), 1,
                               [=](Scene scene) { return scaled_lengths(std::move(scene), factor); }));
    cases.push_back(invariance(exponent < 0 ? "A7" : "A8", fmt::format("radiances-2^{}20", sign),
                               fmt::format("the studio with all radiances times 2^{}", exponent), factor,
                               [=](Scene scene) { return scaled_radiance(std::move(scene), factor); }));
  }
  cases.push_back(curtain());
}

}  // namespace halflight
