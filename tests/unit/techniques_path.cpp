// The path tracer against analytic light, numerical integration, and `mis` in the continuous target.
#include <gtest/gtest.h>

#include "core/parallel.h"
#include "session.h"
#include "support/traced_rooms.h"

namespace halflight {
namespace {

RenderSettings path_settings(int width, int height, LightSelection light,
                             const std::vector<std::pair<const char*, const char*>>& set = {}) {
  RenderSettings settings;
  settings.technique = "path", settings.backend = Backend::none;
  settings.width = width, settings.height = height, settings.light = light;
  for (const auto& [key, value] : set) settings.values.set(key, value);
  return settings;
}

/// Mean of what a camera sees, over independent passes, with its standard error; one channel.
struct Estimate {
  double mean = 0, error = 0;
};

Estimate estimate(Session& session, const RenderSettings& settings, int channel, uint32_t samples) {
  session.set_settings(settings);
  const FrameView frame = session.frame();
  const auto technique = find_technique("path").make();
  technique->prepare(frame);
  constexpr uint32_t passes = 64;
  double sum = 0, squares = 0;
  for (uint32_t pass = 0; pass < passes; ++pass) {
    Film film(settings.width, settings.height);
    PassRequest request;
    request.pass = pass, request.samples = samples, request.half = 0;
    technique->run_pass(frame, request, film);
    EXPECT_EQ(film.nan_samples(), 0u);
    const double mean = film.mean_radiance()[channel];
    sum += mean, squares += mean * mean;
  }
  const double mean = sum / passes;
  return {mean, std::sqrt(std::max(0.0, squares / passes - mean * mean) / (passes - 1))};
}

void expect_near(const Estimate& found, double truth, double narrow = 0.005) {
  EXPECT_NEAR(found.mean, truth, 4 * found.error + 2e-5 * truth);
  EXPECT_LT(found.error, narrow * truth) << "too noisy to tell";
}

/// A camera that sees nothing but `place`, along `direction`.
Camera camera_on(Vec3 place, Vec3 direction, float distance) {
  const Vec3 eye = place - glm::normalize(direction) * distance;
  return look_at(eye, place, std::abs(direction.y) > 0.9f ? Vec3(0, 0, 1) : Vec3(0, 1, 0), 1e-4f);
}

struct OnePixel {
  Messages messages;
  Session session;
  uint32_t samples = 1024;

  OnePixel(Scene scene, const Camera& camera)
      : session(with_camera(std::move(scene), camera), path_settings(1, 1, LightSelection::all), messages) {}

  Estimate find(LightSelection light, const std::vector<std::pair<const char*, const char*>>& set = {},
                int channel = 1) {
    return estimate(session, path_settings(1, 1, light, set), channel, samples);
  }

 private:
  static Scene with_camera(Scene scene, const Camera& camera) {
    scene.cameras = {camera};
    return scene;
  }
};

// ---- Furnaces ----

/// A closed box about the origin, its walls facing inwards.
Scene closed_box(Material material) {
  Scene scene;
  scene.materials.push_back(std::move(material));
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f}) {
      Vec3 n(0), u(0), v(0);
      n[axis] = side, u[(axis + 1) % 3] = 2, v[(axis + 2) % 3] = 2 * -side;
      add_patch(scene, n - 0.5f * (u + v), u, v);
    }
  return scene;
}

