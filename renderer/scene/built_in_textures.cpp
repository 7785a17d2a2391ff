#include "scene/built_in_textures.h"

#include <array>
#include <functional>

#include "core/parallel.h"
#include "core/random.h"
#include "scene/mesh_builder.h"

namespace halflight {

namespace {

/// sRGB code of linear 0..1 in 4096 steps (IEC 61966-2-1).
const std::array<uint8_t, 4096>& srgb_codes() {
  static const std::array<uint8_t, 4096> codes = [] {
    std::array<uint8_t, 4096> table{};
    for (int i = 0; i < 4096; ++i) {
      const float x = static_cast<float>(i) / 4095;
      const float y = x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f;
      table[i] = static_cast<uint8_t>(std::lround(255 * y));
    }
    return table;
  }();
  return codes;
}

/// Fills an image with `color(uv)` at texel centres, v downwards.
ImageRgba8 paint(int width, int height, const std::function<Vec3(Vec2)>& color) {
  ImageRgba8 image;
  image.width = width, image.height = height;
  image.bytes.resize(size_t{4} * width * height);
  const auto& codes = srgb_codes();
  parallel_for(0, static_cast<size_t>(height), 16, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y)
      for (int x = 0; x < width; ++x) {
        const Vec3 c = glm::clamp(color({(x + 0.5f) / width, (y + 0.5f) / height}), Vec3(0), Vec3(1));
        uint8_t* texel = &image.bytes[4 * (y * width + x)];
        for (int k = 0; k < 3; ++k) texel[k] = codes[static_cast<int>(c[k] * 4095 + 0.5f)];
        texel[3] = 255;
      }
  });
  return image;
}

float hash_unit(uint64_t a, uint64_t b) {
  return to_unit_float(static_cast<uint32_t>(hash_combine(a, b) >> 32));
}

float fraction(float x) { return x - std::floor(x); }

/// 1 inside |x| < width, 0 outside, soft over `soft`.
float line(float x, float width, float soft) {
  return 1 - glm::smoothstep(width - soft, width + soft, std::abs(x));
}

/// Grain along v, 0 (early wood) to 1 (late wood): stretched noise bent into rings, and pores.
float grain(Vec2 uv, int across, uint32_t seed) {
  const float bend = 0.5f * fractal_noise({2 * uv.x, 2 * uv.y}, 3, 2, seed);
  const float rings = 0.5f + 0.5f * std::sin(2 * pi * (across * uv.x + 1.6f * bend));
  const float fibre = fractal_noise({64 * uv.x, 2 * uv.y}, 2, 64, seed + 7);
  const float pore = fractal_noise({128 * uv.x, 8 * uv.y}, 1, 128, seed + 11);
  return glm::clamp(0.15f + 0.45f * rings * rings + 0.3f * fibre + 0.35f * std::max(0.0f, pore), 0.0f, 1.0f);
}

}  // namespace

ImageRgba8 board_texture(int size, int boards, Vec3 light, Vec3 dark, uint32_t seed) {
  return paint(size, size, [=](Vec2 uv) {
    const float across = uv.x * boards;
    const int board = static_cast<int>(across);
    // Every board is cut once or twice along the way, at a place of its own.
    const float start = hash_unit(seed, board), along = fraction(uv.y + start);
    const float cut = 0.35f + 0.3f * hash_unit(seed + 1, board);
    const int piece = 2 * board + (along < cut ? 0 : 1);
    const float shade = hash_unit(seed + 2, piece);
    const float figure =
        grain({uv.x + hash_unit(seed + 3, piece), uv.y + hash_unit(seed + 4, piece)}, 14, seed);
    const float joint_x = std::min(fraction(across), 1 - fraction(across)) / boards;
    const float joint_y = std::min({along, std::abs(along - cut), 1 - along});
    const float joint = line(std::min(joint_x, joint_y), 0.0012f, 0.0008f);
    const Vec3 wood = glm::mix(light, dark, glm::clamp(0.5f * figure + 0.55f * shade - 0.05f, 0.0f, 1.0f));
    return wood * (1 - 0.75f * joint);
  });
}

