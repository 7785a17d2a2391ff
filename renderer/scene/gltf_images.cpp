#include "scene/gltf_images.h"

#include <atomic>
#include <map>
#include <tuple>

#include "core/parallel.h"
#include "scene/image_files.h"

namespace halflight {

namespace {

/// A material's lookups; `srgb` says how each one's RGB is encoded.
template <class Visit>
void visit_textures(Material& material, Visit&& visit) {
  visit(material.base_color_texture, true);
  visit(material.emission_texture, true);
  visit(material.specular_color_texture, true);
  visit(material.metallic_roughness_texture, false);
  visit(material.normal_texture, false);
  visit(material.specular_texture, false);
  visit(material.anisotropy_texture, false);
}

/// An image of the file while it is being decoded.
struct PendingImage {
  uint32_t index = 0;              ///< into GltfDocument::images
  std::span<const uint8_t> bytes;  ///< of a view
  std::filesystem::path path;      ///< of a file
  ImageRgba8 image;
  std::string fault;  ///< why it could not be read; empty where it could
};

std::string image_place(uint32_t index) { return fmt::format("images[{}]", index); }

/// Finds out where the bytes are; a URI that must not be opened throws.
PendingImage locate(const GltfSource& source, const GltfDocument& document, GltfReader& reader,
                    uint32_t index) {
  const GltfImage& image = document.images[index];
  PendingImage pending;
  pending.index = index;
  if (image.view >= 0 && !reader.view_has_data(static_cast<uint32_t>(image.view))) {
    pending.fault = "UNDEFINED_PROPERTY: its buffer has neither 'uri' nor data";
  } else if (image.view >= 0) {
    pending.bytes = reader.view(static_cast<uint32_t>(image.view));
  } else if (image.uri.empty()) {
    pending.fault = "ONE_OF_MISMATCH: has neither 'uri' nor 'bufferView'";
  } else if (!is_data_uri(image.uri)) {
    pending.path = resolve_uri(source, image.uri, image_place(index));
  }
  return pending;
}

void decode(const GltfSource& source, const GltfDocument& document, PendingImage& pending) {
  if (!pending.fault.empty()) return;
  const std::string place = image_place(pending.index);
  const LoadLimits& limits = source.options->limits;
  try {
    if (!pending.bytes.empty()) {
      pending.image = decode_ldr(pending.bytes, limits, source.name, place);
    } else if (!pending.path.empty()) {
      pending.image = decode_ldr(read_file(pending.path, limits.buffer_bytes), limits, source.name, place);
    } else {
      const auto bytes =
          decode_data_uri(source, document.images[pending.index].uri, limits.buffer_bytes, place);
      pending.image = decode_ldr(bytes, limits, source.name, place);
    }
  } catch (const Error& error) {
    pending.fault = error.what();
  }
}

/// The fault without the `file: place: ` that Messages::placeholder puts in front.
std::string reason_of(const GltfSource& source, const PendingImage& pending) {
  const std::string prefix = fmt::format("{}: {}: ", source.name, image_place(pending.index));
  const std::string& fault = pending.fault;
  return (fault.starts_with(prefix) ? fault.substr(prefix.size()) : fault) + "; a placeholder is used";
}

/// Decodes all of them; the sum of their pixels is bounded too.
void decode_all(const GltfSource& source, const GltfDocument& document, std::vector<PendingImage>& images) {
  std::atomic<uint64_t> pixels = 0;
  const uint64_t limit = source.options->limits.total_pixels;
  parallel_for(0, images.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      decode(source, document, images[i]);
      const ImageRgba8& image = images[i].image;
      pixels += static_cast<uint64_t>(image.width) * static_cast<uint64_t>(image.height);
      if (pixels > limit) images[i].image = {};
    }
  });
  if (pixels > limit) {
    source.fail(
        "images", "LIMIT",
        fmt::format("{} pixels in all, the limit is {} (--limit-total-pixels)", pixels.load(), limit));
  }
}

}  // namespace

void import_textures(const GltfSource& source, const GltfDocument& document, GltfReader& reader,
                     const std::vector<bool>& used, Scene& scene, Messages& messages) {
  // Images that are looked up, each once.
  std::map<uint32_t, size_t> slot;
  std::vector<PendingImage> images;
  const auto image_of = [&](const TextureUse& use) { return document.textures[use.texture].source; };
  for (size_t m = 0; m < document.materials.size(); ++m) {
    if (!used[m]) continue;
    visit_textures(scene.materials[m], [&](TextureUse& use, bool) {
      if (!use.used() || image_of(use) < 0) return;
      const uint32_t image = static_cast<uint32_t>(image_of(use));
      if (slot.emplace(image, images.size()).second)
        images.push_back(locate(source, document, reader, image));
    });
  }
  decode_all(source, document, images);

  // Scene's images are those that could be read.
  std::vector<int32_t> scene_image(images.size(), -1);
  for (size_t i = 0; i < images.size(); ++i) {
    if (images[i].fault.empty()) {
      scene_image[i] = static_cast<int32_t>(scene.images.size());
      scene.images.push_back(std::move(images[i].image));
    } else {
      messages.placeholder(source.name, image_place(images[i].index), reason_of(source, images[i]));
    }
  }

  std::map<std::tuple<int32_t, bool>, int32_t> known;
  for (size_t m = 0; m < document.materials.size(); ++m) {
    visit_textures(scene.materials[m], [&](TextureUse& use, bool srgb) {
      if (!use.used()) return;
      const int32_t file_index = use.texture;
      const GltfTexture& texture = document.textures[file_index];
      use.texture = -1;
      if (!used[m]) return;
      if (texture.source < 0) {
        if (known.emplace(std::tuple(file_index, false), -1).second) {
          messages.placeholder(source.name, fmt::format("textures[{}]", file_index),
                               "has no image that can be read; a placeholder is used");
        }
        return;
      }
      const int32_t image = scene_image[slot.at(static_cast<uint32_t>(texture.source))];
      if (image < 0) return;
      const auto [entry, fresh] =
          known.emplace(std::tuple(file_index, srgb), static_cast<int32_t>(scene.textures.size()));
      use.texture = entry->second;
      if (!fresh) return;
      const GltfSampler sampler = texture.sampler < 0 ? GltfSampler{} : document.samplers[texture.sampler];
      scene.textures.push_back({texture.name, static_cast<uint32_t>(image), srgb, sampler.nearest,
                                sampler.wrap_u, sampler.wrap_v});
    });
  }
}

}  // namespace halflight
