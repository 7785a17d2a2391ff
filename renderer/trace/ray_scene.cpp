#include "trace/ray_scene.h"

#include <atomic>
#include <cstddef>
#include <cstring>
#include <type_traits>
#include <vector>

#include "core/errors.h"
#include "core/parallel.h"
#include "trace/embree_api.h"

namespace halflight {

namespace {

static_assert(sizeof(ShadowRay) == sizeof(RTCRay) &&
              offsetof(ShadowRay, near_distance) == offsetof(RTCRay, tnear) &&
              offsetof(ShadowRay, direction_x) == offsetof(RTCRay, dir_x) &&
              offsetof(ShadowRay, time) == offsetof(RTCRay, time) &&
              offsetof(ShadowRay, far_distance) == offsetof(RTCRay, tfar) &&
              offsetof(ShadowRay, mask) == offsetof(RTCRay, mask) &&
              offsetof(ShadowRay, id) == offsetof(RTCRay, id) &&
              offsetof(ShadowRay, flags) == offsetof(RTCRay, flags));

static_assert(sizeof(ClosestRay) == sizeof(RTCRayHit) &&
              offsetof(ClosestRay, normal_x) == offsetof(RTCRayHit, hit) + offsetof(RTCHit, Ng_x) &&
              offsetof(ClosestRay, u) == offsetof(RTCRayHit, hit) + offsetof(RTCHit, u) &&
              offsetof(ClosestRay, primitive) == offsetof(RTCRayHit, hit) + offsetof(RTCHit, primID) &&
              offsetof(ClosestRay, geometry) == offsetof(RTCRayHit, hit) + offsetof(RTCHit, geomID) &&
              offsetof(ClosestRay, instance) == offsetof(RTCRayHit, hit) + offsetof(RTCHit, instID));

// Embree's own bound on what it multiplies without overflow (its assertions abort beyond it).
constexpr float largest_coordinate = 1.84e18f;

bool in_range(float v) { return std::abs(v) < largest_coordinate; }  // false for NaN

bool valid(const ShadowRay& ray) {
  // Bitwise, so that a batch is checked without branches.
  const bool place = bool(in_range(ray.origin_x) & in_range(ray.origin_y) & in_range(ray.origin_z));
  const bool way = bool(in_range(ray.direction_x) & in_range(ray.direction_y) & in_range(ray.direction_z));
  return bool(place & way & (ray.near_distance >= 0) & (ray.far_distance >= ray.near_distance));
}

/// Embree 3's ray streams sort rays by the signs of their directions, but put +1e-18 in the place of
/// components smaller than that: of a small negative one the two disagree, and the ray, with others of its
/// packet, passes through everything. So far below the last place of a unit vector a component is nothing.
float without_traces(float component) { return std::abs(component) < 1e-17f ? 0.0f : component; }

/// Makes a ray one that Embree takes; of an invalid one, which gives false, one that ends at once and counts
/// as blocked already.
bool make_traceable(ShadowRay& ray) {
  const bool good = valid(ray);
  ray.direction_x = without_traces(ray.direction_x);
  ray.direction_y = without_traces(ray.direction_y);
  ray.direction_z = without_traces(ray.direction_z);
  if (!good) {
    ray.origin_x = ray.origin_y = ray.origin_z = ray.near_distance = 0;
    ray.direction_x = ray.direction_y = 0, ray.direction_z = 1;
    ray.far_distance = -infinity;
  }
  return good;
}

/// Makes all of them so; returns how many were valid.
template <class Ray, class ShadowRayOf>
uint64_t make_all_traceable(std::span<Ray> rays, const ShadowRayOf& shadow_ray_of) {
  uint64_t good = 0;
  for (Ray& ray : rays) good += make_traceable(shadow_ray_of(ray));
  return good;
}

/// What the alpha filter needs about the geometry it is called for.
struct AlphaGeometry {
  const Scene* scene;
  std::vector<uint32_t> triangles;  ///< Embree's primitive id → the scene's triangle
};

/// Embree's ray context with our seed behind it.
#if RTC_VERSION_MAJOR >= 4
using EmbreeContext = RTCRayQueryContext;
void init_context(EmbreeContext& context) { rtcInitRayQueryContext(&context); }
#else
using EmbreeContext = RTCIntersectContext;
void init_context(EmbreeContext& context) { rtcInitIntersectContext(&context); }
#endif

struct SeededContext {
  explicit SeededContext(uint32_t seed) : alpha_seed(seed) { init_context(embree); }