// Each wall sends 1 and returns a share ρ: what is seen is 1 + ρ + ρ² …, a term for each surface on the way.
TEST(PathTracer, GlowingBoxIsAGeometricSeries) {
  constexpr double albedo = 0.8;
  Material material = diffuse_material(Vec3(static_cast<float>(albedo)));
  material.emission = Vec3(1);
  OnePixel box(closed_box(material), camera_on({0.3f, -1, 0.2f}, {0.4f, -1, 0.3f}, 1));
  box.samples = 256;
  for (const char* model : {"lambert", "whole"}) {
    SCOPED_TRACE(model);
    for (const auto& [bounces, text] : {std::pair{0, "0"}, {1, "1"}, {3, "3"}, {64, "64"}}) {
      SCOPED_TRACE(text);
      const std::vector<std::pair<const char*, const char*>> set{{"path.bounces", text},
                                                                 {"path.model", model}};
      const double all = (1 - std::pow(albedo, bounces + 2)) / (1 - albedo);
      expect_near(box.find(LightSelection::all, set), all, 0.01);
      expect_near(box.find(LightSelection::direct, set), 1 + albedo);
      const Estimate indirect = box.find(LightSelection::indirect, set);
      if (bounces == 0)
        EXPECT_EQ(indirect.mean, 0);
      else
        expect_near(indirect, all - 1 - albedo, 0.01);
    }
  }
}

// Under an even sky a floor returns its albedo, which of GGX is an integral: over what lies above the floor
// itself, even where its normals are bent.
TEST(PathTracer, EvenSkyGivesTheIntegratedAlbedo) {
  constexpr float radiance = 2;
  Material ggx;
  ggx.base_color = Vec4(0.8f, 0.5f, 0.3f, 1), ggx.metallic = 0.4f, ggx.roughness = 0.6f;
  const Vec3 bent = glm::normalize(Vec3(0.7f, 1, 0));
  for (const auto& [material, normal] : {std::pair{diffuse_material(Vec3(0.7f)), Vec3(0, 1, 0)},
                                         {ggx, Vec3(0, 1, 0)},
                                         {diffuse_material(Vec3(0.7f)), bent},
                                         {ggx, bent}}) {
    Scene scene = floor_scene(2);
    scene.materials[0] = material;
    for (Vertex& vertex : scene.vertices) vertex.normal = normal;
    scene.environment = constant_environment(Vec3(radiance));
    const Vec3 direction(0.6f, -0.8f, 0);
    OnePixel floor(scene, camera_on({0.1f, 0, 0.1f}, direction, 1));
    const GBufferTexel texel = shade_surface(floor.session.scene(), {0, {0.25f, 0.25f}}, -direction);
    constexpr int rows = 512, columns = 1024;
    double truth = 0;
    for (int i = 0; i < rows; ++i)
      for (int j = 0; j < columns; ++j) {
        const double cosine = (i + 0.5) / rows, sine = std::sqrt(1 - cosine * cosine);
        const double phi = 2 * 3.141592653589793 * (j + 0.5) / columns;
        const Vec3 wi(Vec3d(sine * std::cos(phi), cosine, sine * std::sin(phi)));
        truth += radiance * evaluate(texel.brdf, texel.basis(), texel.wo, wi).y *
                 std::max(glm::dot(texel.shading_normal, wi), 0.0f);
      }
    truth *= 2 * 3.141592653589793 / (rows * columns);
    expect_near(floor.find(LightSelection::all), truth, 0.004);
    expect_near(floor.find(LightSelection::direct), truth, 0.004);
    EXPECT_EQ(floor.find(LightSelection::indirect).mean, 0);
  }
}

// ---- Analytic light ----

/// Irradiance over radiance of a polygon seen from x (Lambert 1760): ½ Σ angle of each edge times the cosine
/// of its plane's normal. The polygon lies above x's horizon and runs clockwise seen from it.
double polygon_irradiance(Vec3d x, Vec3d n, const std::vector<Vec3d>& corners) {
  double sum = 0;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Vec3d a = glm::normalize(corners[i] - x), b = glm::normalize(corners[(i + 1) % corners.size()] - x);
    const Vec3d across = glm::cross(a, b);
    sum += std::acos(glm::dot(a, b)) * glm::dot(glm::normalize(across), n) / 2;
  }
  return std::abs(sum);
}

