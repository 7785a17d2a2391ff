// Parts of the vaulted hall. Metres; the nave runs along −z from the camera's end to the altar at z = 0.
#pragma once

#include "scene/mesh_builder.h"

namespace halflight {

/// The scene being built and the materials its parts share.
struct Hall {
  Scene scene;
  uint32_t stone, vault, rib, pier, floor, oak, linen, brass, lead;
  uint32_t lancet_glass, rose_glass;
};

namespace hall {
inline constexpr int bays = 6;
inline constexpr float bay = 4.5f, length = bays * bay;
inline constexpr float nave = 3.6f;                          ///< half the width between the arcades' faces
inline constexpr float arcade_back = 4.4f;                   ///< x of the arcade wall's other face
inline constexpr float outer = 7.6f;                         ///< x of the aisles' outer walls
inline constexpr float arcade_spring = 5.0f;                 ///< heights: of the arcade's arches
inline constexpr float gallery = 9.0f, gallery_top = 11.2f;  ///< of the blind arcade over them
inline constexpr float vault_spring = 11.8f, vault_rise = 4.4f;
}  // namespace hall

/// Points of a pointed arch from (−half, 0) over (0, rise) to (half, 0): two arcs of 60°, stretched to
/// `rise`.
std::vector<Vec2> pointed_arch(float half, float rise, int steps);

/// A wall of `width` between heights `low` and `high` with pointed openings, evenly spread, that start at
/// `low`, go up straight to `spring` and close `rise` above: an outline for `extrude_mesh`.
struct ArcadeShape {
  float width, low, high;
  int openings;
  float half, spring, rise;
};
std::vector<Vec2> arcade_outline(const ArcadeShape&, int steps);

/// Texture coordinates that fit the figure of `lancet_slide` to a `rectangle_mesh`.
void set_lancet_uv(Mesh& pane);

void add_bays(Hall&);
void add_vaults(Hall&);
void add_ends(Hall&);
void add_pews(Hall&);
void add_sanctuary(Hall&);

}  // namespace halflight
