// The parts of the built-in scene `car`. Metres; +x is ahead, +y up; the car is the same on both sides of z =
// 0.
#pragma once

#include <span>

#include "scene/implicit_mesh.h"

namespace halflight {

/// Materials of the car, as indices into the scene's.
struct CarMaterials {
  uint32_t paint, glass, chrome, tyre, rim, lamp, tail_lamp, dark;
};

inline constexpr float car_floor = 0.21f;  ///< height of the underside
inline constexpr float wheel_radius = 0.325f, arch_radius = 0.395f,
                       well_depth = 0.36f;                             ///< the well's |z| inside
inline constexpr Vec2 axles[2] = {{1.14f, 0.325f}, {-1.10f, 0.325f}};  ///< (x, y)
inline constexpr Vec3 lamp_middle{1.70f, 0.665f, 0.57f};               ///< of the headlamp for z > 0
inline constexpr Vec3 lamp_axis{0.955f, 0.28f, 0.09f};

/// Distance to the body's skin as it is before windows and wheel arches are cut.
float car_body_distance(Vec3 p);

/// Distance along a unit `direction` from a point inside the body to where `car_body_distance` is `offset`.
float reach(Vec3 from, Vec3 direction, float offset = 0);

/// Skin, windows with their trim, shut lines.
void add_car_body(Scene&, const CarMaterials&);
/// Tyres, rims, and the wells that they stand in.
void add_car_wheels(Scene&, const CarMaterials&);
/// Bumpers, lamps, handles, mirrors, badges.
void add_car_trim(Scene&, const CarMaterials&);

}  // namespace halflight
