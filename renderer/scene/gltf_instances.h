// From posed nodes to the scene's triangles, cameras and lights in world space.
#pragma once

#include "scene/gltf_animation.h"

namespace halflight {

/// Flattens the meshes of the shown nodes into the scene; primitives that share their data are decoded once.
/// Fills Scene::facts' counts. Returns which of the file's materials are drawn; a default material is added
/// where a primitive has none.
std::vector<bool> import_meshes(GltfSource&, const GltfDocument&, GltfReader&, const GltfPose&, Scene&);

/// The environment that the scene's extras name.
void import_environment(const GltfSource&, const GltfDocument&, Scene&, Messages&);

/// Cameras and lights of the shown nodes; projectors' pictures are read here.
void import_cameras(GltfSource&, const GltfDocument&, const GltfPose&, Scene&);
void import_lights(GltfSource&, const GltfDocument&, const GltfPose&, Scene&, Messages&);

}  // namespace halflight
