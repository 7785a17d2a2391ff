in vec2 uv;
in vec4 color;

uniform sampler2D image;

out vec4 result;

void main() { result = color * texture(image, uv); }
