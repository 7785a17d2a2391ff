#include "commands/compare_race.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "commands/render_json.h"
#include "core/stopwatch.h"

namespace halflight {

namespace {

constexpr uint32_t most_in_a_pass = 256;
constexpr double most_in_the_only_pass = 1 << 20;

uint64_t traced(const SessionStats& stats) { return stats.rays.visibility + stats.rays.closest; }

class Run {
 public:
  Run(Session& session, const RunRequest& request, std::stop_token stop)
      : session_(session),
        request_(request),
        stop_(std::move(stop)),
        single_(find_technique(request.settings.technique).exact) {
    session_.set_settings(request.settings);
    restart();
  }

  void restart() {
    session_.start_over();
    wall_ = cpu_ = 0;
    done_ = 0;
    cost_ = request_.cost;
    free_ = false;
  }

  /// Runs the next pass towards `budget`; false when there is no room for one.
  bool step(double budget);
  double spent() const;
  RaceSnapshot snapshot(uint32_t checkpoint, const ReferencePicture&) const;
  bool stopped() const { return stop_.stop_requested(); }
  PassCost measure();

 private:
  uint32_t next_samples(double budget) const;
  uint32_t only_samples(double left) const;
  void pass(uint32_t samples);
  void learn(double cost, uint32_t samples);
  double pixels() const { return static_cast<double>(request_.settings.width) * request_.settings.height; }

