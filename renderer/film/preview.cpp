#include "film/preview.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/parallel.h"

namespace halflight {

namespace {

constexpr float least_albedo = 0.02f;  ///< what is darker is not divided by
constexpr int smoothing_radius = 2;    ///< in steps of the lattice

/// A pixel's surface, and the light that reaches it over all directions.
struct Anchor {
  Vec3 position{0};
  uint32_t material = 0;
  Vec3 normal{0};
  bool lit = false;  ///< whether it reflects any
  Vec3 light{0};
};

struct Lattice {
  int stride = 1, columns = 0, rows = 0;
  std::vector<Anchor> anchors;

  const Anchor& at(int column, int row) const { return anchors[static_cast<size_t>(row) * columns + column]; }
};

Vec3 albedo_of(const GBufferTexel& texel) {
  return glm::max(bounce_albedo(texel.brdf) * texel.throughput, Vec3(least_albedo));
}

Anchor surface_of(const GBufferTexel& texel) {
  return {texel.position, texel.material, texel.shading_normal, texel.hit() && !texel.brdf.black(), Vec3(0)};
}

bool lattice_is_sampled(const Film& film, int stride) {
  for (int y = 0; y < film.height(); y += stride)
    for (int x = 0; x < film.width(); x += stride)
      if (film.samples(static_cast<uint32_t>(y * film.width() + x)) == 0) return false;
  return true;
}

/// How far the light of one place may stand for that of another, in [0, 1]: on one plane, facing the same
/// way.
float likeness(const Anchor& a, const Anchor& b) {
  constexpr float most_off_plane = 0.1f, other_material = 0.25f;
  if (!b.lit) return 0;
  const float facing = glm::dot(a.normal, b.normal);
  if (!(facing > 0)) return 0;
  const Vec3 apart = b.position - a.position;
  const float distance2 = glm::dot(apart, apart), off = glm::dot(apart, a.normal);
  const float off_plane = distance2 > 0 ? off * off / (distance2 * most_off_plane * most_off_plane) : 0.0f;
  const float facing4 = facing * facing * facing * facing;
  return facing4 * facing4 / (1 + off_plane * off_plane) * (a.material == b.material ? 1.0f : other_material);
}

Lattice sampled_lattice(const Film& film, const GBuffer& gbuffer, const std::vector<Vec3>& base, int stride) {
  Lattice lattice{stride, (film.width() + stride - 1) / stride, (film.height() + stride - 1) / stride, {}};
  lattice.anchors.resize(static_cast<size_t>(lattice.columns) * static_cast<size_t>(lattice.rows));
  parallel_for(0, static_cast<size_t>(lattice.rows), 8, [&](size_t begin, size_t end) {
    for (size_t row = begin; row < end; ++row)
      for (int column = 0; column < lattice.columns; ++column) {
        const auto pixel =
            static_cast<uint32_t>(static_cast<int>(row) * stride * film.width() + column * stride);
        const GBufferTexel& texel = gbuffer.texels[pixel];
        Anchor& anchor = lattice.anchors[row * lattice.columns + column];
        anchor = surface_of(texel);
        if (anchor.lit) anchor.light = (film.radiance(pixel) - base[pixel]) / albedo_of(texel);
      }
  });
  return lattice;
}

/// Each anchor's light from those around it.
Lattice smoothed(const Lattice& lattice) {
  Lattice result = lattice;
  parallel_for(0, static_cast<size_t>(lattice.rows), 4, [&](size_t begin, size_t end) {
    for (int row = static_cast<int>(begin); row < static_cast<int>(end); ++row)
      for (int column = 0; column < lattice.columns; ++column) {
        Anchor& anchor = result.anchors[static_cast<size_t>(row) * lattice.columns + column];
        if (!anchor.lit) continue;
        Vec3 sum(0);
        float total = 0;
        for (int j = std::max(0, row - smoothing_radius);
             j <= std::min(lattice.rows - 1, row + smoothing_radius); ++j)
          for (int i = std::max(0, column - smoothing_radius);
               i <= std::min(lattice.columns - 1, column + smoothing_radius); ++i) {
            const float apart2 = static_cast<float>((i - column) * (i - column) + (j - row) * (j - row));
            const Anchor& other = lattice.at(i, j);
            const float weight = likeness(anchor, other) / (1 + apart2);
            sum += weight * other.light, total += weight;
          }
        if (total > 0) anchor.light = sum / total;
      }
  });
  return result;
}

/// Light at a pixel from the four anchors around it: bilinear over those alike, and where none is, over all
/// that reflect.
Vec3 interpolated(const Lattice& lattice, const Anchor& here, int x, int y) {
  constexpr float least_weight = 1e-3f;
  const int column = x / lattice.stride, row = y / lattice.stride;
  const float u = static_cast<float>(x % lattice.stride) / static_cast<float>(lattice.stride),
              v = static_cast<float>(y % lattice.stride) / static_cast<float>(lattice.stride);
  Vec3 sum(0), any(0);
  float total = 0, total_any = 0;
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const Anchor& anchor =
          lattice.at(std::min(column + i, lattice.columns - 1), std::min(row + j, lattice.rows - 1));
      // No anchor goes without a share: the one alike may be the farthest.
      const float share = (i == 0 ? 1 - u : u) * (j == 0 ? 1 - v : v) + 0.01f;
      const float weight = share * likeness(here, anchor);
      sum += weight * anchor.light, total += weight;
      if (anchor.lit) any += share * anchor.light, total_any += share;
    }
  if (total > least_weight) return sum / total;
  return total_any > 0 ? any / total_any : Vec3(0);
}

}  // namespace

