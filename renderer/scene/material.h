// Materials as files describe them; `scene/shading.h` turns one into a Brdf at a point.
#pragma once

#include <cstdint>
#include <string>

#include "core/image.h"
#include "core/math.h"

namespace halflight {

enum class Wrap : uint8_t { repeat, mirror, clamp };

/// An image with the way it is looked up. `image` indexes Scene::images.
struct Texture {
  std::string name;
  uint32_t image = 0;
  bool srgb = false;     ///< RGB is sRGB-encoded (alpha never is)
  bool nearest = false;  ///< no filtering
  Wrap wrap_u = Wrap::repeat, wrap_v = Wrap::repeat;
};

/// A use of a texture: uv' = transform · (u, v, 1), KHR_texture_transform.
struct TextureUse {
  int32_t texture = -1;  ///< index into Scene::textures, or -1
  uint32_t uv_set = 0;   ///< 0 or 1
  Vec3 row_u{1, 0, 0}, row_v{0, 1, 0};

  bool used() const { return texture >= 0; }
};

enum class BrdfModel : uint32_t { none, ggx, phong, ashikhmin_shirley };
enum class AlphaMode : uint32_t { opaque, mask, blend };

/// glTF's metallic-roughness material, or one of the papers' models (through glTF `extras`, docs/scenes.md).
struct Material {
  std::string name;
  BrdfModel model = BrdfModel::ggx;

  // GGX, glTF 2.0 with KHR_materials_ior, specular, anisotropy.
  Vec4 base_color{1};
  float metallic = 1, roughness = 1;
  float ior = 1.5f;
  float specular = 1;
  Vec3 specular_color{1};
  float anisotropy = 0, anisotropy_rotation = 0;  ///< strength in [0, 1]; radians from the tangent

  // Phong and Ashikhmin–Shirley: reflectances and exponents. base_color's texture scales `diffuse`.
  Vec3 diffuse{0}, phong_specular{0};
  Vec2 exponents{10};  ///< Phong: n = x; Ashikhmin–Shirley: (nu, nv)

  Vec3 emission{0};  ///< radiance in nits per unit of emission texture: emissiveFactor × emissive_strength
  AlphaMode alpha_mode = AlphaMode::opaque;
  float alpha_cutoff = 0.5f;
  bool double_sided = false;  ///< emits from both sides; every surface reflects and blocks on both
  bool unlit = false;         ///< KHR_materials_unlit: base colour is what the camera sees, and nothing is reflected
  float normal_scale = 1;

  TextureUse base_color_texture, metallic_roughness_texture, normal_texture, emission_texture;
  TextureUse specular_texture, specular_color_texture, anisotropy_texture;

  bool emissive() const { return max_component(emission) > 0; }
};

}  // namespace halflight
