#include "techniques/light_paths.h"

#include <mutex>

#include "core/parallel.h"
#include "core/warp.h"
#include "lights/emitters.h"
#include "trace/ray_gbuffer.h"

namespace halflight {

namespace {

// Albedos below one end a path long before; this ends it where a material returns more than arrives.
constexpr int longest_path = 4096;

/// Five numbers that place a path's first ray: which light, where on it, which way.
struct PathPoint {
  float choose;
  Vec2 place, way;
};

/// The R5 sequence (Roberts 2018) with a random shift: any run of it, and so each set, is spread evenly.
class PathSequence {
 public:
  explicit PathSequence(uint64_t seed) {
    RandomStream random(0, 0, seed);
    for (uint32_t& shift : shift_) shift = static_cast<uint32_t>(random.next_bits() >> 32);
  }
  PathPoint at(uint32_t index) const {
    // 2³²/φᵏ with φ⁶ = φ + 1.
    constexpr std::array<uint32_t, 5> step{0xe19b01aau, 0xc6d1d6c8u, 0xaf36d01eu, 0x9a69443fu, 0x881403b9u};
    std::array<float, 5> x;
    for (size_t d = 0; d < 5; ++d) x[d] = to_unit_float(shift_[d] + step[d] * index);
    return {x[0], {x[1], x[2]}, {x[3], x[4]}};
  }

 private:
  std::array<uint32_t, 5> shift_;
};

/// A ray that leaves a light, with what it carries over the density with which it was drawn.
struct EmittedRay {
  Vec3 origin, direction;
  Vec3 weight;
  int32_t punctual =
      -1;  ///< `weight` of a point or spot light is a solid angle, for its intensity hangs on the hit
};

/// The lights of a scene with the power each sends into it.
class LightChoice {
 public:
  explicit LightChoice(const LightSources& lights);
  bool empty() const { return table_.empty(); }
  std::optional<EmittedRay> emit(const PathPoint&, RandomStream&) const;

 private:
  enum class Kind { environment, emitters, punctual };
  struct Entry {
    Kind kind;
    uint32_t index;  ///< of Scene::lights
  };
  EmittedRay parallel_ray(Vec3 wi, Vec3 irradiance, Vec2 place) const;
  std::optional<EmittedRay> emitter_ray(float choose, const PathPoint&, RandomStream&) const;
  EmittedRay punctual_ray(uint32_t index, const PathPoint&) const;

