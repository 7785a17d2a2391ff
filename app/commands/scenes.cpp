// halflight scenes: the built-in scenes and environments, listed or written as files.
#include "commands/commands.h"
#include "commands/json_output.h"
#include "console.h"
#include "film/image_writers.h"
#include "scene/built_in_environments.h"
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

std::string write_environment(const BuiltInEnvironment& built_in, const std::filesystem::path& folder) {
  const std::string file = (folder / fmt::format("{}.hdr", built_in.name)).string();
  write_radiance(file, built_in.make().map, {});
  return file;
}

struct Listing {
  std::vector<std::vector<std::string>> rows;
  Json list = Json::array();
};

/// Lists `all`: descriptions, or when `writing` the files that `files_of` makes.
template <class BuiltIn, class Write>
Listing listed(const std::vector<BuiltIn>& all, bool writing, Write&& files_of) {
  Listing listing;
  for (const BuiltIn& built_in : all) {
    std::vector<std::string> row{std::string(built_in.name), std::string(built_in.description)};
    Json entry{{"name", built_in.name}, {"description", built_in.description}};
    if (writing) {
      const std::vector<std::string> files = files_of(built_in);
      row[1] = fmt::format("{}", fmt::join(files, ", "));
      entry["files"] = files;
    }
    listing.rows.push_back(std::move(row));
    listing.list.push_back(std::move(entry));
  }
  return listing;
}

}  // namespace

int run_scenes(const Options& options) {
  check_writable(options.json);
  if (!options.write_folder.empty()) make_folder(options.write_folder);

  const bool writing = !options.write_folder.empty();
  const Listing scenes = listed(built_in_scenes(), writing, [&](const BuiltInScene& built_in) {
    return write_scene(built_in, options.write_folder);
  });
  const Listing environments =
      listed(built_in_environments(), writing, [&](const BuiltInEnvironment& built_in) {
        return std::vector{write_environment(built_in, options.write_folder)};
      });
  if (options.json != "-")
    write_standard_output(text_table(scenes.rows) + "\nEnvironments, for --environment NAME:\n" +
                          text_table(environments.rows));
  if (!options.json.empty())
    write_json(options.json, {{"scenes", scenes.list}, {"environments", environments.list}});
  return static_cast<int>(ExitCode::ok);
}

}  // namespace halflight
