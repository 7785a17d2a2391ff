#include "techniques/pixel_loop.h"

namespace halflight {

namespace {

/// Every second bit of a Morton code.
uint32_t compact_bits(uint32_t code) {
  code &= 0x55;
  code = (code | code >> 1) & 0x33;
  return (code | code >> 2) & 0x0f;
}

}  // namespace

std::array<uint32_t, 2> split_samples(const PassRequest& request) {
  return split_samples(request, request.samples);
}

std::array<uint32_t, 2> split_samples(const PassRequest& request, uint32_t samples) {
  const uint32_t n = std::max(samples, 1u);
  if (request.half) return *request.half == 0 ? std::array{n, 0u} : std::array{0u, n};
  if (n == 1) return request.pass % 2 == 0 ? std::array{1u, 0u} : std::array{0u, 1u};
  return {n - n / 2, n / 2};
}

RandomStream pixel_stream(const FrameView& frame, const PassRequest& request, uint32_t pixel) {
  return RandomStream(pixel, request.pass, frame.seed);
}

RandomStream distribution_stream(const FrameView& frame, const PassRequest& request, uint32_t pixel) {
  return RandomStream(pixel, request.pass, hash_combine(frame.seed, 0x6469737472696275ull));
}

PointGroup PixelGroups::points_of(glm::uvec2 block) const {
  const uint32_t width = static_cast<uint32_t>(gbuffer_->width),
                 height = static_cast<uint32_t>(gbuffer_->height);
  PointGroup points;
  for (uint32_t y = block.y * side; y < std::min((block.y + 1) * side, height); ++y)
    for (uint32_t x = block.x * side; x < std::min((block.x + 1) * side, width); ++x)
      if (const GBufferTexel& texel = gbuffer_->texels[y * width + x]; reflects(texel))
        points.add(texel.position, texel.geometric_normal);
  return points;
}

PixelWorker::PixelWorker(const FrameView& frame, const PassRequest& request, Film& film, bool exhaustive)
    : frame_(frame), request_(request), film_(film), exhaustive_(exhaustive), term_(frame.geometry_term()) {
  rays_.resize(most_rays);
  waiting_.resize(most_rays);
}

void PixelWorker::open(uint32_t pixel) {
  ++stats_.pixels;
  texel_ = &frame_.gbuffer->texels[pixel];
  basis_ = texel_->basis();
  origin_ = RayOrigin(*frame_.scene, texel_->position, texel_->geometric_normal);
  open_[open_count_] = opened(pixel);
}

void PixelWorker::pass_by(uint32_t pixel) {
  ++stats_.pixels;
  add_to_film(opened(pixel));
}

PixelWorker::OpenPixel PixelWorker::opened(uint32_t pixel) {
  return {pixel, split_samples(request_, request_.samples_at(pixel)), {}};
}

void PixelWorker::connect() {
  batch_.connect(*frame_.scene, *texel_, basis_, term_);
  for (size_t i = 0; i < batch_.size; ++i) {
    // Written in any case and kept where it matters: which do is too hard to guess for a branch.
    rays_[ray_count_] = shadow_ray_in_front(origin_, batch_.wi(i), batch_.distance[i]);
    waiting_[ray_count_] = {batch_.value(i), batch_.drawn[i].tag};
    ray_count_ += batch_.matters[i] > 0 ? 1 : 0;
  }
  batch_.size = 0;
  if (ray_count_ + ConnectionBatch::capacity > most_rays) trace();
}

void PixelWorker::end_draws() {
  if (batch_.size > 0) connect();
}

void PixelWorker::close() {
  ++open_count_;
  if (ray_count_ >= enough_rays || open_count_ == most_pixels) finish();
}

void PixelWorker::trace() {
  const std::span<ShadowRay> rays(rays_.data(), ray_count_);
  stats_.useful_rays += rays.size();
  if (request_.watch_rays) request_.watch_rays(rays);
  {
    const TickScope scope(clock.visibility);
    frame_.rays->occluded(rays, frame_.alpha_seed, stats_.rays);
  }
  for (size_t i = 0; i < rays.size(); ++i)
    if (!rays[i].blocked()) open_[waiting_[i].slot / 2].sum[waiting_[i].slot % 2] += waiting_[i].value;
  ray_count_ = 0;
}

void PixelWorker::finish() {
  if (ray_count_ > 0) trace();
  const TickScope scope(clock.resolve);
  for (uint32_t i = 0; i < open_count_; ++i) add_to_film(open_[i]);
  open_count_ = 0;
}

void PixelWorker::add_to_film(const OpenPixel& pixel) {
  const Vec3 base = frame_.base ? (*frame_.base)[pixel.index] : Vec3(0);
  const Vec3d throughput(frame_.gbuffer->texels[pixel.index].throughput);
  for (int half = 0; half < 2; ++half) {
    if (pixel.samples[half] == 0) continue;
    const Vec3d mean =
        exhaustive_ ? pixel.sum[0] : pixel.sum[half] / static_cast<double>(pixel.samples[half]);
    film_.add(pixel.index, half, base + Vec3(throughput * mean), pixel.samples[half]);
  }
}

TileGrid::TileGrid(const GBuffer& gbuffer, const PassRequest& request)
    : request_(request),
      width_(static_cast<uint32_t>(gbuffer.width)),
      height_(static_cast<uint32_t>(gbuffer.height)),
      stride_(request.stride),
      offset_x_(request.offset % request.stride),
      offset_y_(request.offset / request.stride) {
  const auto tiles = [&](uint32_t size, uint32_t offset) {
    const uint32_t pixels = size > offset ? (size - offset + stride_ - 1) / stride_ : 0;
    return (pixels + side - 1) / side;
  };
  columns_ = tiles(width_, offset_x_);
  rows_ = tiles(height_, offset_y_);
}

uint32_t TileGrid::pixels(uint32_t tile, std::array<uint32_t, side * side>& out) const {
  const uint32_t column = tile % columns_, row = tile / columns_;
  uint32_t count = 0;
  for (uint32_t code = 0; code < side * side; ++code) {
    const uint32_t x = (column * side + compact_bits(code)) * stride_ + offset_x_;
    const uint32_t y = (row * side + compact_bits(code >> 1)) * stride_ + offset_y_;
    if (x < width_ && y < height_ && request_.samples_pixel(y * width_ + x)) out[count++] = y * width_ + x;
  }
  return count;
}

}  // namespace halflight
