#include "scene/gltf_geometry.h"

#include <memory>
#include <numeric>

#include "core/parallel.h"
#include "scene/tangents.h"

namespace halflight {

namespace {

constexpr size_t grain = 8192;  // vertices or triangles a piece of a parallel loop

enum class Mode : uint32_t { triangles = 4, strip = 5, fan = 6 };

/// Reads a primitive's attributes from accessors, or from its Draco mesh.
class AttributeSource {
 public:
  AttributeSource(const GltfSource& source, const GltfDocument& document, GltfReader& reader,
                  const GltfPrimitive& primitive, std::string_view place)
      : document_(document), reader_(reader), primitive_(primitive) {
    if (primitive.draco && draco_available)
      draco_ = std::make_unique<DracoMesh>(decode_draco(source, document, reader, primitive, place));
  }

  /// `width` is set to the numbers a vertex; empty where the primitive has no such attribute.
  std::vector<float> floats(std::string_view name, uint32_t& width) {
    if (draco_) {
      for (auto& attribute : draco_->attributes) {
        if (attribute.name != name) continue;
        width = attribute.width;
        return std::move(attribute.values);
      }
    }
    const int32_t accessor = find_attribute(primitive_.attributes, name);
    if (accessor < 0) return {};
    width = document_.accessors[accessor].width();
    return reader_.floats(static_cast<uint32_t>(accessor));
  }

  /// Empty where the primitive has none.
  std::vector<uint32_t> indices() {
    if (draco_) return std::move(draco_->indices);
    if (primitive_.indices >= 0) return reader_.integers(static_cast<uint32_t>(primitive_.indices));
    return {};
  }

  bool is_draco() const { return draco_ != nullptr; }

 private:
#ifdef HALFLIGHT_HAVE_DRACO
  static constexpr bool draco_available = true;
#else
  static constexpr bool draco_available = false;
#endif
  const GltfDocument& document_;
  GltfReader& reader_;
  const GltfPrimitive& primitive_;
  std::unique_ptr<DracoMesh> draco_;
};

/// glTF 2.0 §3.7.2.1: strips turn every other triangle round, fans share their first vertex.
std::vector<UVec3> assemble(const std::vector<uint32_t>& index, Mode mode) {
  std::vector<UVec3> triangles;
  if (index.size() < 3) return triangles;
  if (mode == Mode::triangles) {
    triangles.resize(index.size() / 3);
    parallel_for(0, triangles.size(), grain, [&](size_t begin, size_t end) {
      for (size_t t = begin; t < end; ++t) triangles[t] = {index[3 * t], index[3 * t + 1], index[3 * t + 2]};
    });
    return triangles;
  }
  triangles.reserve(index.size() - 2);
  for (size_t i = 0; i + 2 < index.size(); ++i) {
    if (mode == Mode::fan)
      triangles.emplace_back(index[i + 1], index[i + 2], index[0]);
    else
      triangles.emplace_back(index[i], index[i + 1 + i % 2], index[i + 2 - i % 2]);
  }
  return triangles;
}

uint32_t packed_color(const float* c, uint32_t width) {
  const auto byte = [](float x) { return static_cast<uint32_t>(std::clamp(x, 0.0f, 1.0f) * 255.0f + 0.5f); };
  const auto channel = [&](uint32_t i) { return i < width && !std::isnan(c[i]) ? byte(c[i]) : 255u; };
  return channel(0) | channel(1) << 8 | channel(2) << 16 | channel(3) << 24;
}

void read_vertices(AttributeSource& source, GltfGeometry& geometry) {
  auto& vertices = geometry.vertices;
  uint32_t position_width = 0;
  const auto positions = source.floats("POSITION", position_width);
  const size_t count = position_width < 3 ? 0 : positions.size() / position_width;
  vertices.assign(count, Vertex{Vec3(0), Vec3(0), Vec4(0), {Vec2(0), Vec2(0)}, 0xffffffffu});
  const auto fill = [&](std::string_view name, uint32_t least_width, auto&& set) {
    uint32_t width = 0;
    const auto values = source.floats(name, width);
    if (values.empty() || width < least_width || values.size() < count * width) return false;
    parallel_for(0, count, grain, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) set(vertices[i], values.data() + i * width, width);
    });
    return true;
  };
  parallel_for(0, count, grain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const float* p = positions.data() + i * position_width;
      vertices[i].position = {p[0], p[1], p[2]};
    }
  });
  geometry.has_normals = fill("NORMAL", 3, [](Vertex& v, const float* p, uint32_t) {
    v.normal = unit_or_zero(Vec3d(p[0], p[1], p[2]));
  });
  geometry.has_tangents = fill("TANGENT", 4, [](Vertex& v, const float* p, uint32_t) {
    const Vec3 tangent = unit_or_zero(Vec3d(p[0], p[1], p[2]));
    v.tangent = tangent == Vec3(0) ? Vec4(0) : Vec4(tangent, p[3] < 0 ? -1.0f : 1.0f);
  });
  const auto finite = [](float x) { return std::isfinite(x) ? x : 0.0f; };
  fill("TEXCOORD_0", 2, [&](Vertex& v, const float* p, uint32_t) { v.uv[0] = {finite(p[0]), finite(p[1])}; });
  fill("TEXCOORD_1", 2, [&](Vertex& v, const float* p, uint32_t) { v.uv[1] = {finite(p[0]), finite(p[1])}; });
  fill("COLOR_0", 3, [](Vertex& v, const float* p, uint32_t width) { v.color = packed_color(p, width); });
}

