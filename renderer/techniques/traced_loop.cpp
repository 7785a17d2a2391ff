#include "techniques/traced_loop.h"

#include <algorithm>
#include <numeric>

#include "core/timeline.h"

namespace halflight {

namespace {

/// Points of the R3 sequence (Roberts 2018), moved by a random shift: each is uniform in the cube, and
/// together they are spread evenly. Whole numbers, so that long sequences lose nothing.
class ShiftedLattice {
 public:
  explicit ShiftedLattice(RandomStream& random) {
    const uint64_t bits = random.next_bits();
    x_ = static_cast<uint32_t>(bits >> 32), y_ = static_cast<uint32_t>(bits);
    z_ = static_cast<uint32_t>(random.next_bits() >> 32);
  }

  void advance() { x_ += 0xd1b54a33u, y_ += 0xabc98388u, z_ += 0x8cb92ba7u; }
  /// The dimension that chooses among lobes or lights, and the two inside what was chosen.
  float choose() const { return to_unit_float(z_); }
  double choose_finely() const { return static_cast<double>(z_) * 0x1p-32; }
  Vec2 place() const { return {to_unit_float(x_), to_unit_float(y_)}; }

 private:
  uint32_t x_, y_, z_;
};

}  // namespace

DrawAllocation::DrawAllocation(const Shares& shares, uint32_t samples) {
  const double total = std::accumulate(shares.begin(), shares.end(), 0.0);
  if (!(total > 0)) return;
  std::array<double, draw_kind_count> ideal, whole;
  for (size_t k = 0; k < draw_kind_count; ++k) {
    ideal[k] = samples * (shares[k] / total);
    whole[k] = std::floor(ideal[k]);
  }
  // The largest remainders get what rounding down left.
  std::array<size_t, draw_kind_count> order;
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return ideal[a] - whole[a] > ideal[b] - whole[b]; });
  const double left = samples - std::accumulate(whole.begin(), whole.end(), 0.0);
  for (size_t i = 0; i < draw_kind_count && static_cast<double>(i) < left; ++i)
    if (shares[order[i]] > 0) whole[order[i]] += 1;
  bool each_has_one = true;
  for (size_t k = 0; k < draw_kind_count; ++k) each_has_one &= shares[k] <= 0 || whole[k] >= 1;
  const auto& chosen = each_has_one ? whole : ideal;
  for (size_t k = 0; k < draw_kind_count; ++k) {
    expected_[k] = static_cast<float>(chosen[k]);
    prefix_[k + 1] = std::min(prefix_[k] + chosen[k], static_cast<double>(samples));
  }
  prefix_.back() = samples;  // the sum of shares may miss it by a rounding, either way
}

DrawAllocation DrawAllocation::of_rays_and_samples(float brdf_rays, float light_samples) {
  DrawAllocation allocation;
  allocation.expected_.fill(light_samples);
  allocation.expected_[static_cast<size_t>(DrawKind::brdf)] = brdf_rays;
  return allocation;
}

std::array<uint32_t, draw_kind_count> DrawAllocation::counts(float u) const {
  // Systematic sampling: the points j + u along the kinds' shares. Whole shares hold that many of them
  // always.
  std::array<uint32_t, draw_kind_count> result;
  const auto points_below = [&](double end) {
    return static_cast<uint32_t>(std::max(0.0, std::ceil(end - static_cast<double>(u))));
  };
  for (size_t k = 0; k < draw_kind_count; ++k)
    result[k] = points_below(prefix_[k + 1]) - points_below(prefix_[k]);
  return result;
}

TracedWorker::TracedWorker(const FrameView& frame, const PassRequest& request, Film& film,
                           const LightSources& lights, const TracedParameters& parameters,
                           std::array<uint32_t, 2> samples)
    : frame_(frame),
      request_(request),
      film_(film),
      lights_(lights),
      brdf_estimator_(parameters.brdf_estimator),
      split_(split_samples(request)),
      allocations_{DrawAllocation(parameters.shares, samples[0]),
                   DrawAllocation(parameters.shares, samples[1])} {
  for (std::vector<ShadowRay>* rays : {&rays_, &bounce_rays_}) rays->reserve(most_rays);
  for (std::vector<Waiting>* waiting : {&waiting_, &bounce_waiting_}) waiting->reserve(most_rays);
  bounces_.reserve(most_rays);
  brdf_rays_.reserve(most_brdf_rays), closest_.reserve(most_brdf_rays);
}

