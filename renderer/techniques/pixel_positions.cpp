#include "techniques/pixel_positions.h"

#include "core/random.h"
#include "trace/ray_gbuffer.h"

namespace halflight {

PixelPositions::PixelPositions(const FrameView& frame, uint32_t round, uint32_t positions)
    : frame_(frame),
      round_(round),
      positions_(frame.camera && frame.runs(Stage::antialiasing) ? std::clamp(positions, 1u, most) : 1) {}

/// The R2 sequence (Roberts 2018), moved by a shift of the pixel's own.
Vec2 PixelPositions::place(uint32_t pixel, uint32_t position) const {
  const uint64_t shift = hash_combine(hash_combine(frame_.seed, 0x706f736974696f6eull), pixel);
  const uint32_t n = round_ * (most - 1) + position;
  return {to_unit_float(static_cast<uint32_t>(shift) + n * 0xc13fa9a9u),
          to_unit_float(static_cast<uint32_t>(shift >> 32) + n * 0x91e10da5u)};
}

void PixelPositions::look(std::span<const uint32_t> pixels, RayCounters& counters) {
  pixels_ = pixels;
  const uint32_t more = positions_ - 1;
  if (more == 0) return;
  const auto width = static_cast<uint32_t>(frame_.gbuffer->width);
  const CameraRays camera_rays(*frame_.camera, frame_.gbuffer->width, frame_.gbuffer->height);
  rays_.clear();
  for (const uint32_t pixel : pixels)
    for (uint32_t position = 1; position < positions_; ++position)
      rays_.push_back(
          closest_ray(camera_rays.through(Vec2(pixel % width, pixel / width) + place(pixel, position))));
  texels_.resize(rays_.size());
  trace_texels(*frame_.rays, rays_, frame_.alpha_seed, texels_, counters);
  base_.assign(texels_.size(), Vec3(0));
  if (frame_.base_has_emission)
    for (size_t i = 0; i < base_.size(); ++i) base_[i] = texels_[i].emission * texels_[i].throughput;
  if (frame_.base_has_punctual)
    add_punctual_by_rays(*frame_.rays, texels_, frame_.alpha_seed, base_, counters);
}

SeenTexel PixelPositions::at(size_t i, uint32_t position) const {
  if (position == 0) {
    const uint32_t pixel = pixels_[i];
    return {&frame_.gbuffer->texels[pixel], frame_.base ? (*frame_.base)[pixel] : Vec3(0)};
  }
  const size_t slot = i * (positions_ - 1) + position - 1;
  return {&texels_[slot], base_[slot]};
}

}  // namespace halflight
