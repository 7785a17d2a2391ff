// Contexts in plain memory through OSMesa, opened at run time (Mesa 25.1 has dropped it). The few
// declarations of <GL/osmesa.h> that are used stand here, so that the header need not be installed.
#include <dlfcn.h>

#include <array>

#include "raster/gl_context.h"

#if defined(__SANITIZE_ADDRESS__)
// OSMesa keeps what it notes of each context's window for ever: not a leak of ours.
extern "C" const char* __lsan_default_suppressions() { return "leak:libOSMesa\n"; }
#endif

namespace halflight {

namespace {

struct OsMesaHandle;

struct OsMesaFunctions {
  OsMesaHandle* (*create)(const int* attributes, OsMesaHandle* share) = nullptr;
  void (*destroy)(OsMesaHandle*) = nullptr;
  GLboolean (*make_current)(OsMesaHandle*, void* buffer, GLenum type, GLsizei width,
                            GLsizei height) = nullptr;
  void* (*get_proc_address)(const char*) = nullptr;

  /// Returns what is missing, or "".
  std::string load() {
    void* library = nullptr;
    for (const char* name : {"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"}) {
      library = dlopen(name, RTLD_NOW | RTLD_LOCAL);
      if (library != nullptr) break;
    }
    if (library == nullptr) return fmt::format("cannot open libOSMesa ({})", dlerror());
    const auto find = [&](auto& function, const char* name) {
      function = reinterpret_cast<std::decay_t<decltype(function)>>(dlsym(library, name));
      return function != nullptr;
    };
    const bool complete = find(create, "OSMesaCreateContextAttribs") &&
                          find(destroy, "OSMesaDestroyContext") && find(make_current, "OSMesaMakeCurrent") &&
                          find(get_proc_address, "OSMesaGetProcAddress");
    return complete ? "" : "libOSMesa lacks a function";
  }
};

constexpr int osmesa_format = 0x22, osmesa_depth_bits = 0x30, osmesa_profile = 0x33,
              osmesa_core_profile = 0x34;
constexpr int osmesa_major_version = 0x36, osmesa_minor_version = 0x37;

class OsMesaContext final : public GlContextBase {
 public:
  OsMesaContext(const OsMesaFunctions& osmesa, OsMesaHandle* context) : osmesa_(osmesa), context_(context) {}
  ~OsMesaContext() override {
    release();
    osmesa_.destroy(context_);
  }

  /// Returns why the context will not do, or "".
  std::string start() {
    if (!bind()) return "OSMesaMakeCurrent failed";
    const std::string failure = finish("osmesa", osmesa_.get_proc_address);
    if (!failure.empty()) unbind();
    return failure;
  }

 private:
  bool bind() override {
    return osmesa_.make_current(context_, window_.data(), GL_UNSIGNED_BYTE, window_size, window_size) ==
           GL_TRUE;
  }
  void unbind() override { osmesa_.make_current(nullptr, nullptr, 0, 0, 0); }

  // OSMesa wants a window's memory; every pass draws into framebuffers of its own.
  static constexpr int window_size = 16;
  OsMesaFunctions osmesa_;
  OsMesaHandle* context_;
  std::array<uint32_t, window_size * window_size> window_{};
};

}  // namespace

std::unique_ptr<GlContext> make_osmesa_context(std::string& reasons) {
  const auto note = [&](std::string_view why) {
    reasons += fmt::format("{}OSMesa: {}", reasons.empty() ? "" : "; ", why);
    return nullptr;
  };
  OsMesaFunctions osmesa;
  if (const std::string missing = osmesa.load(); !missing.empty()) return note(missing);
  for (const auto& version : gl_versions) {
    const int attributes[] = {osmesa_format,
                              GL_RGBA,
                              osmesa_depth_bits,
                              24,
                              osmesa_profile,
                              osmesa_core_profile,
                              osmesa_major_version,
                              version[0],
                              osmesa_minor_version,
                              version[1],
                              0};
    OsMesaHandle* handle = osmesa.create(attributes, nullptr);
    if (handle == nullptr) continue;
    auto context = std::make_unique<OsMesaContext>(osmesa, handle);
    if (const std::string failure = context->start(); !failure.empty()) return note(failure);
    return context;
  }
  return note("no OpenGL 4.3 to 4.5 core context");
}

}  // namespace halflight
