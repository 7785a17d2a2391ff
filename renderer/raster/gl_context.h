// What the passes need of a context beside its description. Private to this folder.
#pragma once

#include <memory>
#include <string>

#include "raster/gl_functions.h"
#include "raster/rasterizer.h"

namespace halflight {

/// Every GlContext is one of these: a function table and a way to become current on the calling thread.
class GlContextBase : public GlContext {
 public:
  /// Makes this the calling thread's context, first releasing the one of ours that was: EGL and OSMesa keep
  /// their own idea of what is current, and each skips a switch it believes to be none.
  void make_current();

  /// Lets go of the context where it is current; destructors of derived classes call it while they still can.
  void release();

  /// Throws Error when OpenGL has noted a failure since the last call; `what` names the step.
  void check(const char* what);

  GlFunctions gl;
  /// First error of the debug output since the last `check`; filled in debug builds.
  std::string debug_error;

 protected:
  ~GlContextBase() override;
  /// Loads the functions of the context that is current and fills the description. Returns why it will not
  /// do, or "".
  std::string finish(const char* backend, const ProcLoader& find);

 private:
  virtual bool bind() = 0;
  virtual void unbind() = 0;
};

/// The derived part of a context made by `make_headless` or `adopt`.
inline GlContextBase& base_of(GlContext& context) { return static_cast<GlContextBase&>(context); }

/// Each makes a current context or returns nothing and says in `reasons` what was tried and why it failed.
std::unique_ptr<GlContext> make_egl_context(std::string& reasons);
std::unique_ptr<GlContext> make_osmesa_context(std::string& reasons);
std::unique_ptr<GlContext> make_window_context(std::string& reasons);

#ifdef NDEBUG
inline constexpr bool debug_contexts = false;
#else
inline constexpr bool debug_contexts = true;
#endif

/// Versions asked for, best first: everything here works from 4.3 with ARB_clip_control on.
inline constexpr int gl_versions[][2] = {{4, 5}, {4, 4}, {4, 3}};

}  // namespace halflight