bool TracedWorker::open(uint32_t pixel) {
  ++stats_.pixels;
  const Vec3 base = frame_.base ? (*frame_.base)[pixel] : Vec3(0);
  return open(pixel, {&frame_.gbuffer->texels[pixel], base}, split_);
}

void TracedWorker::add_base(uint32_t pixel, const SeenTexel& seen, std::array<uint32_t, 2> samples) {
  add_to_film({pixel, samples, seen.base, Vec3(0), {}});
}

bool TracedWorker::open(uint32_t pixel, const SeenTexel& seen, std::array<uint32_t, 2> samples) {
  if (!reflects(*seen.texel)) {
    add_base(pixel, seen, samples);
    return false;
  }
  texel_ = seen.texel;
  basis_ = texel_->basis();
  origin_ = RayOrigin(*frame_.scene, texel_->position, texel_->geometric_normal);
  open_[open_count_] = {pixel, samples, seen.base, texel_->throughput, {}};
  return true;
}

void TracedWorker::draw(int half, RandomStream& random, float scale) {
  allocation_ = &allocations_[static_cast<size_t>(half)];
  strata_ = {};
  slot_ = 2 * open_count_ + static_cast<uint32_t>(half);
  scale_ = scale;
  const auto counts = allocation_->counts(random.next());
  const auto count = [&](DrawKind kind) { return counts[static_cast<size_t>(kind)]; };
  draw_brdf_rays(count(DrawKind::brdf), random);
  draw_environment(count(DrawKind::environment), random);
  draw_emitters(count(DrawKind::emitters), random);
  draw_surfaces(count(DrawKind::surfaces), random);
  draw_punctual(count(DrawKind::punctual), random);
}

void TracedWorker::draw_brdf(int half, uint32_t count, const DrawAllocation& allocation,
                             const StrataDensity& strata, RandomStream& random) {
  allocation_ = &allocation;
  strata_ = strata;
  slot_ = 2 * open_count_ + static_cast<uint32_t>(half);
  scale_ = 1;
  draw_brdf_rays(count, random);
}

void TracedWorker::draw_brdf_rays(uint32_t count, RandomStream& random) {
  if (count == 0) return;
  const auto draw_lobe = brdf_estimator_ == BrdfEstimator::whole ? sample : sample_chosen_lobe;
  ShiftedLattice lattice(random);
  for (uint32_t j = 0; j < count; ++j, lattice.advance()) {
    const auto drawn = draw_lobe(texel_->brdf, basis_, texel_->wo, lattice.choose(), lattice.place());
    // Light from below the surface itself is in its own shadow, whatever the shading normal says.
    if (!drawn || !(glm::dot(texel_->geometric_normal, drawn->wi) > 0)) continue;
    const Vec3 reflected = drawn->f * (glm::dot(texel_->shading_normal, drawn->wi) / drawn->pdf * scale_);
    if (!(max_component(reflected) > 0)) continue;
    push_brdf_ray({drawn->wi, drawn->pdf, reflected, slot_, random.next_bits(), allocation_, {}});
  }
}

void TracedWorker::push_brdf_ray(const BrdfRay& ray) {
  ++stats_.stages[Stage::traced_brdf_rays].calls;
  const ShadowRay probe = shadow_ray(origin_, ray.wi, infinity);
  // Where only the environment is looked for, nothing needs to be known of what is in the way.
  if (!frame_.kinds.emitters && !frame_.kinds.surfaces) {
    if (!frame_.kinds.environment) return;
    const MetLight light = environment_met(ray);
    return push(probe, ray.reflected * light.radiance * weigh(ray, light.pdf, DrawKind::environment),
                no_bounce);
  }
  brdf_rays_.push_back(ray);
  closest_.push_back({probe});
  if (brdf_rays_.size() == most_brdf_rays) trace_brdf_rays();
}

