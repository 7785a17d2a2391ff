// halflight error: how far a picture is from its reference.
#include "commands/commands.h"
#include "commands/json_output.h"
#include "console.h"
#include "core/parallel.h"
#include "film/metrics.h"
#include "scene/image_files.h"

namespace halflight {

namespace {

/// In the order of `metric_names`.
std::vector<double> metric_values(const ErrorMetrics& m) {
  return {m.relmse, m.relmse_trimmed, m.rmse, m.smape, m.flip};
}

/// Bounds on a metric that the picture does not keep; a value that is no number keeps none.
std::vector<double> broken_bounds(const Options& options, std::string_view metric, double value) {
  std::vector<double> broken;
  for (const auto& [name, bound] : options.fail_above)
    if (name == metric && !(value <= bound)) broken.push_back(bound);
  return broken;
}

}  // namespace

int run_error(const Options& options) {
  check_writable(options.json);
  set_thread_count(options.threads);
  const ImageRgb image = read_image(options.image, options.load.limits);
  const ImageRgb reference = read_image(options.reference, options.load.limits);
  if (image.width != reference.width || image.height != reference.height)
    throw input_error(options.image, "",
                      fmt::format("is {}x{}, and {} is {}x{}; they must have the same size", image.width,
                                  image.height, options.reference, reference.width, reference.height));
  const std::vector<double> values = metric_values(measure_error(image, reference, options.ev.value_or(0)));

  std::string table;
  Json json{{"image", options.image},
            {"reference", options.reference},
            {"width", image.width},
            {"height", image.height}};
  Json failed = Json::array();
  for (size_t i = 0; i < values.size(); ++i) {
    const std::string_view name = metric_names()[i];
    table += fmt::format("{:<14}  {:<12.6g}", name, values[i]);
    for (const double bound : broken_bounds(options, name, values[i])) {
      table += fmt::format("  above {:g}", bound);
      failed.push_back({{"metric", name}, {"bound", bound}, {"value", finite_or_null(values[i])}});
    }
    table.erase(table.find_last_not_of(' ') + 1);
    table += '\n';
    json[std::string(name)] = finite_or_null(values[i]);
  }
  json["failed"] = failed;
  if (options.json != "-") write_standard_output(table);
  if (!options.json.empty()) write_json(options.json, json);
  return static_cast<int>(failed.empty() ? ExitCode::ok : ExitCode::comparison_failed);
}

}  // namespace halflight