  EmbreeContext embree;
  uint32_t alpha_seed;
  uint64_t alpha_tests = 0;
};

/// Lets rays through the parts of masked and blended triangles that do not block.
void alpha_filter(const RTCFilterFunctionNArguments* arguments) {
  const auto& geometry = *static_cast<const AlphaGeometry*>(arguments->geometryUserPtr);
  auto& context = *reinterpret_cast<SeededContext*>(arguments->context);
  const uint32_t seed = context.alpha_seed;
  for (unsigned i = 0; i < arguments->N; ++i) {
    if (arguments->valid[i] == 0) continue;
    ++context.alpha_tests;
    const SurfacePoint point{
        geometry.triangles[RTCHitN_primID(arguments->hit, arguments->N, i)],
        {RTCHitN_u(arguments->hit, arguments->N, i), RTCHitN_v(arguments->hit, arguments->N, i)}};
    if (!surface_blocks(*geometry.scene, point, seed)) arguments->valid[i] = 0;
  }
}

[[noreturn]] void throw_embree_error(RTCError code, const char* what) {
  throw Error(ExitCode::failure,
              fmt::format("ray tracing: {} failed{}", what,
                          code == RTC_ERROR_OUT_OF_MEMORY ? ": out of memory"
                                                          : fmt::format(" (Embree error {})", int(code))));
}

/// Ends a handle of Embree's, also where the constructor throws.
struct Release {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
template <class Handle>
using Owned = std::unique_ptr<std::remove_pointer_t<Handle>, Release>;

bool count_memory(void* counter, ssize_t bytes, bool) {
  static_cast<std::atomic<int64_t>*>(counter)->fetch_add(bytes, std::memory_order_relaxed);
  return true;
}

}  // namespace

struct RayScene::Impl {
  Impl(const Scene& scene_in, bool filter_all);
  void add_geometry(AlphaGeometry& geometry, bool is_filtered);

