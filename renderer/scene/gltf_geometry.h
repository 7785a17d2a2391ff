// One primitive's triangles in its own frame, and what bends them: morph targets and skins.
#pragma once

#include "scene/gltf_accessors.h"

namespace halflight {

struct GltfGeometry {
  std::vector<Vertex> vertices;
  std::vector<UVec3> triangles;
  bool has_normals = false, has_tangents = false;

  /// Displacements of one morph target, three numbers a vertex; empty where it has none.
  struct Target {
    std::vector<float> position, normal, tangent;
  };
  std::vector<Target> targets;

  size_t influences = 0;         ///< joints a vertex
  std::vector<uint32_t> joints;  ///< influences × vertices, indices into the skin's joints
  std::vector<float> weights;
};

/// What sort of primitive this is: only triangles are drawn.
bool draws_triangles(const GltfPrimitive&);

/// Throws ACCESSOR_INDEX_OOB where an index names no vertex.
void check_indices(const GltfSource&, const std::vector<uint32_t>& indices, size_t vertex_count,
                   std::string_view place);

/// Decodes a primitive. Throws where its data contradict themselves (ACCESSOR_INDEX_OOB).
GltfGeometry decode_primitive(const GltfSource&, const GltfDocument&, GltfReader&, const GltfPrimitive&,
                              std::string_view place);

/// Adds the weighted displacements of the morph targets.
void apply_morph(GltfGeometry&, const std::vector<double>& weights);

/// Moves vertices by their joints' matrices (joint's world matrix × inverse bind matrix); the result is in
/// world space. Throws ACCESSOR_JOINTS_INDEX_OOB.
void apply_skin(const GltfSource&, GltfGeometry&, const std::vector<glm::dmat4>& matrices,
                std::string_view place);

/// Makes flat normals where there are none (which takes the tangents away, glTF 2.0 §3.7.2.1), then tangents
/// for the lookups of `tangents_for` where that is given and there are none.
void complete_geometry(GltfGeometry&, const TextureUse* tangents_for);

/// Transforms normals under `m`: its cofactor matrix, turned so that fronts stay fronts under mirroring.
glm::dmat3 normal_matrix(const glm::dmat3& m);

/// Unit vector along v; zero where v has no direction.
Vec3 unit_or_zero(glm::dvec3 v);

}  // namespace halflight
