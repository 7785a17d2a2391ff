#include "techniques/path_tracer.h"

namespace halflight {

namespace {

constexpr int bounces_before_roulette = 4;

double largest(const Vec3d& v) { return std::max(v.x, std::max(v.y, v.z)); }

/// A surface that returns albedo/π whichever way: modified Phong without a lobe.
Brdf lambert(Vec3 albedo) {
  Brdf brdf;
  brdf.model = BrdfModel::phong;
  brdf.diffuse = albedo;
  return brdf;
}

}  // namespace

PathTracer::PathTracer(const RayScene& rays, const PathLights& lights, const PathSettings& settings,
                       const std::function<void(std::span<const ShadowRay>)>& watch_rays)
    : rays_(rays), scene_(rays.scene()), lights_(lights), settings_(settings), watch_rays_(watch_rays) {}

Vec3d PathTracer::trace(const CameraRay& ray, uint32_t alpha_seed, RandomStream& random) {
  alpha_seed_ = alpha_seed;

  // What the camera sees.
  RayHit seen;
  if (!rays_.intersect(ray.origin, ray.direction, 0, infinity, alpha_seed, seen, counters_))
    return settings_.shows_emission() ? Vec3d(environment_radiance(scene_.environment, ray.direction))
                                      : Vec3d(0);
  const GBufferTexel texel = shade_surface(scene_, seen.point, -ray.direction);
  Vec3d throughput(texel.throughput);
  Vec3d sum = settings_.shows_emission() ? throughput * Vec3d(texel.emission) : Vec3d(0);

  // What surfaces reflect, one after the other.
  Vertex vertex = vertex_seen(texel);
  for (int through = 0; !vertex.brdf.black(); ++through) {
    const bool wanted = settings_.wants(through), last = through == settings_.last();
    if (wanted) sum += throughput * sample_lights(vertex, random);
    if (last && !wanted) break;
    const std::optional<Continuation> next = draw(vertex, random);
    if (!next) break;
    throughput *= next->reflected;
    if (wanted) sum += throughput * light_met(vertex, *next);
    if (last || !next->hit) break;

    // Russian roulette: a path goes on with the share of light that it still carries.
    if (through >= bounces_before_roulette) {
      const double survival = std::min(1.0, largest(throughput));
      if (!(uniform_number(random) < survival)) break;
      throughput /= survival;
    }
    vertex = vertex_met(*next->hit, -next->wi);
  }
  return sum;
}

PathTracer::Vertex PathTracer::vertex_seen(const GBufferTexel& texel) {
  return {texel.position, texel.geometric_normal, texel.wo, texel.basis(), texel.brdf};
}

PathTracer::Vertex PathTracer::vertex_met(const RayHit& hit, Vec3 wo) const {
  if (settings_.model == PathModel::whole) return vertex_seen(shade_surface(scene_, hit.point, wo));
  Vec3 normal(triangle_shape(scene_, hit.point.triangle).normal);
  if (glm::dot(normal, wo) < 0) normal = -normal;
  const Brdf brdf = normal == Vec3(0) ? Brdf() : surface_brdf(scene_, hit.point);
  return {surface_position(scene_, hit.point), normal, wo, basis_around(normal),
          lambert(bounce_albedo(brdf))};
}

/// Light drawn straight from the lights: one direction of the environment, one point of an emitter, and the
/// punctual lights.
Vec3d PathTracer::sample_lights(const Vertex& vertex, RandomStream& random) {
  shadow_rays_.clear(), values_.clear();
  if (!lights_.environment.empty()) add_light(vertex, lights_.environment.sample(random));
  if (!lights_.emitters.empty())
    if (const auto sample = lights_.emitters.sample(vertex.position, random)) add_light(vertex, *sample);
  punctual_.clear();
  if (!lights_.punctual.empty()) lights_.punctual.sample(vertex.position, random, punctual_);
  for (const PathPunctual& light : punctual_) add_punctual(vertex, light);

  if (watch_rays_ && !shadow_rays_.empty()) watch_rays_(shadow_rays_);
  useful_rays_ += shadow_rays_.size();
  rays_.occluded(shadow_rays_, alpha_seed_, counters_);
  Vec3d sum(0);
  for (size_t i = 0; i < shadow_rays_.size(); ++i)
    if (!shadow_rays_[i].blocked()) sum += values_[i];
  return sum;
}

/// One light sample against the one BRDF ray that could have found the same light: L f cos θ / (p_light +
/// p_BRDF), the balance heuristic (Veach & Guibas 1995, eq. 14) with a sample of each.
void PathTracer::add_light(const Vertex& vertex, const PathLightSample& light) {
  const BrdfValue brdf = evaluate_with_pdf(vertex.brdf, vertex.basis, vertex.wo, light.wi);
  const double cosine = glm::dot(vertex.basis.normal, light.wi), pdf = light.pdf + brdf.pdf;
  if (pdf > 0) add_ray(vertex, light.wi, light.distance, Vec3d(brdf.f) * light.radiance * (cosine / pdf));
}

void PathTracer::add_punctual(const Vertex& vertex, const PathPunctual& light) {
  const Vec3 f = evaluate(vertex.brdf, vertex.basis, vertex.wo, light.wi);
  const double cosine = glm::dot(vertex.basis.normal, light.wi);
  add_ray(vertex, light.wi, light.distance, Vec3d(f) * light.irradiance * cosine);
}

/// Only light from above both normals is reflected.
void PathTracer::add_ray(const Vertex& vertex, Vec3 wi, float distance, Vec3d value) {
  if (!(glm::dot(vertex.basis.normal, wi) > 0) || !(glm::dot(vertex.geometric_normal, wi) > 0)) return;
  if (largest(value) == 0) return;
  shadow_rays_.push_back(shadow_ray(scene_, vertex.position, vertex.geometric_normal, wi, distance));
  values_.push_back(value);
}

std::optional<PathTracer::Continuation> PathTracer::draw(const Vertex& vertex, RandomStream& random) {
  const float choose = random.next();
  const auto drawn = sample(vertex.brdf, vertex.basis, vertex.wo, choose, random.next2());
  if (!drawn || !(drawn->pdf > 0) || !(glm::dot(vertex.geometric_normal, drawn->wi) > 0)) return std::nullopt;
  const double cosine = glm::dot(vertex.basis.normal, drawn->wi);
  Continuation next{drawn->wi, drawn->pdf, Vec3d(drawn->f) * (cosine / drawn->pdf), std::nullopt};
  if (largest(next.reflected) == 0) return std::nullopt;
  const Vec3 origin = RayOrigin(scene_, vertex.position, vertex.geometric_normal).front;
  RayHit hit;
  ++brdf_rays_;
  if (rays_.intersect(origin, next.wi, 0, infinity, alpha_seed_, hit, counters_)) next.hit = hit;
  return next;
}

/// Light of what a BRDF ray met, with its share under the balance heuristic: p_BRDF / (p_BRDF + p_light).
Vec3d PathTracer::light_met(const Vertex& vertex, const Continuation& ray) const {
  if (!ray.hit) {
    const double share = ray.pdf / (ray.pdf + lights_.environment.pdf(ray.wi));
    return share * Vec3d(environment_radiance(scene_.environment, ray.wi));
  }
  const SurfacePoint point = ray.hit->point;
  const Vec3d normal = triangle_shape(scene_, point.triangle).normal;
  const Vec3 radiance = surface_emission(scene_, point, glm::dot(normal, Vec3d(ray.wi)) < 0 ? 1 : -1);
  if (!(max_component(radiance) > 0)) return Vec3d(0);
  const double light_pdf =
      lights_.emitters.pdf(point.triangle, vertex.position, surface_position(scene_, point));
  return Vec3d(radiance) * (ray.pdf / (ray.pdf + light_pdf));
}

}  // namespace halflight
