// Images, samplers, textures and materials as the file describes them; nothing is decoded here.
#include "scene/gltf_document.h"
#include "scene/gltf_json.h"

namespace halflight {

namespace {

Wrap read_wrap(const JsonObject& object, std::string_view key) {
  switch (object.integer(key, 10497)) {
    case 10497:
      return Wrap::repeat;
    case 33071:
      return Wrap::clamp;
    case 33648:
      return Wrap::mirror;
    default:
      object.warn(key, "VALUE_NOT_IN_LIST", "unknown wrapping; taken as repeat");
      return Wrap::repeat;
  }
}

void parse_images(GltfSource& source, GltfDocument& document) {
  JsonObject(source).for_each("images", [&](const JsonObject& object) {
    GltfImage image;
    image.uri = object.string("uri");
    image.view = object.index("bufferView", "bufferViews");
    object.string("mimeType");
    document.images.push_back(std::move(image));
  });
}

void parse_textures(GltfSource& source, GltfDocument& document) {
  JsonObject(source).for_each("samplers", [&](const JsonObject& object) {
    constexpr uint64_t nearest = 9728;
    document.samplers.push_back(
        {object.integer("magFilter", 0) == nearest, read_wrap(object, "wrapS"), read_wrap(object, "wrapT")});
    object.integer("minFilter", 0);
  });
  JsonObject(source).for_each("textures", [&](const JsonObject& object) {
    GltfTexture texture;
    texture.name = object.string("name");
    texture.source = object.index("source", "images");
    texture.sampler = object.index("sampler", "samplers");
    if (const auto webp = object.extension("EXT_texture_webp")) {
      const int32_t image = webp->index("source", "images");
#ifdef HALFLIGHT_HAVE_WEBP
      if (image >= 0) texture.source = image;
#else
      if (texture.source < 0) texture.source = image;
#endif
    }
    document.textures.push_back(std::move(texture));
  });
}

/// A textureInfo object with KHR_texture_transform: uv' = translation · rotation · scale · uv, where a
/// positive rotation turns the picture clockwise as seen (v runs down).
TextureUse read_texture(const JsonObject& parent, std::string_view key) {
  TextureUse use;
  const auto object = parent.object(key);
  if (!object) return use;
  use.texture = object->required_index("index", "textures");
  uint64_t set = object->integer("texCoord", 0);
  if (const auto transform = object->extension("KHR_texture_transform")) {
    set = transform->integer("texCoord", set);
    const auto pair = [&](std::string_view name, double otherwise) {
      const auto n = transform->numbers(name, 2);
      return n.empty() ? Vec2(static_cast<float>(otherwise)) : Vec2(n[0], n[1]);
    };
    const Vec2 offset = pair("offset", 0), scale = pair("scale", 1);
    const double angle = transform->number("rotation", 0);
    const float c = static_cast<float>(std::cos(angle)), s = static_cast<float>(std::sin(angle));
    use.row_u = {c * scale.x, s * scale.y, offset.x};
    use.row_v = {-s * scale.x, c * scale.y, offset.y};
  }
  if (set > 1) {
    object->warn("texCoord", "UNSUPPORTED_TEXCOORD",
                 fmt::format("set {}; only 0 and 1 are read, 0 is used", set));
    set = 0;
  }
  use.uv_set = static_cast<uint32_t>(set);
  return use;
}

void read_metallic_roughness(const JsonObject& object, Material& material) {
  material.base_color = object.color4("baseColorFactor", Vec4(1), 0, 1);
  material.metallic = static_cast<float>(object.clamped("metallicFactor", 1, 0, 1));
  material.roughness = static_cast<float>(object.clamped("roughnessFactor", 1, 0, 1));
  material.base_color_texture = read_texture(object, "baseColorTexture");
  material.metallic_roughness_texture = read_texture(object, "metallicRoughnessTexture");
}

void read_material_extensions(const JsonObject& object, Material& material) {
  if (const auto strength = object.extension("KHR_materials_emissive_strength")) {
    material.emission *= static_cast<float>(strength->clamped("emissiveStrength", 1, 0, 1e30));
  }
  if (const auto ior = object.extension("KHR_materials_ior")) {
    material.ior = static_cast<float>(ior->clamped("ior", 1.5, 0, 1e6));
    // KHR_materials_ior: 0 means that Fresnel reflection is total at every angle.
    if (material.ior == 0) material.ior = 1e6f;
    material.ior = std::max(material.ior, 1.0f);
  }
  if (const auto specular = object.extension("KHR_materials_specular")) {
    material.specular = static_cast<float>(specular->clamped("specularFactor", 1, 0, 1));
    material.specular_color = specular->color3("specularColorFactor", Vec3(1), 0, 1e6);
    material.specular_texture = read_texture(*specular, "specularTexture");
    material.specular_color_texture = read_texture(*specular, "specularColorTexture");
  }
  if (const auto anisotropy = object.extension("KHR_materials_anisotropy")) {
    material.anisotropy = static_cast<float>(anisotropy->clamped("anisotropyStrength", 0, 0, 1));
    material.anisotropy_rotation = static_cast<float>(anisotropy->number("anisotropyRotation", 0));
    material.anisotropy_texture = read_texture(*anisotropy, "anisotropyTexture");
  }
  material.unlit = object.extension("KHR_materials_unlit").has_value();
}

/// The papers' reflection models through `extras` (docs/scenes.md).
void read_paper_model(const JsonObject& object, Material& material) {
  const std::string brdf = object.string("brdf");
  if (brdf == "phong") {
    material.model = BrdfModel::phong;
    material.exponents = Vec2(static_cast<float>(object.number("exponent", 10, 0, 1e9)));
  } else if (brdf == "ashikhmin-shirley") {
    material.model = BrdfModel::ashikhmin_shirley;
    const auto n = object.numbers("exponents", 2);
    if (!n.empty()) {
      for (const double exponent : n) {
        if (!(exponent >= 0 && exponent <= 1e9)) {
          object.fail("exponents", "VALUE_NOT_IN_RANGE", fmt::format("{} is out of range", exponent));
        }
      }
      material.exponents = {static_cast<float>(n[0]), static_cast<float>(n[1])};
    }
  } else {
    object.fail("brdf", "VALUE_NOT_IN_LIST",
                fmt::format("'{}' is unknown (valid: phong, ashikhmin-shirley)", printable(brdf)));
  }
  material.diffuse = object.vec3("diffuse", Vec3(0), 0, 1);
  material.phong_specular = object.vec3("specular", Vec3(0), 0, 1);
}

void read_alpha(const JsonObject& object, Material& material) {
  const std::string mode = object.string("alphaMode", "OPAQUE");
  if (mode == "MASK")
    material.alpha_mode = AlphaMode::mask;
  else if (mode == "BLEND")
    material.alpha_mode = AlphaMode::blend;
  else if (mode != "OPAQUE") {
    object.warn("alphaMode", "VALUE_NOT_IN_LIST",
                fmt::format("'{}' is unknown; taken as OPAQUE", printable(mode)));
  }
  material.alpha_cutoff = static_cast<float>(object.clamped("alphaCutoff", 0.5, 0, 1e6));
}

Material read_material(const JsonObject& object) {
  Material material;
  material.name = object.string("name");
  if (const auto pbr = object.object("pbrMetallicRoughness")) read_metallic_roughness(*pbr, material);
  material.normal_texture = read_texture(object, "normalTexture");
  if (const auto normal = object.object("normalTexture")) {
    material.normal_scale = static_cast<float>(normal->number("scale", 1, -1e6, 1e6));
  }
  material.emission_texture = read_texture(object, "emissiveTexture");
  material.emission = object.color3("emissiveFactor", Vec3(0), 0, 1e6);
  material.double_sided = object.boolean("doubleSided", false);
  read_texture(object, "occlusionTexture");
  read_alpha(object, material);
  read_material_extensions(object, material);
  if (const auto ours = object.extra("halflight")) read_paper_model(*ours, material);
  return material;
}

}  // namespace

void parse_materials(GltfSource& source, GltfDocument& document) {
  parse_images(source, document);
  parse_textures(source, document);
  JsonObject(source).for_each(
      "materials", [&](const JsonObject& object) { document.materials.push_back(read_material(object)); });
}

}  // namespace halflight
