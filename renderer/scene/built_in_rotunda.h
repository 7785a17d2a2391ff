// An environment for the built-in sculptures: the inside of a domed round hall by day.
#pragma once

#include "scene/environment.h"

namespace halflight {

/// What one sees from the middle of a rotunda: tiled floor, fourteen arched windows to the sky with the sun
/// in one of them (behind a viewer who looks along −z, to the left), a coffered dome and its open eye.
/// Radiances from 0.05 (corners) over about 1.5 (sky) to 2600 (sun). Computed, at any size; twice as wide as
/// high.
Environment rotunda_environment(int height);

}  // namespace halflight
