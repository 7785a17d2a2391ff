#include "scene/gltf_instances.h"

#include <map>
#include <memory>
#include <set>

#include "core/parallel.h"
#include "scene/gltf_geometry.h"

namespace halflight {

namespace {

constexpr size_t grain = 8192;  // vertices or triangles a piece of a parallel loop

/// One primitive at one node, ready to be copied into the scene.
struct Instance {
  std::shared_ptr<const GltfGeometry> geometry;
  glm::dmat4 to_world{1};
  uint32_t material = 0;
  size_t first_vertex = 0, first_triangle = 0;
};

/// No volume is left of what lies under such a matrix, or it is not finite.
bool is_singular(const glm::dmat4& m) {
  const glm::dmat3 linear(m);
  const double volume = std::abs(glm::determinant(linear));
  const double box = glm::length(linear[0]) * glm::length(linear[1]) * glm::length(linear[2]);
  return !(volume > 1e-12 * box) || !std::isfinite(volume) || !is_finite(Vec3(m[3]));
}

/// Lookups that need tangents; null where none does.
const TextureUse* tangent_lookup(const Material& material) {
  if (material.normal_texture.used()) return &material.normal_texture;
  if (material.anisotropy == 0) return nullptr;
  return material.anisotropy_texture.used() ? &material.anisotropy_texture : &material.base_color_texture;
}

/// Collects the instances of a scene.
class MeshImporter {
 public:
  MeshImporter(GltfSource& source, const GltfDocument& document, GltfReader& reader, const GltfPose& pose,
               Scene& scene)
      : source_(source),
        document_(document),
        reader_(reader),
        pose_(pose),
        scene_(scene),
        used_(document.materials.size(), false) {}

  void add_node(uint32_t index) {
    const GltfNode& node = document_.nodes[index];
    if (node.mesh < 0) return;
    const auto& primitives = document_.meshes[node.mesh].primitives;
    const bool skinned = node.skin >= 0;
    const bool singular = !skinned && is_singular(pose_.world[index]);
    for (size_t p = 0; p < primitives.size(); ++p) {
      const std::string place = fmt::format("meshes[{}].primitives[{}]", node.mesh, p);
      if (!draws_triangles(primitives[p])) {
        skip_primitive(primitives[p], place);
      } else if (!has_data(primitives[p])) {
        ++scene_.facts.skipped_primitives;
        source_.warn(place, "UNDEFINED_PROPERTY", "its buffer has neither 'uri' nor data; it is skipped");
      } else if (singular) {
        ++scene_.facts.skipped_primitives;
        source_.warn(fmt::format("nodes[{}]", index), "NODE_MATRIX_SINGULAR",
                     "its matrix is singular or not finite; what hangs on it is skipped");
      } else {
        add_primitive(index, primitives[p], place);
      }
    }
  }

  std::vector<Instance> take_instances() { return std::move(instances_); }
  std::vector<bool> take_used() { return std::move(used_); }

 private:
  void skip_primitive(const GltfPrimitive& primitive, const std::string& place) {
    ++scene_.facts.skipped_primitives;
    if (find_attribute(primitive.attributes, "POSITION") < 0) {
      source_.warn(place, "MESH_PRIMITIVE_NO_POSITION", "has no POSITION and is skipped");
    } else {
      source_.warn(place, "MESH_PRIMITIVE_MODE", "points and lines are skipped");
    }
  }

  bool has_data(const GltfPrimitive& primitive) const {
    const auto all_have = [&](const GltfAttributes& attributes) {
      return std::all_of(attributes.begin(), attributes.end(), [&](const GltfAttribute& attribute) {
        return reader_.has_data(attribute.accessor);
      });
    };
    if (primitive.indices >= 0 && !reader_.has_data(static_cast<uint32_t>(primitive.indices))) return false;
    return all_have(primitive.attributes) &&
           std::all_of(primitive.targets.begin(), primitive.targets.end(), all_have);
  }