/// What was hit lies anywhere in memory: it is asked for some rays before it is looked at.
void TracedWorker::trace_brdf_rays() {
  if (brdf_rays_.empty()) return;
  {
    const TickScope scope(clock.visibility);
    frame_.rays->intersect(closest_, false, frame_.alpha_seed, stats_.rays);
  }
  const Scene& scene = *frame_.scene;
  for (size_t i = 0; i < closest_.size(); ++i) {
    if (!closest_[i].met()) continue;
    brdf_rays_[i].hit = frame_.rays->hit_of(closest_[i]);
    prefetch_triangle(scene, brdf_rays_[i].hit.point.triangle);
  }
  for (size_t i = 0; i < closest_.size(); ++i)
    if (closest_[i].met()) prefetch_corners(scene, brdf_rays_[i].hit.point.triangle);
  for (size_t i = 0; i < closest_.size(); ++i) {
    if (closest_[i].met())
      add_hit(brdf_rays_[i]);
    else if (frame_.kinds.environment && !closest_[i].ray.blocked())  // one that Embree cannot take is
      add_environment_met(brdf_rays_[i]);
  }
  brdf_rays_.clear(), closest_.clear();
}

void TracedWorker::add_environment_met(const BrdfRay& ray) {
  const MetLight light = environment_met(ray);
  open_[ray.slot / 2].sum[ray.slot % 2] +=
      ray.reflected * light.radiance * weigh(ray, light.pdf, DrawKind::environment);
}

void TracedWorker::add_hit(const BrdfRay& ray) {
  if (frame_.kinds.emitters) {
    const MetLight light = emission_met(ray);
    if (max_component(light.radiance) > 0)
      open_[ray.slot / 2].sum[ray.slot % 2] +=
          ray.reflected * light.radiance * weigh(ray, light.pdf, DrawKind::emitters);
  }
  if (!frame_.kinds.surfaces) return;
  if (const auto place = bounce_place(*frame_.scene, ray.hit.point, ray.wi)) {
    const float weight = weigh(ray, surface_pdf(ray, *place), DrawKind::surfaces);
    light_bounce(*place, ray.reflected * weight, ray.slot, ray.key);
  }
}

MetLight TracedWorker::environment_met(const BrdfRay& ray) const {
  if (!strata_.lights) return met_environment(lights_, ray.wi);
  const Environment& environment = frame_.scene->environment;
  if (!environment.present()) return {Vec3(0), 0};
  const glm::ivec2 texel = environment_texel(environment, ray.wi);
  return {environment_radiance(environment, texel), strata_.of(strata_.lights->met_environment(texel))};
}

MetLight TracedWorker::emission_met(const BrdfRay& ray) const {
  MetLight light = met_emission(lights_, ray.hit, ray.wi);
  if (!strata_.lights || !(max_component(light.radiance) > 0)) return light;
  const Vec3 cross = triangle_cross(*frame_.scene, ray.hit.point.triangle);
  const float cos_light = -glm::dot(cross, ray.wi) / std::max(glm::length(cross), 1e-37f);
  const float density = strata_.of(strata_.lights->met_emitter(ray.hit.point, cos_light > 0));
  return {light.radiance, area_to_solid_angle(density, ray.hit.distance, std::abs(cos_light))};
}

float TracedWorker::surface_pdf(const BrdfRay& ray, const BouncePlace& place) const {
  if (!strata_.lights) return place.pdf(lights_, ray.hit.distance);
  const float density = strata_.of(strata_.lights->met_surface(ray.hit.point, place.front));
  return area_to_solid_angle(density, ray.hit.distance, place.cos_light);
}

float TracedWorker::weigh(const BrdfRay& ray, float light_pdf, DrawKind kind) const {
  return balance_over_n(ray.allocation->expected(DrawKind::brdf), ray.pdf, ray.allocation->expected(kind),
                        light_pdf);
}

void TracedWorker::add_light_sample(const IncidentSample& light, DrawKind kind) {
  const float cosine = glm::dot(texel_->shading_normal, light.wi);
  if (!(cosine > 0) || !(glm::dot(texel_->geometric_normal, light.wi) > 0)) return;
  const BrdfValue brdf = evaluate_with_pdf(texel_->brdf, basis_, texel_->wo, light.wi);
  const float rays = kind == DrawKind::punctual ? 0 : expected(DrawKind::brdf);
  const float weight = balance_over_n(expected(kind), light.pdf, rays, brdf.pdf) * scale_;
  push(shadow_ray(origin_, light.wi, light.distance), brdf.f * cosine * (light.radiance_over_pdf * weight),
       no_bounce);
}

