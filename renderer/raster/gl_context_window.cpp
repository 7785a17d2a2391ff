// A context of a hidden GLFW window: what the display server's own driver gives.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "raster/gl_context.h"

namespace halflight {

namespace {

class WindowContext final : public GlContextBase {
 public:
  explicit WindowContext(GLFWwindow* window) : window_(window) {}
  // GLFW itself stays initialised: the program may have windows of its own.
  ~WindowContext() override {
    release();
    glfwDestroyWindow(window_);
  }

  /// Returns why the context will not do, or "".
  std::string start() {
    bind();
    const std::string failure =
        finish("window", [](const char* name) { return reinterpret_cast<void*>(glfwGetProcAddress(name)); });
    if (!failure.empty()) unbind();
    return failure;
  }

 private:
  bool bind() override {
    glfwMakeContextCurrent(window_);
    return glfwGetCurrentContext() == window_;
  }
  void unbind() override { glfwMakeContextCurrent(nullptr); }

  GLFWwindow* window_;
};

std::string glfw_reason() {
  const char* text = nullptr;
  const int code = glfwGetError(&text);
  return fmt::format("{} ({:#x})", text != nullptr ? text : "GLFW failed", code);
}

}  // namespace

std::unique_ptr<GlContext> make_window_context(std::string& reasons) {
  const auto note = [&](std::string_view why) {
    reasons += fmt::format("{}window: {}", reasons.empty() ? "" : "; ", why);
    return nullptr;
  };
  if (glfwInit() != GLFW_TRUE) return note(glfw_reason());
  std::string reason;
  for (const auto& version : gl_versions) {
    glfwDefaultWindowHints();
    glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, version[0]);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, version[1]);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_DEBUG_CONTEXT, debug_contexts ? GLFW_TRUE : GLFW_FALSE);
    GLFWwindow* window = glfwCreateWindow(16, 16, "halflight", nullptr, nullptr);
    if (window == nullptr) {
      reason = glfw_reason();
      continue;
    }
    auto context = std::make_unique<WindowContext>(window);
    reason = context->start();
    if (reason.empty()) return context;
    return note(reason);
  }
  return note(reason);
}

}  // namespace halflight