  const Scene& scene;
  std::atomic<int64_t> memory{0};
  Owned<RTCDevice> device;
  Owned<RTCScene> embree_scene;
  // Opaque triangles pay nothing for the filter: they are a geometry of their own.
  AlphaGeometry opaque, filtered;
};

RayScene::Impl::Impl(const Scene& scene_in, bool filter_all)
    : scene(scene_in), opaque{&scene_in, {}}, filtered{&scene_in, {}} {
  device.reset(rtcNewDevice(nullptr));
  if (!device) throw_embree_error(rtcGetDeviceError(nullptr), "starting Embree");
  rtcSetDeviceMemoryMonitorFunction(device.get(), count_memory, &memory);
  embree_scene.reset(rtcNewScene(device.get()));
  rtcSetSceneBuildQuality(embree_scene.get(), RTC_BUILD_QUALITY_MEDIUM);
  // Rays along an edge that triangles share must meet one of them.
  rtcSetSceneFlags(embree_scene.get(), RTC_SCENE_FLAG_ROBUST);
  opaque.triangles.reserve(scene.triangles.size());
  for (uint32_t i = 0; i < scene.triangles.size(); ++i) {
    const bool alpha =
        filter_all || scene.materials[scene.triangle_material[i]].alpha_mode != AlphaMode::opaque;
    (alpha ? filtered : opaque).triangles.push_back(i);
  }
  add_geometry(opaque, false);
  add_geometry(filtered, true);
  rtcCommitScene(embree_scene.get());
  const RTCError error = rtcGetDeviceError(device.get());
  if (error != RTC_ERROR_NONE) throw_embree_error(error, "building the acceleration structure");
}

void RayScene::Impl::add_geometry(AlphaGeometry& geometry, bool is_filtered) {
  if (geometry.triangles.empty()) return;
  const Owned<RTCGeometry> mesh(rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
  if (!mesh) throw_embree_error(rtcGetDeviceError(device.get()), "making a geometry");
  // Embree reads 16 bytes a vertex: the rest of a Vertex behind the position is its padding.
  static_assert(sizeof(Vertex) >= 16 && offsetof(Vertex, position) == 0);
  rtcSetSharedGeometryBuffer(mesh.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, scene.vertices.data(),
                             0, sizeof(Vertex), scene.vertices.size());
  auto* indices = static_cast<UVec3*>(rtcSetNewGeometryBuffer(
      mesh.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(UVec3), geometry.triangles.size()));
  if (!indices) throw_embree_error(rtcGetDeviceError(device.get()), "allocating indices");
  parallel_for(0, geometry.triangles.size(), 16384, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) indices[i] = scene.triangles[geometry.triangles[i]];
  });
  rtcSetGeometryUserData(mesh.get(), &geometry);
  if (is_filtered) {
    rtcSetGeometryIntersectFilterFunction(mesh.get(), alpha_filter);
    rtcSetGeometryOccludedFilterFunction(mesh.get(), alpha_filter);
  }
  rtcCommitGeometry(mesh.get());
  // Geometry 0 is opaque, 1 is filtered, whether or not there is the other.
  rtcAttachGeometryByID(embree_scene.get(), mesh.get(), is_filtered ? 1 : 0);
}

RayScene::RayScene(const Scene& scene, bool filter_all) : impl_(std::make_unique<Impl>(scene, filter_all)) {}
RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;

const Scene& RayScene::scene() const { return impl_->scene; }
size_t RayScene::alpha_bytes() const {
  return impl_->filtered.triangles.size() * (sizeof(uint32_t) + sizeof(UVec3));
}
size_t RayScene::memory_bytes() const { return static_cast<size_t>(std::max<int64_t>(impl_->memory, 0)); }

bool RayScene::intersect(Vec3 origin, Vec3 direction, float near_distance, float far_distance,
                         uint32_t alpha_seed, RayHit& hit, RayCounters& counters) const {
  ShadowRay gate{origin.x,    origin.y,    origin.z, near_distance, direction.x,
                 direction.y, direction.z, 0,        far_distance};
  if (!valid(gate)) {
    ++counters.rejected;
    return false;
  }
  ++counters.closest;
  RTCRayHit query;
  std::memcpy(&query.ray, &gate, sizeof gate);
  query.hit.geomID = query.hit.primID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  SeededContext context(alpha_seed);
#if RTC_VERSION_MAJOR >= 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &context.embree;
  rtcIntersect1(impl_->embree_scene.get(), &query, &arguments);
#else
  rtcIntersect1(impl_->embree_scene.get(), &context.embree, &query);
#endif
  counters.alpha_tests += context.alpha_tests;
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  const AlphaGeometry& geometry = query.hit.geomID == 0 ? impl_->opaque : impl_->filtered;
  hit.distance = query.ray.tfar;
  hit.point = {geometry.triangles[query.hit.primID], {query.hit.u, query.hit.v}};
  return true;
}

RayHit RayScene::hit_of(const ClosestRay& ray) const {
  const AlphaGeometry& geometry = ray.geometry == 0 ? impl_->opaque : impl_->filtered;
  return {ray.ray.far_distance, {geometry.triangles[ray.primitive], {ray.u, ray.v}}};
}

void RayScene::intersect(std::span<ClosestRay> rays, bool coherent, uint32_t alpha_seed,
                         RayCounters& counters) const {
  if (rays.empty()) return;
  const uint64_t good = make_all_traceable(rays, [](ClosestRay& ray) -> ShadowRay& { return ray.ray; });
  counters.rejected += rays.size() - good;
  counters.closest += good;
  SeededContext context(alpha_seed);
#if RTC_VERSION_MAJOR >= 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &context.embree;
  arguments.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
  for (ClosestRay& ray : rays)
    rtcIntersect1(impl_->embree_scene.get(), reinterpret_cast<RTCRayHit*>(&ray), &arguments);
#else
  context.embree.flags =
      coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  rtcIntersect1M(impl_->embree_scene.get(), &context.embree, reinterpret_cast<RTCRayHit*>(rays.data()),
                 static_cast<unsigned>(rays.size()), sizeof(ClosestRay));
#endif
  counters.alpha_tests += context.alpha_tests;
}

void RayScene::occluded(std::span<ShadowRay> rays, uint32_t alpha_seed, RayCounters& counters) const {
  if (rays.empty()) return;
  const uint64_t good = make_all_traceable(rays, [](ShadowRay& ray) -> ShadowRay& { return ray; });
  counters.rejected += rays.size() - good;
  counters.visibility += good;
  SeededContext context(alpha_seed);
#if RTC_VERSION_MAJOR >= 4
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.context = &context.embree;
  arguments.flags = RTC_RAY_QUERY_FLAG_INCOHERENT;
  constexpr size_t packet = 16;
  alignas(64) RTCRay16 lanes;
  alignas(64) int active[packet];
  for (size_t begin = 0; begin < rays.size(); begin += packet) {
    const size_t count = std::min(packet, rays.size() - begin);
    for (size_t i = 0; i < packet; ++i) {
      const ShadowRay& ray = rays[begin + std::min(i, count - 1)];
      active[i] = i < count ? -1 : 0;
      lanes.org_x[i] = ray.origin_x, lanes.org_y[i] = ray.origin_y, lanes.org_z[i] = ray.origin_z;
      lanes.dir_x[i] = ray.direction_x, lanes.dir_y[i] = ray.direction_y, lanes.dir_z[i] = ray.direction_z;
      lanes.tnear[i] = ray.near_distance, lanes.tfar[i] = ray.far_distance, lanes.time[i] = ray.time;
      lanes.mask[i] = ray.mask, lanes.id[i] = ray.id, lanes.flags[i] = ray.flags;
    }
    rtcOccluded16(active, impl_->embree_scene.get(), &lanes, &arguments);
    for (size_t i = 0; i < count; ++i) rays[begin + i].far_distance = lanes.tfar[i];
  }
#else
  context.embree.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  rtcOccluded1M(impl_->embree_scene.get(), &context.embree, reinterpret_cast<RTCRay*>(rays.data()),
                static_cast<unsigned>(rays.size()), sizeof(ShadowRay));
#endif
  counters.alpha_tests += context.alpha_tests;
}

}  // namespace halflight
