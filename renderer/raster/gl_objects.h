// Owners of OpenGL objects. Each is destroyed with its context current. Private to this folder.
#pragma once

#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "raster/gl_context.h"

namespace halflight {

/// A GL name with the function that deletes it; 0 owns nothing.
class GlName {
 public:
  GlName() = default;
  GlName(GLuint name, PFNGLDELETEBUFFERSPROC delete_names) : name_(name), delete_names_(delete_names) {}
  GlName(GlName&& other) noexcept
      : name_(std::exchange(other.name_, 0)), delete_names_(other.delete_names_) {}
  GlName& operator=(GlName&& other) noexcept {
    std::swap(name_, other.name_);
    std::swap(delete_names_, other.delete_names_);
    return *this;
  }
  ~GlName() {
    if (name_ != 0) delete_names_(1, &name_);
  }
  operator GLuint() const { return name_; }

 private:
  GLuint name_ = 0;
  PFNGLDELETEBUFFERSPROC delete_names_ = nullptr;
};

GlName make_buffer(const GlFunctions&);
GlName make_texture(const GlFunctions&);
GlName make_framebuffer(const GlFunctions&);
GlName make_vertex_array(const GlFunctions&);

/// A storage buffer of `bytes` bytes (at least 16, so that an empty list can be bound) filled from `data`
/// unless null.
GlName make_storage(const GlFunctions&, size_t bytes, const void* data, GLenum usage = GL_STATIC_DRAW);

/// The same from a list of plain structs.
template <class T>
GlName make_storage(const GlFunctions& gl, std::span<const T> values, GLenum usage = GL_STATIC_DRAW) {
  return make_storage(gl, values.size_bytes(), values.data(), usage);
}

/// Waits for what shaders wrote to a storage buffer of triples and reads its first ones.
void read_triples(const GlFunctions&, const GlName& buffer, std::span<Vec3> values);

/// One stage of a program: a file of shaders/.
struct ShaderStage {
  GLenum type;
  std::string_view file;
};

/// A linked program; uniforms are found by name each time, there are only a few.
class GlProgram {
 public:
  GlProgram() = default;
  /// Compiles the stages, resolving `#include "file"` among shaders/. `defines` are macros, each "NAME
  /// VALUE". Throws Error (failure) with the compiler's log.
  GlProgram(const GlFunctions&, std::initializer_list<ShaderStage>,
            const std::vector<std::string>& defines = {});
  GlProgram(GlProgram&& other) noexcept : gl_(other.gl_), program_(std::exchange(other.program_, 0)) {}
  GlProgram& operator=(GlProgram&& other) noexcept {
    std::swap(gl_, other.gl_);
    std::swap(program_, other.program_);
    return *this;
  }
  ~GlProgram() {
    if (program_ != 0) gl_->DeleteProgram(program_);
  }

  explicit operator bool() const { return program_ != 0; }
  void use() const { gl_->UseProgram(program_); }
  // The setters below need the program in use.
  void set(const char* name, int value) const { gl_->Uniform1i(location(name), value); }
  void set(const char* name, uint32_t value) const { gl_->Uniform1ui(location(name), value); }
  void set(const char* name, float value) const { gl_->Uniform1f(location(name), value); }
  void set(const char* name, Vec2 value) const { gl_->Uniform2f(location(name), value.x, value.y); }
  void set(const char* name, Vec3 value) const { gl_->Uniform3fv(location(name), 1, &value.x); }
  void set(const char* name, Vec4 value) const { gl_->Uniform4fv(location(name), 1, &value.x); }
  void set(const char* name, const Mat4& value) const {
    gl_->UniformMatrix4fv(location(name), 1, GL_FALSE, &value[0][0]);
  }

 private:
  GLint location(const char* name) const { return gl_->GetUniformLocation(program_, name); }

  const GlFunctions* gl_ = nullptr;
  GLuint program_ = 0;
};

/// Puts back, when it goes, what the passes change of the context's state: an adopted context is also drawn
/// to by others.
class StateGuard {
 public:
  explicit StateGuard(const GlFunctions&);
  ~StateGuard();
  StateGuard(const StateGuard&) = delete;
  StateGuard& operator=(const StateGuard&) = delete;

 private:
  static constexpr GLenum capabilities[] = {
      GL_DEPTH_TEST,       GL_BLEND,       GL_CULL_FACE,          GL_SCISSOR_TEST, GL_STENCIL_TEST,
      GL_FRAMEBUFFER_SRGB, GL_DEPTH_CLAMP, GL_POLYGON_OFFSET_FILL};
  const GlFunctions& gl_;
  bool enabled_[std::size(capabilities)];
  GLint draw_framebuffer_, read_framebuffer_, program_, vertex_array_, array_buffer_, active_texture_;
  GLint viewport_[4], depth_function_, clip_origin_, clip_depth_, pack_alignment_, polygon_mode_[2];
  GLboolean depth_mask_, color_mask_[4];
};

}  // namespace halflight