TEST(PathTracer, EmitterAboveAFloorGivesItsFormFactor) {
  constexpr double pi_d = 3.141592653589793;
  Scene scene = floor_scene(10, Vec3(0.6f));
  Material lamp = diffuse_material(Vec3(0));
  lamp.emission = Vec3(1, 3, 9);
  scene.materials.push_back(lamp);
  const Vec3 corner(0.2f, 1, -0.3f), u(0.9f, 0.2f, 0), v(0, 0, 0.7f);
  add_patch(scene, corner, u, v, 1);  // u × v looks down
  ASSERT_LT(glm::cross(u, v).y, 0);
  for (const Vec3 x : {Vec3(0, 0, 0), Vec3(0.5f, 0, 0.1f), Vec3(-2, 0, 1)}) {
    OnePixel floor(scene, camera_on(x, {0.3f, -0.4f, -0.2f}, 0.2f));
    const double e = polygon_irradiance(
        Vec3d(x), {0, 1, 0}, {Vec3d(corner), Vec3d(corner + u), Vec3d(corner + u + v), Vec3d(corner + v)});
    for (int channel = 0; channel < 3; ++channel)
      expect_near(floor.find(LightSelection::all, {}, channel), lamp.emission[channel] * 0.6 / pi_d * e);
    EXPECT_EQ(floor.find(LightSelection::indirect).mean, 0) << "the lamp is black";
  }
  // Blended, it sends its coverage's share, whichever way it is found.
  scene.materials[1].alpha_mode = AlphaMode::blend, scene.materials[1].base_color.w = 0.3f;
  OnePixel blended(scene, camera_on(Vec3(0), {0.3f, -0.4f, -0.2f}, 0.2f));
  const double e = polygon_irradiance(
      Vec3d(0), {0, 1, 0}, {Vec3d(corner), Vec3d(corner + u), Vec3d(corner + u + v), Vec3d(corner + v)});
  expect_near(blended.find(LightSelection::all), 0.3 * lamp.emission.y * 0.6 / pi_d * e);
}

// A point light over a black floor with a wall: all the floor gets from the wall is ∫ ρ/π E(y) G dy.
TEST(PathTracer, OneBounceOfAPointLightIsItsIntegral) {
  constexpr double pi_d = 3.141592653589793, albedo = 0.7, side = 1;
  Scene scene;
  scene.materials.push_back(diffuse_material(Vec3(0.5f)));
  scene.materials.push_back(diffuse_material(Vec3(static_cast<float>(albedo))));
  add_patch(scene, {0, 0, 0}, {0, 0, side}, {side, 0, 0});
  add_patch(scene, {0, 0, 0}, {0, side, 0}, {0, 0, side}, 1);  // faces +x
  PunctualLight light;
  light.position = {0.4f, 0.7f, 0.3f}, light.intensity = Vec3(2, 1, 0.5f);
  scene.lights.push_back(light);
  const Vec3d x(0.3, 0, 0.6), lamp(light.position);
  constexpr int cells = 400;
  double bounced = 0;
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j) {
      const Vec3d y(0, side * (i + 0.5) / cells, side * (j + 0.5) / cells);
      const Vec3d to_lamp = lamp - y, to_x = x - y;
      const double r = glm::length(to_lamp), s = glm::length(to_x);
      const double irradiance = to_lamp.x / (r * r * r);
      bounced += albedo / pi_d * irradiance * (to_x.x / s) * (-to_x.y / s) / (s * s);
    }
  bounced *= side * side / (cells * cells) * 0.5 / pi_d;
  const Vec3d direct_offset = lamp - x;
  const double direct = 0.5 / pi_d * direct_offset.y / std::pow(glm::length(direct_offset), 3);
  OnePixel corner(scene, camera_on(Vec3(x), {-0.2f, -0.5f, -0.3f}, 0.1f));
  for (int channel = 0; channel < 3; ++channel) {
    SCOPED_TRACE(channel);
    const double share = light.intensity[channel];
    expect_near(corner.find(LightSelection::direct, {}, channel), direct * share);
    expect_near(corner.find(LightSelection::indirect, {}, channel), bounced * share, 0.012);
    expect_near(corner.find(LightSelection::all, {}, channel), (direct + bounced) * share);
  }
}

// ---- Against an independent technique ----

constexpr int width = 64, height = 48, tile_side = 16;
constexpr size_t tile_columns = width / tile_side, tile_count = tile_columns * (height / tile_side);

