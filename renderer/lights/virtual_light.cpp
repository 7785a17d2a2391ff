#include "lights/virtual_light.h"

namespace halflight {

namespace {

/// Bilinear look-up, clamped at the edges; uv in [0, 1]², v down from the top.
Vec3 picture_value(const ImageRgb& picture, Vec2 uv) {
  const Vec2 p = uv * Vec2(picture.width, picture.height) - 0.5f;
  const int x = static_cast<int>(std::floor(p.x)), y = static_cast<int>(std::floor(p.y));
  const float fx = p.x - static_cast<float>(x), fy = p.y - static_cast<float>(y);
  const auto texel = [&](int i, int j) {
    return picture.at(std::clamp(i, 0, picture.width - 1), std::clamp(j, 0, picture.height - 1));
  };
  const Vec3 top = glm::mix(texel(x, y), texel(x + 1, y), fx);
  const Vec3 bottom = glm::mix(texel(x, y + 1), texel(x + 1, y + 1), fx);
  return glm::mix(top, bottom, fy);
}

/// The slide over the square that holds the outer cone, seen from the light: right is direction × up.
Vec3 projected_picture(const PunctualLight& light, const Scene& scene, Vec3 travel) {
  if (light.picture < 0) return Vec3(1);
  const float depth = glm::dot(travel, light.direction);
  if (depth <= 0) return Vec3(0);
  const float scale = 1 / (depth * std::tan(std::min(light.outer_cone, 0.499f * pi)));
  const Vec3 right = glm::cross(light.direction, light.up);
  const Vec2 uv(0.5f + 0.5f * glm::dot(travel, right) * scale,
                0.5f - 0.5f * glm::dot(travel, light.up) * scale);
  if (!(uv.x >= 0 && uv.x <= 1 && uv.y >= 0 && uv.y <= 1)) return Vec3(0);
  return picture_value(scene.pictures[static_cast<size_t>(light.picture)], uv);
}

/// KHR_lights_punctual, "Inner and Outer Cone Angles": the squared ramp between the cones' cosines.
float cone_falloff(const PunctualLight& light, Vec3 travel) {
  const float cos_outer = std::cos(light.outer_cone), cos_inner = std::cos(light.inner_cone);
  const float scale = 1 / std::max(0.001f, cos_inner - cos_outer);
  const float ramp = std::clamp((glm::dot(travel, light.direction) - cos_outer) * scale, 0.0f, 1.0f);
  return ramp * ramp;
}

/// KHR_lights_punctual, "Range Property": 1 well inside the range, 0 at its end.
float range_window(float distance, float range) {
  if (!(range < infinity)) return 1;
  return std::clamp(1 - square(square(distance / range)), 0.0f, 1.0f);
}

LightConnection connect_area(const VirtualLight& light, Vec3 x, GeometryTerm term) {
  const Vec3 offset = light.position - x;
  const float distance2 = glm::dot(offset, offset);
  if (!(distance2 > 0)) return {light.normal, 0, Vec3(0)};
  const float distance = std::sqrt(distance2);
  const Vec3 wi = offset / distance;
  return {wi, distance,
          light.radiance * patch_solid_angle(light.measure, -glm::dot(light.normal, wi), distance2, term)};
}

}  // namespace

Vec3 punctual_intensity(const PunctualLight& light, const Scene& scene, Vec3 travel) {
  if (light.kind != PunctualKind::spot) return light.intensity;
  const float cone = cone_falloff(light, travel);
  if (cone <= 0) return Vec3(0);
  return light.intensity * cone * projected_picture(light, scene, travel);
}

LightConnection connect_punctual(const PunctualLight& light, const Scene& scene, Vec3 x) {
  if (light.kind == PunctualKind::directional) return {-light.direction, infinity, light.intensity};
  const Vec3 offset = light.position - x;
  const float distance2 = glm::dot(offset, offset);
  if (!(distance2 > 0)) return {-light.direction, 0, Vec3(0)};
  const float distance = std::sqrt(distance2);
  const Vec3 wi = offset / distance;
  const float window = range_window(distance, light.range);
  // A point next to the light keeps a finite value, whatever the unit of length.
  constexpr float largest = 1e37f;
  return {wi, distance,
          glm::min(punctual_intensity(light, scene, -wi) * (window / distance2), Vec3(largest))};
}

LightConnection connect(const VirtualLight& light, const Scene& scene, Vec3 x, GeometryTerm term) {
  switch (light.kind) {
    case LightKind::environment:
      return {light.position, infinity, light.radiance * light.measure};
    case LightKind::punctual:
      return connect_punctual(scene.lights[light.source], scene, x);
    case LightKind::emitter:
    case LightKind::surface:
      break;
  }
  return connect_area(light, x, term);
}

}  // namespace halflight
