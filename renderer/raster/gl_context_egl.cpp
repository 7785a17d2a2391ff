// Contexts without a window through EGL: GPUs by the device platform, then Mesa's surfaceless platform, then
// software devices. libEGL is opened at run time, so that the program starts where it is missing.
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>

#include "raster/gl_context.h"

namespace halflight {

namespace {

/// The functions of libEGL used here; all found through eglGetProcAddress (EGL 1.5 allows that for core ones
/// too).
struct EglFunctions {
  PFNEGLGETPROCADDRESSPROC get_proc_address = nullptr;
  PFNEGLQUERYSTRINGPROC query_string = nullptr;
  PFNEGLINITIALIZEPROC initialize = nullptr;
  PFNEGLBINDAPIPROC bind_api = nullptr;
  PFNEGLCHOOSECONFIGPROC choose_config = nullptr;
  PFNEGLCREATECONTEXTPROC create_context = nullptr;
  PFNEGLDESTROYCONTEXTPROC destroy_context = nullptr;
  PFNEGLMAKECURRENTPROC make_current = nullptr;
  PFNEGLGETERRORPROC get_error = nullptr;
  PFNEGLGETPLATFORMDISPLAYEXTPROC get_platform_display = nullptr;
  PFNEGLQUERYDEVICESEXTPROC query_devices = nullptr;             // may be null
  PFNEGLQUERYDEVICESTRINGEXTPROC query_device_string = nullptr;  // may be null

  /// Returns what is missing, or "".
  std::string load() {
    // Never closed: drivers do not survive being unloaded.
    void* library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) return fmt::format("cannot open libEGL.so.1 ({})", dlerror());
    const auto find = [&](auto& function, const char* name) {
      function = reinterpret_cast<std::decay_t<decltype(function)>>(dlsym(library, name));
      if (function == nullptr && get_proc_address != nullptr)
        function = reinterpret_cast<std::decay_t<decltype(function)>>(get_proc_address(name));
      return function != nullptr;
    };
    const bool complete =
        find(get_proc_address, "eglGetProcAddress") && find(query_string, "eglQueryString") &&
        find(initialize, "eglInitialize") && find(bind_api, "eglBindAPI") &&
        find(choose_config, "eglChooseConfig") && find(create_context, "eglCreateContext") &&
        find(destroy_context, "eglDestroyContext") && find(make_current, "eglMakeCurrent") &&
        find(get_error, "eglGetError") && find(get_platform_display, "eglGetPlatformDisplayEXT");
    find(query_devices, "eglQueryDevicesEXT");
    find(query_device_string, "eglQueryDeviceStringEXT");
    return complete ? "" : "libEGL.so.1 lacks a function";
  }
};

/// One way to an EGLDisplay.
struct Candidate {
  std::string name;
  EGLenum platform;
  void* native;
};

class EglContext final : public GlContextBase {
 public:
  EglContext(const EglFunctions& egl, EGLDisplay display, EGLContext context)
      : egl_(egl), display_(display), context_(context) {}
  // The display stays initialised: it is shared by all contexts of the process that were made from it.
  ~EglContext() override {
    release();
    egl_.destroy_context(display_, context_);
  }

  /// Returns why the context will not do, or "".
  std::string start() {
    if (!bind()) return fmt::format("eglMakeCurrent failed ({:#06x})", egl_.get_error());
    const std::string failure =
        finish("egl", [&](const char* name) { return reinterpret_cast<void*>(egl_.get_proc_address(name)); });
    if (!failure.empty()) unbind();
    return failure;
  }

