// Numbers out of buffers: decoded views, strides, sparse values, normalised integers. Values are checked
// where an index is made of them.
#pragma once

#include "scene/gltf_document.h"

namespace halflight {

/// Reads accessors of one document. Decoded (meshopt) views are kept until `release`.
class GltfReader {
 public:
  GltfReader(const GltfSource& source, const GltfDocument& document) : source_(source), document_(document) {}

  /// The view's bytes, decoded where they are compressed. Throws where the buffer has no data.
  std::span<const uint8_t> view(uint32_t index);

  /// Whether the file gives the bytes behind a view or an accessor: a buffer may be left without any.
  bool view_has_data(uint32_t view) const;
  bool has_data(uint32_t accessor) const;
  /// Throws ACCESSOR_SPARSE_INDEX_OOB; the accessor must be sparse and have data.
  void check_sparse_indices(uint32_t accessor);

  /// count × width numbers; integers divided by their range where they are normalised.
  std::vector<float> floats(uint32_t accessor);
  /// count × width integers as they are. The component type must be an unsigned integer.
  std::vector<uint32_t> integers(uint32_t accessor);

 private:
  template <class T>
  std::vector<T> read(uint32_t accessor);
  template <class T>
  void apply_sparse(uint32_t accessor, std::vector<T>& values);

  const GltfSource& source_;
  const GltfDocument& document_;
  std::vector<std::vector<uint8_t>> decoded_;  ///< by view; empty where not decoded
};

/// Decodes a meshopt-compressed view (EXT_meshopt_compression, all modes and filters).
std::vector<uint8_t> decode_meshopt(const GltfSource&, const GltfDocument&, uint32_t view);

/// A Draco mesh: what the accessors of its primitive would hold.
struct DracoMesh {
  std::vector<uint32_t> indices;
  struct Attribute {
    std::string name;
    uint32_t width = 0;
    std::vector<float> values;
  };
  std::vector<Attribute> attributes;
};
DracoMesh decode_draco(const GltfSource&, const GltfDocument&, GltfReader&, const GltfPrimitive&,
                       std::string_view place);

}  // namespace halflight