  Session& session_;
  const RunRequest& request_;
  std::stop_token stop_;
  double wall_ = 0, cpu_ = 0;
  uint32_t done_ = 0;  ///< samples a pixel
  PassCost cost_;
  bool single_;        ///< a pass gives all there is, and each stands for itself
  bool free_ = false;  ///< a pass cost nothing of what is shared out: there is no end to wait for
};

double Run::spent() const {
  switch (request_.equal) {
    case Equal::time:
      return wall_;
    case Equal::samples:
      return done_;
    default:
      return static_cast<double>(traced(session_.stats())) / pixels();
  }
}

/// Samples a pixel of the next pass; 0: the budget has no room for half a pass of one.
uint32_t Run::next_samples(double budget) const {
  if (request_.equal == Equal::samples) {
    const auto total = static_cast<uint32_t>(budget);
    const uint32_t most = std::max(1u, total / request_.least_passes);
    return std::min({session_.round_samples(total), most, total - std::min(done_, total)});
  }
  if (free_) return 0;
  if (!cost_.known()) return spent() < budget || done_ == 0 ? 1 : 0;
  const double left = budget - spent() - (done_ == 0 ? cost_.start : 0);
  if (done_ > 0 && left < 0.5 * (cost_.pass + cost_.sample)) return 0;
  if (single_) return only_samples(left);
  // Enough samples to be worth what a pass costs. In the discrete target they may be as many as there are
  // already; in the continuous one those of a pass share S, and unless the technique spreads them over the
  // pixel also the pixel grid: more passes are worth more than larger ones.
  double grown = std::max(1.0, static_cast<double>(done_));
  if (session_.plan().redraws)
    grown = std::min(grown, static_cast<double>(find_technique(request_.settings.technique).samples_a_round));
  const double worth = std::max(grown, cost_.pass / cost_.sample);
  const double most = std::min<double>(worth, most_in_a_pass);
  const double fit = std::max(1.0, (left - cost_.pass) / cost_.sample);
  if (fit <= most) return static_cast<uint32_t>(fit);
  const double passes = std::ceil(left / (cost_.pass + cost_.sample * most));
  return static_cast<uint32_t>(std::clamp((left / passes - cost_.pass) / cost_.sample, 1.0, most));
}

/// All that is left in one pass; another in its place only where the first fell far short of the budget.
uint32_t Run::only_samples(double left) const {
  const double fit = std::clamp((left - cost_.pass) / cost_.sample, 1.0, most_in_the_only_pass);
  return done_ == 0 || fit > 2.0 * done_ ? static_cast<uint32_t>(fit) : 0;
}

bool Run::step(double budget) {
  if (stopped()) return false;
  const uint32_t samples = next_samples(budget);
  if (samples == 0) return false;
  pass(samples);
  return !stopped();
}

void Run::pass(uint32_t samples) {
  const double cpu = process_cpu_seconds();
  if (single_ && done_ > 0) session_.restart(), done_ = 0;
  const double before = spent();
  const Stopwatch watch;
  session_.run_pass(samples, 1, 0, stop_);
  wall_ += watch.seconds();
  cpu_ += process_cpu_seconds() - cpu;
  if (!stopped()) learn(spent() - before, samples);
  done_ += samples;
}

/// Costs follow the machine: all of them by the share that the last pass was off by.
void Run::learn(double cost, uint32_t samples) {
  free_ = !(cost > 0);
  if (free_) return;
  if (!cost_.known()) cost_ = {0, 0, cost / samples};
  const double expected = cost_.pass + cost_.sample * samples + (done_ == 0 ? cost_.start : 0);
  const double factor = std::clamp(cost / expected, 0.5, 2.0);
  cost_ = {cost_.start * factor, cost_.pass * factor, cost_.sample * factor};
}

PassCost Run::measure() {
  const uint32_t many = single_ ? 256 : 8;
  std::array<double, 3> cost{};
  for (size_t i = 0; i < cost.size() && !free_; ++i) {
    const double before = spent();
    pass(i + 1 < cost.size() ? 1 : many);
    cost[i] = spent() - before;
  }
  PassCost result;
  if (free_ || request_.equal == Equal::samples) return result;
  result.sample = std::max((cost[2] - cost[1]) / (many - 1), 0.01 * cost[1]);
  result.pass = std::max(cost[1] - result.sample, 0.0);
  result.start = std::max(cost[0] - cost[1], 0.0);
  return result;
}

RaceSnapshot Run::snapshot(uint32_t checkpoint, const ReferencePicture& reference) const {
  RaceSnapshot s;
  s.checkpoint = checkpoint;
  s.budget = request_.budgets[checkpoint];
  s.wall_seconds = wall_, s.cpu_seconds = cpu_;
  s.spp = session_.film().mean_samples();
  s.rays = traced(session_.stats());
  const ErrorMetrics metrics = measure_radiance_error(session_.film().image(), reference.image);
  // E[(x−r)²] = E[(x−E r)²] + Var(r) (ESTIMATORS, "How an estimator is tested").
  s.relmse = metrics.relmse - reference.own.relmse;
  s.relmse_trimmed = metrics.relmse_trimmed - reference.own.relmse_trimmed;
  s.rmse = std::sqrt(std::max(0.0, metrics.rmse * metrics.rmse - reference.own.rmse * reference.own.rmse));
  s.smape = metrics.smape;
  return s;
}

}  // namespace

ErrorMetrics own_error(const ImageRgb& reference, const ImageRgb& variance) {
  ImageRgb off = reference;
  for (size_t i = 0; i < off.pixels.size(); ++i) off.pixels[i] += glm::sqrt(variance.pixels[i]);
  return measure_radiance_error(off, reference);
}

PassCost measure_cost(Session& session, const RunRequest& request) {
  return Run(session, request, {}).measure();
}

RaceRun run_race(Session& session, const RunRequest& request, const ReferencePicture& reference,
                 std::stop_token stop, const std::function<void(double)>& on_pass,
                 const std::function<void(const Film&)>& keep_last) {
  RaceRun result;
  result.seed = request.settings.seed;
  Run run(session, request, std::move(stop));
  const double total = request.progressive
                           ? request.budgets.back()
                           : std::accumulate(request.budgets.begin(), request.budgets.end(), 0.0);
  double finished = 0;
  for (uint32_t c = 0; c < request.budgets.size(); ++c) {
    const double budget = request.budgets[c];
    if (!request.progressive && c > 0) run.restart();
    bool moved = false;
    while (run.step(budget)) {
      moved = true;
      if (on_pass) on_pass(std::min(1.0, (finished + run.spent()) / total));
    }
    if (run.stopped()) return result;
    if (!request.progressive) finished += budget;
    // Passes are whole pictures: what they made counts at the budget that it came nearest to.
    const auto reached = [&](uint32_t at) {
      return run.spent() > std::sqrt(request.budgets[at - 1] * request.budgets[at]);
    };
    if (request.progressive && c + 1 < request.budgets.size() && reached(c + 1)) continue;
    if (!moved && !(request.progressive && c > 0 && reached(c))) continue;
    result.snapshots.push_back(run.snapshot(c, reference));
  }
  if (keep_last && !result.snapshots.empty()) keep_last(session.film());
  result.complete = true;
  return result;
}

HarnessCost run_null(Session& session, const RenderSettings& settings) {
  constexpr int passes = 8;
  HarnessCost cost;
  RenderSettings null = settings;
  null.technique = "null";
  session.set_settings(null);
  session.start_over();
  Stopwatch watch;
  session.run_pass(1, 1, 0);
  cost.preparation_seconds = watch.lap();
  for (int i = 0; i < passes; ++i) session.run_pass(1, 1, 0);
  cost.pass_seconds = watch.lap() / passes;
  return cost;
}

}  // namespace halflight