/// Mean luminance of each tile and its variance, from what each round of a session adds.
struct Tiles {
  std::vector<double> mean = std::vector<double>(tile_count), variance = mean;
};

std::vector<double> tile_means(const Film& film) {
  std::vector<double> means(tile_count);
  for (uint32_t i = 0; i < width * height; ++i)
    means[i / width / tile_side * tile_columns + i % width / tile_side] +=
        static_cast<double>(luminance(film.radiance(i))) / (tile_side * tile_side);
  return means;
}

Tiles run_rounds(Session& session, const char* technique, LightSelection light, int rounds) {
  RenderSettings settings = path_settings(width, height, light);
  settings.technique = technique, settings.target = Target::continuous, settings.seed = rounds;
  session.set_settings(settings);
  Tiles tiles;
  std::vector<double> before(tile_count), squares(tile_count);
  for (int round = 0; round < rounds; ++round) {
    session.run_pass(2, 1, 0);
    std::vector<double> sums = tile_means(session.film());
    for (size_t t = 0; t < tile_count; ++t) {
      sums[t] *= round + 1;
      squares[t] += (sums[t] - before[t]) * (sums[t] - before[t]);
    }
    before = sums;
  }
  EXPECT_EQ(session.film().nan_samples(), 0u);
  for (size_t t = 0; t < tile_count; ++t) {
    tiles.mean[t] = before[t] / rounds;
    tiles.variance[t] = std::max(0.0, squares[t] / rounds - tiles.mean[t] * tiles.mean[t]) / (rounds - 1.0);
  }
  return tiles;
}

/// All kinds of light, with more lamps than a handful, on textured GGX, seen past a pane that blends.
Scene ggx_room() {
  Scene scene = full_room();
  ImageRgba8 checks{4, 4, std::vector<uint8_t>(64)};
  for (size_t i = 0; i < checks.bytes.size(); ++i)
    checks.bytes[i] = i % 4 == 3 ? 255 : static_cast<uint8_t>(60 + 160 * ((i / 4 + i / 16) % 2));
  scene.images.push_back(checks);
  Texture texture;
  texture.srgb = texture.nearest = true;
  scene.textures.push_back(texture);
  Material floor, wall, pane;
  floor.roughness = 0.4f, floor.base_color_texture.texture = 0;
  wall.base_color = Vec4(0.9f, 0.7f, 0.4f, 1), wall.metallic = 0.5f, wall.roughness = 0.6f;
  pane.base_color = Vec4(0.2f, 0.6f, 0.8f, 0.4f), pane.alpha_mode = AlphaMode::blend;
  scene.materials[0] = floor, scene.materials[1] = wall;
  scene.materials.push_back(pane);
  add_patch(scene, {0.2f, 0.1f, 0.75f}, {0.5f, 0, 0}, {0, 0.5f, 0}, 3);
  scene.cameras = {look_at({0.9f, 0.6f, 1.8f}, {0.4f, 0.3f, 0.3f}, {0, 1, 0}, 0.7f)};
  return scene;
}

struct PathScene {
  const char* name;
  Scene (*make)();
  int rounds;
  double interval;  ///< largest standard error of the picture, relative, that is worth a verdict
};

void PrintTo(const PathScene& scene, std::ostream* out) { *out << scene.name; }

class PathAgainstMis : public testing::TestWithParam<PathScene> {};