  uint32_t material_of(const GltfPrimitive& primitive) {
    if (primitive.material >= 0) {
      used_[primitive.material] = true;
      return static_cast<uint32_t>(primitive.material);
    }
    // glTF 2.0 §3.9.4: the default material.
    if (scene_.materials.size() == document_.materials.size()) scene_.materials.emplace_back();
    return static_cast<uint32_t>(document_.materials.size());
  }

  /// Whatever makes two primitives the same triangles.
  std::string key_of(const GltfPrimitive& primitive, const TextureUse* tangents) const {
    std::string key = fmt::format("{} {}", primitive.mode, primitive.indices);
    for (const auto& [name, accessor] : primitive.attributes) key += fmt::format(" {}={}", name, accessor);
    for (const GltfAttributes& target : primitive.targets) {
      key += " |";
      for (const auto& [name, accessor] : target) key += fmt::format(" {}={}", name, accessor);
    }
    if (primitive.draco) {
      key += fmt::format(" draco {}", primitive.draco->view);
      for (const auto& [name, id] : primitive.draco->attributes) key += fmt::format(" {}={}", name, id);
    }
    if (tangents) {
      const Vec3 u = tangents->row_u, v = tangents->row_v;
      key += fmt::format(" t{} {} {} {} {} {} {}", tangents->uv_set, u.x, u.y, u.z, v.x, v.y, v.z);
    }
    return key;
  }

  std::vector<glm::dmat4> joint_matrices(const GltfSkin& skin) {
    std::vector<float> bind;
    const int32_t accessor = skin.inverse_bind_matrices;
    if (accessor >= 0 && reader_.has_data(static_cast<uint32_t>(accessor))) {
      bind = reader_.floats(static_cast<uint32_t>(accessor));
    }
    std::vector<glm::dmat4> matrices;
    for (size_t j = 0; j < skin.joints.size(); ++j) {
      glm::dmat4 inverse(1);
      for (size_t i = 0; i < 16 && !bind.empty(); ++i)
        inverse[static_cast<int>(i / 4)][static_cast<int>(i % 4)] = bind[16 * j + i];
      matrices.push_back(pose_.world[skin.joints[j]] * inverse);
    }
    return matrices;
  }

  void add_primitive(uint32_t node_index, const GltfPrimitive& primitive, const std::string& place) {
    const GltfNode& node = document_.nodes[node_index];
    Instance instance;
    instance.material = material_of(primitive);
    instance.to_world = pose_.world[node_index];
    const TextureUse* tangents = tangent_lookup(scene_.materials[instance.material]);

    const auto& weights = pose_.weights[node_index];
    const bool morphed = !primitive.targets.empty() &&
                         std::any_of(weights.begin(), weights.end(), [](double w) { return w != 0; });
    const bool skinned = node.skin >= 0 && find_attribute(primitive.attributes, "JOINTS_0") >= 0 &&
                         find_attribute(primitive.attributes, "WEIGHTS_0") >= 0;
    if (!morphed && !skinned) {
      auto& cached = cache_[key_of(primitive, tangents)];
      if (!cached) {
        GltfGeometry geometry = decode_primitive(source_, document_, reader_, primitive, place);
        complete_geometry(geometry, tangents);
        cached = std::make_shared<const GltfGeometry>(std::move(geometry));
      }
      instance.geometry = cached;
    } else {
      GltfGeometry geometry = decode_primitive(source_, document_, reader_, primitive, place);
      if (morphed) apply_morph(geometry, weights);
      if (skinned) {
        apply_skin(source_, geometry, joint_matrices(document_.skins[node.skin]), place);
        instance.to_world = glm::dmat4(1);
      }
      complete_geometry(geometry, tangents);
      instance.geometry = std::make_shared<const GltfGeometry>(std::move(geometry));
    }
    count(instance, place);
    instances_.push_back(std::move(instance));
  }