void TracedWorker::draw_environment(uint32_t count, RandomStream& random) {
  if (count == 0 || lights_.environment.empty()) return;
  ShiftedLattice lattice(random);
  constexpr uint32_t most_at_once = 16;
  std::array<Vec2, most_at_once> places;
  std::array<IncidentSample, most_at_once> samples;
  for (uint32_t begin = 0; begin < count; begin += most_at_once) {
    const uint32_t end = std::min(count - begin, most_at_once);
    for (uint32_t j = 0; j < end; ++j, lattice.advance()) places[j] = lattice.place();
    lights_.environment.sample({places.data(), end}, {samples.data(), end});
    for (uint32_t j = 0; j < end; ++j) add_light_sample(samples[j], DrawKind::environment);
  }
}

void TracedWorker::draw_emitters(uint32_t count, RandomStream& random) {
  if (count == 0 || lights_.emitters.empty()) return;
  ShiftedLattice lattice(random);
  for (uint32_t j = 0; j < count; ++j, lattice.advance())
    if (const auto light = lights_.emitters.sample(texel_->position, lattice.choose(), lattice.place()))
      add_light_sample(*light, DrawKind::emitters);
}

void TracedWorker::draw_punctual(uint32_t count, RandomStream& random) {
  if (lights_.punctual.empty()) return;
  for (uint32_t j = 0; j < count; ++j)
    if (const auto light = lights_.punctual.sample(texel_->position, texel_->shading_normal, random))
      add_light_sample(*light, DrawKind::punctual);
}

void TracedWorker::draw_surfaces(uint32_t count, RandomStream& random) {
  if (count == 0 || !(lights_.surfaces.area() > 0)) return;
  const Scene& scene = *frame_.scene;
  ShiftedLattice lattice(random);
  // Triangles lie anywhere in memory: a few are asked for at once, first their indices and then their
  // corners.
  constexpr uint32_t most_at_once = 16;
  std::array<SurfacePoint, most_at_once> points;
  for (uint32_t begin = 0; begin < count; begin += most_at_once) {
    const uint32_t end = std::min(count - begin, most_at_once);
    for (uint32_t j = 0; j < end; ++j, lattice.advance()) {
      points[j] = lights_.surfaces.at(lattice.choose_finely(), lattice.place());
      prefetch_triangle(scene, points[j].triangle);
    }
    for (uint32_t j = 0; j < end; ++j) prefetch_corners(scene, points[j].triangle);
    for (uint32_t j = 0; j < end; ++j) add_surface_sample(points[j], random);
  }
}

void TracedWorker::add_surface_sample(SurfacePoint surface, RandomStream& random) {
  const Scene& scene = *frame_.scene;
  const Vec3 offset = surface_position(scene, surface) - texel_->position;
  const float distance2 = glm::dot(offset, offset);
  if (!(distance2 > 0)) return;
  const float distance = std::sqrt(distance2);
  const Vec3 wi = offset / distance;
  const float cosine = glm::dot(texel_->shading_normal, wi);
  if (!(cosine > 0) || !(glm::dot(texel_->geometric_normal, wi) > 0)) return;
  const std::optional<BouncePlace> place = bounce_place(scene, surface, wi);
  if (!place || !(place->cos_light > 0)) return;
  const BrdfValue brdf = evaluate_with_pdf(texel_->brdf, basis_, texel_->wo, wi);
  const float pdf = place->pdf(lights_, distance);
  const float weight = balance_over_n(expected(DrawKind::surfaces), pdf, expected(DrawKind::brdf), brdf.pdf);
  const Vec3 value = brdf.f * (cosine / pdf * weight * scale_ * surface_alpha(scene, surface));
  if (!(max_component(value) > 0)) return;
  bounces_.push_back({*place, random.next_bits()});
  push(shadow_ray(origin_, wi, distance), value, static_cast<uint32_t>(bounces_.size() - 1));
}

