// Cases 1–12: reflection at its sharpest, darkest and most slanted.
#include <numbers>

#include "scene/camera.h"
#include "stress/stress_families.h"
#include "stress/stress_scenes.h"

namespace halflight {

namespace {

const std::string studio_text =
    "a floor under a lamp, a wall that returns light, a card and a sky with a soft sun; ";
const std::string mean_bound =
    "the mean of picture, channels and tiles is the truth: P > 0 for every light, and a sample is divided by "
    "it";

const Vec3 some_diffuse{0.3f, 0.25f, 0.2f}, some_specular{0.5f, 0.5f, 0.4f};

/// Those that do not know the BRDF at the leaves.
std::vector<Exemption> blind_on_sharp_lobes(const std::string& why) {
  std::vector<Exemption> list;
  for (const char* id :
       {"illumination", "single-point", "sir", "light-bvh", "stochastic-lightcuts", "bidirectional"})
    list.push_back({id, Expected::tails, why});
  return list;
}

StressCase phong_case(std::string id, std::string name, float exponent) {
  StressCase c{id, name,
               studio_text + fmt::format("the floor is Phong, n = {:g}, k_d 0.25, k_s 0.5", exponent),
               mean_bound, [=] { return studio(phong(some_diffuse, some_specular, exponent)); }};
  const std::string why = "points of S rarely lie in the lobe, and weigh the more when they do";
  if (exponent > 1e3f) c.exemptions = blind_on_sharp_lobes(why);
  if (exponent > 1e5f)
    for (const char* blind : {"brdf", "mis"})
      c.exemptions.push_back({blind, Expected::tails, why, Target::discrete});
  return c;
}

Material ggx(float roughness, float metallic) {
  Material material;
  material.base_color = {0.7f, 0.6f, 0.5f, 1};
  material.roughness = roughness, material.metallic = metallic;
  return material;
}

Scene sunlit_floor(const Material& floor) {
  // Of 3 × 3 texels, so that a cluster of the sun has an extent that a ray can meet.
  ImageRgb map(128, 64, Vec3(0.02f));
  for (int i = 0; i < 9; ++i) map.at(76 + i % 3, 18 + i / 3) = Vec3(1000);
  Scene scene = open_floor(floor, make_environment(std::move(map), "sun", EnvironmentLayout::latlong));
  // Seen so that the sun's reflection lies in the picture.
  scene.cameras = {look_at({-0.7f, 0.75f, 1.0f}, {0, 0, 0}, {0, 1, 0}, 0.4f)};
  return scene;
}

StressCase no_diffuse() {
  StressCase c{"8", "no-diffuse",
               "an open floor, Phong n = 10, k_d = 0, k_s = 0.6, under a dim sky with a sun of 1000, 8° "
               "across",
               mean_bound + "; eq. 9 as printed loses clusters that no counting ray met: well below 1",
               [] { return sunlit_floor(phong(Vec3(0), Vec3(0.6f), 10)); }};
  c.exemptions = {{"brdf", Expected::tails, "blind to the light: few samples meet the sun"}};
  c.variants = {{"bidirectional",
                 {{"bidirectional.form", "printed"}},
                 {"bidirectional",
                  Expected::bias,
                  "eq. 9 as printed: where k_d = 0 a cluster that no counting ray met has probability 0 "
                  "(0.33 of the truth in a like experiment)",
                  {},
                  0.1,
                  0.8},
                 Target::discrete}};
  return c;
}

StressCase tilted_normals() {
  StressCase c{
      "12", "shading-normal-60", studio_text + "the floor's shading normals lean 60° towards the camera",
      mean_bound + "; cosines are of the shading normal, and light that only one normal sees is one for all",
      [] {
        Scene scene = studio(phong(some_diffuse, some_specular, 20));
        const Vec3 leaning(0, 0.5f, std::numbers::sqrt3_v<float> / 2);
        for (size_t i = 0; i < 4; ++i) scene.vertices[i].normal = leaning;
        return scene;
      }};
  return c;
}

StressCase grazing() {
  StressCase c{"11", "grazing", studio_text + "an orthographic camera 0.1° above the floor, Phong n = 20",
               mean_bound + "; wo·n is 0.0017, which no division by cosines may blow up", [] {
                 Scene scene = studio(phong(some_diffuse, some_specular, 20));
                 const float angle = 0.1f * pi / 180;
                 const Vec3 along(0, -std::sin(angle), -std::cos(angle));
                 Camera camera = look_at(Vec3(0.1f, 0, 0) - 3.0f * along, {0.1f, 0, 0}, {0, 1, 0}, 1);
                 camera.projection = Projection::orthographic;
                 camera.half_height = 0.0015f;
                 scene.cameras = {camera};
                 return scene;
               }};
  return c;
}

}  // namespace

void add_material_cases(StressCases& cases) {
  cases.push_back(phong_case("1", "phong-1", 1));
  cases.push_back(phong_case("2", "phong-100", 100));
  cases.push_back(phong_case("3", "phong-1e4", 1e4f));
  cases.push_back(phong_case("4", "phong-1e6", 1e6f));

  StressCase mirror{"5", "ggx-1e-4", studio_text + "the floor is a GGX metal with α = 1e-4, all but a mirror",
                    mean_bound, [] { return studio(ggx(0.01f, 1)); }};
  mirror.exemptions = blind_on_sharp_lobes("the lobe is narrower than what lies between points of S");
  cases.push_back(mirror);
  cases.push_back({"6", "ggx-1", studio_text + "the floor is GGX with α = 1", mean_bound,
                   [] { return studio(ggx(1, 0)); }});

  StressCase brushed{"7", "ashikhmin-shirley-1e5",
                     studio_text + "the floor is Ashikhmin–Shirley, exponents 10 and 1e5", mean_bound, [] {
                       Material material = phong(some_diffuse, some_specular, 10);
                       material.model = BrdfModel::ashikhmin_shirley;
                       material.exponents = {10, 1e5f};
                       Scene scene = studio(material);
                       for (size_t i = 0; i < 4; ++i) scene.vertices[i].tangent = {1, 0, 0, 1};
                       return scene;
                     }};
  brushed.exemptions =
      blind_on_sharp_lobes("across its grooves the lobe is narrower than what lies between points");
  brushed.interval = 0.08;
  cases.push_back(brushed);

  cases.push_back(no_diffuse());
  cases.push_back({"9", "no-specular", studio_text + "the floor has k_s = 0", mean_bound,
                   [] { return studio(matte(some_diffuse)); }});
  StressCase black{"10", "black-brdf", "an open floor that reflects nothing, under a sky with a sun",
                   "0 exactly: nothing is drawn, and nothing divided by it",
                   [] { return sunlit_floor(matte(Vec3(0))); }};
  black.constant_truth = Vec3(0);
  cases.push_back(black);
  cases.push_back(grazing());
  cases.push_back(tilted_normals());
  cases.back().interval = 0.08;
}

}  // namespace halflight