  void count(Instance& instance, const std::string& place) {
    instance.first_vertex = vertices_;
    instance.first_triangle = triangles_;
    vertices_ += instance.geometry->vertices.size();
    triangles_ += instance.geometry->triangles.size();
    const uint64_t limit = source_.options->limits.triangles;
    if (triangles_ > limit) {
      source_.fail(place, "LIMIT", fmt::format("more than {} triangles (--limit-triangles)", limit));
    }
    if (vertices_ > std::numeric_limits<uint32_t>::max())
      source_.fail(place, "LIMIT", "more than 2^32 vertices");
  }

  GltfSource& source_;
  const GltfDocument& document_;
  GltfReader& reader_;
  const GltfPose& pose_;
  Scene& scene_;
  std::vector<bool> used_;
  std::map<std::string, std::shared_ptr<const GltfGeometry>> cache_;
  std::vector<Instance> instances_;
  size_t vertices_ = 0, triangles_ = 0;
};

/// Copies an instance to its place, in world space. Mirroring turns the winding round, so that fronts stay
/// fronts.
void place_instance(const Instance& instance, Scene& scene) {
  const GltfGeometry& geometry = *instance.geometry;
  const glm::dmat3 linear(instance.to_world);
  const glm::dmat3 normals = normal_matrix(linear);
  const bool mirrored = glm::determinant(linear) < 0;
  parallel_for(0, geometry.vertices.size(), grain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      Vertex vertex = geometry.vertices[i];
      vertex.position = Vec3(instance.to_world * glm::dvec4(Vec3d(vertex.position), 1));
      vertex.normal = unit_or_zero(normals * Vec3d(vertex.normal));
      vertex.tangent = Vec4(unit_or_zero(linear * Vec3d(Vec3(vertex.tangent))),
                            mirrored ? -vertex.tangent.w : vertex.tangent.w);
      scene.vertices[instance.first_vertex + i] = vertex;
    }
  });
  parallel_for(0, geometry.triangles.size(), grain, [&](size_t begin, size_t end) {
    for (size_t t = begin; t < end; ++t) {
      UVec3 triangle = geometry.triangles[t] + static_cast<uint32_t>(instance.first_vertex);
      if (mirrored) std::swap(triangle.y, triangle.z);
      scene.triangles[instance.first_triangle + t] = triangle;
      scene.triangle_material[instance.first_triangle + t] = instance.material;
    }
  });
}

/// Finite, and small enough that squared distances are too.
bool is_usable(Vec3 p) { return max_component(glm::abs(p)) <= 1e15f && is_finite(p); }

Vec3d cross_of(const Scene& scene, UVec3 t) {
  const Vec3d a(scene.vertices[t.x].position);
  return glm::cross(Vec3d(scene.vertices[t.y].position) - a, Vec3d(scene.vertices[t.z].position) - a);
}

/// What `drop_unusable` has to do about a triangle.
enum class Fate : uint8_t { keep, mend_normals, drop };

Fate fate_of(const Scene& scene, UVec3 t) {
  const Vertex &a = scene.vertices[t.x], &b = scene.vertices[t.y], &c = scene.vertices[t.z];
  if (!is_usable(a.position) || !is_usable(b.position) || !is_usable(c.position)) return Fate::drop;
  if (cross_of(scene, t) == Vec3d(0)) return Fate::drop;
  const bool complete = a.normal != Vec3(0) && b.normal != Vec3(0) && c.normal != Vec3(0);
  return complete ? Fate::keep : Fate::mend_normals;
}

