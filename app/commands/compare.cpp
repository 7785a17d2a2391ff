// halflight compare: error against time, samples or rays, for several techniques.
#include <algorithm>
#include <filesystem>
#include <map>

#include "commands/compare.h"

#include "commands/commands.h"
#include "commands/compare_reference.h"
#include "commands/compare_report.h"
#include "commands/compare_setup.h"
#include "commands/open_scene.h"
#include "commands/render_json.h"
#include "console.h"
#include "core/parallel.h"
#include "interruption.h"
#include "progress.h"
#include "report/analysis.h"

namespace halflight {

namespace {

/// The continuous reference is a run of this many times the largest budget: a twentieth of the racers'
/// variance at their end where it is made by a technique like theirs.
constexpr double reference_effort = 20;

/// And of the integral beside a discrete race at most this many times.
constexpr double integral_effort = 8;

/// "about 3 min left" from the share that is done.
std::string time_left(double seconds, double share) {
  if (!(share > 0.005)) return "";
  const double left = seconds * (1 - share) / share;
  return left < 90 ? fmt::format(", about {:.0f} s left", left)
                   : fmt::format(", about {:.0f} min left", left / 60);
}

/// A file's name without its folder; a built-in name as it is.
std::string title_of(const std::string& scene) { return std::filesystem::path(scene).filename().string(); }

/// A setting's value, in words where it has words.
std::string setting_text(const std::string& key, double value) {
  for (const SettingInfo* info : all_settings())
    if (info->key == key && !info->choices.empty())
      return std::string(info->choices[static_cast<size_t>(value)]);
  return fmt::format("{:.16g}", value);
}

/// What stays the same while a race goes on.
struct Arena {
  const Options& options;
  const RaceSetup& setup;
  Session& session;
  Messages& messages;
  Progress& progress;
};

RenderSettings settings_of(const Arena& arena, const TechniqueInfo& info, uint64_t seed) {
  RenderSettings settings = arena.options.render;
  settings.technique = info.id;
  settings.seed = seed;
  settings.target.reset();
  if (info.target != TargetSupport::own) settings.target = arena.setup.target;
  return settings;
}

RunRequest request_of(const Arena& arena, const TechniqueInfo& info, uint64_t seed) {
  return {settings_of(arena, info, seed), arena.options.equal, arena.options.budgets,
          arena.options.equal != Equal::samples && !info.exact};
}

ReferencePicture find_reference(const Arena& arena) {
  const Stopwatch watch;
  const ShareDone show = [&](double share) {
    arena.progress.show(fmt::format("reference, {:.0f} %{}", 100 * share, time_left(watch.seconds(), share)));
  };
  arena.progress.show("reference");
  if (!arena.options.reference.empty()) return given_reference(arena.options.reference, arena.options);
  if (arena.setup.target == Target::discrete)
    return discrete_reference(arena.session, arena.options.render, arena.messages, show);
  return continuous_reference(
      arena.session,
      request_of(arena, find_technique(continuous_reference_technique), arena.options.render.seed),
      reference_effort, show);
}

/// The integral that a discrete race's sum stands for, through pixel centres as the sum sees them. It takes
/// no longer than the race itself.
std::optional<ReferencePicture> find_integral(const Arena& arena) {
  const Options& options = arena.options;
  if (arena.setup.target != Target::discrete || options.no_discretisation || !options.reference.empty())
    return std::nullopt;
  const Stopwatch watch;
  RunRequest request = request_of(arena, find_technique(continuous_reference_technique), options.render.seed);
  request.settings.pixel_centres = true;
  // Settings size S and steer draws: the integral hangs on none of them, and few lights would only make it
  // noisy.
  request.settings.values = SettingValues();
  const double runs = static_cast<double>(options.seeds) * static_cast<double>(arena.setup.entries.size());
  return continuous_reference(arena.session, request, std::min(integral_effort, runs), [&](double share) {
    arena.progress.show(fmt::format("the integral beside the sum, {:.0f} %{}", 100 * share,
                                    time_left(watch.seconds(), share)));
  });
}

/// Sampling error beside discretisation error, and both together in the pictures of the first seed.
void tell_errors_apart(const ReferencePicture& reference, const ReferencePicture& integral,
                       const std::map<std::string, ImageRgb>& pictures, Race& race) {
  race.discretisation = discretisation_error(reference, integral);
  for (Racer& racer : race.racers)
    if (const auto image = pictures.find(racer.id); image != pictures.end() && !racer.preview)
      racer.relmse_of_integral =
          measure_radiance_error(image->second, integral.image).relmse - integral.own.relmse;
}

Race describe(const Arena& arena, const OpenedScene& opened, const ReferencePicture& reference) {
  const Options& options = arena.options;
  Race race;
  race.scene = arena.session.scene().facts.source;
  race.title = title_of(race.scene);
  race.camera = arena.session.camera().name;
  race.target = target_name(arena.setup.target);
  race.light = light_selection_name(options.render.light);
  race.width = options.render.width, race.height = options.render.height;
  race.equal = options.equal;
  race.progressive = options.equal != Equal::samples;
  race.budgets = options.budgets;
  for (uint32_t i = 0; i < options.seeds; ++i) race.seeds.push_back(options.render.seed + i);
  for (const RaceEntry& entry : arena.setup.entries) {
    const TechniqueInfo& info = *entry.info;
    const bool own = info.target == TargetSupport::own;
    race.racers.push_back({entry.name,
                           std::string(info.title),
                           std::string(info.source),
                           std::string(info.note),
                           own ? "own" : race.target,
                           !entry.why_preview.empty(),
                           entry.why_preview,
                           {},
                           {},
                           {}});
  }
  race.left_out = arena.setup.left_out;
  race.reference = reference.facts;
  race.settings = {
      {"Scene", race.scene},
      {"Camera", race.camera},
      {"Size", fmt::format("{} × {}", race.width, race.height)},
      {"Target", race.target},
      {"Light", race.light},
      {"Seeds", fmt::format("{} to {}", race.seeds.front(), race.seeds.back())},
      {"Exposure", fmt::format("{:g} stops, tone map {}", opened.display.ev, opened.display.tonemap)}};
  for (const auto& [key, value] : options.render.values.changed())
    race.settings.emplace_back(key, setting_text(key, value));
  return race;
}

/// A technique that fails is left out of `all`; one that was asked for by name ends the race.
void leave_out(const Arena& arena, Race& race, size_t index, const Error& error) {
  if (arena.setup.named) throw error;
  race.left_out.push_back({race.racers[index].id, error.what()});
}

/// Seeds outside, techniques inside: what slows the machine down for a while slows all of them down.
void run_all(const Arena& arena, const ReferencePicture& reference, std::stop_token stop, Race& race,
             std::map<std::string, ImageRgb>& pictures) {
  const Stopwatch watch;
  std::vector<bool> failed(race.racers.size(), false);
  std::vector<RunRequest> requests;
  for (const RaceEntry& entry : arena.setup.entries) {
    requests.push_back(request_of(arena, *entry.info, race.seeds.front()));
    for (const auto& [key, value] : entry.settings) requests.back().settings.values.set(key, value);
  }
  for (size_t i = 0; i < requests.size() && !stop.stop_requested(); ++i) {
    arena.progress.show(fmt::format("{}, warming up", race.racers[i].id));
    try {
      requests[i].cost = measure_cost(arena.session, requests[i]);
    } catch (const Error& error) {
      leave_out(arena, race, i, error);
      failed[i] = true;
    }
  }
  const double runs = static_cast<double>(race.seeds.size() * race.racers.size());
  for (size_t s = 0; s < race.seeds.size() && !stop.stop_requested(); ++s) {
    for (size_t i = 0; i < race.racers.size() && !stop.stop_requested(); ++i) {
      if (failed[i]) continue;
      const double before = static_cast<double>(s * race.racers.size() + i);
      const auto show = [&](double share) {
        const double all = (before + share) / runs;
        arena.progress.show(fmt::format("{}, seed {} of {}, {:.0f} %{}", race.racers[i].id, s + 1,
                                        race.seeds.size(), 100 * all, time_left(watch.seconds(), all)));
      };
      show(0);
      try {
        requests[i].settings.seed = race.seeds[s];
        RaceRun run = run_race(arena.session, requests[i], reference, stop, show, [&](const Film& film) {
          if (s == 0) pictures[race.racers[i].id] = film.image();
          if (const uint64_t count = film.nan_samples())
            arena.messages.warn(fmt::format("{}, seed {}: {} samples were not finite and count as 0",
                                            race.racers[i].id, race.seeds[s], count));
        });
        if (!run.snapshots.empty()) race.racers[i].runs.push_back(std::move(run));
      } catch (const Error& error) {
        leave_out(arena, race, i, error);
        failed[i] = true;
      }
    }
  }
  race.interrupted = stop.stop_requested();
  for (size_t i = race.racers.size(); i-- > 0;)
    if (failed[i]) race.racers.erase(race.racers.begin() + static_cast<ptrdiff_t>(i));
}

std::string summary(const std::string& folder, const Race& race) {
  const Analysis analysis = analyse(race);
  std::string text = fmt::format("{}/report.html: ", folder);
  if (race.interrupted) text += "interrupted, with what was complete; ";
  return text + (analysis.verdicts.empty() ? "no two techniques to compare" : analysis.verdicts.front().text);
}

}  // namespace

bool any_complete(const Race& race) {
  for (const Racer& racer : race.racers)
    for (const RaceRun& run : racer.runs)
      if (run.complete) return true;
  return false;
}

Race compare_techniques(const Options& options, const Workbench& bench) {
  const RaceSetup setup = set_up_race(options);
  check_report_folder(options.output);

  // Scene and session, which all techniques share.
  Messages messages;
  bench.progress.show(fmt::format("opening {}", options.scene));
  OpenedScene opened = open_scene(options, messages);
  RenderSettings first = options.render;
  first.technique = setup.entries.empty() ? first.technique : std::string(setup.entries.front().info->id);
  first.target.reset();
  Session session(std::move(opened.scene), first, messages);
  bench.progress.hide();
  bench.warnings.print_new(messages);

  // Reference, then the race; from here on an interruption keeps what is complete.
  const Arena arena{options, setup, session, messages, bench.progress};
  const ReferencePicture reference = find_reference(arena);
  const std::optional<ReferencePicture> integral = find_integral(arena);
  Race race = describe(arena, opened, reference);
  race.shared_seconds = opened.seconds + session.stats().seconds.load;
  bench.progress.show("the harness itself");
  RenderSettings null = options.render;
  null.target = setup.target;
  race.harness = run_null(session, null);
  race.light_count = session.stats().light_count, race.cut_size = session.stats().cut_size;
  race.settings.emplace_back("Light set",
                             fmt::format("{} members, cut of {}", race.light_count, race.cut_size));
  std::map<std::string, ImageRgb> pictures;
  bench.interruption.keep_what_there_is();
  run_all(arena, reference, bench.interruption.token(), race, pictures);
  bench.progress.hide();
  bench.warnings.print_new(messages);
  if (race.interrupted && !any_complete(race)) return race;
  if (integral) tell_errors_apart(reference, *integral, pictures, race);

  // Files.
  race.machine = machine_facts(session);
  race.warnings = messages.warnings;
  bench.progress.show("report");
  write_report(options.output, race, reference, integral, pictures, opened.display);
  bench.progress.hide();
  return race;
}

int run_compare(const Options& options) {
  set_up_race(options);
  check_report_folder(options.output);
  Interruption interruption;
  set_thread_count(options.threads);
  Progress progress(!options.quiet);
  WarningPrinter warnings(options.quiet);
  const Race race = compare_techniques(options, {interruption, progress, warnings});
  if (race.interrupted && !any_complete(race)) {
    print_note("interrupted before the first run was complete; nothing is written");
    return static_cast<int>(ExitCode::interrupted);
  }
  if (!options.quiet) print_note(summary(options.output, race));
  return static_cast<int>(race.interrupted ? ExitCode::interrupted : ExitCode::ok);
}

}  // namespace halflight