/// All JOINTS_n and WEIGHTS_n, side by side.
void read_influences(AttributeSource& source, GltfGeometry& geometry) {
  const size_t count = geometry.vertices.size();
  std::vector<std::pair<std::vector<float>, std::vector<float>>> sets;
  for (size_t n = 0; n < 8; ++n) {
    uint32_t width = 0;
    auto joints = source.floats(fmt::format("JOINTS_{}", n), width);
    auto weights = source.floats(fmt::format("WEIGHTS_{}", n), width);
    if (joints.size() != 4 * count || weights.size() != 4 * count) break;
    sets.emplace_back(std::move(joints), std::move(weights));
  }
  geometry.influences = 4 * sets.size();
  geometry.joints.reserve(geometry.influences * count);
  geometry.weights.reserve(geometry.influences * count);
  for (size_t v = 0; v < count; ++v) {
    for (const auto& [joints, weights] : sets) {
      for (size_t k = 4 * v; k < 4 * v + 4; ++k) {
        geometry.joints.push_back(static_cast<uint32_t>(joints[k]));
        geometry.weights.push_back(weights[k] > 0 && std::isfinite(weights[k]) ? weights[k] : 0.0f);
      }
    }
  }
}

}  // namespace

bool draws_triangles(const GltfPrimitive& primitive) {
  return primitive.mode >= static_cast<uint32_t>(Mode::triangles) &&
         find_attribute(primitive.attributes, "POSITION") >= 0;
}

void check_indices(const GltfSource& source, const std::vector<uint32_t>& indices, size_t vertex_count,
                   std::string_view place) {
  // The largest is found without branches; where it is too large the first one at fault is looked for.
  uint32_t largest = 0;
  for (const uint32_t index : indices) largest = std::max(largest, index);
  if (largest < vertex_count || indices.empty()) return;
  for (size_t i = 0; i < indices.size(); ++i) {
    if (indices[i] >= vertex_count) {
      source.fail(fmt::format("{}.indices", place), "ACCESSOR_INDEX_OOB",
                  fmt::format("index {} at {}, there are {} vertices", indices[i], i, vertex_count));
    }
  }
}

GltfGeometry decode_primitive(const GltfSource& source, const GltfDocument& document, GltfReader& reader,
                              const GltfPrimitive& primitive, std::string_view place) {
  AttributeSource attributes(source, document, reader, primitive, place);
  GltfGeometry geometry;
  read_vertices(attributes, geometry);
  read_influences(attributes, geometry);

  const size_t count = geometry.vertices.size();
  const bool indexed = attributes.is_draco() || primitive.indices >= 0;
  std::vector<uint32_t> indices = attributes.indices();
  if (!indexed) {
    indices.resize(count);
    std::iota(indices.begin(), indices.end(), 0u);
  }
  check_indices(source, indices, count, place);
  // Draco stores triangles whatever the mode says of its fallback.
  geometry.triangles =
      assemble(indices, attributes.is_draco() ? Mode::triangles : static_cast<Mode>(primitive.mode));

  for (const GltfAttributes& target : primitive.targets) {
    const auto read = [&](std::string_view name) {
      const int32_t accessor = find_attribute(target, name);
      auto values = accessor < 0 ? std::vector<float>() : reader.floats(static_cast<uint32_t>(accessor));
      if (values.size() != 3 * count) values.clear();
      return values;
    };
    geometry.targets.push_back({read("POSITION"), read("NORMAL"), read("TANGENT")});
  }
  return geometry;
}