ImageRgba8 grain_texture(int size, Vec3 light, Vec3 dark, uint32_t seed) {
  return paint(size, size, [=](Vec2 uv) { return glm::mix(light, dark, grain(uv, 6, seed)); });
}

ImageRgba8 weave_texture(int size, int threads, float contrast, uint32_t seed) {
  return paint(size, size, [=](Vec2 uv) {
    const Vec2 t = static_cast<float>(threads) * uv;
    const int i = static_cast<int>(t.x), j = static_cast<int>(t.y);
    const bool warp = (i + j) % 2 == 0;
    // A thread is a half cylinder that dives under its neighbours at both ends of the visible stitch.
    const float across = std::sin(pi * fraction(warp ? t.x : t.y)),
                along = std::sin(pi * fraction(warp ? t.y : t.x));
    const float shade = hash_unit(seed + (warp ? 1 : 2), warp ? i : j) - 0.5f;
    const float slub = fractal_noise({8 * uv.x, 8 * uv.y}, 3, 8, seed);
    return Vec3(1 - contrast * (1 - std::sqrt(across * along)) + 0.35f * contrast * shade +
                0.2f * contrast * slub - 0.15f * contrast);
  });
}

ImageRgba8 rug_texture(int width, int height, Vec3 ground, Vec3 figure, Vec3 accent, uint32_t seed) {
  const float aspect = static_cast<float>(height) / width;
  return paint(width, height, [=](Vec2 uv) {
    // Knots: colours are constant over little cells.
    const float knots = 128;
    const Vec2 p = (glm::floor(Vec2(uv.x, uv.y * aspect) * knots) + 0.5f) / knots;
    const Vec2 centre(0.5f, 0.5f * aspect);
    const Vec2 q = glm::abs(p - centre);
    const float edge = std::min(centre.x - q.x, centre.y - q.y);
    const float run = centre.x - q.x < centre.y - q.y ? p.y : p.x;
    const float diamond = q.x / 0.30f + q.y / (0.34f * aspect);
    const float small = std::abs(fraction(p.x * 8) - 0.5f) + std::abs(fraction(p.y * 8) - 0.5f);

    Vec3 color = ground;
    if (edge < 0.018f)
      color = figure * 0.6f;
    else if (edge < 0.030f)
      color = accent;
    else if (edge < 0.095f) {
      const float zigzag = std::abs(fraction(run * 12) - 0.5f) * 2;
      color = std::abs((edge - 0.030f) / 0.065f - zigzag) < 0.28f ? accent : figure;
    } else if (edge < 0.108f)
      color = accent;
    else if (diamond < 0.22f)
      color = accent;
    else if (diamond < 0.30f)
      color = figure;
    else if (diamond < 0.80f)
      color = fraction(diamond * 8) < 0.35f ? accent * 0.85f : ground;
    else if (diamond < 1.0f)
      color = fraction(diamond * 12) < 0.5f ? figure : glm::mix(figure, ground, 0.4f);
    else if (small < 0.16f)
      color = figure;
    else if (small < 0.24f)
      color = accent;
    // Wool dyed in lots: each row of knots a little different, and wear.
    const float lot = hash_unit(seed, static_cast<uint64_t>(p.y * knots)) - 0.5f;
    const float wear = fractal_noise({5 * uv.x, 5 * uv.y}, 4, 5, seed);
    const float knot =
        hash_unit(seed + 5, static_cast<uint64_t>(p.x * knots) * 4096 + static_cast<uint64_t>(p.y * knots));
    return color * (0.94f + 0.16f * lot + 0.16f * wear + 0.16f * (knot - 0.5f));
  });
}

