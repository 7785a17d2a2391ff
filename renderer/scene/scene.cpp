#include "scene/scene.h"

#include <mutex>

#include "core/parallel.h"

namespace halflight {

void update_bounds(Scene& scene) {
  scene.bounds = Aabb{};
  std::mutex mutex;
  parallel_for(0, scene.triangles.size(), 16384, [&](size_t begin, size_t end) {
    Aabb box;
    for (size_t i = begin; i < end; ++i)
      for (int corner = 0; corner < 3; ++corner)
        box.extend(scene.vertices[scene.triangles[i][corner]].position);
    const std::lock_guard lock(mutex);
    scene.bounds.extend(box);
  });
}

}  // namespace halflight