 private:
  bool bind() override {
    egl_.bind_api(EGL_OPENGL_API);
    return egl_.make_current(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE;
  }
  void unbind() override { egl_.make_current(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT); }

  EglFunctions egl_;
  EGLDisplay display_;
  EGLContext context_;
};

bool has_word(const char* list, std::string_view word) {
  const std::string padded = fmt::format(" {} ", list != nullptr ? list : "");
  return padded.find(fmt::format(" {} ", word)) != std::string::npos;
}

std::vector<Candidate> list_candidates(const EglFunctions& egl) {
  std::vector<Candidate> hardware, software;
  const char* extensions = egl.query_string(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  if (has_word(extensions, "EGL_EXT_platform_device") && egl.query_devices != nullptr) {
    EGLDeviceEXT devices[16];
    EGLint count = 0;
    if (egl.query_devices(16, devices, &count) == EGL_TRUE) {
      for (EGLint i = 0; i < count; ++i) {
        const char* kinds = egl.query_device_string != nullptr
                                ? egl.query_device_string(devices[i], EGL_EXTENSIONS)
                                : nullptr;
        const bool soft = has_word(kinds, "EGL_MESA_device_software");
        (soft ? software : hardware)
            .push_back({fmt::format("EGL device {}", i), EGL_PLATFORM_DEVICE_EXT, devices[i]});
      }
    }
  }
  std::vector<Candidate> all = std::move(hardware);
  if (has_word(extensions, "EGL_MESA_platform_surfaceless"))
    all.push_back({"EGL surfaceless", EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY});
  all.insert(all.end(), software.begin(), software.end());
  return all;
}

/// Makes a context on one display, or returns nothing and the reason.
std::unique_ptr<GlContext> try_candidate(const EglFunctions& egl, const Candidate& candidate,
                                         std::string& reason) {
  const auto fail = [&](const char* call) {
    reason = fmt::format("{} failed ({:#06x})", call, egl.get_error());
    return nullptr;
  };
  const EGLDisplay display = egl.get_platform_display(candidate.platform, candidate.native, nullptr);
  if (display == EGL_NO_DISPLAY) return fail("eglGetPlatformDisplayEXT");
  if (egl.initialize(display, nullptr, nullptr) != EGL_TRUE) return fail("eglInitialize");
  if (!has_word(egl.query_string(display, EGL_EXTENSIONS), "EGL_KHR_surfaceless_context"))
    return reason = "no EGL_KHR_surfaceless_context", nullptr;
  if (egl.bind_api(EGL_OPENGL_API) != EGL_TRUE) return fail("eglBindAPI");
  const EGLint config_attributes[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                                      EGL_NONE};
  EGLConfig config;
  EGLint config_count = 0;
  if (egl.choose_config(display, config_attributes, &config, 1, &config_count) != EGL_TRUE ||
      config_count == 0)
    return fail("eglChooseConfig");
  for (const auto& version : gl_versions) {
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                 version[0],
                                 EGL_CONTEXT_MINOR_VERSION,
                                 version[1],
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                 EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                 EGL_CONTEXT_OPENGL_DEBUG,
                                 debug_contexts ? EGL_TRUE : EGL_FALSE,
                                 EGL_NONE};
    const EGLContext handle = egl.create_context(display, config, EGL_NO_CONTEXT, attributes);
    if (handle == EGL_NO_CONTEXT) continue;
    auto context = std::make_unique<EglContext>(egl, display, handle);
    reason = context->start();
    if (!reason.empty()) return nullptr;
    return context;
  }
  return fail("eglCreateContext for OpenGL 4.3 to 4.5 core");
}

}  // namespace

std::unique_ptr<GlContext> make_egl_context(std::string& reasons) {
  const auto note = [&](std::string_view what, std::string_view why) {
    reasons += fmt::format("{}{}: {}", reasons.empty() ? "" : "; ", what, why);
  };
  EglFunctions egl;
  if (const std::string missing = egl.load(); !missing.empty()) return note("EGL", missing), nullptr;
  const std::vector<Candidate> candidates = list_candidates(egl);
  if (candidates.empty()) note("EGL", "neither the device nor the surfaceless platform");
  for (const Candidate& candidate : candidates) {
    std::string reason;
    if (auto context = try_candidate(egl, candidate, reason)) return context;
    note(candidate.name, reason);
  }
  return nullptr;
}

}  // namespace halflight
