#include <backends/imgui_impl_glfw.h>
#include <fmt/format.h>
#include <imgui.h>

// After ImGui: GLFW must not bring its own OpenGL header.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "viewer/ui_frame.h"
#include "viewer/viewer.h"

namespace halflight {

namespace {

/// The key of `key_help` behind a GLFW key; 0 for others.
char key_letter(int key) {
  switch (key) {
    case GLFW_KEY_TAB:
      return '\t';
    case GLFW_KEY_SPACE:
      return ' ';
    case GLFW_KEY_ESCAPE:
      return '\x1b';
    case GLFW_KEY_LEFT_BRACKET:
      return '[';
    case GLFW_KEY_RIGHT_BRACKET:
      return ']';
    case GLFW_KEY_F1:
      return 'H';
    case GLFW_KEY_F12:
      return 'S';
    default:
      return key >= GLFW_KEY_A && key <= GLFW_KEY_Z ? static_cast<char>('A' + (key - GLFW_KEY_A)) : 0;
  }
}

/// GLFW's library and one window, closed in the right order.
class Window {
 public:
  Window(int width, int height) {
    if (glfwInit() != GLFW_TRUE) throw Error(ExitCode::no_gl, "no window: " + last_error());
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
    window_ = glfwCreateWindow(width, height, "Halflight", nullptr, nullptr);
    if (!window_) {
      const std::string reason = last_error();
      glfwTerminate();
      throw Error(ExitCode::no_gl, "no window with OpenGL 4.5: " + reason);
    }
    glfwMakeContextCurrent(window_);
    glfwSwapInterval(1);
  }
  ~Window() {
    glfwDestroyWindow(window_);
    glfwTerminate();
  }
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;
  operator GLFWwindow*() const { return window_; }

 private:
  static std::string last_error() {
    const char* text = nullptr;
    glfwGetError(&text);
    return text ? text : "unknown reason";
  }
  GLFWwindow* window_ = nullptr;
};

Viewer& viewer_of(GLFWwindow* window) { return *static_cast<Viewer*>(glfwGetWindowUserPointer(window)); }

void on_key(GLFWwindow* window, int key, int, int action, int modifiers) {
  if (action != GLFW_PRESS || ImGui::GetIO().WantTextInput ||
      (modifiers & (GLFW_MOD_CONTROL | GLFW_MOD_ALT)) != 0)
    return;
  if (const char letter = key_letter(key)) viewer_of(window).key(letter);
}

void on_drop(GLFWwindow* window, int count, const char** paths) {
  for (int i = 0; i < count; ++i) viewer_of(window).drop(paths[i]);
}

}  // namespace

void run_window(ViewerStart start, std::stop_token stop) {
  Window window(start.render.width + static_cast<int>(panel_width), start.render.height);
  float scale = 1;
  glfwGetWindowContentScale(window, &scale, nullptr);
  auto context =
      GlContext::adopt([](const char* name) { return reinterpret_cast<void*>(glfwGetProcAddress(name)); });
  UiPainter painter(*context);
  UiContext ui(painter, scale);
  Viewer viewer(std::move(start), painter);

  glfwSetWindowUserPointer(window, &viewer);
  glfwSetKeyCallback(window, on_key);
  glfwSetDropCallback(window, on_drop);
  ImGui_ImplGlfw_InitForOpenGL(window, true);  // chains to the callbacks above
  double titled_at = -1;
  while (!glfwWindowShouldClose(window) && !viewer.wants_to_close() && !stop.stop_requested()) {
    glfwWaitEventsTimeout(1.0 / 30);
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    viewer.frame(glfwGetTime());
    ImGui::Render();
    glm::ivec2 pixels(1);
    glfwGetFramebufferSize(window, &pixels.x, &pixels.y);
    if (pixels.x > 0 && pixels.y > 0) {
      ui.draw(pixels, nullptr);
      glfwSwapBuffers(window);
    }
    if (glfwGetTime() - titled_at > 0.25) {
      glfwSetWindowTitle(window, viewer.title().c_str());
      titled_at = glfwGetTime();
    }
  }
  ImGui_ImplGlfw_Shutdown();
}

}  // namespace halflight
