// The built-in scenes of projected light, slides and sculptures: what each promises, and the tools they are
// made with.
#include <gtest/gtest.h>

#include <array>
#include <map>
#include <numeric>
#include <set>

#include "film/image_writers.h"
#include "lights/virtual_light.h"
#include "scene/built_in_lit.h"
#include "scene/built_in_rotunda.h"
#include "scene/built_in_scenes.h"
#include "scene/built_in_slides.h"
#include "scene/implicit_mesh.h"
#include "session.h"
#include "support/temporary_folder.h"
#include "trace/ray_scene.h"

namespace halflight {
namespace {

double volume(const Mesh& mesh) {
  double sum = 0;
  for (const UVec3 t : mesh.triangles)
    sum += glm::dot(Vec3d(mesh.vertices[t.x].position),
                    glm::cross(Vec3d(mesh.vertices[t.y].position), Vec3d(mesh.vertices[t.z].position))) /
           6;
  return sum;
}

/// Vertex numbers by position: seams are joined.
std::vector<uint32_t> joined(const std::vector<Vertex>& vertices) {
  std::map<std::array<float, 3>, uint32_t> places;
  std::vector<uint32_t> id;
  for (const Vertex& v : vertices) {
    const std::array<float, 3> key{v.position.x, v.position.y, v.position.z};
    id.push_back(places.emplace(key, static_cast<uint32_t>(places.size())).first->second);
  }
  return id;
}

/// Edges that are not walked once each way.
size_t open_edges(const Mesh& mesh) {
  const std::vector<uint32_t> id = joined(mesh.vertices);
  std::map<std::pair<uint32_t, uint32_t>, int> balance;
  for (const UVec3 t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const uint32_t a = id[t[k]], b = id[t[(k + 1) % 3]];
      balance[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  size_t open = 0;
  for (const auto& [edge, count] : balance) open += count != 0;
  return open;
}

/// The scene's triangles of one material.
Mesh part(const Scene& scene, const std::string& material) {
  Mesh mesh;
  mesh.vertices = scene.vertices;
  for (size_t t = 0; t < scene.triangles.size(); ++t)
    if (scene.materials[scene.triangle_material[t]].name == material)
      mesh.triangles.push_back(scene.triangles[t]);
  return mesh;
}

const Material& named(const Scene& scene, const std::string& name) {
  for (const Material& m : scene.materials)
    if (m.name == name) return m;
  throw std::runtime_error("no material " + name);
}

TEST(ImplicitMesh, SphereHasItsVolumeAndNormals) {
  const Vec3 centre(0.1f, -0.2f, 0.3f);
  const auto sphere = [&](Vec3 p) { return glm::length(p - centre) - 0.8f; };
  const Mesh mesh = implicit_mesh(sphere, {Vec3(-1.2f), Vec3(1.3f)}, 0.04f);
  EXPECT_EQ(open_edges(mesh), 0u);
  const double exact = 4.0 / 3 * 3.14159265358979 * 0.8 * 0.8 * 0.8;
  EXPECT_NEAR(volume(mesh), exact, 0.01 * exact);  // positive: the fronts look outside
  for (const Vertex& v : mesh.vertices) {
    EXPECT_NEAR(glm::length(v.position - centre), 0.8f, 0.003f);
    EXPECT_GT(glm::dot(v.normal, glm::normalize(v.position - centre)), 0.9999f);
  }
}

TEST(ImplicitMesh, FieldsOfTheirShapes) {
  // On the surface 0, and the distance itself to first order beside it.
  const Vec3 centre(1, 2, 3), radii(0.5f, 1.0f, 2.0f);
  for (const Vec3 direction :
       {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0.6f, 0.0f, 0.8f), Vec3(0.36f, 0.48f, 0.8f)}) {
    const Vec3 on = centre + radii * direction, normal = glm::normalize(direction / radii);
    EXPECT_NEAR(ellipsoid_distance(on, centre, radii), 0, 1e-5);
    EXPECT_NEAR(ellipsoid_distance(on + 0.01f * normal, centre, radii), 0.01, 5e-4);
    EXPECT_NEAR(ellipsoid_distance(on - 0.01f * normal, centre, radii), -0.01, 5e-4);
  }
  EXPECT_LT(ellipsoid_distance(centre, centre, radii), 0);
  EXPECT_NEAR(rod_distance({0.5f, 2, 0}, {0, 0, 0}, {1, 0, 0}, 0.2f, 0.4f), 1.7, 1e-6);
  EXPECT_NEAR(rod_distance({3, 0, 0}, {0, 0, 0}, {1, 0, 0}, 0.2f, 0.4f), 1.6, 1e-6);
  EXPECT_EQ(blend_union(1, 3, 0.5f), 1);                  // apart: the lesser
  EXPECT_NEAR(blend_union(1, 1, 0.5f), 1 - 0.125, 1e-6);  // a fillet of a quarter of the width
}

TEST(LitScenes, TrefoilIsAClosedTubeOfItsCurve) {
  const float radius = 0.3f;
  const Mesh knot = trefoil_mesh(radius, 600, 32);
  EXPECT_EQ(open_edges(knot), 0u);
  // Pappus: cross-section times the length of the curve through its centroids.
  double length = 0;
  Vec3d last(3, 0, 0);
  for (int i = 1; i <= 10000; ++i) {
    const double t = 2 * 3.14159265358979 * i / 10000, out = 2 + std::cos(3 * t);
    const Vec3d p(out * std::cos(2 * t), out * std::sin(2 * t), std::sin(3 * t));
    length += glm::length(p - last), last = p;
  }
  EXPECT_NEAR(volume(knot), 3.14159265358979 * radius * radius * length, 0.01 * 0.28 * length);
}

TEST(LitScenes, SlidesAreLightWithinAFrameOfBlack) {
  const ImageRgb rose = rose_window_slide(96), sunset = sunset_window_slide(96, 40),
                 lancet = lancet_slide(96, 1);
  for (const ImageRgb* slide : {&rose, &sunset, &lancet}) {
    float brightest = 0;
    double mean = 0;
    for (const Vec3& texel : slide->pixels) {
      ASSERT_TRUE(is_finite(texel));
      ASSERT_GE(std::min(texel.x, std::min(texel.y, texel.z)), 0);
      brightest = std::max(brightest, max_component(texel));
      mean += luminance(texel) / static_cast<double>(slide->pixels.size());
    }
    EXPECT_EQ(brightest > 1.5f, slide == &sunset);
    EXPECT_GT(mean, 0.03);
    for (const int i : {0, 95})
      for (const int j : {0, 48, 95}) EXPECT_EQ(slide->at(i, j), Vec3(0));
  }
  EXPECT_GT(max_component(sunset.at(55, 50)), 20);  // the sun
}

TEST(LitScenes, BoxIsThePapersSize) {
  const Scene scene = make_box();
  EXPECT_NEAR(static_cast<double>(scene.triangles.size()), 20000, 1000);
  EXPECT_FALSE(scene.environment.present());
  std::set<float> glossy;
  bool matt = false;
  for (const Material& m : scene.materials) {
    EXPECT_EQ(m.model, BrdfModel::phong) << m.name;
    EXPECT_FALSE(m.emissive());
    EXPECT_LE(m.exponents.x, 100);
    EXPECT_LE(max_component(m.diffuse + m.phong_specular), 1) << m.name;
    if (max_component(m.phong_specular) > 0)
      glossy.insert(m.exponents.x);
    else
      matt = true;
  }
  EXPECT_TRUE(matt);
  EXPECT_TRUE(glossy.contains(100) && glossy.size() >= 3);
  ASSERT_FALSE(scene.lights.empty());
  EXPECT_GE(scene.lights[0].picture, 0);
}

TEST(LitScenes, PlateIsThePapersSizeAndItsGroovesRunRound) {
  const Scene scene = make_plate();
  EXPECT_NEAR(static_cast<double>(scene.triangles.size()), 1000, 100);
  const Material& brass = named(scene, "brushed brass");
  EXPECT_EQ(brass.model, BrdfModel::ashikhmin_shirley);
  EXPECT_GE(brass.exponents.x, 50 * brass.exponents.y);  // narrow along the grooves
  const Mesh plate = part(scene, "brushed brass");
  ASSERT_GT(plate.triangles.size(), 500u);
  std::set<uint32_t> used;
  for (const UVec3 t : plate.triangles) used.insert({t.x, t.y, t.z});
  for (const uint32_t i : used) {
    const Vertex& v = scene.vertices[i];
    const Vec3 tangent(v.tangent), radial(v.position.x, 0, v.position.z);
    ASSERT_EQ(v.tangent.w, 1);
    EXPECT_NEAR(glm::length(tangent), 1, 1e-5);
    EXPECT_NEAR(tangent.y, 0, 1e-6);
    EXPECT_NEAR(glm::dot(tangent, v.normal), 0, 0.02);
    EXPECT_NEAR(glm::dot(tangent, radial), 0, 1e-5);
    // One way round for the whole plate.
    if (glm::length(radial) > 0.01f) {
      EXPECT_GT(glm::dot(glm::cross(radial, tangent), Vec3(0, 1, 0)), 0);
    }
  }
  float brightest = 0;
  for (const Vec3& texel : scene.pictures.at(0).pixels) brightest = std::max(brightest, max_component(texel));
  EXPECT_GT(brightest, 10);  // high dynamic range
}

TEST(LitScenes, HallIsClosedAndHasFewLights) {
  const Scene scene = make_hall();
  EXPECT_GT(scene.triangles.size(), 50000u);
  EXPECT_LT(scene.triangles.size(), 200000u);
  EXPECT_LE(scene.lights.size(), 8u);  // few enough to be drawn exactly
  for (const Material& m : scene.materials) EXPECT_FALSE(m.emissive());
  const RayScene rays(scene);
  RayCounters counters;
  // A spherical Fibonacci set of directions, turned off the axes, from each camera and from each light.
  std::vector<Vec3> eyes;
  for (const Camera& camera : scene.cameras) eyes.push_back(camera.position);
  for (const PunctualLight& light : scene.lights) eyes.push_back(light.position);
  for (const Vec3 eye : eyes)
    for (int i = 0; i < 2000; ++i) {
      const float y = 1 - (i + 0.5f) / 1000, r = std::sqrt(1 - y * y), phi = 0.7f + 2.39996323f * i;
      RayHit hit;
      ASSERT_TRUE(
          rays.intersect(eye, {r * std::cos(phi), y, r * std::sin(phi)}, 0, infinity, 0, hit, counters))
          << i << " from " << eye.x << ' ' << eye.y << ' ' << eye.z;
      ASSERT_GT(hit.distance, 0.02f);
    }
}

/// Share of the spot's light that meets a surface, and share of it that falls on `names`.
std::pair<double, double> where_light_falls(const Scene& scene, const PunctualLight& light,
                                            const std::set<std::string>& names) {
  const RayScene rays(scene);
  RayCounters counters;
  const Basis basis = basis_around(light.direction);
  double all = 0, met = 0, named_part = 0;
  for (int i = 0; i < 4000; ++i) {
    const float c = 1 - (1 - std::cos(light.outer_cone)) * (i + 0.5f) / 4000, s = std::sqrt(1 - c * c);
    const float phi = 2.39996323f * i;
    const Vec3 travel = basis.to_world({s * std::cos(phi), s * std::sin(phi), c});
    const float power = luminance(punctual_intensity(light, scene, travel));
    all += power;
    RayHit hit;
    if (!rays.intersect(light.position, travel, 0, infinity, 0, hit, counters)) continue;
    const Vec3 irradiance = connect_punctual(light, scene, surface_position(scene, hit.point)).irradiance;
    if (luminance(irradiance) > 0) met += power;
    if (names.contains(scene.materials[scene.triangle_material[hit.point.triangle]].name))
      named_part += power;
  }
  return {met / all, named_part / all};
}

TEST(LitScenes, ProjectorsReachWhatTheyLight) {
  const Scene box = make_box(), plate = make_plate(), hall = make_hall();
  const auto [met, on_wall] = where_light_falls(box, box.lights[0], {"plaster"});
  EXPECT_GT(met, 0.999);
  EXPECT_GT(on_wall, 0.95);
  for (const PunctualLight& light : plate.lights) {
    const auto [reached, wall] = where_light_falls(plate, light, {"wall"});
    EXPECT_GT(wall, 0.99);
  }
  for (const PunctualLight& light : hall.lights)
    if (light.picture >= 0) {
      const auto [reached, low] =
          where_light_falls(hall, light, {"marble floor", "oak", "dressed stone", "ashlar"});
      EXPECT_GT(low, 0.98) << light.name;
    }
}

TEST(LitScenes, SculpturesStandUnderAnEnvironment) {
  const Scene sphere = make_glossy_sphere(), statue = make_bumpy_statue();
  EXPECT_TRUE(sphere.environment.present() && statue.environment.present());
  EXPECT_TRUE(sphere.lights.empty() && statue.lights.empty());
  for (const Vertex& v : sphere.vertices) {
    EXPECT_NEAR(glm::length(v.position), 1, 1e-5);
    EXPECT_LT(glm::length(v.normal - v.position), 1e-5);
  }
  const Mesh bronze = part(statue, "bronze");
  EXPECT_GT(bronze.triangles.size(), 40000u);
  EXPECT_LT(bronze.triangles.size(), 90000u);
  EXPECT_EQ(open_edges(bronze), 0u);
  // In one piece, from below the plinth's top to the ears' tips.
  std::vector<uint32_t> parent(statue.vertices.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  float low = infinity, high = -infinity;
  for (const UVec3 t : bronze.triangles)
    for (int k = 0; k < 3; ++k) {
      parent[root(t[k])] = root(t[0]);
      low = std::min(low, statue.vertices[t[k]].position.y),
      high = std::max(high, statue.vertices[t[k]].position.y);
    }
  for (const UVec3 t : bronze.triangles) ASSERT_EQ(root(t.x), root(bronze.triangles[0].x));
  EXPECT_LT(low, 0);
  EXPECT_GT(high, 2);
}

TEST(LitScenes, RotundaHasItsSunInAWindowAndAnOpenEye) {
  const Environment rotunda = rotunda_environment(128);
  EXPECT_EQ(rotunda.bad_texels, 0u);
  double power = 0, sun_power = 0;
  Vec3 sun(0);
  for (int y = 0; y < rotunda.map.height; ++y)
    for (int x = 0; x < rotunda.map.width; ++x) {
      const float radiance = luminance(rotunda.map.at(x, y)), angle = texel_solid_angle(rotunda, y);
      EXPECT_GT(radiance, 0.005f);
      power += radiance * angle;
      if (radiance < 100) continue;
      sun_power += radiance * angle;
      sun +=
          radiance * angle *
          environment_direction(rotunda, (Vec2(x, y) + 0.5f) / Vec2(rotunda.map.width, rotunda.map.height));
    }
  EXPECT_GT(sun_power, 0.05 * power);
  EXPECT_LT(sun_power, 0.5 * power);
  sun = glm::normalize(sun);
  // Behind a viewer who looks along −z, to the left, within a window's height.
  EXPECT_LT(sun.x, -0.5f);
  EXPECT_GT(sun.z, 0.3f);
  EXPECT_NEAR(sun.y / std::sqrt(1 - sun.y * sun.y), 0.38, 0.02);
  // The eye of the dome, its coffers, and the floor beneath.
  EXPECT_GT(environment_radiance(rotunda, {0, 1, 0}).z, 2);
  EXPECT_LT(luminance(environment_radiance(rotunda, glm::normalize(Vec3(0.3f, 1, 0)))), 1.2f);
  EXPECT_LT(luminance(environment_radiance(rotunda, {0, -1, 0})), 0.6f);
}

constexpr int width = 96, height = 72;

ImageRgb picture_of(Scene scene, LightSelection light) {
  Messages messages;
  RenderSettings settings;
  settings.width = width, settings.height = height, settings.light = light, settings.backend = Backend::none;
  settings.values.set("lights.count", "4096");
  Session session(std::move(scene), settings, messages);
  session.run_pass(32, 1, 0);
  session.run_pass(32, 1, 0);
  EXPECT_EQ(session.film().nan_samples(), 0u);
  return session.film().image();
}

/// Share of pixels that would not be black on a screen: above a hundredth of white.
double lit_share(const ImageRgb& picture) {
  size_t lit = 0;
  for (const Vec3& pixel : picture.pixels) lit += luminance(pixel) > 0.01f;
  return static_cast<double>(lit) / static_cast<double>(picture.pixels.size());
}

TEST(LitScenes, PicturesAreMostlyLit) {
  EXPECT_GT(lit_share(picture_of(make_box(), LightSelection::indirect)), 0.8);
  EXPECT_GT(lit_share(picture_of(make_plate(), LightSelection::indirect)), 0.9);
  EXPECT_GT(lit_share(picture_of(make_hall(), LightSelection::indirect)), 0.75);
  EXPECT_GT(lit_share(picture_of(make_glossy_sphere(), LightSelection::all)), 0.95);
  EXPECT_GT(lit_share(picture_of(make_bumpy_statue(), LightSelection::all)), 0.95);
  // What the slides meet directly is only a part.
  EXPECT_LT(lit_share(picture_of(make_box(), LightSelection::direct)), 0.3);
  EXPECT_LT(lit_share(picture_of(make_plate(), LightSelection::direct)), 0.35);
}

TEST(LitScenes, SavedScenesGiveTheSamePicture) {
  TemporaryFolder folder;
  for (Scene (*make)() : {make_box, make_plate, make_hall}) {
    const Scene scene = make();
    SCOPED_TRACE(scene.facts.source);
    const GlbFile file = make_glb(scene, "saved");
    for (const SidePicture& side : file.pictures) folder.write(side.name, radiance_bytes(side.image, {}));
    Messages messages;
    messages.strict = true;
    const Scene again = load_gltf(folder.write("saved.glb", file.bytes), {}, messages);
    EXPECT_TRUE(messages.warnings.empty());
    // Direct light has no noise; slides are kept to one part in 256.
    const ImageRgb a = picture_of(scene, LightSelection::direct),
                   b = picture_of(again, LightSelection::direct);
    size_t apart = 0;
    for (size_t i = 0; i < a.pixels.size(); ++i)
      apart += glm::length(a.pixels[i] - b.pixels[i]) > 0.02f * glm::length(a.pixels[i]) + 1e-4f;
    EXPECT_LE(apart, a.pixels.size() / 200);
    // Indirect light has other points; its mean stays.
    double sum_a = 0, sum_b = 0;
    for (const Vec3& p : picture_of(scene, LightSelection::indirect).pixels)
      sum_a += std::min(luminance(p), 1.0f);
    for (const Vec3& p : picture_of(again, LightSelection::indirect).pixels)
      sum_b += std::min(luminance(p), 1.0f);
    EXPECT_NEAR(sum_b / sum_a, 1, 0.05);
  }
}

TEST(Statue, IsOneClosedGlossyFigureOfTheStatedSize) {
  const Scene scene = make_statue();
  EXPECT_GE(scene.triangles.size(), 60'000u);
  EXPECT_LE(scene.triangles.size(), 66'000u);
  const Material& marble = named(scene, "marble");
  EXPECT_EQ(marble.model, BrdfModel::phong);
  EXPECT_EQ(marble.exponents.x, 100);
  for (int c = 0; c < 3; ++c) EXPECT_LE(marble.diffuse[c] + marble.phong_specular[c], 1);

  const Mesh figure = part(scene, "marble");
  EXPECT_EQ(open_edges(figure), 0u);
  EXPECT_GT(volume(figure), 0.1);
  const std::vector<uint32_t> id = joined(figure.vertices);
  std::vector<uint32_t> group(figure.vertices.size());
  std::iota(group.begin(), group.end(), 0u);
  const auto root = [&](uint32_t v) {
    while (group[v] != v) v = group[v] = group[group[v]];
    return v;
  };
  for (const UVec3 t : figure.triangles)
    for (int k = 1; k < 3; ++k) group[root(id[t[k]])] = root(id[t.x]);
  std::map<uint32_t, size_t> pieces;
  for (const UVec3 t : figure.triangles) ++pieces[root(id[t.x])];
  EXPECT_EQ(pieces.size(), 1u) << "nothing floats";
}

TEST(Statue, StandsInsideItsUprightPicture) {
  const Scene scene = make_statue();
  const Camera& camera = scene.cameras.front();
  const float tangent = std::tan(0.5f * camera.vertical_fov);
  const Mesh figure = part(scene, "marble");
  for (const UVec3 t : figure.triangles) {
    const Vec3 to = figure.vertices[t.x].position - camera.position;
    const float depth = -glm::dot(to, camera.back);
    ASSERT_GT(depth, 0);
    ASSERT_LT(std::abs(glm::dot(to, camera.up)), tangent * depth);
    ASSERT_LT(std::abs(glm::dot(to, camera.right)), 0.75f * tangent * depth);
  }
}

}  // namespace
}  // namespace halflight
