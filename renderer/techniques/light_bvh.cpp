// Walking the light tree: Conty Estevez & Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree
// Splitting", without the splitting.
//
// Each sample goes from the root to a leaf, at every node in proportion to the children's importance: power,
// distance, and the greatest cosines at light and point that the node's sphere and cone of normals allow
// (techniques/light_walk.h has the formula and how P stays exact). Their tree is binary; here four children
// are weighed at a time. Estimate: (1/N) Σ f cos θ L Ω V/P, P(i) the product of the branches' probabilities.
// Unbiased for the sum over S: every lit leaf has P > 0. Knows place and cosines, not the lobe.
#include "techniques/inspect_leaves.h"
#include "techniques/light_walk.h"

namespace halflight {

namespace {

class BvhSampler {
 public:
  BvhSampler(const WalkTree& tree, GeometryTerm term)
      : tree_(&tree), softening_(term == GeometryTerm::bounded ? 0.5f / pi : 0.0f) {}

  bool begin_pixel(const GBufferTexel& texel, RandomStream&) {
    point_ = {texel.position, texel.shading_normal, softening_};
    return !tree_->nodes.empty();
  }
  void draw(RandomStream& random, std::span<LightSample> out) {
    const auto n = static_cast<uint32_t>(out.size());
    walk_.start(out);
    walk_.enter(*tree_, 0, n, 1, random);
    walk_.finish(*tree_, point_, random);
  }
  double probability(uint32_t leaf, uint32_t) const { return walk_probability(*tree_, point_, 0, leaf, 1); }

 private:
  const WalkTree* tree_;
  float softening_;
  WalkPoint point_{};
  LightWalk walk_;
};

class LightBvh final : public Technique {
 public:
  void prepare(const FrameView& frame) override { tree_.build(*frame.tree, power_unit(*frame.tree)); }

  PassStats run_pass(const FrameView& frame, const PassRequest& request, Film& film) override {
    return run_sampler_pass<BvhSampler>(frame, request, film,
                                        [&] { return BvhSampler(tree_, frame.geometry_term()); });
  }

  std::optional<PixelInspection> inspect(const FrameView& frame, const PassRequest& request,
                                         uint32_t pixel) override {
    BvhSampler sampler(tree_, frame.geometry_term());
    return inspect_leaves(sampler, frame, request, pixel);
  }

 private:
  WalkTree tree_;
};

}  // namespace

TechniqueInfo light_bvh_technique() {
  return {"light-bvh",
          "Light tree walk",
          "Conty Estevez & Kulla 2018",
          TargetSupport::both,
          Bias::unbiased,
          {},
          []() -> std::unique_ptr<Technique> { return std::make_unique<LightBvh>(); },
          "unbiased for the sum over S; blind to the BRDF's lobe"};
}

}  // namespace halflight
