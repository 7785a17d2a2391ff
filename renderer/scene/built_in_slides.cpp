#include "scene/built_in_slides.h"

#include <array>
#include <functional>

#include "core/parallel.h"
#include "core/random.h"
#include "scene/mesh_builder.h"

namespace halflight {

namespace {

/// Glasses, each with one channel far above the rest: ruby, sapphire, amber, emerald, sky, rose.
constexpr std::array<Vec3, 6> glass{{{1.00f, 0.07f, 0.04f},
                                     {0.06f, 0.17f, 1.00f},
                                     {1.00f, 0.50f, 0.07f},
                                     {0.08f, 0.75f, 0.22f},
                                     {0.14f, 0.38f, 0.95f},
                                     {0.85f, 0.22f, 0.18f}}};

/// Fills a slide with `color(p)`, p in [−1, 1]², y up, the mean of 2 × 2 places a texel.
ImageRgb paint_slide(int size, const std::function<Vec3(Vec2)>& color) {
  ImageRgb slide(size, size);
  parallel_for(0, static_cast<size_t>(size), 16, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y)
      for (int x = 0; x < size; ++x)
        for (const Vec2 shift :
             {Vec2(0.25f, 0.25f), Vec2(0.75f, 0.25f), Vec2(0.25f, 0.75f), Vec2(0.75f, 0.75f)}) {
          const Vec2 uv = (Vec2(x, static_cast<float>(y)) + shift) / static_cast<float>(size);
          slide.at(x, static_cast<int>(y)) += 0.25f * color({2 * uv.x - 1, 1 - 2 * uv.y});
        }
  });
  return slide;
}

float hash_unit(uint64_t a, uint64_t b) {
  return to_unit_float(static_cast<uint32_t>(hash_combine(a, b) >> 32));
}

float fraction(float x) { return x - std::floor(x); }

/// One of the glasses, each piece of it a little thicker or thinner.
Vec3 glass_piece(int color, uint64_t piece) {
  return glass[static_cast<size_t>(color) % glass.size()] * (0.7f + 0.3f * hash_unit(77, piece));
}

}  // namespace

ImageRgb rose_window_slide(int size) {
  return paint_slide(size, [](Vec2 p) {
    const float r = glm::length(p), turn = fraction(std::atan2(p.y, p.x) / (2 * pi));
    const float lead = 0.016f;
    if (r > 0.97f) return Vec3(0);
    // Rings of glass from the middle outwards: where they end, how many pieces, two colours in turn.
    struct Ring {
      float end;
      int pieces, first, second;
      float shift;
    };
    constexpr std::array<Ring, 5> rings{{{0.20f, 6, 2, 5, 0},
                                         {0.50f, 12, 0, 4, 0},
                                         {0.60f, 36, 2, 2, 0.5f},
                                         {0.86f, 24, 1, 3, 0.5f},
                                         {0.97f, 48, 0, 2, 0}}};
    float start = 0;
    for (size_t k = 0; k < rings.size(); start = rings[k++].end) {
      const Ring& ring = rings[k];
      if (r > ring.end) continue;
      const float across = turn * ring.pieces + ring.shift, arc = 2 * pi * r / ring.pieces;
      const int piece = static_cast<int>(across) % ring.pieces;
      const float beside = std::min(fraction(across), 1 - fraction(across)) * arc;
      if (std::min({beside, r - start + (k == 0 ? lead : 0), ring.end - r}) < 0.5f * lead) return Vec3(0.01f);
      // Petals: a disc of another glass in the wide end of each piece.
      const float wide = 2 * pi * ring.end / ring.pieces;
      const Vec2 disc(std::abs(fraction(across) - 0.5f) * arc, ring.end - 0.5f * wide - r);
      const float from_disc = glm::length(disc) - 0.36f * wide;
      if ((k == 1 || k == 3) && std::abs(from_disc) < 0.4f * lead) return Vec3(0.01f);
      const bool inside = (k == 1 || k == 3) && from_disc < 0;
      return glass_piece(inside      ? 5 - static_cast<int>(k) / 3 * 3
                         : piece % 2 ? ring.first
                                     : ring.second,
                         100 * k + piece);
    }
    return Vec3(0);
  });
}