void TracedWorker::push(const ShadowRay& ray, Vec3 value, uint32_t bounce, VisibilityCount* visibility) {
  if (!(max_component(value) > 0)) return;
  rays_.push_back(ray);
  waiting_.push_back({value, slot_, bounce, visibility});
  if (rays_.size() == most_rays) trace_first();
}

void TracedWorker::add_ray(const ShadowRay& ray, Vec3 value, int half, VisibilityCount* visibility) {
  slot_ = 2 * open_count_ + static_cast<uint32_t>(half);
  push(ray, value, no_bounce, visibility);
}

void TracedWorker::light_bounce(const BouncePlace& place, Vec3 value, uint32_t slot, uint64_t key) {
  const Vec3 returned = value * bounce_reflection(*frame_.scene, place);
  if (!(max_component(returned) > 0)) return;
  RandomStream random(key, 0, 0);
  if (!lights_.emitters.empty()) {
    const TickScope scope(clock.visibility);
    const Vec3 near = near_emission(*frame_.rays, lights_.emitters, place.position, place.normal, 1, random,
                                    frame_.alpha_seed, stats_.rays);
    open_[slot / 2].sum[slot % 2] += returned * near;
  }
  draw_irradiance(lights_, place, random, [&](const ShadowRay& ray, Vec3 irradiance) {
    bounce_rays_.push_back(ray);
    bounce_waiting_.push_back({returned * irradiance, slot, no_bounce, nullptr});
  });
  if (bounce_rays_.size() + most_irradiance_rays > most_rays) trace_second();
}

template <class Arrive>
void TracedWorker::trace(std::vector<ShadowRay>& rays, Arrive&& arrive) {
  stats_.useful_rays += rays.size();
  if (request_.watch_rays) request_.watch_rays(rays);
  {
    const TickScope scope(clock.visibility);
    frame_.rays->occluded(rays, frame_.alpha_seed, stats_.rays);
  }
  for (size_t i = 0; i < rays.size(); ++i)
    if (!rays[i].blocked()) arrive(i);
  rays.clear();
}

void TracedWorker::trace_first() {
  trace(rays_, [&](size_t i) {
    const Waiting& waiting = waiting_[i];
    if (waiting.visibility) ++waiting.visibility->arrived;
    if (waiting.bounce == no_bounce) {
      open_[waiting.slot / 2].sum[waiting.slot % 2] += waiting.value;
    } else {
      const WaitingBounce& bounce = bounces_[waiting.bounce];
      light_bounce(bounce.place, waiting.value, waiting.slot, bounce.key);
    }
  });
  waiting_.clear();
  bounces_.clear();
}

void TracedWorker::trace_second() {
  trace(bounce_rays_, [&](size_t i) {
    const Waiting& waiting = bounce_waiting_[i];
    open_[waiting.slot / 2].sum[waiting.slot % 2] += waiting.value;
  });
  bounce_waiting_.clear();
}

void TracedWorker::close() {
  ++open_count_;
  if (rays_.size() + bounce_rays_.size() >= enough_rays || open_count_ == most_pixels) finish();
}

void TracedWorker::finish() {
  trace_brdf_rays();
  if (!rays_.empty()) trace_first();
  if (!bounce_rays_.empty()) trace_second();
  const TickScope scope(clock.resolve);
  for (uint32_t i = 0; i < open_count_; ++i) add_to_film(open_[i]);
  open_count_ = 0;
}

void TracedWorker::add_to_film(const OpenPixel& pixel) {
  const Vec3d throughput(pixel.throughput);
  for (int half = 0; half < 2; ++half)
    if (pixel.samples[half] > 0)
      film_.add(pixel.index, half, pixel.base + Vec3(throughput * pixel.sum[half]), pixel.samples[half]);
}

PassStats run_traced_pass(const FrameView& frame, const PassRequest& request, Film& film,
                          const LightSources& lights, const TracedParameters& parameters) {
  const std::array<uint32_t, 2> split = split_samples(request);
  return run_traced_pixels(
      frame, request, [&] { return TracedWorker(frame, request, film, lights, parameters, split); },
      [&](TracedWorker& worker, uint32_t, RandomStream& random) {
        for (int half = 0; half < 2; ++half)
          if (split[half] > 0) worker.draw(half, random);
      });
}

}  // namespace halflight
