#include "scene/gltf_json.h"

#include <cmath>

namespace halflight {

namespace {

using nlohmann::json;

std::string type_reason(const json& value, std::string_view wanted) {
  return fmt::format("{} where {} belongs", value.type_name(), wanted);
}

/// The value as an integer in [0, 2^53]; nothing where it is no number, no whole one, or out of that range.
std::optional<uint64_t> whole_number(const json& value) {
  if (value.is_number_unsigned()) {
    const uint64_t integer = value.get<uint64_t>();
    if (integer <= JsonObject::largest) return integer;
  } else if (value.is_number_float()) {
    const double number = value.get<double>();
    if (number >= 0 && number <= static_cast<double>(JsonObject::largest) && number == std::floor(number)) {
      return static_cast<uint64_t>(number);
    }
  }
  return {};
}

}  // namespace

size_t root_array_size(const GltfSource& source, std::string_view name) {
  const auto found = source.root.find(name);
  if (found == source.root.end()) return 0;
  if (!found->is_array()) source.fail(name, "TYPE_MISMATCH", type_reason(*found, "an array"));
  return found->size();
}

JsonObject::JsonObject(GltfSource& source, const json& value, std::string place)
    : source_(&source), value_(&value), place_(std::move(place)) {
  if (!value.is_object()) source.fail(place_, "TYPE_MISMATCH", type_reason(value, "an object"));
}

std::string JsonObject::place_of(std::string_view key) const {
  if (key.empty()) return place_;
  return place_.empty() ? std::string(key) : fmt::format("{}.{}", place_, key);
}

void JsonObject::fail(std::string_view key, std::string_view code, std::string_view reason) const {
  source_->fail(place_of(key), code, reason);
}

void JsonObject::warn(std::string_view key, std::string_view code, std::string_view reason) const {
  source_->warn(place_of(key), code, reason);
}

void JsonObject::require(std::string_view key) const {
  if (!has(key)) fail("", "UNDEFINED_PROPERTY", fmt::format("'{}' is missing", key));
}

const json* JsonObject::find(std::string_view key) const {
  const auto found = value_->find(key);
  return found == value_->end() ? nullptr : &*found;
}

const json& JsonObject::array(std::string_view key) const {
  static const json empty = json::array();
  const json* value = find(key);
  if (!value) return empty;
  if (!value->is_array()) fail(key, "TYPE_MISMATCH", type_reason(*value, "an array"));
  return *value;
}

bool JsonObject::boolean(std::string_view key, bool otherwise) const {
  const json* value = find(key);
  if (!value) return otherwise;
  if (!value->is_boolean()) fail(key, "TYPE_MISMATCH", type_reason(*value, "a boolean"));
  return value->get<bool>();
}

std::string JsonObject::string(std::string_view key, std::string otherwise) const {
  const json* value = find(key);
  if (!value) return otherwise;
  if (!value->is_string()) fail(key, "TYPE_MISMATCH", type_reason(*value, "a string"));
  return value->get<std::string>();
}

float JsonObject::ranged(std::string_view key, double value, double least, double most) const {
  if (!(value >= least && value <= most))
    fail(key, "VALUE_NOT_IN_RANGE", fmt::format("{} is out of range", value));
  // Numbers beyond a float's range become its largest, not infinity.
  constexpr double limit = std::numeric_limits<float>::max();
  return static_cast<float>(std::clamp(value, -limit, limit));
}

double JsonObject::number(std::string_view key, double otherwise, double least, double most) const {
  const json* value = find(key);
  if (!value) return otherwise;
  if (!value->is_number()) fail(key, "TYPE_MISMATCH", type_reason(*value, "a number"));
  const double number = value->get<double>();
  ranged(key, number, least, most);
  return number;
}

uint64_t JsonObject::integer(std::string_view key, uint64_t otherwise, uint64_t least, uint64_t most) const {
  const json* value = find(key);
  if (!value) return otherwise;
  if (!value->is_number()) fail(key, "TYPE_MISMATCH", type_reason(*value, "an integer"));
  const auto integer = whole_number(*value);
  if (!integer) {
    const double number = value->get<double>();
    const bool whole = number == std::floor(number);
    fail(key, whole ? "VALUE_NOT_IN_RANGE" : "TYPE_MISMATCH",
         fmt::format("{} is {}", value->dump(), whole ? "out of range" : "no integer"));
  }
  if (*integer < least || *integer > most) {
    fail(key, "VALUE_NOT_IN_RANGE", fmt::format("{} is out of range", *integer));
  }
  return *integer;
}

int32_t JsonObject::index(std::string_view key, std::string_view of) const {
  if (!has(key)) return -1;
  const uint64_t index = integer(key, 0);
  const size_t size = root_array_size(*source_, of);
  if (index >= size || index > std::numeric_limits<int32_t>::max()) {
    fail(key, "UNRESOLVED_REFERENCE", fmt::format("{} {}, there are {}", of, index, size));
  }
  return static_cast<int32_t>(index);
}

int32_t JsonObject::required_index(std::string_view key, std::string_view of) const {
  require(key);
  return index(key, of);
}

std::vector<uint32_t> JsonObject::indices(std::string_view key, std::string_view of) const {
  std::vector<uint32_t> result;
  const size_t size = has(key) ? root_array_size(*source_, of) : 0;
  for (const json& entry : array(key)) {
    const auto index = whole_number(entry);
    if (!index) fail(key, "TYPE_MISMATCH", type_reason(entry, "an index"));
    if (*index >= size)
      fail(key, "UNRESOLVED_REFERENCE", fmt::format("{} {}, there are {}", of, *index, size));
    result.push_back(static_cast<uint32_t>(*index));
  }
  return result;
}

std::vector<double> JsonObject::numbers(std::string_view key, size_t length) const {
  std::vector<double> result;
  for (const json& entry : array(key)) {
    if (!entry.is_number()) fail(key, "TYPE_MISMATCH", type_reason(entry, "a number"));
    result.push_back(entry.get<double>());
  }
  if (length > 0 && has(key) && result.size() != length) {
    fail(key, "ARRAY_LENGTH_NOT_IN_LIST", fmt::format("{} numbers where {} belong", result.size(), length));
  }
  return result;
}

Vec3 JsonObject::vec3(std::string_view key, Vec3 otherwise, double least, double most) const {
  const auto n = numbers(key, 3);
  if (n.empty()) return otherwise;
  return {ranged(key, n[0], least, most), ranged(key, n[1], least, most), ranged(key, n[2], least, most)};
}

double JsonObject::clamp_with_warning(std::string_view key, double value, double least, double most) const {
  if (value >= least && value <= most) return value;
  const double nearest = std::clamp(value, least, most);
  warn(key, "VALUE_NOT_IN_RANGE", fmt::format("{} is out of range; taken as {}", value, nearest));
  return nearest;
}

double JsonObject::clamped(std::string_view key, double otherwise, double least, double most) const {
  return clamp_with_warning(key, number(key, otherwise), least, most);
}

Vec3 JsonObject::color3(std::string_view key, Vec3 otherwise, double least, double most) const {
  auto n = numbers(key, 3);
  if (n.empty()) return otherwise;
  for (double& x : n) x = clamp_with_warning(key, x, least, most);
  return {n[0], n[1], n[2]};
}

Vec4 JsonObject::color4(std::string_view key, Vec4 otherwise, double least, double most) const {
  auto n = numbers(key, 4);
  if (n.empty()) return otherwise;
  for (double& x : n) x = clamp_with_warning(key, x, least, most);
  return {n[0], n[1], n[2], n[3]};
}

std::vector<std::string> JsonObject::strings(std::string_view key) const {
  std::vector<std::string> result;
  for (const json& entry : array(key)) {
    if (!entry.is_string()) fail(key, "TYPE_MISMATCH", type_reason(entry, "a string"));
    result.push_back(entry.get<std::string>());
  }
  return result;
}

std::optional<JsonObject> JsonObject::object(std::string_view key) const {
  const json* value = find(key);
  if (!value) return {};
  return JsonObject(*source_, *value, place_of(key));
}

std::optional<JsonObject> JsonObject::extension(std::string_view name) const {
  if (!has("extensions")) return {};
  return object("extensions")->object(name);
}

std::optional<JsonObject> JsonObject::extra(std::string_view name) const {
  const json* extras = find("extras");
  if (!extras || !extras->is_object() || !extras->contains(name)) return {};
  return JsonObject(*source_, (*extras)[std::string(name)], fmt::format("{}.{}", place_of("extras"), name));
}

void JsonObject::for_each(std::string_view key, const std::function<void(const JsonObject&)>& visit) const {
  size_t i = 0;
  const std::string place = place_of(key);
  for (const json& entry : array(key)) visit(JsonObject(*source_, entry, fmt::format("{}[{}]", place, i++)));
}

void JsonObject::for_each_index(
    std::string_view of, const std::function<void(const std::string& name, uint32_t index)>& visit) const {
  for (const auto& entry : value_->items()) {
    visit(entry.key(), static_cast<uint32_t>(index(entry.key(), of)));
  }
}

}  // namespace halflight
