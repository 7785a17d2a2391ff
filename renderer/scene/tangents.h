// Tangent frames for normal maps where a file brings none.
#pragma once

#include <vector>

#include "scene/scene.h"

namespace halflight {

/// Sets every vertex's tangent from the texture coordinates that `use` looks up, after its transform. In the
/// manner of MikkTSpace (Mikkelsen 2008): each face's ∂p/∂u is projected onto the vertex's tangent plane and
/// averaged with the corner's angle as weight; faces whose mapping is mirrored do not share vertices with
/// those whose is not, for which vertices are duplicated. w is glTF's: bitangent = w · normal × tangent
/// points up in the picture (against v). Vertices without a usable mapping keep w = 0.
void make_tangents(std::vector<Vertex>&, std::vector<UVec3>& triangles, const TextureUse& use);

}  // namespace halflight