/// Drops triangles without area or with unusable positions, and mends normals that are missing: the first
/// triangle of a vertex gives its own.
size_t drop_unusable(Scene& scene) {
  const size_t count = scene.triangles.size();
  std::vector<Fate> fates(count);
  parallel_for(0, count, grain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) fates[i] = fate_of(scene, scene.triangles[i]);
  });
  size_t kept = 0;
  for (size_t i = 0; i < count; ++i) {
    if (fates[i] == Fate::drop) continue;
    const UVec3 t = scene.triangles[i];
    for (int corner = 0; fates[i] == Fate::mend_normals && corner < 3; ++corner) {
      Vertex& vertex = scene.vertices[t[corner]];
      if (vertex.normal == Vec3(0)) vertex.normal = unit_or_zero(cross_of(scene, t));
    }
    if (kept != i) {
      scene.triangles[kept] = t;
      scene.triangle_material[kept] = scene.triangle_material[i];
    }
    ++kept;
  }
  scene.triangles.resize(kept);
  scene.triangle_material.resize(kept);
  parallel_for(0, scene.vertices.size(), grain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      Vertex& vertex = scene.vertices[i];
      if (!is_usable(vertex.position)) vertex.position = Vec3(0);
      if (vertex.normal == Vec3(0)) vertex.normal = Vec3(0, 1, 0);
      if (Vec3(vertex.tangent) == Vec3(0)) vertex.tangent = Vec4(0);
    }
  });
  return count - kept;
}

/// What is not shown has not been decoded; its index values are tested all the same, as those of sparse
/// accessors.
void check_hidden_values(const GltfSource& source, const GltfDocument& document, GltfReader& reader,
                         const GltfPose& pose) {
  for (uint32_t i = 0; i < document.accessors.size(); ++i) {
    if (document.accessors[i].sparse && reader.has_data(i)) reader.check_sparse_indices(i);
  }
  std::set<std::pair<int32_t, uint64_t>> checked;  // many primitives may share one accessor
  std::vector<bool> shown(document.meshes.size(), false);
  for (const uint32_t node : pose.shown) {
    if (document.nodes[node].mesh >= 0) shown[document.nodes[node].mesh] = true;
  }
  for (size_t m = 0; m < document.meshes.size(); ++m) {
    const auto& primitives = document.meshes[m].primitives;
    for (size_t p = 0; p < primitives.size() && !shown[m]; ++p) {
      const int32_t indices = primitives[p].indices,
                    positions = find_attribute(primitives[p].attributes, "POSITION");
      if (indices < 0 || positions < 0 || primitives[p].draco) continue;
      if (!reader.has_data(static_cast<uint32_t>(indices))) continue;
      if (!checked.insert({indices, document.accessors[positions].count}).second) continue;
      check_indices(source, reader.integers(static_cast<uint32_t>(indices)),
                    document.accessors[positions].count, fmt::format("meshes[{}].primitives[{}]", m, p));
    }
  }
}

}  // namespace

std::vector<bool> import_meshes(GltfSource& source, const GltfDocument& document, GltfReader& reader,
                                const GltfPose& pose, Scene& scene) {
  check_hidden_values(source, document, reader, pose);
  scene.materials = document.materials;
  MeshImporter importer(source, document, reader, pose, scene);
  for (const uint32_t node : pose.shown) importer.add_node(node);

  const std::vector<Instance> instances = importer.take_instances();
  if (!instances.empty()) {
    const Instance& last = instances.back();
    scene.vertices.resize(last.first_vertex + last.geometry->vertices.size());
    scene.triangles.resize(last.first_triangle + last.geometry->triangles.size());
    scene.triangle_material.resize(scene.triangles.size());
  }
  parallel_for(0, instances.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) place_instance(instances[i], scene);
  });
  if (const size_t dropped = drop_unusable(scene)) {
    scene.facts.skipped_triangles += dropped;
    source.warn("", "ACCESSOR_INDEX_TRIANGLE_DEGENERATE",
                fmt::format("{} triangles without area or with unusable positions were skipped", dropped));
  }
  if (scene.triangles.empty()) source.warn("", "SCENE_EMPTY", "there is nothing to draw");
  return importer.take_used();
}

}  // namespace halflight