ImageRgb preview_picture(const Film& film, const GBuffer& gbuffer, const std::vector<Vec3>& base) {
  if (lattice_is_sampled(film, 1)) return film.image();
  const size_t pixels = static_cast<size_t>(film.width()) * static_cast<size_t>(film.height());
  const int stride = lattice_is_sampled(film, 2) ? 2 : 4;
  if (gbuffer.width != film.width() || gbuffer.height != film.height() || base.size() != pixels ||
      !lattice_is_sampled(film, stride))
    return film.preview();
  const Lattice lattice = smoothed(sampled_lattice(film, gbuffer, base, stride));
  ImageRgb image(film.width(), film.height());
  parallel_for(0, static_cast<size_t>(film.height()), 8, [&](size_t begin, size_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
      for (int x = 0; x < film.width(); ++x) {
        const size_t pixel = static_cast<size_t>(y) * film.width() + x;
        const GBufferTexel& texel = gbuffer.texels[pixel];
        const Anchor here = surface_of(texel);
        image.pixels[pixel] = base[pixel];
        if (here.lit) image.pixels[pixel] += albedo_of(texel) * interpolated(lattice, here, x, y);
      }
  });
  return image;
}

ImageRgb resized(const ImageRgb& image, int width, int height) {
  // The two pixels around a place of the result, and how far the second counts.
  struct Between {
    int first, second;
    float share;
  };
  const auto between = [](int i, int from, int to) {
    const float place =
        (static_cast<float>(i) + 0.5f) * static_cast<float>(from) / static_cast<float>(to) - 0.5f;
    const float clamped = std::clamp(place, 0.0f, static_cast<float>(from - 1));
    const int first = static_cast<int>(clamped);
    return Between{first, std::min(first + 1, from - 1), clamped - static_cast<float>(first)};
  };
  ImageRgb result(width, height);
  if (image.width <= 0 || image.height <= 0) return result;
  parallel_for(0, static_cast<size_t>(height), 16, [&](size_t begin, size_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      const Between row = between(y, image.height, height);
      for (int x = 0; x < width; ++x) {
        const Between column = between(x, image.width, width);
        const Vec3 above =
            glm::mix(image.at(column.first, row.first), image.at(column.second, row.first), column.share);
        const Vec3 below =
            glm::mix(image.at(column.first, row.second), image.at(column.second, row.second), column.share);
        result.at(x, y) = glm::mix(above, below, row.share);
      }
    }
  });
  return result;
}

}  // namespace halflight
