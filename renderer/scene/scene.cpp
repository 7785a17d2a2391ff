#include "scene/scene.h"

namespace halflight {

void update_bounds(Scene& scene) {
  scene.bounds = Aabb{};
  for (const UVec3& t : scene.triangles) {
    for (int corner = 0; corner < 3; ++corner) scene.bounds.extend(scene.vertices[t[corner]].position);
  }
}

}  // namespace halflight