  const LightSources& lights_;
  std::vector<Entry> entries_;
  DiscreteTable table_;
  Vec3 centre_{0};
  float radius_ = 0;
};

/// ∫ L dω, luminance.
double environment_flux(const Environment& environment) {
  double flux = 0;
  for (int y = 0; y < environment.map.height; ++y) {
    double row = 0;
    for (int x = 0; x < environment.map.width; ++x) row += luminance(environment.map.at(x, y));
    flux += row * texel_solid_angle(environment, y);
  }
  return flux * environment.strength;
}

/// Roughly, for textures are taken as white.
double emitter_power(const Scene& scene) {
  double power = 0;
  for (const EmissiveTriangle& emitter : emissive_triangles(scene)) {
    const Material& material = scene.materials[scene.triangle_material[emitter.triangle]];
    power += static_cast<double>(pi) * emitter.area * luminance(material.emission) *
             (material.double_sided ? 2 : 1);
  }
  return power;
}

LightChoice::LightChoice(const LightSources& lights) : lights_(lights) {
  const Scene& scene = lights.scene;
  centre_ = scene.bounds.centre();
  radius_ = 0.5f * scene.bounds.diagonal();
  std::vector<double> powers;
  const auto add = [&](Kind kind, uint32_t index, double power) {
    entries_.push_back({kind, index});
    powers.push_back(power);
  };
  if (!lights.environment.empty())
    add(Kind::environment, 0,
        environment_flux(scene.environment) * static_cast<double>(pi) * radius_ * radius_);
  if (!lights.emitters.empty()) add(Kind::emitters, 0, emitter_power(scene));
  for (uint32_t i = 0; i < scene.lights.size(); ++i)
    if (max_component(scene.lights[i].intensity) > 0)
      add(Kind::punctual, i, punctual_power(scene.lights[i], radius_));
  const double strongest = powers.empty() ? 0 : *std::max_element(powers.begin(), powers.end());
  std::vector<float> weights;
  for (const double power : powers)
    weights.push_back(static_cast<float>(strongest > 0 ? power / strongest : 1.0));
  table_ = DiscreteTable(weights);
}

EmittedRay LightChoice::parallel_ray(Vec3 wi, Vec3 irradiance, Vec2 place) const {
  const Basis basis = basis_around(wi);
  const Vec2 disc = radius_ * concentric_disk(place);
  return {centre_ + disc.x * basis.tangent + disc.y * basis.bitangent + 1.001f * radius_ * wi, -wi,
          irradiance * (pi * radius_ * radius_)};
}

std::optional<EmittedRay> LightChoice::emitter_ray(float choose, const PathPoint& at,
                                                   RandomStream& random) const {
  const Scene& scene = lights_.scene;
  const EmitterSampler::Point drawn = lights_.emitters.point(choose, at.place);
  const bool both = scene.materials[scene.triangle_material[drawn.surface.triangle]].double_sided;
  const int side = both && random.next() < 0.5f ? -1 : 1;
  const Vec3 cross = triangle_cross(scene, drawn.surface.triangle);
  const float length = glm::length(cross);
  const Vec3 radiance = covered_emission(scene, drawn.surface, side);
  if (!(length > 0) || !(drawn.density > 0) || !(max_component(radiance) > 0)) return std::nullopt;
  const Vec3 normal = cross * (static_cast<float>(side) / length);
  const Vec3 way = basis_around(normal).to_world(cosine_hemisphere(at.way));
  const RayOrigin origin(scene, surface_position(scene, drawn.surface), normal);
  // The cosine over its density cos/π.
  return EmittedRay{origin.front, way, radiance * (pi / drawn.density * (both ? 2.0f : 1.0f))};
}

EmittedRay LightChoice::punctual_ray(uint32_t index, const PathPoint& at) const {
  const PunctualLight& light = lights_.scene.lights[index];
  if (light.kind == PunctualKind::directional)
    return parallel_ray(-light.direction, light.intensity, at.place);
  EmittedRay ray;
  ray.origin = light.position;
  ray.punctual = static_cast<int32_t>(index);
  if (light.kind == PunctualKind::point) {
    ray.direction = uniform_sphere(at.way);
    ray.weight = Vec3(4 * pi);
    return ray;
  }
  // Uniform over the outer cone, by its height 1 − cos.
  const float height = 2 * square(std::sin(0.5f * light.outer_cone));
  const float up = at.way.x * height, sine = std::sqrt(std::max(0.0f, up * (2 - up))),
              phi = 2 * pi * at.way.y;
  ray.direction = glm::normalize(
      basis_around(light.direction).to_world({sine * std::cos(phi), sine * std::sin(phi), 1 - up}));
  ray.weight = Vec3(2 * pi * height);
  return ray;
}

std::optional<EmittedRay> LightChoice::emit(const PathPoint& at, RandomStream& random) const {
  const DiscreteTable::Draw draw = table_.draw(at.choose);
  std::optional<EmittedRay> ray;
  switch (entries_[draw.index].kind) {
    case Kind::environment: {
      const IncidentSample sample = lights_.environment.sample(at.way);
      ray = parallel_ray(sample.wi, sample.radiance_over_pdf, at.place);
      break;
    }
    case Kind::emitters:
      ray = emitter_ray(draw.residual, at, random);
      break;
    case Kind::punctual:
      ray = punctual_ray(entries_[draw.index].index, at);
      break;
  }
  if (ray) ray->weight /= draw.probability;
  return ray;
}

/// Follows one path and leaves a virtual light at each surface it meets.
void follow_path(const LightSources& lights, const RayScene& rays, EmittedRay ray, uint32_t alpha_seed,
                 float share, RandomStream& random, std::vector<VirtualLight>& out, RayCounters& counters) {
  const Scene& scene = lights.scene;
  RayHit hit;
  for (int vertex = 0; vertex < longest_path; ++vertex) {
    if (!rays.intersect(ray.origin, ray.direction, 0, infinity, alpha_seed, hit, counters)) return;
    const GBufferTexel texel = shade_surface(scene, hit.point, -ray.direction);
    if (ray.punctual >= 0) {
      const PunctualLight& light = scene.lights[static_cast<size_t>(ray.punctual)];
      ray.weight *= connect_punctual(light, scene, texel.position).irradiance * square(hit.distance);
      ray.punctual = -1;
    }
    const Vec3 returned = ray.weight * bounce_albedo(texel.brdf) * (share / pi);
    if (max_component(returned) > 0 && is_finite(returned))
      out.push_back({texel.position, 1, texel.geometric_normal, LightKind::surface, returned, 0});

    const float choose = random.next();
    const auto next = sample(texel.brdf, texel.basis(), texel.wo, choose, random.next2());
    if (!next || !(glm::dot(texel.geometric_normal, next->wi) > 0)) return;
    const Vec3 reflectance = next->f * (glm::dot(texel.shading_normal, next->wi) / next->pdf);
    const float survival = std::min(1.0f, luminance(reflectance));
    if (!(random.next() < survival)) return;
    ray.weight *= reflectance / survival;
    ray.origin = RayOrigin(scene, texel.position, texel.geometric_normal).front;
    ray.direction = next->wi;
  }
}

}  // namespace

std::vector<std::vector<VirtualLight>> trace_light_paths(const LightSources& lights, const RayScene& rays,
                                                         const LightPathSettings& settings,
                                                         RayCounters& counters) {
  std::vector<std::vector<VirtualLight>> sets(settings.sets);
  const LightChoice choice(lights);
  if (choice.empty()) return sets;
  const PathSequence sequence(settings.seed);
  std::mutex mutex;
  parallel_for(0, settings.sets, 1, [&](size_t begin, size_t end) {
    RayCounters local;
    for (size_t set = begin; set < end; ++set) {
      for (uint32_t i = 0; i < settings.paths; ++i) {
        const auto index = static_cast<uint32_t>(set) * settings.paths + i;
        RandomStream random(index, 0x70617468, settings.seed);
        if (const auto ray = choice.emit(sequence.at(index), random))
          follow_path(lights, rays, *ray, settings.alpha_seed, 1 / static_cast<float>(settings.paths), random,
                      sets[set], local);
      }
    }
    std::lock_guard lock(mutex);
    counters += local;  // whole numbers: the order does not matter
  });
  return sets;
}

}  // namespace halflight
