// Scenes, contexts and a brute-force tracer shared by the rasteriser's tests.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "core/parallel.h"
#include "core/random.h"
#include "raster/rasterizer.h"
#include "scene/shading.h"

namespace halflight::test {

inline const char* backend_name(Backend backend) { return backend == Backend::egl ? "egl" : "osmesa"; }

/// The context, or nothing where its library is not installed; any other failure throws.
inline std::unique_ptr<GlContext> context_or_null(Backend backend) {
  try {
    return GlContext::make_headless(backend);
  } catch (const Error& error) {
    if (std::string(error.what()).find("cannot open lib") == std::string::npos) throw;
    return nullptr;
  }
}

/// Tests that run on EGL and on OSMesa; skipped, and saying so, where the library is absent.
class OnBackend : public testing::TestWithParam<Backend> {
 protected:
  void SetUp() override {
    context = context_or_null(GetParam());
    if (!context) GTEST_SKIP() << backend_name(GetParam()) << ": its library is not installed";
  }
  std::unique_ptr<GlContext> context;
  Messages messages;
};

#define HALFLIGHT_ON_BACKENDS(suite)                                                        \
  INSTANTIATE_TEST_SUITE_P(Backends, suite, testing::Values(Backend::egl, Backend::osmesa), \
                           [](const auto& chosen) { return std::string(backend_name(chosen.param)); })

// ---- Geometry ----

inline Vertex make_vertex(Vec3 position, Vec3 normal, Vec2 uv) {
  return {position, normal, Vec4(0), {uv, uv}, 0xffffffffu};
}

/// Appends the parallelogram corner + [0,1] a + [0,1] b with normal a × b, tangent along a, uv along (a, b).
inline void add_quad(Scene& scene, Vec3 corner, Vec3 a, Vec3 b, uint32_t material, float handedness = 1) {
  const auto first = static_cast<uint32_t>(scene.vertices.size());
  const Vec3 normal = glm::normalize(glm::cross(glm::normalize(a), glm::normalize(b)));
  const Vec2 uvs[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (const Vec2 uv : uvs) {
    Vertex v = make_vertex(corner + uv.x * a + uv.y * b, normal, uv);
    v.tangent = Vec4(glm::normalize(a), handedness);
    scene.vertices.push_back(v);
  }
  scene.triangles.push_back({first, first + 1, first + 2});
  scene.triangles.push_back({first, first + 2, first + 3});
  scene.triangle_material.insert(scene.triangle_material.end(), 2, material);
}

/// Appends a closed axis-aligned box with outward normals.
inline void add_box(Scene& scene, Vec3 low, Vec3 high, uint32_t material) {
  const Vec3 e = high - low, x(e.x, 0, 0), y(0, e.y, 0), z(0, 0, e.z);
  add_quad(scene, low, y, x, material);
  add_quad(scene, low + z, x, y, material);
  add_quad(scene, low, x, z, material);
  add_quad(scene, low + y, z, x, material);
  add_quad(scene, low, z, y, material);
  add_quad(scene, low + x, y, z, material);
}

/// Appends a sphere of (2 · steps) × steps quads with smooth normals and tangents along longitude.
inline void add_sphere(Scene& scene, Vec3 centre, float radius, int steps, uint32_t material) {
  const auto first = static_cast<uint32_t>(scene.vertices.size());
  for (int j = 0; j <= steps; ++j) {
    for (int i = 0; i <= 2 * steps; ++i) {
      const float u = static_cast<float>(i) / static_cast<float>(2 * steps);
      const float v = static_cast<float>(j) / static_cast<float>(steps);
      const float phi = 2 * pi * u, theta = pi * v;
      const Vec3 n(std::sin(theta) * std::cos(phi), std::cos(theta), -std::sin(theta) * std::sin(phi));
      Vertex vertex = make_vertex(centre + radius * n, n, {u, v});
      vertex.tangent = Vec4(-std::sin(phi), 0, -std::cos(phi), 1);
      scene.vertices.push_back(vertex);
    }
  }
  const auto at = [&](int i, int j) { return first + static_cast<uint32_t>(j * (2 * steps + 1) + i); };
  for (int j = 0; j < steps; ++j) {
    for (int i = 0; i < 2 * steps; ++i) {
      if (j > 0) scene.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
      if (j + 1 < steps) scene.triangles.push_back({at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
    }
  }
  scene.triangle_material.resize(scene.triangles.size(), material);
}

/// Multiplies all lengths of the scene and the camera by `factor`; light keeps its irradiance.
inline void scale_lengths(Scene& scene, Camera& camera, float factor) {
  for (Vertex& v : scene.vertices) v.position *= factor;
  for (PunctualLight& light : scene.lights) {
    light.position *= factor;
    light.range *= factor;
    if (light.kind != PunctualKind::directional) light.intensity *= factor * factor;
  }
  camera.position *= factor;
  camera.half_height *= factor;
  update_bounds(scene);
}

// ---- Materials ----

inline Material diffuse_material(Vec3 color) {
  Material m;
  m.base_color = Vec4(color, 1);
  m.metallic = 0;
  m.roughness = 1;
  return m;
}

/// Smooth noise with the given mean byte and amplitude in each channel.
inline ImageRgba8 noise_image(int width, int height, glm::ivec4 mean, glm::ivec4 amplitude, uint64_t seed) {
  ImageRgba8 image{width, height, {}};
  RandomStream random(0, 0, seed);
  for (int i = 0; i < width * height; ++i)
    for (int c = 0; c < 4; ++c)
      image.bytes.push_back(static_cast<uint8_t>(
          std::clamp(mean[c] + static_cast<int>(amplitude[c] * (2 * random.next() - 1)), 0, 255)));
  return image;
}

/// Adds an image and a texture of it; returns a use of the texture.
inline TextureUse add_texture(Scene& scene, ImageRgba8 image, bool srgb, Wrap wrap = Wrap::repeat,
                              bool nearest = false) {
  Texture texture;
  texture.image = static_cast<uint32_t>(scene.images.size());
  texture.srgb = srgb;
  texture.nearest = nearest;
  texture.wrap_u = texture.wrap_v = wrap;
  scene.images.push_back(std::move(image));
  scene.textures.push_back(texture);
  TextureUse use;
  use.texture = static_cast<int32_t>(scene.textures.size()) - 1;
  return use;
}

// ---- Brute force ----

struct BruteHit {
  double distance;
  Vec3d barycentric;
};

/// Möller & Trumbore 1997 in double; both sides.
inline std::optional<BruteHit> intersect_triangle(const Scene& scene, uint32_t triangle, Vec3d origin,
                                                  Vec3d direction) {
  const UVec3 t = scene.triangles[triangle];
  const Vec3d a(scene.vertices[t.x].position);
  const Vec3d ab = Vec3d(scene.vertices[t.y].position) - a, ac = Vec3d(scene.vertices[t.z].position) - a;
  const Vec3d p = glm::cross(direction, ac);
  const double determinant = glm::dot(ab, p);
  if (determinant == 0) return std::nullopt;
  const Vec3d from = origin - a, q = glm::cross(from, ab);
  const double u = glm::dot(from, p) / determinant, v = glm::dot(direction, q) / determinant;
  if (u < 0 || v < 0 || u + v > 1) return std::nullopt;
  return BruteHit{glm::dot(ac, q) / determinant, {1 - u - v, u, v}};
}

/// Closest surface that blocks the ray within (near, far).
inline std::optional<SurfacePoint> brute_closest(const Scene& scene, Vec3 origin, Vec3 direction,
                                                 double near_distance, double far_distance,
                                                 uint32_t alpha_seed) {
  std::optional<SurfacePoint> closest;
  for (uint32_t i = 0; i < scene.triangles.size(); ++i) {
    const auto hit = intersect_triangle(scene, i, Vec3d(origin), Vec3d(direction));
    if (!hit || hit->distance <= near_distance || hit->distance >= far_distance) continue;
    const SurfacePoint point{
        i, {static_cast<float>(hit->barycentric.y), static_cast<float>(hit->barycentric.z)}};
    if (!surface_blocks(scene, point, alpha_seed)) continue;
    closest = point;
    far_distance = hit->distance;
  }
  return closest;
}

/// The G-buffer by brute force; background texels keep only wo.
inline GBuffer brute_gbuffer(const Scene& scene, const Camera& camera, int width, int height, Vec2 jitter,
                             uint32_t alpha_seed) {
  GBuffer gbuffer;
  gbuffer.resize(width, height);
  parallel_for(0, gbuffer.pixel_count(), 64, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const Vec2 pixel(static_cast<float>(i % width) + 0.5f + jitter.x,
                       static_cast<float>(i / width) + 0.5f + jitter.y);
      const CameraRay ray = camera_ray(camera, pixel, width, height);
      const auto hit = brute_closest(scene, ray.origin, ray.direction, 0, infinity, alpha_seed);
      if (hit) gbuffer.texels[i] = shade_surface(scene, *hit, -ray.direction);
      gbuffer.texels[i].wo = -ray.direction;
    }
  });
  return gbuffer;
}

/// Whether the straight way from x (moved `offset` along n) to the light is free.
inline bool brute_visible(const Scene& scene, Vec3 x, Vec3 n, Vec3 wi, float distance, float offset) {
  return !brute_closest(scene, x + offset * n, wi, 0, distance - offset, 0);
}

}  // namespace halflight::test