ImageRgb sunset_window_slide(int size, float sun) {
  return paint_slide(size, [sun](Vec2 p) {
    const Vec2 half(0.66f, 0.70f);
    if (std::abs(p.x) > half.x || std::abs(p.y) > half.y) return Vec3(0);
    const Vec2 pane = (p / half * 0.5f + 0.5f) * Vec2(4, 3);
    const Vec2 edge = glm::min(glm::fract(pane), 1.0f - glm::fract(pane)) * 2.0f * half / Vec2(4, 3);
    if (std::min(edge.x, edge.y) < 0.022f) return Vec3(0);
    const float height = p.y / half.y;
    const float ridge = -0.42f + 0.10f * fractal_noise({1.6f * p.x + 3, 0.5f}, 3, 8, 5);
    if (height < ridge) return Vec3(0.055f, 0.030f, 0.034f) * (1 + 0.7f * (ridge - height));
    const float up = glm::clamp((height - ridge) / 1.4f, 0.0f, 1.0f);
    Vec3 sky =
        glm::mix(Vec3(1.0f, 0.36f, 0.10f), Vec3(0.13f, 0.24f, 0.60f), glm::smoothstep(0.0f, 0.75f, up));
    const float cloud = fractal_noise({2.5f * p.x + 4, 9 * p.y + 40}, 4, 64, 11);
    sky = glm::mix(sky, Vec3(1.25f, 0.42f, 0.22f), 0.75f * glm::smoothstep(0.05f, 0.5f, cloud));
    const float away = glm::length(p - Vec2(0.15f, -0.06f));
    sky += Vec3(1.3f, 0.6f, 0.2f) * std::exp(-away * away / 0.03f);
    return away < 0.085f ? sun * Vec3(1.0f, 0.72f, 0.38f) : sky;
  });
}

ImageRgb lancet_slide(int size, int hue) {
  return paint_slide(size, [hue](Vec2 p) {
    // A pointed arch of two circles about the springing points on a rectangle, half as wide as high.
    const float half = 0.48f, spring = 0.14f, lead = 0.018f;
    const float rim = p.y > spring ? 2 * half - glm::length(Vec2(std::abs(p.x) + half, p.y - spring))
                                   : std::min(half - std::abs(p.x), p.y + 0.97f);
    if (rim < 0) return Vec3(0);
    if (rim < lead || std::abs(rim - 0.09f) < 0.5f * lead) return Vec3(0.01f);
    const auto color = [&](int k) { return k + hue; };
    if (rim < 0.09f) {
      const float along = fraction(7 * p.y);
      if (along < 0.12f) return Vec3(0.01f);
      return glass_piece(color(static_cast<int>(std::floor(7 * p.y)) + 20),
                         static_cast<uint64_t>(50 + 7 * p.y));
    }
    const Vec2 lattice(4.6f * p.x + 2.3f * p.y + 16.5f, -4.6f * p.x + 2.3f * p.y + 16.5f);
    const Vec2 cell = glm::floor(lattice), in = glm::fract(lattice);
    const float edge = std::min({in.x, in.y, 1 - in.x, 1 - in.y});
    if (edge < 0.05f) return Vec3(0.01f);
    const auto piece = static_cast<uint64_t>(cell.x * 64 + cell.y);
    const int pick = static_cast<int>(3 * hash_unit(5 + static_cast<uint64_t>(hue), piece));
    return glass_piece(color(pick == 0   ? 1
                             : pick == 1 ? 4
                                         : 1 + static_cast<int>(cell.x + cell.y) % 2),
                       piece);
  });
}

}  // namespace halflight
