// The folder of a comparison: errors.csv, report.json, report.html and pictures.
#pragma once

#include <map>

#include "commands/compare_race.h"
#include "film/image_writers.h"
#include "options.h"

namespace halflight {

/// Processor, cores, memory, OpenGL, version and when.
Facts machine_facts(const Session&);

/// Throws Error (exit code 2) where the report's folder is there as a file, (1) where it cannot be made.
void check_report_folder(const std::string& folder);

/// Writes everything; `pictures` are the racers' by their ids. Fills in the paths of pictures and the error
/// maps' scale. Throws Error (exit code 1).
void write_report(const std::string& folder, Race&, const ReferencePicture&,
                  const std::optional<ReferencePicture>& integral,
                  const std::map<std::string, ImageRgb>& pictures, const DisplaySettings&);

}  // namespace halflight
