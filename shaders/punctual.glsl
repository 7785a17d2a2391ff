// Punctual lights and their shadow maps. Light as `connect_punctual` of renderer/lights/virtual_light.h has it.

layout(std430, binding = BINDING_LIGHTS) readonly buffer Lights { GpuLight lights[]; };
layout(std430, binding = BINDING_SHADOW_VIEWS) readonly buffer ShadowViews { GpuShadowView shadow_views[]; };
layout(std430, binding = BINDING_PICTURES) readonly buffer Pictures { float picture_values[]; };
layout(binding = UNIT_SHADOW_MAPS) uniform sampler2DArray shadow_maps;
layout(binding = UNIT_SHADOW_CUBES) uniform sampler2DArray shadow_cubes;

uniform uint light_count;
// Greatest coordinate of the scene, for `surface_epsilon` of renderer/scene/scene.h.
uniform float scene_extreme;

// How far a receiver is moved off its surface, and how far its plane is followed behind it, in texels at its distance.
const float normal_offset = 0.5, greatest_depth_step = 2.0;

// ---- Light ----

vec3 picture_pixel(GpuLight light, int x, int y) {
  uint width = light.kinds.z, height = light.kinds.w;
  uint at = light.kinds.y + uint(clamp(y, 0, int(height) - 1)) * width + uint(clamp(x, 0, int(width) - 1));
  return vec3(picture_values[3u * at], picture_values[3u * at + 1u], picture_values[3u * at + 2u]);
}

/// Value of a projector's picture towards `travel`, bilinear; 1 without a picture, 0 beside it.
vec3 picture_value(GpuLight light, vec3 travel, float cosine) {
  if (light.kinds.w == 0u) return vec3(1.0);
  if (cosine <= 0.0) return vec3(0.0);
  vec3 right = cross(light.direction.xyz, light.up.xyz);
  vec2 uv = 0.5 + 0.5 * vec2(dot(travel, right), -dot(travel, light.up.xyz)) * (light.intensity.w / cosine);
  if (any(lessThan(uv, vec2(0.0))) || any(greaterThan(uv, vec2(1.0)))) return vec3(0.0);
  vec2 texel = uv * vec2(light.kinds.zw) - 0.5;
  vec2 corner = floor(texel), f = texel - corner;
  int x = int(corner.x), y = int(corner.y);
  return mix(mix(picture_pixel(light, x, y), picture_pixel(light, x + 1, y), f.x),
             mix(picture_pixel(light, x, y + 1), picture_pixel(light, x + 1, y + 1), f.x), f.y);
}

/// Irradiance per unit of cosine that the light would give at x unoccluded, and the unit direction towards it.
vec3 punctual_irradiance(GpuLight light, vec3 x, out vec3 wi) {
  if (light.kinds.x == LIGHT_DIRECTIONAL) {
    wi = -light.direction.xyz;
    return light.intensity.rgb;
  }
  vec3 offset = light.position.xyz - x;
  // Scaled first: squares of tiny lengths vanish in float.
  float scale = max(max(abs(offset.x), abs(offset.y)), abs(offset.z));
  wi = vec3(0.0);
  if (!(scale > 0.0)) return vec3(0.0);
  float r = scale * length(offset / scale);
  wi = offset / r;
  vec3 irradiance = light.intensity.rgb / r / r;
  if (light.position.w >= 0.0) {
    float ratio = r / light.position.w;
    irradiance *= clamp(1.0 - ratio * ratio * ratio * ratio, 0.0, 1.0);
  }
  if (light.kinds.x == LIGHT_SPOT) {
    float cosine = dot(light.direction.xyz, -wi);
    float ramp = clamp((cosine - light.up.w) * light.direction.w, 0.0, 1.0);
    if (!(ramp > 0.0)) return vec3(0.0);
    irradiance *= ramp * ramp * picture_value(light, -wi, cosine);
  }
  return irradiance;
}

// ---- Shadow ----

/// Which of the light's views sees the point: the face of the axis along which it lies farthest.
uint view_of(GpuLight light, vec3 x) {
  if (light.shadow.y < CUBE_FACES) return light.shadow.x;
  vec3 offset = x - light.position.xyz, a = abs(offset);
  uint axis = a.x >= a.y && a.x >= a.z ? 0u : a.y >= a.z ? 1u : 2u;
  return light.shadow.x + 2u * axis + (offset[axis] < 0.0 ? 1u : 0u);
}

/// 1 where nothing in the texel lies before `depth`.
float texel_passes(GpuShadowView view, ivec2 texel, float depth) {
  ivec3 at = ivec3(clamp(texel, ivec2(0), ivec2(int(view.place.w) - 1)), int(view.place.x));
  float stored = view.place.y != 0u ? texelFetch(shadow_cubes, at, 0).r : texelFetch(shadow_maps, at, 0).r;
  bool passes = view.place.z != 0u ? depth <= (1.0 - stored) * view.origin.w : depth * stored <= view.origin.w;
  return passes ? 1.0 : 0.0;
}

/// Fraction of the four texels around x that see it, weighed bilinearly. `n`: unit normal on the light's side.
/// Bias: x is moved along n by half a texel's width there, and each texel is compared with the depth its own centre line
/// has on the plane through the moved point, so that a flat surface never shadows itself however steeply it is lit.
float visibility(GpuLight light, vec3 x, vec3 n) {
  if (light.shadow.y == 0u) return 1.0;
  GpuShadowView view = shadow_views[view_of(light, x)];
  bool orthographic = view.place.z != 0u;
  float size = float(view.place.w), half_width = view.right.w;

  // Move the point off its surface
  vec3 offset = x - view.origin.xyz;
  float z = dot(offset, view.forward.xyz);
  float texel = 2.0 * half_width / size * (orthographic ? 1.0 : max(z, 0.0));
  float greatest = max(max(abs(x.x), abs(x.y)), abs(x.z));
  offset += n * (normal_offset * texel + greatest / 524288.0 + scene_extreme / 2097152.0);
  z = dot(offset, view.forward.xyz);
  if (!orthographic && !(z > view.origin.w)) return 1.0;

  // Find its four texels
  vec3 in_view = vec3(dot(n, view.right.xyz), dot(n, view.up.xyz), dot(n, view.forward.xyz));
  vec2 p = vec2(dot(offset, view.right.xyz), dot(offset, view.up.xyz)) / (half_width * (orthographic ? 1.0 : z));
  vec2 t = (0.5 * p + 0.5) * size - 0.5;
  vec2 corner = floor(t), f = t - corner;
  float plane = dot(n, offset), sum = 0.0;
  for (int i = 0; i < 4; ++i) {
    vec2 neighbour = vec2(float(i & 1), float(i >> 1));
    // Depth of the receiver's plane on the line through the texel's centre
    vec2 centre = (2.0 * (corner + neighbour + 0.5) / size - 1.0) * half_width;
    float slope = orthographic ? in_view.z : dot(in_view, vec3(centre, 1.0));
    float depth = orthographic ? plane - dot(in_view.xy, centre) : plane;
    float farthest = z + greatest_depth_step * texel;
    depth = slope < 0.0 ? min(depth / slope, farthest) : farthest;
    vec2 weight = mix(1.0 - f, f, neighbour);
    sum += weight.x * weight.y * texel_passes(view, ivec2(corner + neighbour), depth);
  }
  return sum;
}