ImageRgba8 landscape_texture(int size, Vec3 sky, Vec3 land, Vec3 sun, uint32_t seed) {
  return paint(size, size, [=](Vec2 uv) {
    Vec3 color = glm::mix(sky, glm::mix(sky, Vec3(0.85f, 0.78f, 0.66f), 0.7f), uv.y * 1.6f);
    const float disk = glm::length((uv - Vec2(0.64f, 0.34f)) * Vec2(1, 1));
    color = glm::mix(sun, color, glm::smoothstep(0.125f, 0.13f, disk));
    for (int ridge = 0; ridge < 5; ++ridge) {
      const float far = 1 - ridge / 4.0f;
      const float height =
          0.46f + 0.11f * ridge + 0.06f * fractal_noise({uv.x * 3 + ridge * 0.37f, 0.5f}, 4, 3, seed + ridge);
      const Vec3 tone = glm::mix(land, glm::mix(sky, land, 0.35f), far);
      color = glm::mix(color, tone, glm::smoothstep(height - 0.003f, height + 0.003f, uv.y));
    }
    return color * (1 + 0.08f * fractal_noise(uv * 40.0f, 3, 40, seed + 50));
  });
}

ImageRgba8 botanical_texture(int size, Vec3 paper, Vec3 leaf, uint32_t seed) {
  return paint(size, size, [=](Vec2 uv) {
    Vec3 color = paper * (1 + 0.03f * fractal_noise(uv * 24.0f, 3, 24, seed));
    const auto stem_x = [](float y) { return 0.5f + 0.06f * std::sin(4 * y); };
    if (uv.y > 0.14f && uv.y < 0.9f)
      color = glm::mix(color, leaf * 0.8f, line(uv.x - stem_x(uv.y), 0.006f, 0.003f));
    for (int i = 0; i < 11; ++i) {
      // Pairs of leaves, shorter towards the tip: an ellipse about a slanted axis with a pale vein.
      const float y = 0.16f + 0.062f * i, side = i == 0 ? 0.0f : (i % 2 == 0 ? 1.0f : -1.0f);
      const float length = 0.10f + 0.013f * i, slant = side * (1.0f + 0.02f * i);
      const Vec2 axis(std::sin(slant), -std::cos(slant));
      const Vec2 from = uv - Vec2(stem_x(y), y + 0.03f);
      const float along = glm::dot(from, axis) / length,
                  across = (from.x * axis.y - from.y * axis.x) / length;
      const float half_width = 0.30f * std::sin(pi * glm::clamp(along, 0.0f, 1.0f));
      if (along <= 0 || along >= 1 || std::abs(across) > half_width) continue;
      const Vec3 tone = leaf * (0.75f + 0.5f * hash_unit(seed, i) + 0.25f * across / 0.3f);
      color = glm::mix(tone, glm::mix(tone, paper, 0.5f), line(across, 0.012f, 0.01f));
    }
    return color;
  });
}

ImageRgba8 checker_texture(int size, int tiles, Vec3 light, Vec3 dark, uint32_t seed) {
  return paint(size, size, [=](Vec2 uv) {
    const Vec2 t = uv * static_cast<float>(tiles);
    const int i = static_cast<int>(t.x), j = static_cast<int>(t.y);
    const Vec2 edge = glm::min(glm::fract(t), 1.0f - glm::fract(t));
    const auto tile = static_cast<uint64_t>(i * tiles + j);
    const float warp = fractal_noise(uv * 8.0f, 3, 8, seed) + 5 * hash_unit(seed, tile);
    const float vein = line(std::sin(2 * pi * (2 * uv.x + 3 * uv.y + 0.8f * warp)), 0.05f, 0.05f);
    const float cloud = fractal_noise(uv * 16.0f, 3, 16, seed + 9);
    const bool pale = (i + j) % 2 == 0;
    Vec3 color = (pale ? light : dark) * (0.9f + 0.2f * hash_unit(seed + 1, tile) + 0.15f * cloud);
    color = glm::mix(color, pale ? light * 0.7f : glm::mix(dark, light, 0.4f), 0.5f * vein);
    return color * (1 - 0.6f * line(std::min(edge.x, edge.y), 0.012f, 0.006f));
  });
}

ImageRgba8 encoded(const ImageRgb& picture) {
  const Vec2 size(picture.width, picture.height);
  return paint(picture.width, picture.height, [&](Vec2 uv) {
    const Vec2 texel = uv * size;
    return picture.at(static_cast<int>(texel.x), static_cast<int>(texel.y));
  });
}

}  // namespace halflight
