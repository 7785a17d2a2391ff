// The contents of a glTF file as plain structs: indices checked, defaults filled in, nothing decoded.
#pragma once

#include <array>
#include <optional>

#include "scene/gltf_source.h"
#include "scene/scene.h"

namespace halflight {

enum class GltfComponent : uint32_t { int8 = 5120, uint8, int16, uint16, uint32 = 5125, float32 };

size_t component_size(GltfComponent);

struct GltfBuffer {
  uint64_t length = 0;             ///< declared
  std::vector<uint8_t> owned;      ///< of a file or a data: URI
  std::span<const uint8_t> bytes;  ///< into `owned` or the GLB; empty where the file gives no data
};

enum class MeshoptMode { attributes, triangles, indices };
enum class MeshoptFilter { none, octahedral, quaternion, exponential };

/// EXT_meshopt_compression of a buffer view.
struct MeshoptView {
  uint32_t buffer = 0;
  uint64_t offset = 0, length = 0, stride = 0, count = 0;
  MeshoptMode mode = MeshoptMode::attributes;
  MeshoptFilter filter = MeshoptFilter::none;
};

struct GltfBufferView {
  uint32_t buffer = 0;
  uint64_t offset = 0, length = 0;
  uint64_t stride = 0;  ///< 0: packed
  std::optional<MeshoptView> meshopt;
};

struct GltfSparse {
  uint64_t count = 0;
  uint32_t index_view = 0, value_view = 0;
  uint64_t index_offset = 0, value_offset = 0;
  GltfComponent index_component = GltfComponent::uint16;
};

struct GltfAccessor {
  int32_t view = -1;
  uint64_t offset = 0, count = 0;
  GltfComponent component = GltfComponent::float32;
  uint32_t columns = 1, rows = 1;  ///< a matrix has columns, a vector rows
  bool normalized = false;
  std::optional<GltfSparse> sparse;

  uint32_t width() const { return columns * rows; }
  /// Bytes of one element; each column of a matrix begins at a multiple of 4 bytes.
  uint64_t element_size() const;
  /// "VEC3 of float", for messages.
  std::string format() const;
};

struct GltfAttribute {
  std::string name;
  uint32_t accessor = 0;
};
using GltfAttributes = std::vector<GltfAttribute>;

/// Accessor of a semantic, or -1.
int32_t find_attribute(const GltfAttributes&, std::string_view name);

/// KHR_draco_mesh_compression: `attributes` holds Draco's own ids.
struct DracoPrimitive {
  uint32_t view = 0;
  GltfAttributes attributes;
};

struct GltfPrimitive {
  GltfAttributes attributes;
  std::vector<GltfAttributes> targets;
  int32_t indices = -1, material = -1;
  uint32_t mode = 4;
  std::optional<DracoPrimitive> draco;
};

struct GltfMesh {
  std::string name;
  std::vector<GltfPrimitive> primitives;
  std::vector<double> weights;
};

struct GltfNode {
  std::string name;
  std::vector<uint32_t> children;
  std::optional<std::array<double, 16>> matrix;
  glm::dvec3 translation{0}, scale{1};
  glm::dquat rotation{1, 0, 0, 0};
  std::vector<double> weights;
  int32_t mesh = -1, skin = -1, camera = -1, light = -1;
};

struct GltfSkin {
  std::vector<uint32_t> joints;
  int32_t inverse_bind_matrices = -1;
};

enum class GltfPath { translation, rotation, scale, weights, other };
enum class GltfInterpolation { linear, step, cubic_spline };

struct GltfChannel {
  uint32_t sampler = 0;
  int32_t node = -1;
  GltfPath path = GltfPath::other;
};

struct GltfAnimationSampler {
  uint32_t input = 0, output = 0;
  GltfInterpolation interpolation = GltfInterpolation::linear;
};

struct GltfAnimation {
  std::vector<GltfChannel> channels;
  std::vector<GltfAnimationSampler> samplers;
};

struct GltfImage {
  std::string uri;
  int32_t view = -1;
};

struct GltfSampler {
  bool nearest = false;
  Wrap wrap_u = Wrap::repeat, wrap_v = Wrap::repeat;
};

struct GltfTexture {
  std::string name;
  int32_t source = -1;  ///< the image to use: WebP's where the extension gives one that can be read
  int32_t sampler = -1;
};

struct GltfLight {
  PunctualLight light;
  std::string picture;  ///< projector's slide, a relative URI; from extras
  bool known_type = true;
};

/// A scene's distant light, from extras (docs/scenes.md).
struct GltfEnvironment {
  std::string file;    ///< a relative URI; empty where there is none
  float rotation = 0;  ///< radians
  float strength = 1;
};

struct GltfDocument {
  std::vector<GltfBuffer> buffers;
  std::vector<GltfBufferView> views;
  std::vector<GltfAccessor> accessors;
  std::vector<GltfMesh> meshes;
  std::vector<GltfNode> nodes;
  std::vector<GltfSkin> skins;
  std::vector<GltfAnimation> animations;
  std::vector<GltfImage> images;
  std::vector<GltfSampler> samplers;
  std::vector<GltfTexture> textures;
  std::vector<Material>
      materials;  ///< TextureUse::texture indexes `textures` until `import_textures` replaces it
  std::vector<Camera> cameras;    ///< in their own frame
  std::vector<GltfLight> lights;  ///< in their own frame
  std::vector<uint32_t> roots;    ///< of the scene that is shown
  GltfEnvironment environment;    ///< of the scene that is shown
  std::vector<std::string> extensions_used, ignored_extensions;
  bool quantized = false;  ///< KHR_mesh_quantization is declared
};

/// Reads everything but the bytes of buffers and images. Throws Error (exit code 3).
GltfDocument parse_gltf(GltfSource&);

// Its parts; one root array or extension each.
void parse_extensions(GltfSource&, GltfDocument&);
void parse_data(GltfSource&, GltfDocument&);  ///< buffers, views, accessors
void parse_meshes(GltfSource&, GltfDocument&);
void parse_nodes(GltfSource&, GltfDocument&);  ///< nodes, skins, scenes
void parse_animations(GltfSource&, GltfDocument&);
void parse_materials(GltfSource&, GltfDocument&);  ///< images, samplers, textures, materials
void parse_cameras(GltfSource&, GltfDocument&);
void parse_lights(GltfSource&, GltfDocument&);

/// Loads the bytes of all buffers: BIN chunk, data: URIs, files.
void load_buffers(GltfSource&, GltfDocument&);

/// What the structs cannot hold: ranges of views and accessors, formats and counts of attributes, the node
/// graph.
void validate_gltf(GltfSource&, const GltfDocument&);
void validate_data(GltfSource&, const GltfDocument&);
void validate_meshes(GltfSource&, const GltfDocument&);
void validate_graph(GltfSource&, const GltfDocument&);
void validate_animations(GltfSource&, const GltfDocument&);

}  // namespace halflight
