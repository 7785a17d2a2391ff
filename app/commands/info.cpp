// halflight info: what is in a scene, and the stages its picture takes.
#include <algorithm>
#include <map>

#include "commands/commands.h"
#include "commands/json_output.h"
#include "commands/open_scene.h"
#include "commands/render_json.h"
#include "commands/scene_summary.h"
#include "console.h"
#include "core/parallel.h"
#include "progress.h"
#include "text_table.h"

namespace halflight {

namespace {

std::string plan_text(const Session& session) {
  std::vector<std::vector<std::string>> rows;
  for (const PlanStage& stage : session.plan().stages)
    rows.push_back({std::string(stage_name(stage.stage)), stage.runs ? "runs" : "skipped", stage.why});
  return fmt::format("\nPlan for {} ({} target, {} light)\n", session.settings().technique,
                     target_name(used_target(session)), light_selection_name(session.settings().light)) +
         text_table(rows, "  ");
}

}  // namespace

int run_info(const Options& options) {
  check_writable(options.json);
  set_thread_count(options.threads);
  Progress progress(!options.quiet);
  WarningPrinter warnings(options.quiet);
  Messages messages;
  progress.show(fmt::format("opening {}", options.scene));
  OpenedScene opened = open_scene(options, messages);
  const Session session(std::move(opened.scene), options.render, messages);
  progress.hide();
  warnings.print_new(messages);

  if (options.json != "-") write_standard_output(scene_text(session.scene()) + plan_text(session));
  if (!options.json.empty()) {
    Json json = scene_json(session.scene());
    json["technique"] = session.settings().technique;
    json["target"] = target_name(used_target(session));
    json["plan"] = plan_json(session.plan());
    json["gl"] = gl_json(session);
    json["peak_memory_mb"] = peak_memory_mb();
    json["warnings"] = messages.warnings;
    write_json(options.json, json);
  }
  return static_cast<int>(ExitCode::ok);
}

}  // namespace halflight
