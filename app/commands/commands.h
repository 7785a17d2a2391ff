// One function a command, each in its own file. They return the program's exit code, and throw Error for
// failures.
#pragma once

#include "options.h"

namespace halflight {

int run_view(const Options&);
int run_render(const Options&);
int run_compare(const Options&);
int run_info(const Options&);
int run_experiments(const Options&);
int run_stress(const Options&);
int run_error(const Options&);
int run_techniques(const Options&);
int run_scenes(const Options&);

}  // namespace halflight
