#include "scene/gltf_accessors.h"

#include <bit>
#include <cstring>

namespace halflight {

namespace {

static_assert(std::endian::native == std::endian::little, "glTF's data are little-endian");

template <class T>
T load(const uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

/// One component as T; normalised integers by glTF 2.0 §3.11 (signed: max(c / 127, −1)).
template <class T>
T component(const uint8_t* bytes, GltfComponent type, bool normalized) {
  const bool scale = normalized && std::is_same_v<T, float>;
  switch (type) {
    case GltfComponent::int8: {
      const T value = static_cast<T>(load<int8_t>(bytes));
      return scale ? static_cast<T>(std::max(static_cast<float>(value) / 127.0f, -1.0f)) : value;
    }
    case GltfComponent::uint8: {
      const T value = static_cast<T>(load<uint8_t>(bytes));
      return scale ? static_cast<T>(static_cast<float>(value) / 255.0f) : value;
    }
    case GltfComponent::int16: {
      const T value = static_cast<T>(load<int16_t>(bytes));
      return scale ? static_cast<T>(std::max(static_cast<float>(value) / 32767.0f, -1.0f)) : value;
    }
    case GltfComponent::uint16: {
      const T value = static_cast<T>(load<uint16_t>(bytes));
      return scale ? static_cast<T>(static_cast<float>(value) / 65535.0f) : value;
    }
    case GltfComponent::uint32:
      return static_cast<T>(load<uint32_t>(bytes));
    case GltfComponent::float32:
      break;
  }
  return static_cast<T>(load<float>(bytes));
}

/// Elements from `first`, `stride` bytes apart, into `values`; the caller has checked that they are there.
template <class T>
void read_elements(const GltfAccessor& accessor, const uint8_t* first, uint64_t stride, uint64_t count,
                   T* values) {
  const size_t size = component_size(accessor.component);
  const size_t column = accessor.columns == 1 ? 0 : (accessor.rows * size + 3) / 4 * 4;
  const bool as_they_are =
      (accessor.component == GltfComponent::float32 && std::is_same_v<T, float> && accessor.columns == 1) ||
      (accessor.component == GltfComponent::uint32 && std::is_same_v<T, uint32_t>);
  if (as_they_are && stride == accessor.element_size()) {
    std::memcpy(values, first, count * stride);
    return;
  }
  if (accessor.component == GltfComponent::float32 && std::is_same_v<T, float> && accessor.columns == 1) {
    for (uint64_t i = 0; i < count; ++i, values += accessor.rows) {
      std::memcpy(values, first + i * stride, accessor.rows * sizeof(float));
    }
    return;
  }
  for (uint64_t i = 0; i < count; ++i) {
    for (uint32_t c = 0; c < accessor.columns; ++c) {
      const uint8_t* bytes = first + i * stride + c * column;
      for (uint32_t r = 0; r < accessor.rows; ++r) {
        *values++ = component<T>(bytes + r * size, accessor.component, accessor.normalized);
      }
    }
  }
}

std::string accessor_place(uint32_t accessor) { return fmt::format("accessors[{}]", accessor); }

}  // namespace

std::span<const uint8_t> GltfReader::view(uint32_t index) {
  const GltfBufferView& view = document_.views[index];
  if (view.meshopt) {
    if (decoded_.empty()) decoded_.resize(document_.views.size());
    if (decoded_[index].empty()) decoded_[index] = decode_meshopt(source_, document_, index);
    return decoded_[index];
  }
  const GltfBuffer& buffer = document_.buffers[view.buffer];
  if (buffer.bytes.empty()) {
    source_.fail(fmt::format("buffers[{}]", view.buffer), "UNDEFINED_PROPERTY", "has no 'uri' and no data");
  }
  return buffer.bytes.subspan(view.offset, view.length);
}

bool GltfReader::view_has_data(uint32_t index) const {
  const GltfBufferView& view = document_.views[index];
  return !document_.buffers[view.meshopt ? view.meshopt->buffer : view.buffer].bytes.empty();
}

bool GltfReader::has_data(uint32_t index) const {
  const GltfAccessor& accessor = document_.accessors[index];
  if (accessor.view >= 0 && !view_has_data(static_cast<uint32_t>(accessor.view))) return false;
  return !accessor.sparse ||
         (view_has_data(accessor.sparse->index_view) && view_has_data(accessor.sparse->value_view));
}

void GltfReader::check_sparse_indices(uint32_t index) {
  const GltfAccessor& accessor = document_.accessors[index];
  const GltfSparse& sparse = *accessor.sparse;
  const uint8_t* indices = view(sparse.index_view).data() + sparse.index_offset;
  const size_t size = component_size(sparse.index_component);
  for (uint64_t i = 0; i < sparse.count; ++i) {
    const uint32_t target = component<uint32_t>(indices + i * size, sparse.index_component, false);
    if (target >= accessor.count) {
      source_.fail(accessor_place(index) + ".sparse", "ACCESSOR_SPARSE_INDEX_OOB",
                   fmt::format("index {} at {}, the accessor has {} elements", target, i, accessor.count));
    }
  }
}

template <class T>
void GltfReader::apply_sparse(uint32_t index, std::vector<T>& values) {
  const GltfAccessor& accessor = document_.accessors[index];
  const GltfSparse& sparse = *accessor.sparse;
  check_sparse_indices(index);
  const uint8_t* indices = view(sparse.index_view).data() + sparse.index_offset;
  const uint8_t* replacements = view(sparse.value_view).data() + sparse.value_offset;
  const size_t index_size = component_size(sparse.index_component);
  const uint64_t width = accessor.width(), element = accessor.element_size();
  for (uint64_t i = 0; i < sparse.count; ++i) {
    const uint32_t target = component<uint32_t>(indices + i * index_size, sparse.index_component, false);
    read_elements(accessor, replacements + i * element, element, 1, values.data() + target * width);
  }
}

template <class T>
std::vector<T> GltfReader::read(uint32_t index) {
  const GltfAccessor& accessor = document_.accessors[index];
  // Zeros cost no bytes of the file: a bound that only files made to harm exceed.
  constexpr uint64_t most_zeros = uint64_t{1} << 24;
  if (accessor.view < 0 && accessor.count > most_zeros) {
    source_.fail(
        accessor_place(index), "LIMIT",
        fmt::format("{} elements without a bufferView, the limit is {}", accessor.count, most_zeros));
  }
  std::vector<T> values(accessor.count * accessor.width());
  if (accessor.view >= 0) {
    const auto bytes = view(static_cast<uint32_t>(accessor.view));
    const uint64_t packed = accessor.element_size(), own = document_.views[accessor.view].stride;
    read_elements(accessor, bytes.data() + accessor.offset, own > 0 ? own : packed, accessor.count,
                  values.data());
  }
  if (accessor.sparse) apply_sparse(index, values);
  return values;
}

std::vector<float> GltfReader::floats(uint32_t accessor) { return read<float>(accessor); }

std::vector<uint32_t> GltfReader::integers(uint32_t accessor) { return read<uint32_t>(accessor); }

}  // namespace halflight
