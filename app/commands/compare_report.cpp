#include "commands/compare_report.h"

#include <unistd.h>

#include <ctime>
#include <filesystem>
#include <fstream>
#include <thread>

#include "commands/json_output.h"
#include "commands/render_json.h"
#include "core/parallel.h"
#include "film/image_writers.h"
#include "film/tonemap.h"
#include "report/error_map.h"
#include "report/report_html.h"
#include "report/report_json.h"

namespace halflight {

namespace {

namespace fs = std::filesystem;

std::string processor_name() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    const size_t colon = line.find(": ");
    if (line.rfind("model name", 0) == 0 && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

std::string now_text() {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  char text[64];
  return {text, std::strftime(text, sizeof text, "%Y-%m-%d %H:%M %Z", &local)};
}

ImageMetadata metadata_of(const Race& race, const std::string& technique) {
  ImageMetadata metadata;
  metadata.text = {{"software", "halflight " HALFLIGHT_VERSION},
                   {"scene", race.scene},
                   {"camera", race.camera},
                   {"technique", technique},
                   {"light", race.light}};
  return metadata;
}

/// Of a picture at the end of the racer's first run.
ImageMetadata metadata_of(const Race& race, const Racer& racer) {
  ImageMetadata metadata = metadata_of(race, racer.id);
  metadata.text["target"] = racer.target;
  if (racer.runs.empty() || racer.runs.front().snapshots.empty()) return metadata;
  metadata.text["seed"] = std::to_string(racer.runs.front().seed);
  metadata.numbers["spp"] = racer.runs.front().snapshots.back().spp;
  metadata.numbers["seconds"] = racer.runs.front().snapshots.back().wall_seconds;
  return metadata;
}

/// Picture as EXR and PNG.
PictureFiles write_picture(const fs::path& folder, const std::string& name, const ImageRgb& image,
                           const DisplaySettings& display, const ImageMetadata& metadata) {
  write_exr(folder / "images" / (name + ".exr"), image, metadata);
  write_png(folder / "images" / (name + ".png"),
            display_image(image, display.ev, find_tone_map(display.tonemap)), metadata);
  return {"images/" + name + ".exr", "images/" + name + ".png", ""};
}

void write_pictures(const fs::path& folder, Race& race, const ReferencePicture& reference,
                    const std::optional<ReferencePicture>& integral,
                    const std::map<std::string, ImageRgb>& pictures, const DisplaySettings& display) {
  race.reference.picture =
      write_picture(folder, "reference", reference.image, display, metadata_of(race, reference.facts.how));
  race.reference.file = race.reference.picture.exr;
  if (integral && race.discretisation)
    race.discretisation->picture =
        write_picture(folder, "integral", integral->image, display, metadata_of(race, integral->facts.how));
  std::map<std::string, std::vector<float>> maps;
  std::vector<std::vector<float>> ranked;
  for (Racer& racer : race.racers) {
    const auto image = pictures.find(racer.id);
    if (image == pictures.end()) continue;
    racer.picture = write_picture(folder, racer.id, image->second, display, metadata_of(race, racer));
    maps[racer.id] = signed_error(image->second, reference.image);
    if (!racer.preview) ranked.push_back(maps[racer.id]);
  }
  race.error_scale = error_scale(ranked);
  if (integral && race.discretisation) {
    race.discretisation->picture.error_png = "images/discretisation-error.png";
    write_png(folder / race.discretisation->picture.error_png,
              error_picture(signed_error(reference.image, integral->image), race.width, race.height,
                            race.error_scale),
              metadata_of(race, "discretisation"));
  }
  for (Racer& racer : race.racers) {
    const auto map = maps.find(racer.id);
    if (map == maps.end()) continue;
    racer.picture.error_png = "images/" + racer.id + "-error.png";
    write_png(folder / racer.picture.error_png,
              error_picture(map->second, race.width, race.height, race.error_scale),
              metadata_of(race, racer));
  }
}

}  // namespace

Facts machine_facts(const Session& session) {
  const double memory =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  const auto& gl = session.gl();
  return {{"Processor", processor_name()},
          {"Cores", fmt::format("{}, {} threads used", std::thread::hardware_concurrency(), thread_count())},
          {"Memory", fmt::format("{:.1f} GB", memory / 1e9)},
          {"OpenGL",
           gl ? fmt::format("{} ({}, {})", gl->version, gl->backend, gl->renderer) : "none: pixels by rays"},
          {"Program", "halflight " HALFLIGHT_VERSION},
          {"Peak memory", fmt::format("{:.0f} MB", peak_memory_mb())},
          {"When", now_text()}};
}

void check_report_folder(const std::string& folder) {
  if (folder.empty()) throw usage_error("`halflight compare` needs -o DIR, a folder for the report");
  std::error_code failed;
  const fs::file_status status = fs::status(folder, failed);
  if (fs::exists(status) && !fs::is_directory(status))
    throw usage_error(fmt::format("--output: {} is a file; `halflight compare` writes a folder", folder));
  // Nothing is made before there is something to put there: the nearest folder that exists must let it be
  // made later.
  fs::path nearest = fs::absolute(folder).lexically_normal();
  while (!fs::exists(nearest, failed) && nearest.has_relative_path()) nearest = nearest.parent_path();
  check_writable((nearest / "report.html").string());
}

void write_report(const std::string& folder, Race& race, const ReferencePicture& reference,
                  const std::optional<ReferencePicture>& integral,
                  const std::map<std::string, ImageRgb>& pictures, const DisplaySettings& display) {
  const fs::path path(folder);
  std::error_code failed;
  fs::create_directories(path / "images", failed);
  if (failed) throw Error(ExitCode::failure, fmt::format("{}: cannot write: {}", folder, failed.message()));
  write_pictures(path, race, reference, integral, pictures, display);
  const Analysis analysis = analyse(race);
  write_text_atomically(path / "errors.csv", errors_csv(race));
  write_json((path / "report.json").string(), race_json(race, analysis));
  write_text_atomically(path / "report.html", race_html(race, analysis));
}

}  // namespace halflight
