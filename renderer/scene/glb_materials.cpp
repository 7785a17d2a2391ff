// Images, textures, materials, lights and cameras of a glTF document, and what glTF has no words for:
// `extras` named "halflight" hold the papers' BRDFs, projectors' slides and the environment.
#include "core/errors.h"
#include "scene/glb_document.h"

#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb_image_write.h>

namespace halflight {

namespace {

Json to_json(Vec3 v) { return {v.x, v.y, v.z}; }
Json to_json(Vec4 v) { return {v.x, v.y, v.z, v.w}; }

std::string png_bytes(const ImageRgba8& image) {
  std::string bytes;
  const auto append = [](void* context, void* data, int size) {
    static_cast<std::string*>(context)->append(static_cast<const char*>(data), static_cast<size_t>(size));
  };
  stbi_write_png_to_func(append, &bytes, image.width, image.height, 4, image.bytes.data(), 4 * image.width);
  return bytes;
}

int wrap_code(Wrap wrap) { return wrap == Wrap::repeat ? 10497 : wrap == Wrap::mirror ? 33648 : 33071; }

/// textureInfo object; the transform is offset · rotation · scale (KHR_texture_transform), without shear.
Json texture_info(GlbDocument& document, const TextureUse& use) {
  Json info{{"index", use.texture}};
  if (use.uv_set != 0) info["texCoord"] = use.uv_set;
  if (use.row_u == Vec3(1, 0, 0) && use.row_v == Vec3(0, 1, 0)) return info;
  const float scale_u = std::hypot(use.row_u.x, use.row_v.x);
  const float determinant = use.row_u.x * use.row_v.y - use.row_u.y * use.row_v.x;
  Json transform;
  transform["offset"] = {use.row_u.z, use.row_v.z};
  if (use.row_v.x != 0 || use.row_u.x < 0) transform["rotation"] = std::atan2(-use.row_v.x, use.row_u.x);
  transform["scale"] = {scale_u, scale_u > 0 ? determinant / scale_u : use.row_v.y};
  info["extensions"]["KHR_texture_transform"] = std::move(transform);
  document.extensions.insert("KHR_texture_transform");
  return info;
}

void put_texture(GlbDocument& document, Json& owner, const char* name, const TextureUse& use) {
  if (use.used()) owner[name] = texture_info(document, use);
}

void put_extension(GlbDocument& document, Json& material, const char* name, Json value) {
  if (value.empty()) return;
  material["extensions"][name] = std::move(value);
  document.extensions.insert(name);
}

void put_extensions(GlbDocument& document, Json& json, const Material& material) {
  if (material.unlit) {
    json["extensions"]["KHR_materials_unlit"] = Json::object();
    document.extensions.insert("KHR_materials_unlit");
  }
  if (material.ior != 1.5f) put_extension(document, json, "KHR_materials_ior", {{"ior", material.ior}});
  Json specular;
  if (material.specular != 1) specular["specularFactor"] = material.specular;
  if (material.specular_color != Vec3(1)) specular["specularColorFactor"] = to_json(material.specular_color);
  put_texture(document, specular, "specularTexture", material.specular_texture);
  put_texture(document, specular, "specularColorTexture", material.specular_color_texture);
  put_extension(document, json, "KHR_materials_specular", specular);
  Json anisotropy;
  if (material.anisotropy != 0) anisotropy["anisotropyStrength"] = material.anisotropy;
  if (material.anisotropy_rotation != 0) anisotropy["anisotropyRotation"] = material.anisotropy_rotation;
  put_texture(document, anisotropy, "anisotropyTexture", material.anisotropy_texture);
  put_extension(document, json, "KHR_materials_anisotropy", anisotropy);
}

/// The papers' models; see docs/scenes.md.
void put_paper_model(Json& json, const Material& material) {
  if (material.model == BrdfModel::ggx || material.model == BrdfModel::none) return;
  const bool phong = material.model == BrdfModel::phong;
  Json& extra = json["extras"]["halflight"];
  extra["brdf"] = phong ? "phong" : "ashikhmin-shirley";
  extra["diffuse"] = to_json(material.diffuse);
  extra["specular"] = to_json(material.phong_specular);
  if (phong)
    extra["exponent"] = material.exponents.x;
  else
    extra["exponents"] = {material.exponents.x, material.exponents.y};
}

Json material_json(GlbDocument& document, const Material& material) {
  Json json;
  if (!material.name.empty()) json["name"] = material.name;
  Json& base = json["pbrMetallicRoughness"];
  base["baseColorFactor"] = to_json(material.base_color);
  base["metallicFactor"] = material.metallic;
  base["roughnessFactor"] = material.roughness;
  put_texture(document, base, "baseColorTexture", material.base_color_texture);
  put_texture(document, base, "metallicRoughnessTexture", material.metallic_roughness_texture);
  put_texture(document, json, "normalTexture", material.normal_texture);
  if (material.normal_texture.used() && material.normal_scale != 1)
    json["normalTexture"]["scale"] = material.normal_scale;
  put_texture(document, json, "emissiveTexture", material.emission_texture);
  if (material.emissive()) {
    // emissiveFactor may not exceed 1.
    const float strength = std::max(1.0f, max_component(material.emission));
    json["emissiveFactor"] = to_json(material.emission / strength);
    if (strength > 1)
      put_extension(document, json, "KHR_materials_emissive_strength", {{"emissiveStrength", strength}});
  }
  if (material.alpha_mode == AlphaMode::mask)
    json["alphaMode"] = "MASK", json["alphaCutoff"] = material.alpha_cutoff;
  if (material.alpha_mode == AlphaMode::blend) json["alphaMode"] = "BLEND";
  if (material.double_sided) json["doubleSided"] = true;
  put_extensions(document, json, material);
  put_paper_model(json, material);
  return json;
}

/// Node that stands at `position` and looks along −`back`.
Json placed_node(Vec3 position, Vec3 right, Vec3 up, Vec3 back) {
  const glm::quat rotation = glm::normalize(glm::quat_cast(Mat3(right, up, back)));
  return {{"translation", to_json(position)}, {"rotation", {rotation.x, rotation.y, rotation.z, rotation.w}}};
}

Json light_json(const PunctualLight& light) {
  const float strength = max_component(light.intensity);
  Json json;
  if (!light.name.empty()) json["name"] = light.name;
  json["type"] = light.kind == PunctualKind::point  ? "point"
                 : light.kind == PunctualKind::spot ? "spot"
                                                    : "directional";
  json["color"] = to_json(strength > 0 ? light.intensity / strength : Vec3(1));
  json["intensity"] = std::max(0.0f, strength);
  if (light.kind != PunctualKind::directional && std::isfinite(light.range)) json["range"] = light.range;
  if (light.kind == PunctualKind::spot)
    json["spot"] = {{"innerConeAngle", light.inner_cone}, {"outerConeAngle", light.outer_cone}};
  return json;
}

}  // namespace

void add_images(GlbDocument& document, const Scene& scene) {
  for (const ImageRgba8& image : scene.images) {
    const std::string png = png_bytes(image);
    document.add("images",
                 {{"bufferView", document.add_view(png.data(), png.size(), 0)}, {"mimeType", "image/png"}});
  }
  for (const Texture& texture : scene.textures) {
    Json sampler{{"wrapS", wrap_code(texture.wrap_u)}, {"wrapT", wrap_code(texture.wrap_v)}};
    if (texture.nearest) sampler["magFilter"] = 9728, sampler["minFilter"] = 9728;
    Json json{{"source", texture.image}, {"sampler", document.add("samplers", std::move(sampler))}};
    if (!texture.name.empty()) json["name"] = texture.name;
    document.add("textures", std::move(json));
  }
}

void add_materials(GlbDocument& document, const Scene& scene) {
  for (const Material& material : scene.materials)
    document.add("materials", material_json(document, material));
}

void add_lights(GlbDocument& document, const Scene& scene, const std::string& stem,
                std::vector<SidePicture>& pictures) {
  if (scene.lights.empty()) return;
  const auto slide_name = [&](size_t i) { return fmt::format("{}-slide-{}.hdr", stem, i); };
  for (size_t i = 0; i < scene.pictures.size(); ++i) pictures.push_back({slide_name(i), scene.pictures[i]});
  Json lights = Json::array();
  for (const PunctualLight& light : scene.lights) {
    Json json = light_json(light);
    if (light.picture >= 0)
      json["extras"]["halflight"]["picture"] = slide_name(static_cast<size_t>(light.picture));
    lights.push_back(std::move(json));
    const Basis frame = basis_along(-light.direction, light.up);  // tangent: the picture's top
    Json node =
        placed_node(light.position, glm::cross(frame.tangent, frame.normal), frame.tangent, frame.normal);
    if (!light.name.empty()) node["name"] = light.name;
    node["extensions"]["KHR_lights_punctual"]["light"] = lights.size() - 1;
    document.add_node(std::move(node));
  }
  document.extensions.insert("KHR_lights_punctual");
  document.json["extensions"]["KHR_lights_punctual"]["lights"] = std::move(lights);
}

void add_cameras(GlbDocument& document, const Scene& scene) {
  const float extent = scene.bounds.empty() ? 1 : scene.bounds.diagonal();
  for (const Camera& camera : scene.cameras) {
    Json json;
    if (!camera.name.empty()) json["name"] = camera.name;
    if (camera.projection == Projection::perspective) {
      json["type"] = "perspective";
      json["perspective"] = {{"yfov", camera.vertical_fov}, {"znear", 1e-3f * extent}};
    } else {
      json["type"] = "orthographic";
      json["orthographic"] = {
          {"xmag", camera.half_height}, {"ymag", camera.half_height}, {"znear", 0.0f}, {"zfar", 4 * extent}};
    }
    Json node = placed_node(camera.position, camera.right, camera.up, camera.back);
    if (!camera.name.empty()) node["name"] = camera.name;
    node["camera"] = document.add("cameras", std::move(json));
    document.add_node(std::move(node));
  }
}

void add_environment(GlbDocument& document, const Scene& scene, const std::string& stem,
                     std::vector<SidePicture>& pictures) {
  if (!scene.environment.present()) return;
  pictures.push_back({stem + ".hdr", scene.environment.map});
  document.scene["extras"]["halflight"]["environment"] = {
      {"file", stem + ".hdr"},
      {"rotation", glm::degrees(scene.environment.rotation)},
      {"strength", scene.environment.strength}};
}

}  // namespace halflight
