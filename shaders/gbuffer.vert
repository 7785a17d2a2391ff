// The scene seen from the camera; everything else is found in the fragment shader.
layout(location = 0) in vec3 position;

uniform vec3 eye;
uniform mat4 clip_from_eye_offset;

invariant gl_Position;

void main() {
  // Relative to the eye first: far from the world's origin the difference is still exact.
  gl_Position = clip_from_eye_offset * vec4(position - eye, 1.0);
}
