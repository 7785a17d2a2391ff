// halflight scenes: the built-in scenes, listed or written as files.
#include "commands/commands.h"
#include "commands/json_output.h"
#include "console.h"
#include "film/image_writers.h"
#include "scene/load.h"
#include "text_table.h"

namespace halflight {

namespace {

void make_folder(const std::filesystem::path& folder) {
  std::error_code fault;
  std::filesystem::create_directories(folder, fault);
  if (fault)
    throw Error(ExitCode::failure,
                fmt::format("{}: cannot make the folder: {}", folder.string(), fault.message()));
}

/// Writes the scene as .glb with the pictures that go beside it; returns the files' paths.
std::vector<std::string> write_scene(const BuiltInScene& built_in, const std::filesystem::path& folder) {
  const GlbFile glb = make_glb(built_in.make(), std::string(built_in.name));
  std::vector<std::string> files;
  for (const SidePicture& picture : glb.pictures) {
    files.push_back((folder / picture.name).string());
    write_radiance(files.back(), picture.image, {});
  }
  files.push_back((folder / fmt::format("{}.glb", built_in.name)).string());
  write_text_atomically(files.back(), glb.bytes);
  return files;
}

}  // namespace

int run_scenes(const Options& options) {
  check_writable(options.json);
  if (!options.write_folder.empty()) make_folder(options.write_folder);

  std::vector<std::vector<std::string>> rows;
  Json list = Json::array();
  for (const BuiltInScene& built_in : built_in_scenes()) {
    std::vector<std::string> row{std::string(built_in.name), std::string(built_in.description)};
    Json entry{{"name", built_in.name}, {"description", built_in.description}};
    if (!options.write_folder.empty()) {
      const std::vector<std::string> files = write_scene(built_in, options.write_folder);
      row[1] = fmt::format("{}", fmt::join(files, ", "));
      entry["files"] = files;
    }
    rows.push_back(std::move(row));
    list.push_back(std::move(entry));
  }
  if (options.json != "-") write_standard_output(text_table(rows));
  if (!options.json.empty()) write_json(options.json, {{"scenes", list}});
  return static_cast<int>(ExitCode::ok);
}

}  // namespace halflight
