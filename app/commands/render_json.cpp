#include "commands/render_json.h"

#include <sys/resource.h>

#include <ctime>

#include "core/parallel.h"

namespace halflight {

namespace {

std::string_view program_name() { return "halflight " HALFLIGHT_VERSION; }

Json seconds_json(const RenderRecord& record) {
  const StageSeconds& s = record.session->stats().seconds;
  return {{"total", record.total_seconds},
          {"load", record.load_seconds + s.load},
          {"raster", s.raster},
          {"positions", s.positions},
          {"lights", s.lights},
          {"distribution", s.distribution},
          {"sampling", s.sampling},
          {"visibility", s.visibility},
          {"resolve", s.resolve},
          {"gpu", s.gpu}};
}

Json settings_json(const Session& session) {
  Json values = Json::object();
  for (const auto& [key, value] : session.settings().values.changed()) values[key] = value;
  return values;
}

/// Three channels a pixel from a function of the pixel's index.
template <class Value>
ImageLayer layer(std::string name, std::vector<std::string> channels, size_t pixels, Value value) {
  ImageLayer result{std::move(name), std::move(channels), std::vector<float>(3 * pixels)};
  for (size_t i = 0; i < pixels; ++i) {
    const Vec3 v = value(i);
    for (int c = 0; c < 3; ++c) result.values[3 * i + c] = v[c];
  }
  return result;
}

std::vector<ImageLayer> aov_layers(const Session& session) {
  const GBuffer& gbuffer = session.gbuffer();
  const Film& film = session.film();
  const auto texel = [&](size_t i) -> const GBufferTexel& { return gbuffer.texels[i]; };
  const auto where_hit = [&](size_t i, Vec3 value) { return texel(i).hit() ? value : Vec3(0); };
  const size_t pixels = gbuffer.pixel_count();
  return {
      layer("Albedo", {"R", "G", "B"}, pixels,
            [&](size_t i) { return where_hit(i, bounce_albedo(texel(i).brdf)); }),
      layer("N", {"X", "Y", "Z"}, pixels, [&](size_t i) { return where_hit(i, texel(i).shading_normal); }),
      layer("P", {"X", "Y", "Z"}, pixels, [&](size_t i) { return where_hit(i, texel(i).position); }),
      layer("Variance", {"R", "G", "B"}, pixels,
            [&](size_t i) { return film.variance(static_cast<uint32_t>(i)); })};
}

}  // namespace

Target used_target(const Session& session) {
  const RenderSettings& settings = session.settings();
  return choose_target(find_technique(settings.technique), settings.target);
}

double peak_memory_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024 / 1e6;
}

double process_cpu_seconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

Json plan_json(const Plan& plan, const StageCounters* counters) {
  Json stages = Json::array();
  for (const PlanStage& stage : plan.stages) {
    Json json{{"stage", stage_name(stage.stage)}, {"runs", stage.runs}, {"why", stage.why}};
    if (counters) {
      const StageCounter& counter = (*counters)[stage.stage];
      json["calls"] = counter.calls, json["bytes"] = counter.bytes, json["seconds"] = counter.seconds;
    }
    stages.push_back(std::move(json));
  }
  return stages;
}

Json gl_json(const Session& session) {
  const std::optional<GlDescription>& gl = session.gl();
  if (!gl) return {{"backend", "none"}, {"renderer", nullptr}, {"version", nullptr}};
  return {{"backend", gl->backend}, {"renderer", gl->renderer}, {"version", gl->version}};
}

Json render_json(const RenderRecord& record) {
  const Session& session = *record.session;
  const RenderSettings& settings = session.settings();
  const SessionStats& stats = session.stats();
  const Film& film = session.film();
  const Vec3 mean = film.mean_radiance();
  const double error = session.estimated_relmse();
  Json json;
  json["program"] = program_name();
  json["scene"] = session.scene().facts.source;
  json["camera"] = session.camera().name;
  json["technique"] = settings.technique;
  json["target"] = target_name(used_target(session));
  json["light"] = light_selection_name(settings.light);
  json["width"] = film.width();
  json["height"] = film.height();
  json["seed"] = settings.seed;
  json["settings"] = settings_json(session);
  json["threads"] = thread_count();
  json["spp"] = film.mean_samples();
  json["passes"] = stats.passes;
  json["adaptive"] = record.adaptive;
  json["stopped_by"] = stop_reason_name(record.stopped_by);
  json["partial"] = record.stopped_by == StopReason::interrupted;
  json["seconds"] = seconds_json(record);
  json["cpu_seconds"] = record.cpu_seconds;
  json["rays"] = {{"visibility", stats.rays.visibility},
                  {"closest", stats.rays.closest},
                  {"rejected", stats.rays.rejected},
                  {"useful", stats.useful_rays}};
  json["nan_samples"] = film.nan_samples();
  json["estimated_relmse"] = error < 0 ? Json(nullptr) : finite_or_null(error);
  json["mean_radiance"] = {finite_or_null(mean.x), finite_or_null(mean.y), finite_or_null(mean.z)};
  json["light_count"] = stats.light_count;
  json["cut_size"] = stats.cut_size;
  json["peak_memory_mb"] = peak_memory_mb();
  json["gl"] = gl_json(session);
  json["plan"] = plan_json(session.plan(), &stats.stages);
  json["warnings"] = *record.warnings;
  return json;
}

ImageMetadata render_metadata(const RenderRecord& record, bool aovs) {
  const Session& session = *record.session;
  const RenderSettings& settings = session.settings();
  const Camera& camera = session.camera();
  const ClipRange clip = clip_range(camera, session.scene().bounds);
  ImageMetadata metadata;
  metadata.text["software"] = program_name();
  metadata.text["scene"] = session.scene().facts.source;
  metadata.text["technique"] = settings.technique;
  metadata.text["target"] = target_name(used_target(session));
  metadata.text["light"] = light_selection_name(settings.light);
  metadata.text["camera"] = camera.name;
  metadata.text["seed"] = std::to_string(settings.seed);  // 64 bits are more than a double holds
  metadata.text["sampling"] = record.adaptive ? "adaptive" : "uniform";
  if (record.stopped_by == StopReason::error)
    metadata.text["bias"] = "stopped by its estimated error, which its samples decide";
  if (record.stopped_by == StopReason::interrupted) metadata.text["partial"] = "interrupted";
  metadata.numbers["width"] = settings.width;
  metadata.numbers["height"] = settings.height;
  metadata.numbers["spp"] = session.film().mean_samples();
  metadata.numbers["seconds"] = record.total_seconds;
  metadata.matrices["worldToCamera"] = view_matrix(camera);
  metadata.matrices["worldToNDC"] =
      projection_matrix(camera, settings.width, settings.height, clip.near_plane, clip.far_plane) *
      view_matrix(camera);
  if (aovs) metadata.layers = aov_layers(session);
  return metadata;
}

}  // namespace halflight
