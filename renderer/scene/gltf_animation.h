// Where every node is at one moment: animations, then the node hierarchy.
#pragma once

#include "scene/gltf_accessors.h"

namespace halflight {

struct GltfPose {
  std::vector<glm::dmat4> world;             ///< by node: its frame to the world
  std::vector<uint32_t> shown;               ///< nodes of the shown scene, parents first
  std::vector<std::vector<double>> weights;  ///< by node: morph weights, its own or its mesh's
};

/// The pose at `seconds`, clamped to each animation's range. Where several animations move one property, the
/// first does.
GltfPose pose_nodes(GltfSource&, const GltfDocument&, GltfReader&, double seconds);

/// One animation sampler's keys: `width` numbers a key (three times that with CUBICSPLINE: in-tangent, value,
/// out-tangent).
struct GltfKeys {
  std::vector<float> times, values;
  size_t width = 0;
  GltfInterpolation interpolation = GltfInterpolation::linear;
  bool rotation = false;  ///< quaternions: spherical, and unit
};

/// glTF 2.0 appendix C. Times must increase; before the first and after the last key the value stays.
std::vector<double> evaluate(const GltfKeys&, double seconds);

}  // namespace halflight
