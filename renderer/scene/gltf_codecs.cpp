// Compressed geometry: KHR_draco_mesh_compression and EXT_meshopt_compression, where their libraries are
// there.
#include "scene/gltf_accessors.h"

#ifdef HALFLIGHT_HAVE_DRACO
#include <draco/compression/decode.h>
#endif
#ifdef HALFLIGHT_HAVE_MESHOPT
#include <meshoptimizer.h>
#endif

namespace halflight {

#ifdef HALFLIGHT_HAVE_MESHOPT

namespace {

/// The library asserts these; a file must not get that far.
void check_meshopt(const GltfSource& source, const MeshoptView& view, const std::string& place) {
  const bool of_indices = view.mode != MeshoptMode::attributes;
  const bool stride_fits = of_indices ? view.stride == 2 || view.stride == 4 : view.stride % 4 == 0;
  if (!stride_fits) source.fail(place, "VALUE_NOT_IN_LIST", fmt::format("byteStride {}", view.stride));
  if (view.mode == MeshoptMode::triangles && view.count % 3 != 0) {
    source.fail(place, "VALUE_MULTIPLE_OF", fmt::format("count {} is not a multiple of 3", view.count));
  }
  const bool filter_fits =
      view.filter == MeshoptFilter::none ||
      (!of_indices && (view.filter != MeshoptFilter::octahedral || view.stride == 4 || view.stride == 8) &&
       (view.filter != MeshoptFilter::quaternion || view.stride == 8));
  if (!filter_fits) source.fail(place, "VALUE_NOT_IN_LIST", "the filter does not fit mode and byteStride");
}

}  // namespace

std::vector<uint8_t> decode_meshopt(const GltfSource& source, const GltfDocument& document, uint32_t index) {
  const MeshoptView& view = *document.views[index].meshopt;
  const std::string place = fmt::format("bufferViews[{}].extensions.EXT_meshopt_compression", index);
  check_meshopt(source, view, place);
  const GltfBuffer& buffer = document.buffers[view.buffer];
  if (buffer.bytes.empty()) {
    source.fail(fmt::format("buffers[{}]", view.buffer), "UNDEFINED_PROPERTY", "has no 'uri' and no data");
  }
  const auto packed = buffer.bytes.subspan(view.offset, view.length);
  std::vector<uint8_t> bytes(document.views[index].length);
  const auto failed = [&] {
    switch (view.mode) {
      case MeshoptMode::attributes:
        return meshopt_decodeVertexBuffer(bytes.data(), view.count, view.stride, packed.data(),
                                          packed.size());
      case MeshoptMode::triangles:
        return meshopt_decodeIndexBuffer(bytes.data(), view.count, view.stride, packed.data(), packed.size());
      case MeshoptMode::indices:
        break;
    }
    return meshopt_decodeIndexSequence(bytes.data(), view.count, view.stride, packed.data(), packed.size());
  }();
  if (failed != 0)
    source.fail(place, "EXT_MESHOPT_COMPRESSION_INVALID_DATA", "the compressed data are damaged");
  switch (view.filter) {
    case MeshoptFilter::none:
      break;
    case MeshoptFilter::octahedral:
      meshopt_decodeFilterOct(bytes.data(), view.count, view.stride);
      break;
    case MeshoptFilter::quaternion:
      meshopt_decodeFilterQuat(bytes.data(), view.count, view.stride);
      break;
    case MeshoptFilter::exponential:
      meshopt_decodeFilterExp(bytes.data(), view.count, view.stride);
      break;
  }
  return bytes;
}

#else

std::vector<uint8_t> decode_meshopt(const GltfSource& source, const GltfDocument& document, uint32_t index) {
  // An optional extension has a fallback buffer: the view as it would be without it.
  const GltfBufferView& view = document.views[index];
  const auto bytes = document.buffers[view.buffer].bytes;
  if (bytes.empty()) {
    source.fail(fmt::format("bufferViews[{}]", index), "UNSUPPORTED_EXTENSION",
                "EXT_meshopt_compression cannot be read by this build, and there is no fallback");
  }
  const auto part = bytes.subspan(view.offset, view.length);
  return {part.begin(), part.end()};
}

#endif

#ifdef HALFLIGHT_HAVE_DRACO

namespace {

/// Divides integers by their range where the accessor says so and Draco has not done it.
float integer_scale(const GltfAccessor& accessor, const draco::PointAttribute& attribute) {
  if (!accessor.normalized || attribute.normalized()) return 1;
  switch (accessor.component) {
    case GltfComponent::int8:
      return 1.0f / 127;
    case GltfComponent::uint8:
      return 1.0f / 255;
    case GltfComponent::int16:
      return 1.0f / 32767;
    case GltfComponent::uint16:
      return 1.0f / 65535;
    default:
      return 1;
  }
}

DracoMesh::Attribute read_attribute(const draco::Mesh& mesh, const draco::PointAttribute& attribute,
                                    const GltfAccessor& accessor, std::string name) {
  DracoMesh::Attribute result{std::move(name), accessor.rows, {}};
  const float scale = integer_scale(accessor, attribute);
  result.values.resize(static_cast<size_t>(mesh.num_points()) * result.width);
  for (uint32_t p = 0; p < mesh.num_points(); ++p) {
    float value[4] = {0, 0, 0, 0};
    attribute.ConvertValue<float>(attribute.mapped_index(draco::PointIndex(p)),
                                  static_cast<int8_t>(accessor.rows), value);
    for (uint32_t k = 0; k < accessor.rows; ++k) result.values[p * accessor.rows + k] = value[k] * scale;
  }
  return result;
}

}  // namespace

DracoMesh decode_draco(const GltfSource& source, const GltfDocument& document, GltfReader& reader,
                       const GltfPrimitive& primitive, std::string_view place) {
  const std::string where = fmt::format("{}.extensions.KHR_draco_mesh_compression", place);
  const auto bytes = reader.view(primitive.draco->view);
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) {
    source.fail(where, "KHR_DRACO_MESH_COMPRESSION_INVALID_DATA",
                printable(decoded.status().error_msg_string()));
  }
  const draco::Mesh& mesh = *decoded.value();
  if (mesh.num_faces() > source.options->limits.triangles) {
    source.fail(where, "LIMIT",
                fmt::format("{} triangles, the limit is {} (--limit-triangles)", mesh.num_faces(),
                            source.options->limits.triangles));
  }
  DracoMesh result;
  result.indices.reserve(3 * static_cast<size_t>(mesh.num_faces()));
  for (uint32_t f = 0; f < mesh.num_faces(); ++f) {
    for (const draco::PointIndex& point : mesh.face(draco::FaceIndex(f)))
      result.indices.push_back(point.value());
  }
  for (const auto& [name, id] : primitive.draco->attributes) {
    const int32_t accessor = find_attribute(primitive.attributes, name);
    const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(id);
    if (!attribute) {
      source.fail(where, "UNRESOLVED_REFERENCE",
                  fmt::format("attribute {} ({}) is not in the data", id, name));
    }
    if (accessor >= 0)
      result.attributes.push_back(read_attribute(mesh, *attribute, document.accessors[accessor], name));
  }
  return result;
}

#else

DracoMesh decode_draco(const GltfSource& source, const GltfDocument&, GltfReader&, const GltfPrimitive&,
                       std::string_view place) {
  source.fail(place, "UNSUPPORTED_EXTENSION", "KHR_draco_mesh_compression cannot be read by this build");
}

#endif

}  // namespace halflight
