#include "techniques/path_lights.h"

#include <numeric>

#include "core/warp.h"

namespace halflight {

namespace {

constexpr double pi_d = 3.14159265358979323846;

/// Index i with sums[i] ≤ u · total < sums[i + 1], out of `count` steps of running sums that begin with 0;
/// steps of no width are never taken.
size_t find_step(const double* sums, size_t count, double u) {
  const double wanted = u * sums[count];
  const double* const above = std::upper_bound(sums + 1, sums + count, wanted);
  return static_cast<size_t>(above - sums) - 1;
}

/// Cosine of the polar angle at the top of a row.
double row_cosine(int y, int height) { return std::cos(pi_d * y / height); }

}  // namespace

// ---- Environment ----

PathEnvironment::PathEnvironment(const Environment& environment) : environment_(environment) {
  if (!environment.present() || !(environment.strength > 0)) return;
  const int width = environment.map.width, height = environment.map.height;
  rows_.assign(1, 0.0);
  columns_.reserve(static_cast<size_t>(height) * (width + 1));
  for (int y = 0; y < height; ++y) {
    double row = 0;
    columns_.push_back(0);
    for (int x = 0; x < width; ++x) columns_.push_back(row += texel_luminance(x, y));
    const double texel = 2 * pi_d / width * (row_cosine(y, height) - row_cosine(y + 1, height));
    rows_.push_back(rows_.back() + row * texel);
  }
  total_ = rows_.back();
}

PathLightSample PathEnvironment::sample(RandomStream& random) const {
  const int width = environment_.map.width, height = environment_.map.height;
  const int y = static_cast<int>(find_step(rows_.data(), height, uniform_number(random)));
  const int x = static_cast<int>(
      find_step(&columns_[static_cast<size_t>(y) * (width + 1)], width, uniform_number(random)));
  // Even over the texel's solid angle: evenly in azimuth and in the cosine of the polar angle.
  const double top = row_cosine(y, height), low = row_cosine(y + 1, height);
  const double u = (x + uniform_number(random)) / width;
  const double cosine = top + (low - top) * uniform_number(random);
  const double v = std::acos(std::clamp(cosine, -1.0, 1.0)) / pi_d;
  const Vec3 wi = environment_direction(environment_, {static_cast<float>(u), static_cast<float>(v)});
  const Vec3d radiance = Vec3d(environment_.map.at(x, y)) * static_cast<double>(environment_.strength);
  return {wi, infinity, radiance, texel_luminance(x, y) / total_};
}

double PathEnvironment::pdf(Vec3 wi) const {
  if (empty()) return 0;
  const ImageRgb& map = environment_.map;
  const Vec2 uv = environment_uv(environment_, wi);
  const int x = std::min(static_cast<int>(uv.x * static_cast<float>(map.width)), map.width - 1);
  const int y = std::min(static_cast<int>(uv.y * static_cast<float>(map.height)), map.height - 1);
  return texel_luminance(x, y) / total_;
}

// ---- Emitters ----

TriangleShape triangle_shape(const Scene& scene, uint32_t triangle) {
  const UVec3 t = scene.triangles[triangle];
  const Vec3d a(scene.vertices[t.x].position), b(scene.vertices[t.y].position),
      c(scene.vertices[t.z].position);
  const Vec3d cross = glm::cross(b - a, c - a);
  const double length = glm::length(cross);
  return length > 0 ? TriangleShape{cross / length, 0.5 * length} : TriangleShape{Vec3d(0), 0};
}

PathEmitters::PathEmitters(const Scene& scene) : scene_(scene) {
  std::vector<double> areas;
  for (uint32_t i = 0; i < scene.triangles.size(); ++i) {
    const Material& material = scene.materials[scene.triangle_material[i]];
    const double area = triangle_shape(scene, i).area;
    if (material.unlit || !material.emissive() || !(area > 0)) continue;
    // Textures and coverage only take away from this.
    const double weight = area * max_component(material.emission);
    if (triangles_.empty()) sums_.push_back(0);
    triangles_.push_back(i), areas.push_back(area);
    sums_.push_back(sums_.back() + weight);
  }
  if (empty()) return;
  densities_.assign(scene.triangles.size(), 0.0);
  for (size_t i = 0; i < triangles_.size(); ++i)
    densities_[triangles_[i]] = (sums_[i + 1] - sums_[i]) / (sums_.back() * areas[i]);
}

std::optional<PathLightSample> PathEmitters::sample(Vec3 x, RandomStream& random) const {
  const uint32_t triangle = triangles_[find_step(sums_.data(), triangles_.size(), uniform_number(random))];
  const SurfacePoint point{triangle, uniform_triangle(random.next2())};
  const Vec3 y = surface_position(scene_, point);
  const Vec3d offset = Vec3d(y) - Vec3d(x);
  const double distance = glm::length(offset), density = pdf(triangle, x, y);
  if (!(distance > 0) || !(density > 0) || !std::isfinite(density)) return std::nullopt;
  const int side = glm::dot(triangle_shape(scene_, triangle).normal, offset) < 0 ? 1 : -1;
  const Vec3 radiance = surface_emission(scene_, point, side) * surface_alpha(scene_, point);
  return PathLightSample{Vec3(offset / distance), static_cast<float>(distance), Vec3d(radiance), density};
}

double PathEmitters::pdf(uint32_t triangle, Vec3 x, Vec3 y) const {
  if (empty() || !(densities_[triangle] > 0)) return 0;
  // Per area to per solid angle: r²/|cos θ'|.
  const Vec3d offset = Vec3d(y) - Vec3d(x);
  const double distance2 = glm::dot(offset, offset);
  if (!(distance2 > 0)) return 0;
  const double along_normal = std::abs(glm::dot(triangle_shape(scene_, triangle).normal, offset));
  return densities_[triangle] * distance2 * std::sqrt(distance2) / along_normal;
}

// ---- Punctual lights ----

namespace {

/// The slide of a projector at a unit direction of travel: it fills the square about the outer cone, its top
/// towards `up` and its right towards direction × up; bilinear between texel centres, black outside.
Vec3d slide_value(const Scene& scene, const PunctualLight& light, Vec3d travel) {
  const double depth = glm::dot(travel, Vec3d(light.direction));
  if (!(depth > 0)) return Vec3d(0);
  const double half_side = depth * std::tan(std::min(static_cast<double>(light.outer_cone), 0.499 * pi_d));
  const Vec3d up(light.up), right = glm::cross(Vec3d(light.direction), up);
  const double across = glm::dot(travel, right) / half_side, above = glm::dot(travel, up) / half_side;
  if (!(std::abs(across) <= 1 && std::abs(above) <= 1)) return Vec3d(0);
  const ImageRgb& slide = scene.pictures[static_cast<size_t>(light.picture)];
  const double x = (1 + across) / 2 * slide.width - 0.5, y = (1 - above) / 2 * slide.height - 0.5;
  Vec3d sum(0);
  for (const int j : {0, 1})
    for (const int i : {0, 1}) {
      const double column = std::floor(x) + i, row = std::floor(y) + j;
      const double share = (1 - std::abs(x - column)) * (1 - std::abs(y - row));
      sum += share * Vec3d(slide.at(std::clamp(static_cast<int>(column), 0, slide.width - 1),
                                    std::clamp(static_cast<int>(row), 0, slide.height - 1)));
    }
  return sum;
}

/// Share of a spot's intensity along a unit direction of travel. KHR_lights_punctual, "Inner and Outer Cone
/// Angles".
double spot_share(const PunctualLight& light, Vec3d travel) {
  const double outer = std::cos(static_cast<double>(light.outer_cone)),
               inner = std::cos(static_cast<double>(light.inner_cone));
  const double cosine = glm::dot(travel, Vec3d(light.direction));
  const double ramp = std::clamp((cosine - outer) / std::max(0.001, inner - outer), 0.0, 1.0);
  return ramp * ramp;
}

/// KHR_lights_punctual, "Range Property".
double range_share(const PunctualLight& light, double distance) {
  if (!std::isfinite(light.range)) return 1;
  return std::clamp(1 - std::pow(distance / light.range, 4), 0.0, 1.0);
}

/// Watts of a light, as if it shone evenly on all that its cone or the scene's disc hold.
double rough_power(const Scene& scene, const PunctualLight& light) {
  const double intensity = max_component(light.intensity);
  if (light.kind == PunctualKind::directional)
    return intensity * pi_d * std::pow(0.5 * scene.bounds.diagonal(), 2);
  const bool spot = light.kind == PunctualKind::spot;
  return intensity * 2 * pi_d * (spot ? 1 - std::cos(static_cast<double>(light.outer_cone)) : 2.0);
}

}  // namespace

PathPunctual punctual_towards(const Scene& scene, const PunctualLight& light, Vec3 x) {
  const Vec3d intensity(light.intensity);
  if (light.kind == PunctualKind::directional) return {-light.direction, infinity, intensity};
  const Vec3d offset = Vec3d(light.position) - Vec3d(x);
  const double distance = glm::length(offset);
  if (!(distance > 0)) return {-light.direction, 0, Vec3d(0)};
  const Vec3d wi = offset / distance;
  // A point next to the light keeps a value that fits a float, whatever the unit of length.
  constexpr double largest = 1e37;
  Vec3d irradiance =
      glm::min(intensity * (range_share(light, distance) / (distance * distance)), Vec3d(largest));
  if (light.kind == PunctualKind::spot) {
    irradiance *= spot_share(light, -wi);
    if (light.picture >= 0) irradiance *= slide_value(scene, light, -wi);
  }
  return {Vec3(wi), static_cast<float>(distance), irradiance};
}

PathPunctuals::PathPunctuals(const Scene& scene) : scene_(scene), sums_(1, 0.0) {
  std::vector<double> powers;
  for (uint32_t i = 0; i < scene.lights.size(); ++i) {
    if (!(max_component(scene.lights[i].intensity) > 0)) continue;
    lights_.push_back(i);
    powers.push_back(rough_power(scene, scene.lights[i]));
  }
  // Half of the draws go by power, half to all alike: power says nothing of who stands near.
  const double total = std::accumulate(powers.begin(), powers.end(), 0.0), count = double(lights_.size());
  for (const double power : powers)
    sums_.push_back(sums_.back() + (total > 0 ? 0.5 / count + 0.5 * power / total : 1 / count));
}

void PathPunctuals::sample(Vec3 x, RandomStream& random, std::vector<PathPunctual>& out) const {
  if (lights_.size() <= few) {
    for (const uint32_t light : lights_) out.push_back(punctual_towards(scene_, scene_.lights[light], x));
    return;
  }
  const size_t i = find_step(sums_.data(), lights_.size(), uniform_number(random));
  out.push_back(punctual_towards(scene_, scene_.lights[lights_[i]], x));
  out.back().irradiance *= sums_.back() / (sums_[i + 1] - sums_[i]);
}

}  // namespace halflight
