#include "scene/mesh_builder.h"

#include <array>
#include <numeric>

#include "core/errors.h"
#include "core/random.h"

namespace halflight {

uint32_t add_vertex(Mesh& mesh, Vec3 position, Vec2 uv) {
  Vertex vertex{};
  vertex.position = position;
  vertex.uv[0] = vertex.uv[1] = uv;
  vertex.color = 0xffffffffu;
  mesh.vertices.push_back(vertex);
  return static_cast<uint32_t>(mesh.vertices.size() - 1);
}

namespace {

void add_quad(Mesh& mesh, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
  mesh.triangles.push_back({a, b, c});
  mesh.triangles.push_back({a, c, d});
}

Vec3 face_cross(const Mesh& mesh, UVec3 t) {
  const Vec3 a = mesh.vertices[t.x].position;
  return glm::cross(mesh.vertices[t.y].position - a, mesh.vertices[t.z].position - a);
}

Vec3 unit_or_up(Vec3 v) {
  const float length2 = glm::dot(v, v);
  return length2 > 0 ? v / std::sqrt(length2) : Vec3(0, 1, 0);
}

void transform_vertices(std::span<Vertex> vertices, const Mat4& transform) {
  const Mat3 linear(transform);
  const Mat3 normal_matrix = glm::transpose(glm::inverse(linear));
  const float handedness = glm::determinant(linear) < 0 ? -1.0f : 1.0f;
  for (Vertex& vertex : vertices) {
    vertex.position = Vec3(transform * Vec4(vertex.position, 1));
    vertex.normal = unit_or_up(normal_matrix * vertex.normal);
    if (vertex.tangent.w != 0)
      vertex.tangent = Vec4(unit_or_up(linear * Vec3(vertex.tangent)), vertex.tangent.w * handedness);
  }
}

/// Appends vertices and triangles to any pools; shared by meshes and scenes.
void append_to(std::vector<Vertex>& vertices, std::vector<UVec3>& triangles, const Mesh& mesh,
               const Mat4& transform) {
  const auto first = static_cast<uint32_t>(vertices.size());
  vertices.insert(vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
  transform_vertices(std::span(vertices).subspan(first), transform);
  const bool mirrored = glm::determinant(Mat3(transform)) < 0;
  for (UVec3 t : mesh.triangles) {
    if (mirrored) std::swap(t.y, t.z);
    triangles.push_back(t + UVec3(first));
  }
}

}  // namespace

void append(Mesh& mesh, const Mesh& other, const Mat4& transform) {
  append_to(mesh.vertices, mesh.triangles, other, transform);
}

void smooth_normals(Mesh& mesh, float crease) {
  for (const Vertex& vertex : mesh.vertices) HALFLIGHT_CHECK(is_finite(vertex.position));
  std::erase_if(mesh.triangles, [&](UVec3 t) { return glm::length(face_cross(mesh, t)) <= 1e-14f; });
  std::vector<Vec3> own(mesh.vertices.size(), Vec3(0));
  for (const UVec3 t : mesh.triangles)
    for (int k = 0; k < 3; ++k) own[t[k]] += face_cross(mesh, t);

  // Vertices at one position stand side by side in `order`.
  std::vector<uint32_t> order(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto key = [&](uint32_t i) {
    const Vec3 p = mesh.vertices[i].position;
    return std::array<float, 3>{p.x, p.y, p.z};
  };
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return key(a) < key(b); });
  const float least_cosine = std::cos(crease);
  for (size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    while (end < order.size() && key(order[end]) == key(order[begin])) ++end;
    for (size_t i = begin; i < end; ++i) {
      const Vec3 mine = unit_or_up(own[order[i]]);
      Vec3 sum(0);
      for (size_t j = begin; j < end; ++j)
        if (j == i || glm::dot(mine, unit_or_up(own[order[j]])) >= least_cosine) sum += own[order[j]];
      mesh.vertices[order[i]].normal = unit_or_up(sum);
    }
  }
}

void displace(Mesh& mesh, const std::function<Vec3(Vec3, Vec3, Vec2)>& displacement) {
  for (Vertex& v : mesh.vertices) v.position += displacement(v.position, v.normal, v.uv[0]);
  smooth_normals(mesh);
}

Mesh grid_mesh(GridShape shape, const std::function<Vec3(float, float)>& position) {
  Mesh mesh;
  const int columns = shape.columns, rows = shape.rows;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) {
      const Vec2 uv(static_cast<float>(i) / columns, static_cast<float>(j) / rows);
      add_vertex(mesh,
                 position(shape.wrap_u && i == columns ? 0 : uv.x, shape.wrap_v && j == rows ? 0 : uv.y), uv);
    }
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const uint32_t a = static_cast<uint32_t>(j * (columns + 1) + i), below = a + columns + 1;
      add_quad(mesh, a, a + 1, below + 1, below);
    }
  smooth_normals(mesh);
  return mesh;
}

