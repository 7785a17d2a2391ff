// A caster in a light's view; origin and axes as in GpuShadowView.
layout(location = 0) in vec3 position;

uniform vec4 view_origin, view_right, view_up, view_forward;
uniform int orthographic;

invariant gl_Position;

void main() {
  // Relative to the light first: far from the world's origin the difference is still exact.
  vec3 offset = position - view_origin.xyz;
  float x = dot(offset, view_right.xyz) / view_right.w, y = dot(offset, view_up.xyz) / view_right.w;
  float z = dot(offset, view_forward.xyz);
  gl_Position = orthographic != 0 ? vec4(x, y, 1.0 - z / view_origin.w, 1.0) : vec4(x, y, view_origin.w, z);
}
