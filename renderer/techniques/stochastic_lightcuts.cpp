// Stochastic lightcuts: Yuksel 2019, after Walter et al. 2005.
//
// A pixel has a cut of its own: from the root, the node whose members may send most is replaced by its
// children while the cut has at most C nodes (never more than samples); the bound is Φ times the greatest
// geometry term and BRDF its sphere and cone allow. Every node k of the cut gets m_k samples, one or as near
// to equal as N allows, each led to a leaf by the children's importances, the BRDF's bound included
// (techniques/light_walk.h). Nodes whose bound is 0 share one sample, which enters one of them by chance, so
// that they keep P > 0 at little cost. Estimate:
//   Σ_k (1/m_k) Σ_s f cos θ L Ω V/P(i | k).
// Unbiased for the sum over S: cut and m_k do not depend on random numbers, the nodes cover every lit leaf,
// and each lit leaf has P(i | k) > 0. Distances are to the centre and at least the radius, where Yuksel
// averages two ends.
#include "techniques/inspect_leaves.h"
#include "techniques/light_walk.h"

namespace halflight {

namespace {

constexpr std::array settings{
    SettingInfo{"stochastic-lightcuts.cut", 32, 1, 1024, "nodes in a pixel's cut, C"},
};

class LightcutSampler {
 public:
  LightcutSampler(const FrameView& frame, const WalkTree& tree, uint32_t cut_size)
      : tree_(&tree),
        cut_size_(cut_size),
        softening_(frame.geometry_term() == GeometryTerm::bounded ? 0.5f / pi : 0.0f) {
    heap_.reserve(cut_size), settled_.reserve(cut_size);
  }

  bool begin_pixel(const GBufferTexel& texel, RandomStream&) {
    point_ = {texel.position, texel.shading_normal, softening_, true, lobe_bound(texel)};
    samples_ = 0;
    return !tree_->nodes.empty();
  }

  void draw(RandomStream& random, std::span<LightSample> out) {
    const auto n = static_cast<uint32_t>(out.size());
    if (samples_ != n) choose_cut(n);
    walk_.start(out);
    const uint32_t one = dark_ > 0 ? static_cast<uint32_t>(random.next_bits() % dark_) : 0;
    uint32_t dark = 0;
    for (const Cluster& cluster : settled_) {
      const bool enters = cluster.bound > 0 || dark++ == one;
      if (enters) walk_.enter(*tree_, cluster.node, cluster.samples, share(cluster), random);
    }
    walk_.finish(*tree_, point_, random);
  }

  /// Of the cut chosen last; draws of n chose it.
  double probability(uint32_t leaf, uint32_t) const {
    const auto behind =
        std::upper_bound(settled_.begin(), settled_.end(), leaf,
                         [](uint32_t i, const Cluster& cluster) { return i < cluster.begin; });
    if (behind == settled_.begin()) return 0;
    const Cluster& cluster = *(behind - 1);
    return walk_probability(*tree_, point_, cluster.node, leaf, share(cluster));
  }

 private:
  struct Cluster {
    float bound;
    uint32_t begin;  ///< first leaf
    int32_t node;    ///< or ~leaf
    uint32_t samples;

    bool operator<(const Cluster& o) const { return bound != o.bound ? bound < o.bound : begin > o.begin; }
  };

  /// Expected share of all samples.
  double share(const Cluster& cluster) const {
    return static_cast<double>(cluster.samples) / samples_ / (cluster.bound > 0 ? 1 : dark_);
  }
  void choose_cut(uint32_t n);
  void share_out(uint32_t n);

  const WalkTree* tree_;
  uint32_t cut_size_;
  float softening_;
  WalkPoint point_{};
  LightWalk walk_;
  uint32_t dark_ = 0;             ///< nodes of the cut that can send nothing
  uint32_t samples_ = 0;          ///< that the cut was chosen for
  std::vector<Cluster> heap_;     ///< open nodes, the greatest bound first
  std::vector<Cluster> settled_;  ///< the cut, in the order of the tree
};

void LightcutSampler::choose_cut(uint32_t n) {
  const uint32_t most = std::min(cut_size_, n);
  samples_ = n;
  heap_.assign(1, {infinity, 0, 0, 0});
  settled_.clear();
  while (!heap_.empty()) {
    std::pop_heap(heap_.begin(), heap_.end());
    const Cluster top = heap_.back();
    const WalkNode& node = tree_->nodes[top.node];
    uint32_t children = 0;
    for (int c = 0; c < WalkNode::width; ++c) children += node.guard[c] > 0 ? 1 : 0;
    if (heap_.size() + settled_.size() - 1 + children > most) break;
    heap_.pop_back();
    alignas(16) float bound[WalkNode::width];
    bound_children(node, point_, bound);
    for (int c = 0; c < WalkNode::width; ++c) {
      if (!(node.guard[c] > 0)) continue;
      const Cluster child{bound[c], node.begin[c], node.child[c], 0};
      if (child.node < 0) {
        settled_.push_back(child);
      } else {
        heap_.push_back(child);
        std::push_heap(heap_.begin(), heap_.end());
      }
    }
  }
  settled_.insert(settled_.end(), heap_.begin(), heap_.end());

  share_out(n);
}

void LightcutSampler::share_out(uint32_t n) {
  const auto size = static_cast<uint32_t>(settled_.size());
  std::sort(settled_.begin(), settled_.end(), [](const Cluster& a, const Cluster& b) { return b < a; });
  dark_ = 0;
  for (const Cluster& cluster : settled_) dark_ += cluster.bound > 0 ? 0 : 1;
  // The greatest bounds get what is over.
  const uint32_t bright = size - dark_, for_bright = n - (dark_ > 0 ? 1 : 0);
  for (uint32_t k = 0; k < bright; ++k)
    settled_[k].samples = for_bright / bright + (k < for_bright % bright ? 1 : 0);
  for (uint32_t k = bright; k < size; ++k) settled_[k].samples = bright > 0 ? 1 : n;
  std::sort(settled_.begin(), settled_.end(),
            [](const Cluster& a, const Cluster& b) { return a.begin < b.begin; });
}

class StochasticLightcuts final : public Technique {
 public:
  void prepare(const FrameView& frame) override { tree_.build(*frame.tree, power_unit(*frame.tree)); }

  PassStats run_pass(const FrameView& frame, const PassRequest& request, Film& film) override {
    return run_sampler_pass<LightcutSampler>(frame, request, film, [&] { return sampler(frame); });
  }

  std::optional<PixelInspection> inspect(const FrameView& frame, const PassRequest& request,
                                         uint32_t pixel) override {
    LightcutSampler one = sampler(frame);
    return inspect_leaves(one, frame, request, pixel);
  }

 private:
  LightcutSampler sampler(const FrameView& frame) const {
    return LightcutSampler(frame, tree_,
                           static_cast<uint32_t>(frame.settings->get("stochastic-lightcuts.cut")));
  }

  WalkTree tree_;
};

}  // namespace

TechniqueInfo stochastic_lightcuts_technique() {
  return {"stochastic-lightcuts",
          "A cut a pixel, sampled",
          "Yuksel 2019",
          TargetSupport::both,
          Bias::unbiased,
          settings,
          []() -> std::unique_ptr<Technique> { return std::make_unique<StochasticLightcuts>(); },
          "unbiased for the sum over S"};
}

}  // namespace halflight
