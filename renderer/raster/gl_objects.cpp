#include "raster/gl_objects.h"

#include "shader_sources.h"

namespace halflight {

namespace {

GlName make_name(PFNGLGENBUFFERSPROC generate, PFNGLDELETEBUFFERSPROC delete_names) {
  GLuint name = 0;
  generate(1, &name);
  return {name, delete_names};
}

/// Text of a shader file with its `#include "file"` lines replaced by those files, and without comments: they
/// are not plain ASCII, which some compilers insist on.
std::string expand(std::string_view file) {
  const std::string_view source = shader_source(file);
  HALFLIGHT_CHECK(!source.empty());
  constexpr std::string_view directive = "#include \"";
  std::string text;
  for (size_t begin = 0; begin < source.size();) {
    const size_t end = std::min(source.find('\n', begin), source.size() - 1) + 1;
    const std::string_view line = source.substr(begin, end - begin);
    if (line.starts_with(directive))
      text += expand(line.substr(directive.size(), line.rfind('"') - directive.size()));
    else
      text.append(line.substr(0, std::min(line.find("//"), line.size() - 1))).push_back('\n');
    begin = end;
  }
  return text;
}

GLuint compile(const GlFunctions& gl, const ShaderStage& stage, const std::string& prologue) {
  const std::string text = prologue + expand(stage.file);
  const GLchar* pointer = text.c_str();
  const GLuint shader = gl.CreateShader(stage.type);
  gl.ShaderSource(shader, 1, &pointer, nullptr);
  gl.CompileShader(shader);
  GLint done = GL_FALSE;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &done);
  if (done == GL_TRUE) return shader;
  GLchar log[2048] = "";
  gl.GetShaderInfoLog(shader, sizeof log, nullptr, log);
  gl.DeleteShader(shader);
  throw Error(ExitCode::failure, fmt::format("shader {} does not compile: {}", stage.file, log));
}

}  // namespace

GlName make_buffer(const GlFunctions& gl) { return make_name(gl.GenBuffers, gl.DeleteBuffers); }
GlName make_texture(const GlFunctions& gl) { return make_name(gl.GenTextures, gl.DeleteTextures); }
GlName make_framebuffer(const GlFunctions& gl) {
  return make_name(gl.GenFramebuffers, gl.DeleteFramebuffers);
}
GlName make_vertex_array(const GlFunctions& gl) {
  return make_name(gl.GenVertexArrays, gl.DeleteVertexArrays);
}

GlName make_storage(const GlFunctions& gl, size_t bytes, const void* data, GLenum usage) {
  GlName buffer = make_buffer(gl);
  gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
  gl.BufferData(GL_SHADER_STORAGE_BUFFER, std::max<size_t>(bytes, 16), bytes >= 16 ? data : nullptr, usage);
  if (bytes > 0 && bytes < 16 && data != nullptr) gl.BufferSubData(GL_SHADER_STORAGE_BUFFER, 0, bytes, data);
  gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, 0);
  return buffer;
}

void read_triples(const GlFunctions& gl, const GlName& buffer, std::span<Vec3> values) {
  gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
  gl.GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, static_cast<GLsizeiptr>(values.size_bytes()),
                      values.data());
  gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, 0);
}

GlProgram::GlProgram(const GlFunctions& gl, std::initializer_list<ShaderStage> stages,
                     const std::vector<std::string>& defines)
    : gl_(&gl), program_(gl.CreateProgram()) {
  std::string prologue = "#version 430 core\n";
  for (const std::string& define : defines) prologue += fmt::format("#define {}\n", define);
  for (const ShaderStage& stage : stages) {
    GLuint shader = 0;
    try {
      shader = compile(gl, stage, prologue);
    } catch (...) {
      gl.DeleteProgram(program_);
      throw;
    }
    gl.AttachShader(program_, shader);
    gl.DeleteShader(shader);  // lives on while attached
  }
  gl.LinkProgram(program_);
  GLint done = GL_FALSE;
  gl.GetProgramiv(program_, GL_LINK_STATUS, &done);
  if (done == GL_TRUE) return;
  GLchar log[2048] = "";
  gl.GetProgramInfoLog(program_, sizeof log, nullptr, log);
  gl.DeleteProgram(program_);
  throw Error(ExitCode::failure,
              fmt::format("shader program {} does not link: {}", stages.begin()->file, log));
}

StateGuard::StateGuard(const GlFunctions& gl) : gl_(gl) {
  for (size_t i = 0; i < std::size(capabilities); ++i) enabled_[i] = gl.IsEnabled(capabilities[i]) == GL_TRUE;
  gl.GetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &draw_framebuffer_);
  gl.GetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &read_framebuffer_);
  gl.GetIntegerv(GL_CURRENT_PROGRAM, &program_);
  gl.GetIntegerv(GL_VERTEX_ARRAY_BINDING, &vertex_array_);
  gl.GetIntegerv(GL_ARRAY_BUFFER_BINDING, &array_buffer_);
  gl.GetIntegerv(GL_ACTIVE_TEXTURE, &active_texture_);
  gl.GetIntegerv(GL_VIEWPORT, viewport_);
  gl.GetIntegerv(GL_DEPTH_FUNC, &depth_function_);
  gl.GetIntegerv(GL_CLIP_ORIGIN, &clip_origin_);
  gl.GetIntegerv(GL_CLIP_DEPTH_MODE, &clip_depth_);
  gl.GetIntegerv(GL_PACK_ALIGNMENT, &pack_alignment_);
  gl.GetIntegerv(GL_POLYGON_MODE, polygon_mode_);
  gl.GetBooleanv(GL_DEPTH_WRITEMASK, &depth_mask_);
  gl.GetBooleanv(GL_COLOR_WRITEMASK, color_mask_);

  for (const GLenum capability : capabilities) gl.Disable(capability);
  gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  gl.DepthMask(GL_TRUE);
  gl.PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  gl.PixelStorei(GL_PACK_ALIGNMENT, 4);
  // Reversed depth in floating point: near / distance keeps the same relative precision at every distance.
  gl.ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  gl.DepthFunc(GL_GREATER);
}

StateGuard::~StateGuard() {
  for (size_t i = 0; i < std::size(capabilities); ++i)
    (enabled_[i] ? gl_.Enable : gl_.Disable)(capabilities[i]);
  gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, draw_framebuffer_);
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, read_framebuffer_);
  gl_.UseProgram(program_);
  gl_.BindVertexArray(vertex_array_);
  gl_.BindBuffer(GL_ARRAY_BUFFER, array_buffer_);
  gl_.ActiveTexture(active_texture_);
  gl_.Viewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
  gl_.DepthFunc(depth_function_);
  gl_.ClipControl(clip_origin_, clip_depth_);
  gl_.PixelStorei(GL_PACK_ALIGNMENT, pack_alignment_);
  gl_.PolygonMode(GL_FRONT_AND_BACK, polygon_mode_[0]);
  gl_.DepthMask(depth_mask_);
  gl_.ColorMask(color_mask_[0], color_mask_[1], color_mask_[2], color_mask_[3]);
}

}  // namespace halflight
