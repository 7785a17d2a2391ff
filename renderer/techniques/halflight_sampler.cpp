#include "techniques/halflight_sampler.h"

#include "lights/cut_importance.h"
#include "techniques/shared_distribution.h"

namespace halflight {

namespace {

// A lobe below this roughness is a mirror: no light sample finds it.
constexpr float mirror_alpha = 1e-3f;
// A lobe up to so many times as wide as a cluster, in variance, still sees light otherwise in each pixel.
constexpr float narrow_lobe = 8;
constexpr float most_share_beside_punctual = 0.75f;
/// Between normals of views that share a distribution.
constexpr float least_cosine = 0.95f;
/// How many groups of a block a view is held against: those that came last.
constexpr size_t most_compared = 8;

bool is_mirror(const Brdf& brdf) {
  return brdf.model == BrdfModel::ggx && max_component(brdf.diffuse) <= 0 &&
         std::max(brdf.roughness.x, brdf.roughness.y) < mirror_alpha;
}

/// Uniform over seeds; neighbours and successive rounds differ as much as can be (Roberts 2018, the R3
/// sequence).
float split_phase(const FrameView& frame, uint32_t pixel, uint32_t round) {
  const auto width = static_cast<uint32_t>(frame.gbuffer->width);
  const auto seed = static_cast<uint32_t>(hash_combine(frame.seed, 0x73706c6974ull));
  return to_unit_float(seed + pixel % width * 0xd1b54a33u + pixel / width * 0xabc98388u +
                       round * 0x8cb92ba7u);
}

/// The first few positions in a pixel buy more than later ones.
uint32_t positions_of(const PassRequest& request, uint32_t samples_each) {
  constexpr uint32_t few = 8;
  const uint32_t positions = request.samples / std::max(1u, samples_each);
  return std::max({1u, std::min(positions, few), positions / 2});
}

}  // namespace

uint32_t share_of_position(uint32_t samples, uint32_t position, uint32_t positions) {
  return samples * (position + 1) / positions - samples * position / positions;
}

HalflightSampler::HalflightSampler(const FrameView& frame, const PassRequest& request,
                                   const HalflightParameters& parameters, const LearnedLights& lights,
                                   LearnedVisibility& visibility)
    : frame_(frame),
      request_(request),
      parameters_(parameters),
      lights_(lights),
      visibility_(visibility),
      positions_(frame, request.pass, positions_of(request, parameters.position_samples)),
      guard_(lights.cut().padded_size()),
      arriving_(guard_.size()),
      factor_(guard_.size(), 1.0f) {
  allocations_.reserve(2 * block_size * PixelPositions::most);
}

void HalflightSampler::render(TracedWorker& worker, std::span<const uint32_t> pixels) {
  worker.stats().pixels += pixels.size();
  {
    const TickScope scope(worker.clock.gbuffer);
    positions_.look(pixels, worker.stats().rays);
  }
  for (size_t first = 0, end = 0; first < pixels.size(); first = end) {
    while (end < pixels.size() && block_of(pixels[end]) == block_of(pixels[first])) ++end;
    const auto block = pixels.subspan(first, end - first);
    {
      const TickScope scope(worker.clock.distribution);
      look_at_block(worker, block, first);
      if (views_.empty()) continue;
      prepare_visibility(worker, block.front());
      sort_by_group();
    }
    size_t begin = 0;
    for (const Group& group : groups_) {
      render_group(worker, std::span<const View>(sorted_).subspan(begin, group.count));
      begin += group.count;
    }
  }
}

/// The 4×4 block of the visited pixels that a pixel is in.
glm::uvec2 HalflightSampler::block_of(uint32_t pixel) const {
  const auto width = static_cast<uint32_t>(frame_.gbuffer->width);
  return glm::uvec2(pixel % width, pixel / width) / (block_side * request_.stride);
}

/// Gathers the views that reflect light, in groups; the others get their base at once.
void HalflightSampler::look_at_block(TracedWorker& worker, std::span<const uint32_t> pixels,
                                     size_t first_in_tile) {
  views_.clear(), groups_.clear(), random_.clear();
  const std::array<uint32_t, 2> split = split_samples(request_);
  const uint32_t positions = positions_.count();
  for (uint32_t place = 0; place < pixels.size(); ++place) {
    random_.push_back(pixel_stream(frame_, request_, pixels[place]));
    for (uint32_t position = 0; position < positions; ++position) {
      View view;
      view.pixel = pixels[place], view.place = place;
      view.seen = positions_.at(first_in_tile + place, position);
      for (size_t half = 0; half < 2; ++half)
        view.samples[half] = share_of_position(split[half], position, positions);
      if (!frame_.kinds.any() || !reflects(*view.seen.texel)) {
        worker.add_base(view.pixel, view.seen, view.samples);
        continue;
      }
      view.narrow = has_narrow_lobe(view.seen.texel->brdf, lights_.cut(), narrow_lobe);
      view.group = group_of(view);
      if (view.group == groups_.size()) groups_.push_back({static_cast<uint32_t>(views_.size()), 0});
      ++groups_[view.group].count;
      views_.push_back(view);
    }
  }
}

/// A lobe hardly wider than the clusters is at home in one pixel only.
uint32_t HalflightSampler::group_of(const View& view) const {
  const size_t oldest = groups_.size() > most_compared ? groups_.size() - most_compared : 0;
  for (size_t g = groups_.size(); parameters_.share && g-- > oldest;) {
    const View& leader = views_[groups_[g].leader];
    if ((view.narrow || leader.narrow) && leader.place != view.place) continue;
    if (alike(*leader.seen.texel, *view.seen.texel, least_cosine)) return static_cast<uint32_t>(g);
  }
  return static_cast<uint32_t>(groups_.size());
}

void HalflightSampler::sort_by_group() {
  sorted_.resize(views_.size());
  thread_local std::vector<uint32_t> next;
  next.assign(1, 0);
  for (const Group& group : groups_) next.push_back(next.back() + group.count);
  for (const View& view : views_) sorted_[next[view.group]++] = view;
}

void HalflightSampler::prepare_visibility(TracedWorker& worker, uint32_t pixel) {
  if (!parameters_.visibility) return;
  const uint32_t tile = visibility_.tile_of(pixel);
  if (tile == tile_) return;
  ++worker.stats().stages[Stage::learned_visibility].calls;
  tile_ = tile;
  counts_ = visibility_.pending(tile);
  visibility_.factors(tile, factor_);
}

bool HalflightSampler::build(const GBufferTexel& texel) {
  const Cut& cut = lights_.cut();
  if (cut.size == 0) return false;
  const std::span<float> importance = distribution_.importance(cut);
  analytic_importance(cut, texel, 0, {importance, guard_, arriving_});
  if (parameters_.visibility)
    for (uint32_t k = 0; k < cut.size; ++k) importance[k] *= factor_[k];
  return distribution_.build(cut, guard_, parameters_.alpha);
}

float HalflightSampler::brdf_share(const GBufferTexel& texel) const {
  const LightKinds& kinds = frame_.kinds;
  if (!kinds.met_by_rays() || !frame_.runs(Stage::traced_brdf_rays)) return 0;
  const Brdf& brdf = texel.brdf;
  float share = parameters_.brdf_share;
  if (is_mirror(brdf)) {
    share = 1;
  } else if (brdf.has_specular()) {
    const float specular = specular_probability(brdf, texel.basis(), texel.wo);
    share = std::max(share, std::min(parameters_.specular_share, specular));
  }
  return kinds.punctual ? std::min(share, most_share_beside_punctual) : share;
}

void HalflightSampler::render_group(TracedWorker& worker, std::span<const View> views) {
  allocations_.clear();
  const GBufferTexel& leader = *views.front().seen.texel;
  float share = brdf_share(leader);
  {
    const TickScope scope(worker.clock.distribution);
    drawable_ = share < 1 && build(leader);
  }
  if (!drawable_) share = share > 0 ? 1.0f : 0.0f;
  for (size_t begin = 0; begin < views.size();) {
    size_t end = begin + 1;
    while (end < views.size() && views[end].pixel == views[begin].pixel) ++end;
    for (int half = 0; half < 2; ++half)
      render_pixel(worker, views.subspan(begin, end - begin), share, half, random_[views[begin].place]);
    begin = end;
  }
  worker.trace_brdf_rays();
}

/// Shares BRDF rays and light samples out among a pixel's views: whole numbers whose means over a uniform
/// `phase` are the expected ones.
void HalflightSampler::share_out(std::span<const View> views, float share, int half, float phase) {
  uint32_t samples_before = 0, rays_before = 0, total = 0;
  for (size_t i = 0; i < views.size(); ++i) {
    samples_before += views[i].samples[half];
    const auto rays = static_cast<uint32_t>(share * static_cast<float>(samples_before) + phase);
    rays_[i] = std::min(rays - rays_before, views[i].samples[half]);
    rays_before += rays_[i];
    samples_[i] = drawable_ ? views[i].samples[half] - rays_[i] : 0;
    begin_[i] = total;
    total += samples_[i];
  }
  draws_.resize(total), dealt_.resize(total);
}

/// Light samples of all views, dealt in turn along the tree, so that each view's are spread over all light.
/// Whose turn is first is left to chance: what the views of a pixel see decides how many they are, and no
/// stratum may hang on that.
void HalflightSampler::draw_and_deal(size_t views, RandomStream& random) {
  if (draws_.empty()) return;
  distribution_.draw(lights_.drawn(), random, draws_);
  for (const LightSample& draw : draws_) prefetch_whole(lights_.light(draw.light));
  const size_t total = draws_.size();
  if (views == 1) return std::swap(draws_, dealt_);
  turns_.clear();
  for (uint32_t turn = 0; turns_.size() < total; ++turn)
    for (size_t i = 0; i < views; ++i)
      if (turn < samples_[i]) turns_.push_back(static_cast<uint8_t>(i));
  auto at = static_cast<size_t>(random.next() * static_cast<float>(total));
  std::array<uint32_t, PixelPositions::most> next = begin_;
  for (size_t j = 0; j < total; ++j, at = at + 1 == total ? 0 : at + 1)
    dealt_[next[turns_[at]]++] = draws_[j];
}

void HalflightSampler::render_pixel(TracedWorker& worker, std::span<const View> views, float share, int half,
                                    RandomStream& random) {
  if (split_samples(request_)[half] == 0) return;
  share_out(views, share, half, split_phase(frame_, views.front().pixel, request_.pass));
  draw_and_deal(views.size(), random);
  for (size_t i = 0; i < views.size(); ++i) draw_view(worker, views[i], i, share, half, random);
}

void HalflightSampler::draw_view(TracedWorker& worker, const View& view, size_t index, float share, int half,
                                 RandomStream& random) {
  const auto count = static_cast<float>(view.samples[half]);
  const float expected_rays = share * count, expected_samples = drawable_ ? count - expected_rays : 0.0f;
  std::array<uint32_t, 2> samples{};
  samples[half] = view.samples[half];
  if (samples[half] == 0) return;
  worker.open(view.pixel, view.seen, samples);
  for (const LightSample& draw :
       std::span<const LightSample>(dealt_).subspan(begin_[index], samples_[index])) {
    const float learned = lights_.learned_over_drawn(draw.light);
    batch_.add({&lights_.light(draw.light), draw.weight / learned, draw.cluster,
                lights_.met_by_rays(draw.light) ? expected_rays : 0.0f, learned});
    if (batch_.full()) connect(worker, half, expected_samples);
  }
  if (batch_.size > 0) connect(worker, half, expected_samples);
  if (rays_[index] > 0)
    worker.draw_brdf(
        half, rays_[index],
        allocations_.emplace_back(DrawAllocation::of_rays_and_samples(expected_rays, expected_samples)),
        {&lights_, drawable_ ? &distribution_ : nullptr}, random);
  worker.close();
}

void HalflightSampler::connect(TracedWorker& worker, int half, float expected_samples) {
  batch_.connect_beside_rays(*frame_.scene, worker.texel(), worker.basis(), GeometryTerm::exact,
                             expected_samples);
  for (size_t i = 0; i < batch_.size; ++i) {
    if (!(batch_.matters[i] > 0)) continue;
    VisibilityCount* count = nullptr;
    if (parameters_.visibility) {
      count = &counts_[batch_.drawn[i].tag];
      count = count->drawn < 0xffff ? count : nullptr;
      if (count) ++count->drawn;
    }
    worker.add_ray(shadow_ray(worker.origin(), batch_.wi(i), batch_.distance[i]), batch_.value(i), half,
                   count);
  }
  batch_.size = 0;
}

}  // namespace halflight
