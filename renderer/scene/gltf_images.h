// From a file's textures to Scene::images and Scene::textures.
#pragma once

#include "scene/gltf_accessors.h"

namespace halflight {

/// Decodes the images that `used` materials look up, in parallel, and turns every TextureUse::texture of
/// Scene::materials from the file's index into Scene's. An image used as colour and as data gets two
/// textures. What cannot be read becomes a placeholder (Messages::placeholder): the use is dropped, which is
/// white, or flat for normals.
void import_textures(const GltfSource&, const GltfDocument&, GltfReader&, const std::vector<bool>& used,
                     Scene&, Messages&);

}  // namespace halflight
