#include "lights/cut_counting.h"

#include <array>

#include "core/simd.h"

namespace halflight {

namespace {

constexpr size_t lanes = 16;

// Boxes are widened by this share of what bounds them, so that rounding loses no ray.
constexpr float slack = 4e-6f;

/// Bounds of a bundle's directions along one axis, as factors that bound distances to a slab from below and
/// above. Where the directions point both ways there is no bound: factors 0, and the far end is moved out of
/// the way.
struct AxisBounds {
  float low, high;  ///< of the directions
  float inverse_a, inverse_b;
  float mirror;  ///< −1 where all directions point to −axis
  float far_offset;
};

AxisBounds axis_bounds(const float* direction, uint32_t count) {
  AxisBounds bounds{infinity, -infinity, 0, 0, 1, 0};
  for (uint32_t i = 0; i < count; ++i) {
    bounds.low = std::min(bounds.low, direction[i]);
    bounds.high = std::max(bounds.high, direction[i]);
  }
  constexpr float least = 1e-6f;
  if (bounds.low > least || bounds.high < -least) {
    bounds.mirror = bounds.low > 0 ? 1.0f : -1.0f;
    bounds.inverse_a = 1 / std::abs(bounds.low), bounds.inverse_b = 1 / std::abs(bounds.high);
  } else {
    bounds.far_offset = 1e30f;
  }
  return bounds;
}

struct BundleBounds {
  AxisBounds axis[3];
  Vec3 x;
};

struct Slab {
  float near_distance, far_distance;
};

HALFLIGHT_INLINE Slab bundle_slab(float low, float high, float x, const AxisBounds& axis) {
  const float a = (low - x) * axis.mirror, b = (high - x) * axis.mirror;
  const float l = a < b ? a : b, h = a < b ? b : a;
  const float l_a = l * axis.inverse_a, l_b = l * axis.inverse_b, h_a = h * axis.inverse_a,
              h_b = h * axis.inverse_b;
  return {l_a < l_b ? l_a : l_b, (h_a > h_b ? h_a : h_b) + axis.far_offset};
}

HALFLIGHT_INLINE bool overlaps(float low, float high, const AxisBounds& axis) {
  return (low <= axis.high + slack) & (high >= axis.low - slack);
}

/// 1 where some ray of the bundle may meet the cluster's box (interval arithmetic: never 0 falsely).
HALFLIGHT_SIMD_CLONES void cull(const Cut& cut, const BundleBounds& bundle, const float* arriving,
                                size_t count, float* may_meet) {
  const float *low_x = cut.low_x.data(), *low_y = cut.low_y.data(), *low_z = cut.low_z.data();
  const float *high_x = cut.high_x.data(), *high_y = cut.high_y.data(), *high_z = cut.high_z.data();
  const float *local = cut.local.data(), *has_extent = cut.has_extent.data(), *radius = cut.radius.data();
  const AxisBounds ax = bundle.axis[0], ay = bundle.axis[1], az = bundle.axis[2];
  const Vec3 x = bundle.x;
#pragma GCC ivdep
  for (size_t k = 0; k < count; ++k) {
    const Slab sx = bundle_slab(low_x[k], high_x[k], x.x, ax), sy = bundle_slab(low_y[k], high_y[k], x.y, ay),
               sz = bundle_slab(low_z[k], high_z[k], x.z, az);
    const float near_xy = sx.near_distance > sy.near_distance ? sx.near_distance : sy.near_distance;
    const float near_distance = near_xy > sz.near_distance ? near_xy : sz.near_distance;
    const float far_xy = sx.far_distance < sy.far_distance ? sx.far_distance : sy.far_distance;
    const float far_distance = far_xy < sz.far_distance ? far_xy : sz.far_distance;
    const float meets_local =
        (far_distance > 0.0f) & (near_distance <= far_distance + slack * (far_distance + radius[k])) ? 1.0f
                                                                                                     : 0.0f;
    const float meets_distant = overlaps(low_x[k], high_x[k], ax) & overlaps(low_y[k], high_y[k], ay) &
                                        overlaps(low_z[k], high_z[k], az)
                                    ? 1.0f
                                    : 0.0f;
    const float light = (arriving[k] > 0.0f ? 1.0f : 0.0f) * has_extent[k];
    may_meet[k] = light * (local[k] > 0.0f ? meets_local : meets_distant);
  }
}

struct Box {
  Vec3 low, high;
  float least_distance;  ///< a box that is left before this far is the point's own surface
};

/// 1 where a ray from the origin meets the box (already relative to x), per ray of the padded bundle.
HALFLIGHT_INLINE float meets_box(const Box& box, float inverse_x, float inverse_y, float inverse_z) {
  const float ax = box.low.x * inverse_x, bx = box.high.x * inverse_x;
  const float ay = box.low.y * inverse_y, by = box.high.y * inverse_y;
  const float az = box.low.z * inverse_z, bz = box.high.z * inverse_z;
  const float nx = ax < bx ? ax : bx, ny = ay < by ? ay : by, nz = az < bz ? az : bz;
  const float fx = ax < bx ? bx : ax, fy = ay < by ? by : ay, fz = az < bz ? bz : az;
  const float nxy = nx > ny ? nx : ny, fxy = fx < fy ? fx : fy;
  const float near_distance = nxy > nz ? nxy : nz, far_distance = fxy < fz ? fxy : fz;
  return (far_distance > box.least_distance) & (near_distance <= far_distance * (1.0f + slack)) ? 1.0f : 0.0f;
}

HALFLIGHT_INLINE float holds_direction(const Box& box, float x, float y, float z) {
  return (x >= box.low.x) & (x <= box.high.x) & (y >= box.low.y) & (y <= box.high.y) & (z >= box.low.z) &
                 (z <= box.high.z)
             ? 1.0f
             : 0.0f;
}

struct PaddedBundle {
  alignas(64) float inverse_x[RayBundle::capacity], inverse_y[RayBundle::capacity],
      inverse_z[RayBundle::capacity];
  alignas(64) float weight[RayBundle::capacity];  ///< what the ray adds to a box; 0 in the padding
  alignas(64) float met[RayBundle::capacity];     ///< m
  size_t padded;
};

/// Adds to `met` of each ray how many of the boxes it meets: one box of places.
HALFLIGHT_SIMD_CLONES void count_local_box(PaddedBundle& bundle, const Box& box) {
  const float *x = bundle.inverse_x, *y = bundle.inverse_y, *z = bundle.inverse_z;
  float* met = bundle.met;
#pragma GCC ivdep
  for (size_t i = 0; i < bundle.padded; ++i) met[i] += meets_box(box, x[i], y[i], z[i]);
}

/// The same for one box of directions.
HALFLIGHT_SIMD_CLONES void count_distant_box(const RayBundle& rays, PaddedBundle& bundle, const Box& box) {
  const float *x = rays.x, *y = rays.y, *z = rays.z;
  float* met = bundle.met;
#pragma GCC ivdep
  for (size_t i = 0; i < bundle.padded; ++i) met[i] += holds_direction(box, x[i], y[i], z[i]);
}

float sum_of_lanes(const float* lane) {
  float total = 0;
  for (size_t l = 0; l < lanes; ++l) total += lane[l];
  return total;
}

/// Σ weight over the rays that meet the box, in one fixed order for every vector width.
HALFLIGHT_SIMD_CLONES float weigh_local_box(const PaddedBundle& bundle, const Box& box) {
  const float *x = bundle.inverse_x, *y = bundle.inverse_y, *z = bundle.inverse_z, *weight = bundle.weight;
  alignas(64) float sum[lanes] = {};
  for (size_t i = 0; i < bundle.padded; i += lanes)
    for (size_t l = 0; l < lanes; ++l) sum[l] += weight[i + l] * meets_box(box, x[i + l], y[i + l], z[i + l]);
  return sum_of_lanes(sum);
}

HALFLIGHT_SIMD_CLONES float weigh_distant_box(const RayBundle& rays, const PaddedBundle& bundle,
                                              const Box& box) {
  const float *x = rays.x, *y = rays.y, *z = rays.z, *weight = bundle.weight;
  alignas(64) float sum[lanes] = {};
  for (size_t i = 0; i < bundle.padded; i += lanes)
    for (size_t l = 0; l < lanes; ++l)
      sum[l] += weight[i + l] * holds_direction(box, x[i + l], y[i + l], z[i + l]);
  return sum_of_lanes(sum);
}

float safe_inverse(float d) { return 1 / (std::abs(d) > 1e-20f ? d : std::copysign(1e-20f, d)); }

/// Fills up to a multiple of the vector width with copies of the first ray that weigh nothing.
void pad(RayBundle& rays, PaddedBundle& bundle) {
  bundle.padded = (rays.size + lanes - 1) / lanes * lanes;
  for (size_t i = rays.size; i < bundle.padded; ++i)
    rays.x[i] = rays.x[0], rays.y[i] = rays.y[0], rays.z[i] = rays.z[0];
  for (size_t i = 0; i < bundle.padded; ++i) {
    bundle.inverse_x[i] = safe_inverse(rays.x[i]);
    bundle.inverse_y[i] = safe_inverse(rays.y[i]);
    bundle.inverse_z[i] = safe_inverse(rays.z[i]);
    bundle.weight[i] = i < rays.size ? 1.0f : 0.0f;
    bundle.met[i] = 0;
  }
}

Box candidate_box(const Cut& cut, uint32_t k, Vec3 x) {
  const Vec3 low(cut.low_x[k], cut.low_y[k], cut.low_z[k]), high(cut.high_x[k], cut.high_y[k], cut.high_z[k]);
  if (cut.local[k] == 0) return {low - slack, high + slack, 0};
  return {low - x, high - x, 1e-3f * cut.radius[k]};
}

/// Whether a cluster is a plate that x lies in: tilted, its box is deep, but a ray leaves it without meeting
/// anything but the point's own surface.
bool lies_in_plate(const Cut& cut, uint32_t k, Vec3 x) {
  constexpr float thin = 0.02f;  // of the radius
  if (cut.local[k] == 0 || cut.thickness[k] > thin * cut.radius[k]) return false;
  const Vec3 from_centre = x - Vec3(cut.centre_x[k], cut.centre_y[k], cut.centre_z[k]);
  const Vec3 normal(cut.normal_x[k], cut.normal_y[k], cut.normal_z[k]);
  const float most = cut.thickness[k] + slack * (cut.radius[k] + glm::length(from_centre));
  return normal != Vec3(0) && std::abs(glm::dot(normal, from_centre)) <= most * glm::length(normal);
}

}  // namespace

std::span<const ClusterCounter::Count> ClusterCounter::count(const Cut& cut, Vec3 x,
                                                             std::span<const float> arriving, RayBundle& rays,
                                                             CountRule rule) {
  counts_.clear();
  if (rays.size == 0) return counts_;
  may_meet_.resize(cut.padded_size());
  BundleBounds bounds{
      {axis_bounds(rays.x, rays.size), axis_bounds(rays.y, rays.size), axis_bounds(rays.z, rays.size)}, x};
  cull(cut, bounds, arriving.empty() ? cut.has_extent.data() : arriving.data(), cut.padded_size(),
       may_meet_.data());
  candidates_.clear();
  for (uint32_t k = 0; k < cut.size; ++k)
    if (may_meet_[k] > 0 && (rule == CountRule::whole || !lies_in_plate(cut, k, x))) candidates_.push_back(k);

  PaddedBundle bundle;
  pad(rays, bundle);
  if (rule == CountRule::shared) {
    for (const uint32_t k : candidates_) {
      if (cut.local[k] > 0)
        count_local_box(bundle, candidate_box(cut, k, x));
      else
        count_distant_box(rays, bundle, candidate_box(cut, k, x));
    }
    for (size_t i = 0; i < rays.size; ++i) bundle.weight[i] = bundle.met[i] > 0 ? 1 / bundle.met[i] : 0.0f;
  }
  for (const uint32_t k : candidates_) {
    const Box box = candidate_box(cut, k, x);
    const float hits = cut.local[k] > 0 ? weigh_local_box(bundle, box) : weigh_distant_box(rays, bundle, box);
    if (hits > 0) counts_.push_back({k, hits});
  }
  return counts_;
}

}  // namespace halflight
