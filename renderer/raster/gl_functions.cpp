#include "raster/gl_functions.h"

namespace halflight {

const char* GlFunctions::load(const ProcLoader& find) {
#define HALFLIGHT_GL_LOAD(TYPE, name)                           \
  name = reinterpret_cast<PFNGL##TYPE##PROC>(find("gl" #name)); \
  if (name == nullptr) return "gl" #name;
  HALFLIGHT_GL_FUNCTIONS(HALFLIGHT_GL_LOAD)
#undef HALFLIGHT_GL_LOAD
  return nullptr;
}

}  // namespace halflight
