#include "raster/ui_painter.h"

#include <cstddef>
#include <map>

#include "raster/gl_objects.h"

namespace halflight {

namespace {
constexpr Vec4 ground{0.055f, 0.057f, 0.062f, 1};
}

struct UiPainter::Impl {
  explicit Impl(GlContext& context_in)
      : context(base_of(context_in)),
        gl(context.gl),
        program(gl, {{GL_VERTEX_SHADER, "ui.vert"}, {GL_FRAGMENT_SHADER, "ui.frag"}}),
        vertex_array(make_vertex_array(gl)),
        vertices(make_buffer(gl)),
        indices(make_buffer(gl)) {
    gl.BindVertexArray(vertex_array);
    gl.BindBuffer(GL_ARRAY_BUFFER, vertices);
    gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices);
    const auto attribute = [&](GLuint index, GLint size, GLenum type, GLboolean normalized, size_t offset) {
      gl.EnableVertexAttribArray(index);
      gl.VertexAttribPointer(index, size, type, normalized, sizeof(UiVertex),
                             reinterpret_cast<const void*>(offset));
    };
    attribute(0, 2, GL_FLOAT, GL_FALSE, offsetof(UiVertex, position));
    attribute(1, 2, GL_FLOAT, GL_FALSE, offsetof(UiVertex, uv));
    attribute(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(UiVertex, color));
    gl.BindVertexArray(0);
  }

  void draw_mesh(const UiMesh& mesh, Vec2 scale, glm::ivec2 pixels);

  GlContextBase& context;
  const GlFunctions& gl;
  GlProgram program;
  GlName vertex_array, vertices, indices;
  std::map<uint32_t, GlName> textures;
};

UiPainter::UiPainter(GlContext& context) {
  base_of(context).make_current();
  impl_ = std::make_unique<Impl>(context);
}

UiPainter::~UiPainter() { impl_->context.make_current(); }

uint32_t UiPainter::set_texture(uint32_t id, const ImageRgba8& image) {
  const GlFunctions& gl = impl_->gl;
  impl_->context.make_current();
  if (id == 0) {
    GlName name = make_texture(gl);
    id = name;
    impl_->textures.emplace(id, std::move(name));
  }
  gl.ActiveTexture(GL_TEXTURE0);
  gl.BindTexture(GL_TEXTURE_2D, id);
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, image.width, image.height, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                image.bytes.data());
  for (GLenum parameter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    gl.TexParameteri(GL_TEXTURE_2D, parameter, GL_LINEAR);
  for (GLenum parameter : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    gl.TexParameteri(GL_TEXTURE_2D, parameter, GL_CLAMP_TO_EDGE);
  impl_->context.check("uploading a picture");
  return id;
}

void UiPainter::Impl::draw_mesh(const UiMesh& mesh, Vec2 scale, glm::ivec2 pixels) {
  gl.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(mesh.vertices.size_bytes()), mesh.vertices.data(),
                GL_STREAM_DRAW);
  gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(mesh.indices.size_bytes()),
                mesh.indices.data(), GL_STREAM_DRAW);
  for (const UiCommand& command : mesh.commands) {
    const glm::ivec2 low = glm::max(glm::ivec2(command.clip_low * scale), glm::ivec2(0));
    const glm::ivec2 high = glm::min(glm::ivec2(command.clip_high * scale), pixels);
    if (high.x <= low.x || high.y <= low.y) continue;
    gl.Scissor(low.x, pixels.y - high.y, high.x - low.x, high.y - low.y);
    gl.BindTexture(GL_TEXTURE_2D, command.texture);
    gl.DrawElementsBaseVertex(GL_TRIANGLES, static_cast<GLsizei>(command.index_count), GL_UNSIGNED_SHORT,
                              reinterpret_cast<const void*>(sizeof(uint16_t) * command.first_index),
                              static_cast<GLint>(command.base_vertex));
  }
}

void UiPainter::draw(std::span<const UiMesh> meshes, Vec2 size, glm::ivec2 pixels, ImageRgba8* target) {
  const GlFunctions& gl = impl_->gl;
  impl_->context.make_current();
  const StateGuard guard(gl);
  GlName color, framebuffer;
  if (target) {
    color = make_texture(gl);
    gl.BindTexture(GL_TEXTURE_2D, color);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, pixels.x, pixels.y, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
    framebuffer = make_framebuffer(gl);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, color, 0);
  }
  gl.Viewport(0, 0, pixels.x, pixels.y);
  for (GLenum capability : {GL_DEPTH_TEST, GL_CULL_FACE, GL_SCISSOR_TEST}) gl.Disable(capability);
  gl.ClearBufferfv(GL_COLOR, 0, &ground.x);
  gl.Enable(GL_BLEND);
  gl.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  gl.Enable(GL_SCISSOR_TEST);
  gl.ActiveTexture(GL_TEXTURE0);
  gl.BindVertexArray(impl_->vertex_array);
  gl.BindBuffer(GL_ARRAY_BUFFER, impl_->vertices);
  gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, impl_->indices);
  impl_->program.use();
  impl_->program.set("display_size", size);
  impl_->program.set("image", 0);
  for (const UiMesh& mesh : meshes) impl_->draw_mesh(mesh, Vec2(pixels) / size, pixels);

  if (target) {
    std::vector<uint8_t> rows(static_cast<size_t>(4) * pixels.x * pixels.y);
    gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl.ReadPixels(0, 0, pixels.x, pixels.y, GL_RGBA, GL_UNSIGNED_BYTE, rows.data());
    target->width = pixels.x, target->height = pixels.y;
    target->bytes.resize(rows.size());
    const size_t stride = static_cast<size_t>(4) * pixels.x;
    for (int y = 0; y < pixels.y; ++y)  // OpenGL's rows start at the bottom
      std::copy_n(rows.begin() + static_cast<ptrdiff_t>(stride) * (pixels.y - 1 - y), stride,
                  target->bytes.begin() + static_cast<ptrdiff_t>(stride) * y);
  }
  impl_->context.check("drawing the window");
}

}  // namespace halflight
