// What the pictures of a race are measured against: brute force, a long run, or a file.
#pragma once

#include <functional>
#include <stop_token>

#include "commands/compare_race.h"
#include "options.h"

namespace halflight {

/// Tells how far long work is: 0 to 1.
using ShareDone = std::function<void(double)>;

/// The sum over S itself (technique `reference`), from the cache where it is there. The cache is keyed by the
/// data it is made of - lights, pixels' surfaces, geometry, the alpha of textures - and by a small picture of
/// the same scene, which any change of the program's own arithmetic changes too. A cache that cannot be
/// written is a warning.
ReferencePicture discrete_reference(Session&, const RenderSettings&, Messages&, const ShareDone&);

/// What makes the continuous target's reference, racing or not: of those that are unbiased there, the one
/// that is nearest to it soonest.
inline constexpr std::string_view continuous_reference_technique = "halflight";

/// A long run of `settings.technique` in the continuous target: `effort` times the largest budget. Its own
/// variance is told by two halves from independent sets S.
ReferencePicture continuous_reference(Session&, const RunRequest&, double effort, const ShareDone&);

/// Of the sum's picture against the integral's.
DiscretisationError discretisation_error(const ReferencePicture& sum, const ReferencePicture& integral);

/// A picture given by the user. Throws Error (exit code 3) when it cannot be read or has another size.
ReferencePicture given_reference(const std::string& file, const Options&);

}  // namespace halflight