// `mis` moves all pixels of a round together, which makes rounds differ more than their mean does: z is small
// rather than large, so only large ones count.
TEST_P(PathAgainstMis, TilesHaveTheSameMean) {
  const auto& [name, make, rounds, interval] = GetParam();
  Messages messages;
  Session session(make ? make() : load_scene(name, {}, messages),
                  path_settings(width, height, LightSelection::all), messages);
  const double bound = two_sided_bound(sidak_level(0.01, tile_count));
  for (const LightSelection light : {LightSelection::all, LightSelection::direct, LightSelection::indirect}) {
    SCOPED_TRACE(static_cast<int>(light));
    const Tiles path = run_rounds(session, "path", light, rounds);
    const Tiles mis = run_rounds(session, "mis", light, rounds);
    double squares = 0, sum = 0, variance = 0;
    for (size_t t = 0; t < tile_count; ++t) {
      const double difference = path.mean[t] - mis.mean[t];
      const double variance_of_both = path.variance[t] + mis.variance[t] + std::pow(1e-5 * path.mean[t], 2);
      if (!(variance_of_both > 0)) continue;
      EXPECT_LE(std::abs(difference), bound * std::sqrt(variance_of_both)) << "tile " << t;
      squares += difference * difference / variance_of_both;
      sum += path.mean[t], variance += variance_of_both;
    }
    EXPECT_GT(chi_square_tail(squares, tile_count), 0.001);
    EXPECT_LT(std::sqrt(variance), interval * sum) << "too noisy to tell";
    RecordProperty("relative_error", fmt::format("{}", std::sqrt(variance) / sum));
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, PathAgainstMis,
                         testing::Values(PathScene{"cornell", nullptr, 192, 0.02},
                                         PathScene{"spheres", nullptr, 64, 0.01},
                                         PathScene{"box", nullptr, 96, 0.02},
                                         PathScene{"ggx_room", ggx_room, 160, 0.01}),
                         [](const auto& test) { return std::string(test.param.name); });

// ---- As a technique ----

/// A mirror floor under a lamp, and a shiny wall: what the floor shows of the wall hangs on the wall's whole
/// BRDF.
Scene mirror_room() {
  Scene scene;
  Material mirror;
  mirror.metallic = 1, mirror.roughness = 0.05f;
  Material lamp = diffuse_material(Vec3(0));
  lamp.emission = Vec3(20);
  scene.materials = {mirror, mirror, lamp};
  add_patch(scene, {0, 0, 0}, {0, 0, 1}, {1, 0, 0});
  add_patch(scene, {0, 0, 0}, {0, 1, 0}, {0, 0, 1}, 1);
  add_patch(scene, {0.6f, 0.9f, 0.3f}, {0.3f, 0, 0}, {0, 0, 0.3f}, 2);
  scene.cameras = {look_at({1.5f, 0.8f, 0.5f}, {0.2f, 0.2f, 0.5f}, {0, 1, 0}, 0.8f)};
  return scene;
}

TEST(PathTracer, WholeBrdfsAreAnotherPicture) {
  Messages messages;
  Session session(mirror_room(), path_settings(32, 24, LightSelection::all), messages);
  const auto picture = [&](const char* model) {
    session.set_settings(path_settings(32, 24, LightSelection::indirect, {{"path.model", model}}));
    for (int round = 0; round < 8; ++round) session.run_pass(64, 1, 0);
    return session.film().image().pixels;
  };
  const std::vector<Vec3> lambert = picture("lambert"), whole = picture("whole");
  double difference = 0, sum = 0;
  for (size_t i = 0; i < lambert.size(); ++i)
    difference += std::abs(lambert[i].y - whole[i].y), sum += lambert[i].y;
  EXPECT_GT(sum, 0);
  EXPECT_GT(difference, sum);
}

TEST(PathTracer, SameBitsForAnyNumberOfThreadsAndSubsets) {
  Messages messages;
  const RenderSettings settings = path_settings(37, 21, LightSelection::all, {{"path.bounces", "8"}});
  Session session(load_scene("cornell", {}, messages), settings, messages);
  const auto picture = [&](uint32_t stride) {
    session.restart();
    for (int round = 0; round < 2; ++round)
      for (uint32_t offset = 0; offset < stride * stride; ++offset) session.run_pass(3, stride, offset);
    return session.film().image().pixels;
  };
  set_thread_count(1);
  const std::vector<Vec3> one = picture(1);
  set_thread_count(2);
  EXPECT_EQ(picture(1), one);
  set_thread_count(0);
  EXPECT_EQ(picture(4), one);
  EXPECT_EQ(picture(2), one);
}

TEST(PathTracer, StopsWhenAskedAndCountsItsRays) {
  Messages messages;
  Session session(load_scene("cornell", {}, messages), path_settings(32, 24, LightSelection::all), messages);
  const FrameView frame = session.frame();
  const auto technique = find_technique("path").make();
  technique->prepare(frame);
  Film film(32, 24);
  PassRequest request;
  request.samples = 3;
  std::atomic<uint64_t> watched = 0;
  request.watch_rays = [&](std::span<const ShadowRay> rays) { watched += rays.size(); };
  const PassStats stats = technique->run_pass(frame, request, film);
  EXPECT_TRUE(stats.finished);
  EXPECT_EQ(stats.pixels, 32u * 24u);
  EXPECT_GT(stats.rays.closest, 3u * 32u * 24u);
  EXPECT_EQ(stats.rays.visibility, watched);
  EXPECT_EQ(stats.useful_rays, watched);
  EXPECT_EQ(film.mean_samples(), 3);

  std::stop_source source;
  source.request_stop();
  request.stop = source.get_token();
  Film untouched(32, 24);
  EXPECT_FALSE(technique->run_pass(frame, request, untouched).finished);
  EXPECT_EQ(untouched.mean_samples(), 0);
}

TEST(PathTracer, NothingIsMadeForIt) {
  Messages messages;
  Session session(load_scene("spheres", {}, messages), path_settings(32, 24, LightSelection::all), messages);
  for (int round = 0; round < 3; ++round) session.run_pass(2, 1, 0);
  for (const PlanStage& stage : session.plan().stages)
    EXPECT_EQ(stage.runs, stage.stage == Stage::antialiasing || stage.stage == Stage::traced_brdf_rays)
        << stage_name(stage.stage) << ": " << stage.why;
  EXPECT_EQ(session.stats().seconds.lights, 0);
  EXPECT_EQ(session.stats().seconds.raster, 0);
  EXPECT_EQ(session.stats().light_count, 0u);
  EXPECT_EQ(session.frame().gbuffer, nullptr);

  // Whoever asks for the G-buffer gets one all the same, and other techniques theirs.
  ASSERT_EQ(session.gbuffer().pixel_count(), 32u * 24u);
  EXPECT_TRUE(session.gbuffer().texels[12 * 32 + 16].hit());
  RenderSettings settings = session.settings();
  settings.technique = "mis", settings.target = Target::continuous;
  session.set_settings(settings);
  session.run_pass(2, 1, 0);
  EXPECT_GT(session.stats().seconds.raster, 0);
  EXPECT_NE(session.frame().gbuffer, nullptr);
}

TEST(PathTracer, ExtremesLeaveNoNan) {
  for (const float length : {1e-6f, 1.0f, 1e6f})
    for (const float light : {1e-30f, 1.0f, 1e30f}) {
      Scene scene = mirror_room();
      scene.materials[0].roughness = 0;
      scene.environment = constant_environment(Vec3(light));
      scene.materials[2].emission = Vec3(light);
      PunctualLight lamp;
      lamp.position = {0.5f, 0, 0.5f}, lamp.intensity = Vec3(light) * length * length;
      scene.lights.push_back(lamp);  // in the floor itself
      for (Vertex& vertex : scene.vertices) vertex.position *= length;
      for (PunctualLight& l : scene.lights) l.position *= length;
      scene.cameras[0].position *= length;
      update_bounds(scene);
      Messages messages;
      for (const char* model : {"lambert", "whole"}) {
        Session session(
            scene, path_settings(16, 12, LightSelection::all, {{"path.bounces", "8"}, {"path.model", model}}),
            messages);
        for (int round = 0; round < 4; ++round) session.run_pass(16, 1, 0);
        EXPECT_EQ(session.film().nan_samples(), 0u) << length << " " << light;
        EXPECT_GT(session.film().mean_radiance().y, 0);
        EXPECT_EQ(session.stats().rays.rejected, 0u);
      }
    }
}

}  // namespace
}  // namespace halflight
