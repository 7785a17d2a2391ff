// What arrays hold, for accounts of memory.
#pragma once

#include <cstddef>

namespace halflight {

/// Bytes that vectors have reserved.
template <class... Vectors>
size_t vector_bytes(const Vectors&... vectors) {
  return (size_t{0} + ... + (vectors.capacity() * sizeof(typename Vectors::value_type)));
}

}  // namespace halflight
