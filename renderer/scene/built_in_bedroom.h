// Parts of the bedroom scene. Metres; the headboard stands at the wall z = 0, the window in the wall x = 0.
#pragma once

#include <array>

#include "scene/mesh_builder.h"

namespace halflight {

/// The scene being furnished and the materials its parts share.
struct Bedroom {
  Scene scene;
  uint32_t wall, feature_wall, trim, floor, dark_wood, light_wood, brass, steel, black, enamel;
  uint32_t linen, duvet, upholstery, throw_wool, cushion, curtain, rug, paper;
  std::array<uint32_t, 8> book_covers;
  uint32_t ceramic_white, ceramic_blue, terracotta, leaf, glass;
};

inline constexpr Vec3 room_size{5.0f, 2.6f, 4.4f};
inline constexpr float bed_centre = 2.4f;                  ///< x of the bed's middle
inline constexpr Vec3 lamp_position{0.72f, 1.42f, 0.80f};  ///< of the light itself

void add_bedroom_materials(Bedroom&);
void add_room(Bedroom&);
void add_bed(Bedroom&);
void add_curtains(Bedroom&);
void add_rug(Bedroom&);
void add_bedside(Bedroom&);
void add_lamp(Bedroom&);
void add_wardrobe(Bedroom&);
void add_desk(Bedroom&);
void add_bookcase(Bedroom&);
void add_decoration(Bedroom&);
/// Things on the tables, the desk and the bed.
void add_tableware(Bedroom&);

/// A row of upright books along +x from the origin, backs towards +z; returns its length.
float add_books(Bedroom&, int count, const Mat4& transform, uint32_t seed);

}  // namespace halflight