Mesh rectangle_mesh(Vec3 corner, Vec3 a, Vec3 b) {
  Mesh mesh;
  const float width = glm::length(a), height = glm::length(b);
  add_vertex(mesh, corner, {0, 0});
  add_vertex(mesh, corner + a, {width, 0});
  add_vertex(mesh, corner + a + b, {width, height});
  add_vertex(mesh, corner + b, {0, height});
  add_quad(mesh, 0, 1, 2, 3);
  smooth_normals(mesh);
  return mesh;
}

namespace {

/// Stations across one face of a rounded box: where the flat core ends, and the tangent of the angle beyond
/// it.
struct Station {
  float side;     ///< −1 or +1: which end of the core
  float tangent;  ///< of the angle away from the face's axis, in [−1, 1]
};

std::vector<Station> box_stations(float radius, int segments) {
  std::vector<Station> stations;
  if (radius <= 0) return {{-1, 0}, {1, 0}};
  for (int side = -1; side <= 1; side += 2)
    for (int i = 0; i <= segments; ++i) {
      const float t = static_cast<float>(side < 0 ? segments - i : i) / segments;
      stations.push_back({static_cast<float>(side), side * std::tan(t * pi / 4)});
    }
  return stations;
}

}  // namespace

Mesh box_mesh(Vec3 size, float radius, int segments) {
  Mesh mesh;
  const Vec3 half = 0.5f * size;
  radius = std::min(radius, 0.999f * std::min(half.x, std::min(half.y, half.z)));
  const Vec3 core = half - Vec3(std::max(radius, 0.0f));
  const std::vector<Station> stations = box_stations(radius, segments);
  const auto count = static_cast<uint32_t>(stations.size());
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2, a = (axis + 1) % 3, b = (axis + 2) % 3;
    const float sign = face % 2 == 0 ? 1.0f : -1.0f;
    const auto first = static_cast<uint32_t>(mesh.vertices.size());
    for (const Station& sb : stations)
      for (const Station& sa : stations) {
        Vec3 centre, out;
        centre[axis] = sign * core[axis], centre[a] = sa.side * core[a], centre[b] = sb.side * core[b];
        out[axis] = sign, out[a] = sa.tangent, out[b] = sb.tangent;
        const Vec3 normal = glm::normalize(out), p = centre + std::max(radius, 0.0f) * normal;
        // Texture u runs along the horizontal of upright faces, v along their vertical.
        const Vec2 uv = axis == 0 ? Vec2(p.z, p.y) : axis == 1 ? Vec2(p.x, p.z) : Vec2(p.x, p.y);
        mesh.vertices[add_vertex(mesh, p, uv + half.x + half.z)].normal = normal;
      }
    for (uint32_t j = 0; j + 1 < count; ++j)
      for (uint32_t i = 0; i + 1 < count; ++i) {
        const uint32_t v = first + j * count + i;
        if (sign > 0)
          add_quad(mesh, v, v + 1, v + 1 + count, v + count);
        else
          add_quad(mesh, v, v + count, v + 1 + count, v + 1);
      }
  }
  std::erase_if(mesh.triangles, [&](UVec3 t) { return glm::length(face_cross(mesh, t)) <= 1e-14f; });
  return mesh;
}

Mesh superquadric_mesh(Vec3 half_axes, Vec2 round, int columns, int rows) {
  const auto power = [](float x, float e) { return std::copysign(std::pow(std::abs(x), e), x); };
  return grid_mesh({columns, rows, true, false}, [&](float u, float v) {
    const float longitude = -2 * pi * u, latitude = pi * (v - 0.5f);
    const float ring = v <= 0 || v >= 1 ? 0 : power(std::cos(latitude), round.x);
    return half_axes * Vec3(ring * power(std::cos(longitude), round.y), power(std::sin(latitude), round.x),
                            ring * power(std::sin(longitude), round.y));
  });
}

Mesh lathe_mesh(std::span<const Vec2> profile, int segments, float crease) {
  Mesh mesh;
  const auto ring = [&](Vec2 p, float v) {
    for (int i = 0; i <= segments; ++i) {
      const float phi = 2 * pi * static_cast<float>(i % segments) / segments;
      add_vertex(mesh, {p.x * std::cos(phi), p.y, -p.x * std::sin(phi)},
                 {static_cast<float>(i) / segments, v});
    }
  };
  // Each piece of the profile has rings of its own; smooth_normals joins them again where the corner is
  // blunt.
  float along = 0;
  for (size_t k = 0; k + 1 < profile.size(); ++k) {
    const auto first = static_cast<uint32_t>(mesh.vertices.size());
    ring(profile[k], along);
    along += glm::length(profile[k + 1] - profile[k]);
    ring(profile[k + 1], along);
    for (uint32_t i = 0; i < static_cast<uint32_t>(segments); ++i)
      add_quad(mesh, first + i, first + i + 1, first + i + segments + 2, first + i + segments + 1);
  }
  smooth_normals(mesh, crease);
  return mesh;
}