void apply_morph(GltfGeometry& geometry, const std::vector<double>& weights) {
  for (size_t t = 0; t < std::min(weights.size(), geometry.targets.size()); ++t) {
    const float weight = static_cast<float>(weights[t]);
    if (weight == 0) continue;
    const auto& target = geometry.targets[t];
    const auto delta = [&](const std::vector<float>& values, size_t i) {
      return values.empty() ? Vec3(0) : weight * Vec3(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
    };
    for (size_t i = 0; i < geometry.vertices.size(); ++i) {
      Vertex& vertex = geometry.vertices[i];
      vertex.position += delta(target.position, i);
      vertex.normal += delta(target.normal, i);
      vertex.tangent += Vec4(delta(target.tangent, i), 0);
    }
  }
  for (Vertex& vertex : geometry.vertices) {
    vertex.normal = unit_or_zero(Vec3d(vertex.normal));
    vertex.tangent = Vec4(unit_or_zero(Vec3d(vertex.tangent)), vertex.tangent.w);
  }
}

void apply_skin(const GltfSource& source, GltfGeometry& geometry, const std::vector<glm::dmat4>& matrices,
                std::string_view place) {
  size_t mirrored = 0;
  const size_t n = geometry.influences;
  for (size_t v = 0; v < geometry.vertices.size(); ++v) {
    glm::dmat4 blend(0);
    double sum = 0;
    for (size_t k = v * n; k < (v + 1) * n; ++k) {
      if (geometry.weights[k] == 0) continue;
      if (geometry.joints[k] >= matrices.size()) {
        source.fail(
            place, "ACCESSOR_JOINTS_INDEX_OOB",
            fmt::format("vertex {} names joint {}, the skin has {}", v, geometry.joints[k], matrices.size()));
      }
      blend += static_cast<double>(geometry.weights[k]) * matrices[geometry.joints[k]];
      sum += geometry.weights[k];
    }
    if (sum > 0)
      blend /= sum;
    else if (!matrices.empty())
      blend = matrices[0];
    Vertex& vertex = geometry.vertices[v];
    const glm::dmat3 linear(blend);
    vertex.position = Vec3(blend * glm::dvec4(Vec3d(vertex.position), 1));
    vertex.normal = unit_or_zero(normal_matrix(linear) * Vec3d(vertex.normal));
    vertex.tangent = Vec4(unit_or_zero(linear * Vec3d(vertex.tangent)), vertex.tangent.w);
    if (glm::determinant(linear) < 0) ++mirrored;
  }
  if (2 * mirrored > geometry.vertices.size()) {
    for (UVec3& triangle : geometry.triangles) std::swap(triangle.y, triangle.z);
    for (Vertex& vertex : geometry.vertices) vertex.tangent.w = -vertex.tangent.w;
  }
}

void complete_geometry(GltfGeometry& geometry, const TextureUse* tangents_for) {
  if (!geometry.has_normals) {
    std::vector<Vertex> flat;
    flat.reserve(3 * geometry.triangles.size());
    for (UVec3& triangle : geometry.triangles) {
      const Vec3d a(geometry.vertices[triangle.x].position);
      const Vec3 normal = unit_or_zero(glm::cross(Vec3d(geometry.vertices[triangle.y].position) - a,
                                                  Vec3d(geometry.vertices[triangle.z].position) - a));
      for (int k = 0; k < 3; ++k) {
        Vertex vertex = geometry.vertices[triangle[k]];
        vertex.normal = normal;
        vertex.tangent = Vec4(0);
        triangle[k] = static_cast<uint32_t>(flat.size());
        flat.push_back(vertex);
      }
    }
    geometry.vertices = std::move(flat);
    geometry.has_normals = true;
    geometry.has_tangents = false;
  }
  if (tangents_for && !geometry.has_tangents)
    make_tangents(geometry.vertices, geometry.triangles, *tangents_for);
}

glm::dmat3 normal_matrix(const glm::dmat3& m) {
  const glm::dmat3 cofactor(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
  return glm::dot(m[0], cofactor[0]) < 0 ? -cofactor : cofactor;
}

Vec3 unit_or_zero(glm::dvec3 v) {
  const double scale = std::max(std::abs(v.x), std::max(std::abs(v.y), std::abs(v.z)));
  if (!(scale > 0) || !std::isfinite(scale)) return Vec3(0);
  v /= scale;
  const Vec3 unit(v / glm::length(v));
  return is_finite(unit) ? unit : Vec3(0);
}

}  // namespace halflight
