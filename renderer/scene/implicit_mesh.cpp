#include "scene/implicit_mesh.h"

#include <array>

#include "core/errors.h"
#include "core/parallel.h"

namespace halflight {

namespace {

constexpr int block = 8;  // samples along a side of what is skipped at once

/// Values of the field at the corners of cubes.
struct FieldGrid {
  std::array<int, 3> count;  ///< corners along each axis
  Vec3 origin;
  float cell;
  std::vector<float> values;

  size_t index(int i, int j, int k) const { return (static_cast<size_t>(k) * count[1] + j) * count[0] + i; }
  Vec3 place(Vec3 corner) const { return origin + cell * corner; }
};

void sample_block(FieldGrid& grid, const Field& field, std::array<int, 3> from) {
  std::array<int, 3> to;
  for (int a = 0; a < 3; ++a) to[a] = std::min(from[a] + block, grid.count[a]);
  const Vec3 middle = grid.place(Vec3(from[0], from[1], from[2]) + 0.5f * (block - 1));
  const float inside = field(middle);
  // Half the block's diagonal and as much again for fields steeper than a distance.
  const bool far = std::abs(inside) > grid.cell * block * 0.87f * 1.6f;
  for (int k = from[2]; k < to[2]; ++k)
    for (int j = from[1]; j < to[1]; ++j)
      for (int i = from[0]; i < to[0]; ++i)
        grid.values[grid.index(i, j, k)] = far ? inside : field(grid.place(Vec3(i, j, k)));
}

FieldGrid sample_field(const Field& field, const Aabb& box, float cell) {
  FieldGrid grid;
  const Vec3 extent = box.extent();
  size_t total = 1;
  std::array<size_t, 3> blocks{};
  for (int a = 0; a < 3; ++a) {
    grid.count[a] = static_cast<int>(std::ceil(extent[a] / cell)) + 1;
    total *= static_cast<size_t>(grid.count[a]);
    blocks[a] = static_cast<size_t>((grid.count[a] + block - 1) / block);
  }
  grid.origin = box.low, grid.cell = cell;
  grid.values.resize(total);
  parallel_for(0, blocks[0] * blocks[1] * blocks[2], 4, [&](size_t begin, size_t end) {
    for (size_t b = begin; b < end; ++b)
      sample_block(
          grid, field,
          {static_cast<int>(b % blocks[0]) * block, static_cast<int>(b / blocks[0] % blocks[1]) * block,
           static_cast<int>(b / (blocks[0] * blocks[1])) * block});
  });
  return grid;
}

constexpr uint32_t no_vertex = 0xffffffffu;

/// Mean of the surface's crossings with the edges of the cube at (i, j, k), in corners; nothing where there
/// is none.
bool crossing_mean(const FieldGrid& grid, int i, int j, int k, Vec3& mean) {
  std::array<float, 8> value;
  int negative = 0;
  for (int c = 0; c < 8; ++c) {
    value[c] = grid.values[grid.index(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2))];
    negative += value[c] < 0;
  }
  if (negative == 0 || negative == 8) return false;
  Vec3 sum(0);
  int crossings = 0;
  for (int c = 0; c < 8; ++c)
    for (int a = 0; a < 3; ++a) {
      const int d = c | 1 << a;
      if (d == c || (value[c] < 0) == (value[d] < 0)) continue;
      Vec3 at(c & 1, c >> 1 & 1, c >> 2);
      at[a] = value[c] / (value[c] - value[d]);
      sum += at, ++crossings;
    }
  mean = Vec3(i, j, k) + sum / static_cast<float>(crossings);
  return true;
}

/// Joins the vertices of the four cubes around every edge that the surface crosses.
void add_faces(Mesh& mesh, const FieldGrid& grid, const std::vector<uint32_t>& vertex_of) {
  for (int k = 1; k + 1 < grid.count[2]; ++k)
    for (int j = 1; j + 1 < grid.count[1]; ++j)
      for (int i = 1; i + 1 < grid.count[0]; ++i)
        for (int a = 0; a < 3; ++a) {
          std::array<int, 3> next{i, j, k};
          ++next[a];
          const bool here = grid.values[grid.index(i, j, k)] < 0;
          if (here == (grid.values[grid.index(next[0], next[1], next[2])] < 0)) continue;
          const int b = (a + 1) % 3, c = (a + 2) % 3;
          const auto cube = [&](int back_b, int back_c) {
            std::array<int, 3> at{i, j, k};
            at[b] -= back_b, at[c] -= back_c;
            return vertex_of[grid.index(at[0], at[1], at[2])];
          };
          const uint32_t v[4] = {cube(1, 1), cube(0, 1), cube(0, 0), cube(1, 0)};
          for (const uint32_t vertex : v) HALFLIGHT_CHECK(vertex != no_vertex);
          if (here)
            mesh.triangles.insert(mesh.triangles.end(), {{v[0], v[1], v[2]}, {v[0], v[2], v[3]}});
          else
            mesh.triangles.insert(mesh.triangles.end(), {{v[0], v[2], v[1]}, {v[0], v[3], v[2]}});
        }
}

Vec3 gradient(const Field& field, Vec3 p, float step) {
  Vec3 g;
  for (int a = 0; a < 3; ++a) {
    Vec3 offset(0);
    offset[a] = step;
    g[a] = field(p + offset) - field(p - offset);
  }
  return g;
}

}  // namespace

Mesh implicit_mesh(const Field& field, const Aabb& box, float cell) {
  const FieldGrid grid = sample_field(field, box, cell);
  Mesh mesh;
  std::vector<uint32_t> vertex_of(grid.values.size(), no_vertex);
  for (int k = 0; k + 1 < grid.count[2]; ++k)
    for (int j = 0; j + 1 < grid.count[1]; ++j)
      for (int i = 0; i + 1 < grid.count[0]; ++i)
        if (Vec3 corner; crossing_mean(grid, i, j, k, corner))
          vertex_of[grid.index(i, j, k)] = add_vertex(mesh, grid.place(corner));
  add_faces(mesh, grid, vertex_of);
  smooth_normals(mesh);
  parallel_for(0, mesh.vertices.size(), 256, [&](size_t begin, size_t end) {
    for (size_t v = begin; v < end; ++v) {
      const Vec3 g = gradient(field, mesh.vertices[v].position, 0.5f * cell);
      if (glm::dot(g, mesh.vertices[v].normal) > 0) mesh.vertices[v].normal = glm::normalize(g);
    }
  });
  return mesh;
}

}  // namespace halflight