namespace {

template <class Vec>
std::vector<Vec> catmull_rom(std::span<const Vec> points, int steps) {
  std::vector<Vec> curve;
  const int last = static_cast<int>(points.size()) - 1;
  const auto at = [&](int i) {
    // Reflected ends: the curve starts and stops straight.
    if (i < 0) return 2.0f * points[0] - points[1];
    return i > last ? 2.0f * points[last] - points[last - 1] : points[i];
  };
  for (int i = 0; i < last; ++i)
    for (int k = 0; k < steps; ++k) {
      const float t = static_cast<float>(k) / steps;
      const Vec a = at(i - 1), b = at(i), c = at(i + 1), d = at(i + 2);
      curve.push_back(0.5f * (2.0f * b + (c - a) * t + (2.0f * a - 5.0f * b + 4.0f * c - d) * (t * t) +
                              (3.0f * b - a - 3.0f * c + d) * (t * t * t)));
    }
  curve.push_back(points[last]);
  return curve;
}

}  // namespace

std::vector<Vec2> smooth_curve(std::span<const Vec2> points, int steps) { return catmull_rom(points, steps); }
std::vector<Vec3> smooth_curve(std::span<const Vec3> points, int steps) { return catmull_rom(points, steps); }

Mesh tube_mesh(std::span<const Vec3> path, int sides, const std::function<float(float)>& radius) {
  HALFLIGHT_CHECK(path.size() >= 2);
  Mesh mesh;
  const int last = static_cast<int>(path.size()) - 1;
  Basis frame = basis_around(glm::normalize(path[1] - path[0]));
  for (int k = 0; k <= last; ++k) {
    const Vec3 ahead = path[std::min(k + 1, last)] - path[std::max(k - 1, 0)];
    frame = basis_along(glm::normalize(ahead), frame.tangent);
    const float t = static_cast<float>(k) / last, r = radius(t);
    for (int i = 0; i <= sides; ++i) {
      const float phi = 2 * pi * static_cast<float>(i % sides) / sides;
      add_vertex(mesh, path[k] + r * (std::cos(phi) * frame.tangent + std::sin(phi) * frame.bitangent),
                 {static_cast<float>(i) / sides, t});
    }
  }
  for (int k = 0; k < last; ++k)
    for (int i = 0; i < sides; ++i) {
      const uint32_t a = static_cast<uint32_t>(k * (sides + 1) + i), above = a + sides + 1;
      add_quad(mesh, a, a + 1, above + 1, above);
    }
  for (int end = 0; end < 2; ++end) {
    const auto first = static_cast<uint32_t>(mesh.vertices.size());
    const uint32_t source = end == 0 ? 0 : static_cast<uint32_t>(last * (sides + 1));
    for (int i = 0; i < sides; ++i) add_vertex(mesh, mesh.vertices[source + i].position);
    for (uint32_t i = 1; i + 1 < static_cast<uint32_t>(sides); ++i)
      mesh.triangles.push_back(end == 0 ? UVec3(first, first + i + 1, first + i)
                                        : UVec3(first, first + i, first + i + 1));
  }
  smooth_normals(mesh);
  return mesh;
}

Mesh tube_mesh(std::span<const Vec3> path, int sides, float radius) {
  return tube_mesh(path, sides, [radius](float) { return radius; });
}

Mat4 move(Vec3 by) { return glm::translate(Mat4(1), by); }
Mat4 turn(float radians, Vec3 axis) { return glm::rotate(Mat4(1), radians, axis); }
Mat4 stretch(Vec3 factors) { return glm::scale(Mat4(1), factors); }

void place(Scene& scene, const Mesh& mesh, uint32_t material, const Mat4& transform) {
  const size_t first = scene.triangles.size();
  append_to(scene.vertices, scene.triangles, mesh, transform);
  // Slivers may lose their area in the scene's coordinates.
  const auto flat = [&](UVec3 t) {
    const Vec3 a = scene.vertices[t.x].position;
    return glm::cross(scene.vertices[t.y].position - a, scene.vertices[t.z].position - a) == Vec3(0);
  };
  scene.triangles.erase(std::remove_if(scene.triangles.begin() + static_cast<std::ptrdiff_t>(first),
                                       scene.triangles.end(), flat),
                        scene.triangles.end());
  scene.triangle_material.resize(scene.triangles.size(), material);
}

uint32_t add_material(Scene& scene, Material material) {
  scene.materials.push_back(std::move(material));
  return static_cast<uint32_t>(scene.materials.size() - 1);
}

Material plain_material(std::string name, Vec3 color, float roughness) {
  Material material;
  material.name = std::move(name);
  material.base_color = Vec4(color, 1);
  material.metallic = 0, material.roughness = roughness;
  return material;
}

Material metal_material(std::string name, Vec3 color, float roughness) {
  Material material = plain_material(std::move(name), color, roughness);
  material.metallic = 1;
  return material;
}

TextureUse add_texture(Scene& scene, ImageRgba8 image, std::string name, Vec2 size) {
  scene.images.push_back(std::move(image));
  Texture texture;
  texture.name = std::move(name);
  texture.image = static_cast<uint32_t>(scene.images.size() - 1);
  texture.srgb = true;
  scene.textures.push_back(texture);
  TextureUse use;
  use.texture = static_cast<int32_t>(scene.textures.size() - 1);
  use.row_u = {1 / size.x, 0, 0}, use.row_v = {0, 1 / size.y, 0};
  return use;
}

}  // namespace halflight
