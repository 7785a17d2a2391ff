// Cut × BRDF at one point a cluster: Wang & Åkerlund 2009, §3.3, "Single point sampling"; Akerlund et al.
// 2007.
//
// q̂_k = l_k Ω_k f(x, x_k) cos θ_k with the cluster's representative light x_k (mean position and normal); q =
// (1 − α) q̂/Σq̂ + α u, u_k ∝ Φ_k/(r_k² + R_k²); leaves ∝ Φ_i. Estimate: (1/N) Σ f cos θ L Ω V/P. Unbiased for
// the sum over S: the guard u keeps the clusters whose representative alone faces away or misses the lobe's
// peak. The BRDF is evaluated once a cluster.
#include "core/simd.h"
#include "lights/cut_importance.h"
#include "scene/brdf_batch.h"
#include "techniques/pixel_loop.h"

namespace halflight {

namespace {

constexpr std::array settings{
    SettingInfo{"single-point.alpha", 0.05, 0, 1, "share of draws that ignore the BRDF"},
};

/// The representatives from one point, as arrays over the cut.
struct Representatives {
  std::vector<float> x, y, z;           ///< directions in the BRDF's frame
  std::vector<float> arriving;          ///< l_k Ω_k
  std::vector<float> red, green, blue;  ///< f

  explicit Representatives(size_t count)
      : x(count), y(count), z(count), arriving(count), red(count), green(count), blue(count) {}
};

HALFLIGHT_SIMD_CLONES void see_representatives(const Cut& cut, Vec3 from, const Basis& basis,
                                               Representatives& out) {
  const float *centre_x = cut.centre_x.data(), *centre_y = cut.centre_y.data(),
              *centre_z = cut.centre_z.data();
  const float *normal_x = cut.normal_x.data(), *normal_y = cut.normal_y.data(),
              *normal_z = cut.normal_z.data();
  const float *power = cut.power.data(), *softening = cut.softening.data(), *local = cut.local.data(),
              *spread = cut.normal_spread.data();
  float *x = out.x.data(), *y = out.y.data(), *z = out.z.data(), *arriving = out.arriving.data();
  const Basis b = basis;
  const size_t count = cut.padded_size();
#pragma GCC ivdep
  for (size_t k = 0; k < count; ++k) {
    const float dx = centre_x[k] - from.x * local[k], dy = centre_y[k] - from.y * local[k],
                dz = centre_z[k] - from.z * local[k];
    const float length2 = dx * dx + dy * dy + dz * dz;
    const float r2 = length2 > 1e-36f ? length2 : 1e-36f;
    const float inverse_r = 1.0f / std::sqrt(r2);
    const float wx = dx * inverse_r, wy = dy * inverse_r, wz = dz * inverse_r;
    // Mean normals have the length 1 − spread; without a normal the cluster shines all round.
    const float faces = -(normal_x[k] * wx + normal_y[k] * wy + normal_z[k] * wz);
    const float front = faces > 0.0f ? faces : 0.0f;
    const float agreement = 1.0f - spread[k];
    const float cos_light = agreement > 0.0f ? front / agreement : 1.0f;
    x[k] = b.tangent.x * wx + b.tangent.y * wy + b.tangent.z * wz;
    y[k] = b.bitangent.x * wx + b.bitangent.y * wy + b.bitangent.z * wz;
    z[k] = b.normal.x * wx + b.normal.y * wy + b.normal.z * wz;
    const float above = z[k] > 0.0f ? z[k] : 0.0f;
    arriving[k] = above * (power[k] * cos_light / (r2 + softening[k] * cos_light));
  }
}

HALFLIGHT_SIMD_CLONES void multiply_luminance(const Representatives& in, std::span<float> importance) {
  const float *red = in.red.data(), *green = in.green.data(), *blue = in.blue.data(),
              *arriving = in.arriving.data();
  float* out = importance.data();
  const size_t count = importance.size();
#pragma GCC ivdep
  for (size_t k = 0; k < count; ++k) {
    const float f = 0.2126f * red[k] + 0.7152f * green[k] + 0.0722f * blue[k];
    out[k] = arriving[k] > 0.0f ? arriving[k] * f : 0.0f;
  }
}

class SinglePointSampler {
 public:
  SinglePointSampler(const Cut& cut, float alpha)
      : cut_(&cut), alpha_(alpha), seen_(cut.padded_size()), guard_(cut.padded_size()) {}

  bool begin_pixel(const GBufferTexel& texel, RandomStream&) {
    const Basis basis = texel.basis();
    see_representatives(*cut_, texel.position, basis, seen_);
    evaluate_batch(texel.brdf, basis.to_local(texel.wo),
                   {seen_.x.data(), seen_.y.data(), seen_.z.data(), seen_.red.data(), seen_.green.data(),
                    seen_.blue.data(), seen_.x.size()});
    multiply_luminance(seen_, distribution_.importance(*cut_));
    guard_importance(*cut_, texel.position, guard_);
    return distribution_.build(*cut_, guard_, alpha_);
  }
  void draw(RandomStream& random, std::span<LightSample> out) const {
    distribution_.draw(*cut_, random, out);
  }
  const CutDistribution& distribution() const { return distribution_; }
  const Cut& cut() const { return *cut_; }

 private:
  const Cut* cut_;
  float alpha_;
  Representatives seen_;
  std::vector<float> guard_;
  CutDistribution distribution_;
};

class SinglePoint final : public Technique {
 public:
  PassStats run_pass(const FrameView& frame, const PassRequest& request, Film& film) override {
    return run_sampler_pass<SinglePointSampler>(frame, request, film, [&] { return sampler(frame); });
  }

  std::optional<PixelInspection> inspect(const FrameView& frame, const PassRequest& request,
                                         uint32_t pixel) override {
    return inspect_sampler(sampler(frame), frame, request, pixel);
  }

 private:
  static SinglePointSampler sampler(const FrameView& frame) {
    return SinglePointSampler(*frame.cut, static_cast<float>(frame.settings->get("single-point.alpha")));
  }
};

}  // namespace

TechniqueInfo single_point_technique() {
  return {"single-point",
          "Cut × BRDF, one point a cluster",
          "Wang & Åkerlund 2009, §3.3",
          TargetSupport::both,
          Bias::unbiased,
          settings,
          []() -> std::unique_ptr<Technique> { return std::make_unique<SinglePoint>(); },
          "unbiased for the sum over S",
          reads_cut};
}

}  // namespace halflight
