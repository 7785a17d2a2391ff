// Window content: positions in points from the top left.
layout(location = 0) in vec2 position;
layout(location = 1) in vec2 texture_position;
layout(location = 2) in vec4 vertex_color;

uniform vec2 display_size;

out vec2 uv;
out vec4 color;

void main() {
  uv = texture_position;
  color = vertex_color;
  vec2 unit = position / display_size;
  gl_Position = vec4(2.0 * unit.x - 1.0, 1.0 - 2.0 * unit.y, 0.0, 1.0);
}
