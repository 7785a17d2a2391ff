#include "raster/gl_context.h"

#include <utility>

namespace halflight {

namespace {

thread_local GlContextBase* current_context = nullptr;

void APIENTRY debug_message(GLenum, GLenum type, GLuint, GLenum, GLsizei length, const GLchar* text,
                            const void* user) {
  auto& context = *static_cast<GlContextBase*>(const_cast<void*>(user));
  if (type == GL_DEBUG_TYPE_ERROR && context.debug_error.empty()) context.debug_error.assign(text, length);
}

bool is_software(const std::string& renderer) {
  for (const char* name : {"llvmpipe", "softpipe", "swrast", "Software Rasterizer", "SwiftShader"})
    if (renderer.find(name) != std::string::npos) return true;
  return false;
}

/// A context somebody else made and keeps current.
class AdoptedContext final : public GlContextBase {
 public:
  explicit AdoptedContext(const ProcLoader& find) {
    const std::string failure = finish("window", find);
    if (!failure.empty())
      throw Error(ExitCode::no_gl, fmt::format("the window's OpenGL context: {}", failure));
  }
  ~AdoptedContext() override { release(); }

 private:
  bool bind() override { return true; }
  void unbind() override {}
};

using Maker = std::unique_ptr<GlContext> (*)(std::string&);

}  // namespace

GlContextBase::~GlContextBase() = default;

void GlContextBase::make_current() {
  if (current_context == this) return;
  if (current_context != nullptr) current_context->unbind();
  current_context = nullptr;
  if (!bind()) throw Error(ExitCode::no_gl, "the OpenGL context cannot be made current");
  current_context = this;
}

void GlContextBase::release() {
  if (current_context != this) return;
  unbind();
  current_context = nullptr;
}

std::string GlContextBase::finish(const char* backend, const ProcLoader& find) {
  const auto get_string = reinterpret_cast<PFNGLGETSTRINGPROC>(find("glGetString"));
  const auto text = [&](GLenum name) -> std::string {
    const GLubyte* string = get_string != nullptr ? get_string(name) : nullptr;
    return string != nullptr ? reinterpret_cast<const char*>(string) : "";
  };
  description_ = {backend, text(GL_RENDERER), text(GL_VERSION), false};
  description_.software = is_software(description_.renderer);
  if (description_.version.empty()) return "no OpenGL context is current";
  if (const char* missing = gl.load(find))
    return fmt::format("OpenGL {} ({}) lacks {}", description_.version, description_.renderer, missing);
  GLint major = 0, minor = 0;
  gl.GetIntegerv(GL_MAJOR_VERSION, &major);
  gl.GetIntegerv(GL_MINOR_VERSION, &minor);
  if (major * 10 + minor < 43) return fmt::format("OpenGL {} is older than 4.3", description_.version);
  // The stubs of some loaders are never null, so the extension itself is asked for below 4.5.
  if (major * 10 + minor < 45) {
    const auto get_string_i = reinterpret_cast<PFNGLGETSTRINGIPROC>(find("glGetStringi"));
    GLint count = 0;
    bool found = false;
    gl.GetIntegerv(GL_NUM_EXTENSIONS, &count);
    for (GLint i = 0; i < count && get_string_i != nullptr && !found; ++i)
      found = std::string_view(reinterpret_cast<const char*>(get_string_i(GL_EXTENSIONS, i))) ==
              "GL_ARB_clip_control";
    if (!found) return fmt::format("OpenGL {} without ARB_clip_control", description_.version);
  }
  if (debug_contexts) {
    gl.Enable(GL_DEBUG_OUTPUT);
    gl.Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    gl.DebugMessageCallback(debug_message, this);
  }
  if (current_context != nullptr && current_context != this) current_context = nullptr;
  current_context = this;
  return "";
}

void GlContextBase::check(const char* what) {
  const GLenum error = gl.GetError();
  if (error == GL_NO_ERROR && debug_error.empty()) return;
  std::string reason = std::exchange(debug_error, {});
  // GL_CONTEXT_LOST repeats for ever, so one is enough.
  if (error == GL_CONTEXT_LOST)
    throw Error(ExitCode::no_gl, fmt::format("{}: the OpenGL context was lost", what));
  while (gl.GetError() != GL_NO_ERROR) {
  }
  if (error == GL_OUT_OF_MEMORY)
    throw Error(ExitCode::no_gl, fmt::format("{}: OpenGL is out of memory", what));
  throw Error(ExitCode::failure, fmt::format("{}: OpenGL error {:#06x} {}", what, error, reason));
}

std::unique_ptr<GlContext> GlContext::make_headless(Backend backend) {
  std::vector<Maker> makers;
  switch (backend) {
    case Backend::automatic:
      makers = {make_egl_context, make_osmesa_context};
      break;
    case Backend::window:
      makers = {make_window_context};
      break;
    case Backend::egl:
      makers = {make_egl_context};
      break;
    case Backend::osmesa:
      makers = {make_osmesa_context};
      break;
    case Backend::none:
      break;
  }
  HALFLIGHT_CHECK(!makers.empty());
  if (current_context != nullptr) current_context->release();
  std::string reasons;
  for (const Maker make : makers)
    if (auto context = make(reasons)) return context;
  throw Error(ExitCode::no_gl, fmt::format("no OpenGL context could be made; tried {}", reasons));
}

std::unique_ptr<GlContext> GlContext::adopt(void* (*get_proc)(const char*)) {
  return std::make_unique<AdoptedContext>(get_proc);
}

}  // namespace halflight
