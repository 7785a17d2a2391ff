#include "stress/stress_stage.h"

#include <algorithm>

#include "core/stopwatch.h"

namespace halflight {

namespace {

constexpr uint32_t rounds_a_run = 4;          ///< continuous target: sets drawn for a run
constexpr uint32_t truth_batches = 16;        ///< of the path tracer
constexpr uint64_t seeds_of_truth = 0x7275e;  ///< apart from those of the runs

ImageRgb constant_image(int width, int height, Vec3 value) { return ImageRgb(width, height, value); }

}  // namespace

StressStage::StressStage(const StressCase& stress_case, const StressEffort& effort, std::stop_token stop)
    : case_(stress_case), effort_(effort), stop_(std::move(stop)) {}

RunCounts StressStage::run_counts(Target target) const {
  RunCounts counts = effort_.quick                ? RunCounts{4, 8, 16}
                     : target == Target::discrete ? RunCounts{8, 16, 64}
                                                  : RunCounts{8, 16, 48};
  if (effort_.most_runs > 0) {
    // Fewer tell nothing of their own spread.
    counts.most = std::max(effort_.most_runs, StressRuns::block);
    counts.least = std::min(counts.least, counts.most), counts.pilot = std::min(counts.pilot, counts.most);
  }
  return counts;
}

RenderSettings StressStage::settings(std::string_view technique, Target target,
                                     const std::vector<std::pair<std::string, std::string>>& more) const {
  RenderSettings settings;
  settings.technique = technique;
  const TargetSupport support = find_technique(technique).target;
  if (support != TargetSupport::own) settings.target = target;
  settings.backend = Backend::none;
  settings.width = case_.width, settings.height = case_.height;
  // As many lights as brute force can sum quickly, and clusters of several each.
  settings.values.set("lights.count", "256");
  settings.values.set("lights.samples", "4");
  settings.values.set("cut.least", "32");
  settings.values.set("cut.most", "128");
  case_.set(settings);
  for (const auto& [key, value] : more) settings.values.set(key, value);
  return settings;
}

Session& StressStage::session(const RenderSettings& settings, bool of_truth) {
  const Target target = choose_target(find_technique(settings.technique), settings.target);
  std::unique_ptr<Session>& kept = sessions_[{target, of_truth}];
  if (kept) {
    kept->set_settings(settings);
    return *kept;
  }
  Scene scene = of_truth && case_.truth_scene ? case_.truth_scene() : case_.scene();
  kept = std::make_unique<Session>(std::move(scene), settings, messages_);
  if (case_.adjust) case_.adjust(*kept);
  return *kept;
}

const StressTruth& StressStage::truth(Target target) {
  const auto found = truths_.find(target);
  return found != truths_.end() ? found->second : truths_.emplace(target, find_truth(target)).first->second;
}

StressTruth StressStage::find_truth(Target target) {
  StressTruth truth;
  const size_t pixels = static_cast<size_t>(case_.width) * static_cast<size_t>(case_.height);
  truth.variance.assign(pixels, Vec3d(0));
  if (case_.constant_truth) {
    truth.picture = constant_image(case_.width, case_.height, *case_.constant_truth);
    truth.marks.add(Marks::of(truth.picture));
  } else if (target == Target::discrete) {
    Session& session = this->session(settings("reference", target), case_.truth_scene != nullptr);
    session.run_pass(2, 1, 0, stop_);
    truth.picture = session.film().image();
    truth.marks.add(Marks::of(truth.picture));
  } else {
    RenderSettings settings = this->settings("path", target);
    const uint32_t samples = effort_.quick ? 8 : 48;
    std::vector<Vec3d> sum(pixels), squares(pixels);
    for (uint32_t batch = 0; batch < truth_batches && !stop_.stop_requested(); ++batch) {
      settings.seed = seeds_of_truth + batch;
      Session& session = this->session(settings, case_.truth_scene != nullptr);
      session.restart();
      session.run_pass(samples, 1, 0, stop_);
      const ImageRgb picture = session.film().image();
      truth.marks.add(Marks::of(picture));
      for (size_t i = 0; i < pixels; ++i) {
        const Vec3d value(picture.pixels[i]);
        sum[i] += value, squares[i] += value * value;
      }
    }
    const double n = std::max(1.0, truth.marks.runs);
    truth.picture = ImageRgb(case_.width, case_.height);
    for (size_t i = 0; i < pixels; ++i) {
      const Vec3d mean = sum[i] / n;
      truth.picture.pixels[i] = Vec3(mean);
      truth.variance[i] = glm::max(Vec3d(0), squares[i] / n - mean * mean) / std::max(1.0, n - 1);
    }
  }
  for (int c = 0; c < Marks::channels && !truth.marks.mean.empty(); ++c)
    truth.mean += truth.marks.mean[c] / Marks::channels;
  return truth;
}

StressRuns::StressRuns(StressStage& stage, const Contestant& contestant, bool of_truth)
    : stage_(stage),
      settings_(stage.settings(contestant.technique->id, contestant.target, contestant.settings)),
      session_(stage.session(settings_, of_truth)) {
  session_.start_over();
  Stopwatch watch;
  session_.run_pass(1, 1, 0, stage.stop());
  first_picture_ = watch.seconds();
  if (contestant.target != Target::discrete) return;
  session_.restart();
  frame_ = session_.frame();
  technique_ = contestant.technique->make();
  technique_->prepare(frame_);
}

StressPicture StressRuns::run(uint32_t index) {
  const uint32_t samples = stage_.samples();
  if (technique_) {
    Film film(settings_.width, settings_.height);
    PassRequest request;
    request.pass = index, request.samples = samples, request.stop = stage_.stop();
    technique_->run_pass(frame_, request, film);
    return {film.image(), film.nan_samples(), film.first_nan()};
  }
  const uint32_t before = index % block;
  if (before == 0) {
    settings_.seed = index / block + 1;
    session_.set_settings(settings_);
    session_.restart();
    sum_.assign(session_.film().image().pixels.size(), Vec3d(0)), sum_nans_ = 0;
  }
  const uint32_t rounds = std::min(rounds_a_run, samples);
  for (uint32_t round = 0; round < rounds; ++round)
    session_.run_pass(samples / rounds + (round < samples % rounds ? 1 : 0), 1, 0, stage_.stop());

  // What came since the last run of this seed: the film holds the mean of all.
  const Film& film = session_.film();
  StressPicture picture{film.image(), film.nan_samples() - sum_nans_, film.first_nan()};
  sum_nans_ = film.nan_samples();
  for (size_t i = 0; i < sum_.size(); ++i) {
    const Vec3d sum = Vec3d(picture.image.pixels[i]) * (before + 1.0);
    picture.image.pixels[i] = Vec3(sum - sum_[i]);
    sum_[i] = sum;
  }
  return picture;
}

double StressRuns::largest_weight() {
  if (!technique_) return Measured::none;
  const auto lights = static_cast<double>(frame_.tree->lights.size());
  const auto pixels = static_cast<uint32_t>(frame_.gbuffer->pixel_count());
  double largest = Measured::none;
  for (uint32_t i = 0; i < 12; ++i) {
    const uint32_t pixel = static_cast<uint32_t>((i + 0.5) / 12 * pixels);
    PassRequest request;
    request.samples = stage_.samples();
    const auto inspection = technique_->inspect(frame_, request, pixel);
    if (!inspection) return Measured::none;
    for (const LightSample& draw : inspection->draws) largest = std::fmax(largest, draw.weight / lights);
  }
  return largest;
}

}  // namespace halflight
