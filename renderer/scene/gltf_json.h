// Typed reading of a glTF file's JSON: every getter checks type, range and reference, and names the place at
// fault.
#pragma once

#include <functional>
#include <limits>
#include <optional>

#include "scene/gltf_source.h"

namespace halflight {

/// An object of the file and its place ("meshes[3].primitives[0]"). Getters throw input_error with
/// TYPE_MISMATCH, UNDEFINED_PROPERTY, VALUE_NOT_IN_RANGE, ARRAY_LENGTH_NOT_IN_LIST or UNRESOLVED_REFERENCE.
class JsonObject {
 public:
  using json = nlohmann::json;

  /// The root object.
  explicit JsonObject(GltfSource& source) : source_(&source), value_(&source.root) {}
  /// `value` must turn out to be an object.
  JsonObject(GltfSource& source, const json& value, std::string place);

  GltfSource& source() const { return *source_; }
  const std::string& place() const { return place_; }
  std::string place_of(std::string_view key) const;
  [[noreturn]] void fail(std::string_view key, std::string_view code, std::string_view reason) const;
  void warn(std::string_view key, std::string_view code, std::string_view reason) const;

  bool has(std::string_view key) const { return value_->contains(key); }
  /// Throws UNDEFINED_PROPERTY unless the object has `key`.
  void require(std::string_view key) const;

  bool boolean(std::string_view key, bool otherwise) const;
  std::string string(std::string_view key, std::string otherwise = {}) const;
  double number(std::string_view key, double otherwise, double least = lowest, double most = highest) const;
  /// A number taken to the nearest in range, with a warning, where the meaning is plain.
  double clamped(std::string_view key, double otherwise, double least, double most) const;
  /// Integers written as 3.0 are integers (JSON knows one kind of number).
  uint64_t integer(std::string_view key, uint64_t otherwise, uint64_t least = 0,
                   uint64_t most = largest) const;
  /// Index into the root array `of`; -1 where there is none.
  int32_t index(std::string_view key, std::string_view of) const;
  int32_t required_index(std::string_view key, std::string_view of) const;
  std::vector<uint32_t> indices(std::string_view key, std::string_view of) const;

  /// Numbers of an array, empty where there is none; a `length` other than 0 must be met. Finite always: JSON
  /// has no others.
  std::vector<double> numbers(std::string_view key, size_t length = 0) const;
  Vec3 vec3(std::string_view key, Vec3 otherwise, double least = lowest, double most = highest) const;
  /// Colours between `least` and `most`, clamped with a warning.
  Vec3 color3(std::string_view key, Vec3 otherwise, double least, double most) const;
  Vec4 color4(std::string_view key, Vec4 otherwise, double least, double most) const;
  std::vector<std::string> strings(std::string_view key) const;

  std::optional<JsonObject> object(std::string_view key) const;
  /// The object of an extension of this object.
  std::optional<JsonObject> extension(std::string_view name) const;
  /// An object inside `extras`; nothing where `extras` is no object, which glTF allows.
  std::optional<JsonObject> extra(std::string_view name) const;
  /// Calls `visit` with each object of an array; nothing where there is no array.
  void for_each(std::string_view key, const std::function<void(const JsonObject&)>& visit) const;
  /// Calls `visit` with each name and index of an object of references, as `attributes` are.
  void for_each_index(std::string_view of,
                      const std::function<void(const std::string& name, uint32_t index)>& visit) const;

  static constexpr double lowest = std::numeric_limits<double>::lowest();
  static constexpr double highest = std::numeric_limits<double>::max();
  static constexpr uint64_t largest = uint64_t{1} << 53;  ///< what a JSON number holds exactly

 private:
  const json* find(std::string_view key) const;
  const json& array(std::string_view key) const;
  double clamp_with_warning(std::string_view key, double value, double least, double most) const;
  float ranged(std::string_view key, double value, double least, double most) const;

  GltfSource* source_;
  const json* value_;
  std::string place_;
};

/// Number of entries of a root array; 0 where there is none. Throws TYPE_MISMATCH where it is no array.
size_t root_array_size(const GltfSource&, std::string_view name);

}  // namespace halflight
