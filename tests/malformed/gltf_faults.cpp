// The fault table of a hostile glTF: every row is made here from a sound file and one fault, with the outcome
// it must come to. A row either loads (with a warning that says what was left out) or ends in exit code 3
// with its code.
#include <gtest/gtest.h>

#include <functional>

#include "support/gltf_fixture.h"
#include "support/png_fixture.h"

namespace halflight {

namespace {

using nlohmann::json;

/// One fault: what is done to the sound triangle, and what must be said.
struct Fault {
  std::string name;
  std::function<void(GltfFixture&)> apply;
  ExitCode exit = ExitCode::bad_input;
  std::string told;
};

std::ostream& operator<<(std::ostream& out, const Fault& fault) { return out << fault.name; }

std::string fault_name(const testing::TestParamInfo<Fault>& info) { return info.param.name; }

class GltfFault : public testing::TestWithParam<Fault> {};

TEST_P(GltfFault, HasItsOutcome) {
  GltfFixture gltf = triangle_fixture();
  GetParam().apply(gltf);
  const LoadOutcome outcome = load_outcome(gltf);
  EXPECT_EQ(static_cast<int>(outcome.exit), static_cast<int>(GetParam().exit)) << outcome.all();
  EXPECT_TRUE(outcome.tells(GetParam().told)) << "not told: " << GetParam().told << "\n" << outcome.all();
  EXPECT_EQ(outcome.message.find('\n'), std::string::npos) << "more than one line";
  if (GetParam().exit == ExitCode::bad_input) {
    EXPECT_NE(outcome.message.find("test.gltf: "), std::string::npos)
        << "the file is not named: " << outcome.message;
  }
}

constexpr ExitCode ok = ExitCode::ok, bad = ExitCode::bad_input;

std::vector<Fault> data_faults() {
  const uint64_t huge = uint64_t{1} << 62, exact = uint64_t{1} << 53;
  return {
      {"count_2_to_62", [=](GltfFixture& g) { g.json["accessors"][0]["count"] = huge; }, bad,
       "VALUE_NOT_IN_RANGE"},
      {"count_2_to_53", [=](GltfFixture& g) { g.json["accessors"][0]["count"] = exact; }, bad,
       "accessors[0]: ACCESSOR_TOO_LONG"},
      {"count_1e300", [](GltfFixture& g) { g.json["accessors"][0]["count"] = 1e300; }, bad,
       "VALUE_NOT_IN_RANGE"},
      {"count_negative", [](GltfFixture& g) { g.json["accessors"][0]["count"] = -3; }, bad,
       "VALUE_NOT_IN_RANGE"},
      {"count_fraction", [](GltfFixture& g) { g.json["accessors"][0]["count"] = 2.5; }, bad, "TYPE_MISMATCH"},
      {"count_zero", [](GltfFixture& g) { g.json["accessors"][0]["count"] = 0; }, bad, "VALUE_NOT_IN_RANGE"},
      {"count_without_view_huge",
       [](GltfFixture& g) {
         g.json["accessors"][0].erase("bufferView");
         g.json["accessors"][0]["count"] = 1'000'000'000;
       },
       bad, "LIMIT"},
      {"accessor_too_long", [](GltfFixture& g) { g.json["accessors"][0]["count"] = 4; }, bad,
       "accessors[0]: ACCESSOR_TOO_LONG: needs 48 bytes, bufferView 0 has 36"},
      {"accessor_offset_wraps",
       [=](GltfFixture& g) { g.json["accessors"][0]["byteOffset"] = ~uint64_t{0} - 8; }, bad,
       "VALUE_NOT_IN_RANGE"},
      {"accessor_offset_beyond", [](GltfFixture& g) { g.json["accessors"][0]["byteOffset"] = 4; }, bad,
       "ACCESSOR_TOO_LONG"},
      {"view_too_long", [](GltfFixture& g) { g.json["bufferViews"][1]["byteLength"] = 100; }, bad,
       "bufferViews[1]: BUFFER_VIEW_TOO_LONG"},
      {"view_offset_wraps", [=](GltfFixture& g) { g.json["bufferViews"][1]["byteOffset"] = exact; }, bad,
       "BUFFER_VIEW_TOO_LONG"},
      {"view_of_no_buffer", [](GltfFixture& g) { g.json["bufferViews"][0]["buffer"] = 7; }, bad,
       "bufferViews[0].buffer: UNRESOLVED_REFERENCE"},
      {"accessor_of_no_view", [](GltfFixture& g) { g.json["accessors"][0]["bufferView"] = 7; }, bad,
       "accessors[0].bufferView: UNRESOLVED_REFERENCE"},
      {"view_index_negative", [](GltfFixture& g) { g.json["accessors"][0]["bufferView"] = -1; }, bad,
       "accessors[0].bufferView"},
      {"stride_below_element", [](GltfFixture& g) { g.json["bufferViews"][0]["byteStride"] = 4; }, bad,
       "ACCESSOR_SMALL_BYTESTRIDE"},
      {"stride_out_of_range", [](GltfFixture& g) { g.json["bufferViews"][0]["byteStride"] = 1u << 31; }, bad,
       "VALUE_NOT_IN_RANGE"},
      {"stride_makes_it_long", [](GltfFixture& g) { g.json["bufferViews"][0]["byteStride"] = 16; }, bad,
       "ACCESSOR_TOO_LONG"},
      {"misaligned",
       [](GltfFixture& g) {
         std::vector<uint8_t> bytes(g.bytes);
         bytes.insert(bytes.begin(), 0);
         g.bytes = bytes;
         for (auto& view : g.json["bufferViews"]) view["byteOffset"] = view["byteOffset"].get<int>() + 1;
       },
       ok, "ACCESSOR_OFFSET_ALIGNMENT"},
      {"index_out_of_bounds", [](GltfFixture& g) { g.bytes[36] = 3; }, bad,
       "meshes[0].primitives[0].indices: ACCESSOR_INDEX_OOB: index 3 at 0, there are 3"},
      {"index_restart", [](GltfFixture& g) { g.bytes[36] = g.bytes[37] = 255; }, bad, "ACCESSOR_INDEX_OOB"},
      {"sparse_index_out_of_bounds",
       [](GltfFixture& g) {
         const size_t at = g.add_view<uint16_t>({3}), values = g.add_view<float>({0, 0, 0});
         g.json["accessors"][0]["sparse"] = {{"count", 1},
                                             {"indices", {{"bufferView", at}, {"componentType", 5123}}},
                                             {"values", {{"bufferView", values}}}};
       },
       bad, "accessors[0].sparse: ACCESSOR_SPARSE_INDEX_OOB"},
      {"sparse_more_than_there_are",
       [](GltfFixture& g) {
         const size_t at = g.add_view<uint16_t>({0, 1, 2, 3}),
                      values = g.add_view<float>(std::vector<float>(12));
         g.json["accessors"][0]["sparse"] = {{"count", 4},
                                             {"indices", {{"bufferView", at}, {"componentType", 5123}}},
                                             {"values", {{"bufferView", values}}}};
       },
       bad, "ACCESSOR_SPARSE_COUNT_OUT_OF_RANGE"},
      {"sparse_values_too_short",
       [](GltfFixture& g) {
         const size_t at = g.add_view<uint16_t>({0, 1}), values = g.add_view<float>({0, 0, 0});
         g.json["accessors"][0]["sparse"] = {{"count", 2},
                                             {"indices", {{"bufferView", at}, {"componentType", 5123}}},
                                             {"values", {{"bufferView", values}}}};
       },
       bad, "accessors[0].sparse.values: ACCESSOR_TOO_LONG"},
      {"sparse_float_indices",
       [](GltfFixture& g) {
         g.json["accessors"][0]["sparse"] = {{"count", 1},
                                             {"indices", {{"bufferView", 0}, {"componentType", 5126}}},
                                             {"values", {{"bufferView", 0}}}};
       },
       bad, "VALUE_NOT_IN_LIST"},
      {"buffer_without_data",
       [](GltfFixture& g) {
         g.json["buffers"] = {{{"byteLength", 44}}};
       },
       ok, "its buffer has neither 'uri' nor data"},
      {"buffer_of_petabytes",
       [](GltfFixture& g) {
         g.json["buffers"] = {{{"byteLength", uint64_t{1} << 50}, {"uri", "data:,x"}}};
       },
       bad, "buffers[0].byteLength: LIMIT"},
  };
}

std::vector<Fault> mesh_faults() {
  const auto format = "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT";
  const auto with_attribute = [](const char* name, const char* type, auto value, size_t count) {
    return [=](GltfFixture& g) {
      std::vector<decltype(value)> values(count * GltfFixture::width(type), value);
      g.primitive()["attributes"][name] = g.add_accessor(type, values);
    };
  };
  return {
      {"position_vec2", [](GltfFixture& g) { g.json["accessors"][0]["type"] = "VEC2"; }, bad, format},
      {"position_integer", with_attribute("POSITION", "VEC3", int16_t{0}, 3), bad, format},
      {"position_matrix", with_attribute("POSITION", "MAT4", 0.0f, 3), bad, format},
      {"normal_vec4", with_attribute("NORMAL", "VEC4", 0.0f, 3), bad, format},
      {"tangent_vec3", with_attribute("TANGENT", "VEC3", 0.0f, 3), bad, format},
      {"texcoord_uint32", with_attribute("TEXCOORD_0", "VEC2", uint32_t{0}, 3), bad, format},
      {"color_not_normalized", with_attribute("COLOR_0", "VEC4", uint8_t{0}, 3), bad, format},
      {"joints_float", with_attribute("JOINTS_0", "VEC4", 0.0f, 3), bad, format},
      {"weights_int8", with_attribute("WEIGHTS_0", "VEC4", int8_t{0}, 3), bad, format},
      {"unequal_counts", with_attribute("NORMAL", "VEC3", 1.0f, 2), bad,
       "MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT"},
      {"indices_float",
       [](GltfFixture& g) {
         g.primitive()["indices"] = g.add_accessor<float>("SCALAR", {0, 1, 2});
       },
       bad, "MESH_PRIMITIVE_INDICES_ACCESSOR_INVALID_FORMAT"},
      {"indices_vec2",
       [](GltfFixture& g) {
         g.primitive()["indices"] = g.add_accessor<uint16_t>("VEC2", {0, 1, 2, 0});
       },
       bad, "MESH_PRIMITIVE_INDICES_ACCESSOR_INVALID_FORMAT"},
      {"mode_7", [](GltfFixture& g) { g.primitive()["mode"] = 7; }, bad, "VALUE_NOT_IN_RANGE"},
      {"component_type_double", [](GltfFixture& g) { g.json["accessors"][0]["componentType"] = 5130; }, bad,
       "VALUE_NOT_IN_LIST"},
      {"type_vec5", [](GltfFixture& g) { g.json["accessors"][0]["type"] = "VEC5"; }, bad,
       "VALUE_NOT_IN_LIST"},
      {"material_out_of_range", [](GltfFixture& g) { g.primitive()["material"] = 0; }, bad,
       "UNRESOLVED_REFERENCE"},
      {"target_of_other_size",
       [](GltfFixture& g) {
         g.primitive()["targets"] = {{{"POSITION", g.add_accessor<float>("VEC3", {0, 0, 0})}}};
       },
       bad, "MESH_PRIMITIVE_MORPH_TARGET_INVALID_ATTRIBUTE_COUNT"},
      {"joint_out_of_range",
       [=](GltfFixture& g) {
         with_attribute("JOINTS_0", "VEC4", uint8_t{9}, 3)(g);
         with_attribute("WEIGHTS_0", "VEC4", 0.25f, 3)(g);
         g.json["skins"] = {{{"joints", {0}}}};
         g.json["nodes"][0]["skin"] = 0;
       },
       bad, "ACCESSOR_JOINTS_INDEX_OOB"},
      {"too_few_inverse_bind_matrices",
       [](GltfFixture& g) {
         g.json["skins"] = {
             {{"joints", {0, 0}}, {"inverseBindMatrices", g.add_accessor("MAT4", std::vector<float>(16))}}};
       },
       bad, "INVALID_IBM_ACCESSOR_COUNT"},
      {"points", [](GltfFixture& g) { g.primitive()["mode"] = 0; }, ok, "points and lines are skipped"},
      {"lines", [](GltfFixture& g) { g.primitive()["mode"] = 3; }, ok, "points and lines are skipped"},
      {"no_position",
       [](GltfFixture& g) {
         g.primitive()["attributes"] = {{"NORMAL", 0}};
       },
       ok, "MESH_PRIMITIVE_NO_POSITION"},
      {"no_mesh", [](GltfFixture& g) { g.json.erase("meshes"), g.json["nodes"][0].erase("mesh"); }, ok,
       "nothing to draw"},
      {"no_scene", [](GltfFixture& g) { g.json.erase("scenes"); }, ok, "no scene; all nodes are shown"},
      {"nothing_at_all", [](GltfFixture& g) { g = GltfFixture(); }, ok, "nothing to draw"},
      {"two_indices", [](GltfFixture& g) { g.json["accessors"][1]["count"] = 2; }, ok, "nothing to draw"},
      {"nan_position", [](GltfFixture& g) { g.bytes[2] = 0xc0, g.bytes[3] = 0x7f; }, ok,
       "1 triangles without area or with unusable positions"},
      {"infinite_position", [](GltfFixture& g) { g.bytes[2] = 0x80, g.bytes[3] = 0x7f; }, ok, "1 triangles"},
      {"huge_position", [](GltfFixture& g) { g.bytes[2] = 0x7f, g.bytes[3] = 0x7f; }, ok, "1 triangles"},
      {"zero_area", [](GltfFixture& g) { g.bytes[38] = 0; }, ok, "1 triangles"},
      {"draco_junk",
       [](GltfFixture& g) {
         g.json["extensionsUsed"] = {"KHR_draco_mesh_compression"};
         g.primitive()["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", 0},
                                                                      {"attributes", {{"POSITION", 0}}}};
       },
       bad, "KHR_draco_mesh_compression: KHR_DRACO_MESH_COMPRESSION_INVALID_DATA"},
      {"meshopt_junk",
       [](GltfFixture& g) {
         g.json["extensionsUsed"] = {"EXT_meshopt_compression"};
         g.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = {
             {"buffer", 0}, {"byteLength", 36}, {"byteStride", 12}, {"count", 3}, {"mode", "ATTRIBUTES"}};
       },
       bad, "EXT_MESHOPT_COMPRESSION_INVALID_DATA"},
      {"meshopt_too_many",
       [](GltfFixture& g) {
         g.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0},
                                                                              {"byteLength", 36},
                                                                              {"byteStride", 12},
                                                                              {"count", 1u << 30},
                                                                              {"mode", "ATTRIBUTES"}};
       },
       bad, "BUFFER_VIEW_TOO_LONG"},
      {"meshopt_odd_stride",
       [](GltfFixture& g) {
         g.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = {
             {"buffer", 0}, {"byteLength", 36}, {"byteStride", 9}, {"count", 3}, {"mode", "ATTRIBUTES"}};
       },
       bad, "byteStride 9"},
      {"meshopt_filter_on_indices",
       [](GltfFixture& g) {
         g.json["bufferViews"][1]["extensions"]["EXT_meshopt_compression"] = {
             {"buffer", 0}, {"byteLength", 6},     {"byteStride", 2},
             {"count", 3},  {"mode", "TRIANGLES"}, {"filter", "EXPONENTIAL"}};
       },
       bad, "filter does not fit"},
  };
}

std::vector<Fault> graph_faults() {
  return {
      {"node_is_its_child", [](GltfFixture& g) { g.json["nodes"][0]["children"] = {0}; }, bad, "NODE_LOOP"},
      {"loop_of_three",
       [](GltfFixture& g) {
         for (const int next : {2, 3, 1}) g.json["nodes"].push_back({{"children", {next}}});
       },
       bad, "NODE_LOOP"},
      {"two_parents",
       [](GltfFixture& g) {
         g.json["nodes"] = {{{"children", {2}}}, {{"children", {2}}}, {{"mesh", 0}}};
       },
       bad, "NODE_PARENT_OVERRIDE"},
      {"child_twice",
       [](GltfFixture& g) {
         g.json["nodes"].push_back({{"children", {0, 0}}});
       },
       bad, "NODE_PARENT_OVERRIDE"},
      {"child_as_root",
       [](GltfFixture& g) {
         g.json["nodes"].push_back({{"children", {0}}});
       },
       bad, "SCENE_NON_ROOT_NODE"},
      {"child_out_of_range", [](GltfFixture& g) { g.json["nodes"][0]["children"] = {5}; }, bad,
       "nodes[0].children: UNRESOLVED_REFERENCE"},
      {"scene_out_of_range", [](GltfFixture& g) { g.json["scene"] = 1; }, bad, "scene: UNRESOLVED_REFERENCE"},
      {"mesh_out_of_range", [](GltfFixture& g) { g.json["nodes"][0]["mesh"] = 4; }, bad,
       "UNRESOLVED_REFERENCE"},
      {"very_deep_tree",
       [](GltfFixture& g) {
         json nodes = json::array({{{"mesh", 0}}});
         for (int i = 1; i < 50'000; ++i)
           nodes.push_back({{"children", {i - 1}}, {"translation", {0, 0, 1}}});
         g.json["nodes"] = nodes;
         g.json["scenes"][0]["nodes"] = {49'999};
       },
       ok, ""},
      {"singular_matrix",
       [](GltfFixture& g) {
         g.json["nodes"][0]["scale"] = {1, 0, 1};
       },
       ok, "singular"},
      {"zero_matrix", [](GltfFixture& g) { g.json["nodes"][0]["matrix"] = std::vector<int>(16, 0); }, ok,
       "singular"},
      {"infinite_matrix",
       [](GltfFixture& g) {
         g.json["nodes"][0]["scale"] = {1e300, 1e300, 1e300};
       },
       ok, "singular"},
      {"matrix_of_15", [](GltfFixture& g) { g.json["nodes"][0]["matrix"] = std::vector<int>(15, 1); }, bad,
       "ARRAY_LENGTH_NOT_IN_LIST"},
      {"animation_without_sampler",
       [](GltfFixture& g) {
         g.json["animations"] = {
             {{"samplers", json::array()},
              {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "scale"}}}}}}}};
       },
       bad, "UNRESOLVED_REFERENCE"},
      {"animation_of_wrong_size",
       [](GltfFixture& g) {
         const size_t times = g.add_accessor<float>("SCALAR", {0, 1}),
                      values = g.add_accessor<float>("VEC3", {1, 1, 1});
         g.json["animations"] = {
             {{"samplers", {{{"input", times}, {"output", values}}}},
              {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "scale"}}}}}}}};
       },
       bad, "ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_COUNT"},
      {"animation_of_wrong_type",
       [](GltfFixture& g) {
         const size_t times = g.add_accessor<float>("SCALAR", {0}),
                      values = g.add_accessor<float>("VEC3", {1, 1, 1});
         g.json["animations"] = {
             {{"samplers", {{{"input", times}, {"output", values}}}},
              {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "rotation"}}}}}}}};
       },
       bad, "ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_FORMAT"},
      {"animation_times_backwards",
       [](GltfFixture& g) {
         const size_t times = g.add_accessor<float>("SCALAR", {1, 0}),
                      values = g.add_accessor<float>("VEC3", {1, 1, 1, 2, 2, 2});
         g.json["animations"] = {
             {{"samplers", {{{"input", times}, {"output", values}}}},
              {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "scale"}}}}}}}};
       },
       ok, "ACCESSOR_ANIMATION_INPUT_NON_INCREASING"},
  };
}

std::vector<Fault> light_and_camera_faults() {
  const auto light = [](json description) {
    return [=](GltfFixture& g) {
      g.json["extensions"]["KHR_lights_punctual"]["lights"] = json::array({description});
      g.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
    };
  };
  const auto camera = [](json description) {
    return [=](GltfFixture& g) { g.json["cameras"] = json::array({description}); };
  };
  return {
      {"light_negative_intensity", light({{"type", "point"}, {"intensity", -1}}), bad,
       "lights[0].intensity: VALUE_NOT_IN_RANGE"},
      {"light_negative_color", light({{"type", "point"}, {"color", {1, -1, 1}}}), bad,
       "lights[0].color: VALUE_NOT_IN_RANGE"},
      {"light_inner_above_outer",
       light({{"type", "spot"}, {"spot", {{"innerConeAngle", 1}, {"outerConeAngle", 0.5}}}}), ok,
       "KHR_LIGHTS_PUNCTUAL_LIGHT_SPOT_ANGLES"},
      {"light_outer_zero", light({{"type", "spot"}, {"spot", {{"outerConeAngle", 0}}}}), bad,
       "outerConeAngle: VALUE_NOT_IN_RANGE"},
      {"light_outer_wide", light({{"type", "spot"}, {"spot", {{"outerConeAngle", 3}}}}), ok, "taken as π/2"},
      {"light_inner_negative", light({{"type", "spot"}, {"spot", {{"innerConeAngle", -1}}}}), bad,
       "innerConeAngle: VALUE_NOT_IN_RANGE"},
      {"light_without_spot", light({{"type", "spot"}}), bad, "'spot' is missing"},
      {"light_range_zero", light({{"type", "point"}, {"range", 0}}), ok, "taken as no range"},
      {"light_range_negative", light({{"type", "point"}, {"range", -2}}), ok, "taken as no range"},
      {"light_unknown_type", light({{"type", "area"}}), ok, "the light is skipped"},
      {"light_index_out_of_range",
       [=](GltfFixture& g) {
         light({{"type", "point"}})(g);
         g.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 1;
       },
       bad, "nodes[0].extensions.KHR_lights_punctual.light: UNRESOLVED_REFERENCE"},
      {"light_picture_missing",
       light({{"type", "spot"},
              {"spot", json::object()},
              {"extras", {{"halflight", {{"picture", "none.jpg"}}}}}}),
       ok, "none.jpg"},
      {"light_picture_outside",
       light({{"type", "spot"},
              {"spot", json::object()},
              {"extras", {{"halflight", {{"picture", "../slide.jpg"}}}}}}),
       bad, "leaves the asset's folder"},
      {"camera_without_type", camera(json::object()), bad, "'type' is missing"},
      {"camera_of_unknown_type", camera({{"type", "oblique"}}), bad, "VALUE_NOT_IN_LIST"},
      {"camera_without_projection", camera({{"type", "perspective"}}), bad, "'perspective' is missing"},
      {"camera_without_angle",
       camera({{"type", "perspective"}, {"perspective", {{"yfov", 0}, {"znear", 1}}}}), bad,
       "yfov: VALUE_NOT_IN_RANGE"},
      {"camera_flat",
       camera({{"type", "orthographic"},
               {"orthographic", {{"xmag", 1}, {"ymag", 0}, {"znear", 0}, {"zfar", 1}}}}),
       bad, "ymag: VALUE_NOT_IN_RANGE"},
      {"camera_planes_swapped",
       camera({{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 2}, {"zfar", 1}}}}), ok,
       "CAMERA_ZFAR_LEQUAL_ZNEAR"},
  };
}

std::vector<Fault> type_faults() {
  const auto set = [](const char* pointer, json value) {
    return [=](GltfFixture& g) { g.json[json::json_pointer(pointer)] = value; };
  };
  return {
      {"no_asset", [](GltfFixture& g) { g.json.erase("asset"); }, bad,
       "UNDEFINED_PROPERTY: 'asset' is missing"},
      {"version_1", set("/asset/version", "1.0"), bad, "UNKNOWN_ASSET_MAJOR_VERSION"},
      {"version_number", set("/asset/version", 2.0), bad, "asset.version: TYPE_MISMATCH"},
      {"version_words", set("/asset/version", "two"), bad, "PATTERN_MISMATCH"},
      {"nodes_object", set("/nodes", json::object()), bad, "nodes: TYPE_MISMATCH"},
      {"node_number", set("/nodes/0", 1), bad, "nodes[0]: TYPE_MISMATCH"},
      {"children_strings", set("/nodes/0/children", json::array({"a"})), bad, "TYPE_MISMATCH"},
      {"mesh_string", set("/nodes/0/mesh", "0"), bad, "nodes[0].mesh: TYPE_MISMATCH"},
      {"matrix_strings", set("/nodes/0/matrix", json::array({"a"})), bad, "TYPE_MISMATCH"},
      {"primitives_object", set("/meshes/0/primitives", json::object()), bad,
       "meshes[0].primitives: TYPE_MISMATCH"},
      {"attributes_array", set("/meshes/0/primitives/0/attributes", json::array()), bad, "TYPE_MISMATCH"},
      {"extensions_array", set("/meshes/0/primitives/0/extensions", json::array()), bad, "TYPE_MISMATCH"},
      {"extras_anything", set("/nodes/0/extras", json::array({1, "a"})), ok, ""},
      {"uri_number", set("/buffers", json::array({{{"byteLength", 1}, {"uri", 1}}})), bad,
       "buffers[0].uri: TYPE_MISMATCH"},
      {"newline_in_a_name", set("/extensionsRequired", json::array({"EVIL\nhalflight: all is well"})), bad,
       "EVIL?halflight"},
      {"base_color_of_three",
       set("/materials", json::array({{{"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1}}}}}})), bad,
       "ARRAY_LENGTH_NOT_IN_LIST"},
      {"base_color_above_one",
       set("/materials", json::array({{{"pbrMetallicRoughness", {{"baseColorFactor", {2, 1, 1, 1}}}}}})), ok,
       "taken as 1"},
      {"texture_out_of_range", set("/materials", json::array({{{"normalTexture", {{"index", 0}}}}})), bad,
       "UNRESOLVED_REFERENCE"},
      {"brdf_unknown", set("/materials", json::array({{{"extras", {{"halflight", {{"brdf", "ward"}}}}}}})),
       bad, "valid: phong, ashikhmin-shirley"},
      {"extension_required", set("/extensionsRequired", json::array({"KHR_texture_basisu"})), bad,
       "requires KHR_texture_basisu"},
      {"extension_used", set("/extensionsUsed", json::array({"ACME_glitter"})), ok, "ACME_glitter"},
      {"extension_used_without_loss", set("/extensionsUsed", json::array({"KHR_materials_variants"})), ok,
       ""},
  };
}

INSTANTIATE_TEST_SUITE_P(Data, GltfFault, testing::ValuesIn(data_faults()), fault_name);
INSTANTIATE_TEST_SUITE_P(Mesh, GltfFault, testing::ValuesIn(mesh_faults()), fault_name);
INSTANTIATE_TEST_SUITE_P(Graph, GltfFault, testing::ValuesIn(graph_faults()), fault_name);
INSTANTIATE_TEST_SUITE_P(LightAndCamera, GltfFault, testing::ValuesIn(light_and_camera_faults()), fault_name);
INSTANTIATE_TEST_SUITE_P(Type, GltfFault, testing::ValuesIn(type_faults()), fault_name);

TEST(GltfFault, TheSoundTriangleHasNone) {
  const LoadOutcome outcome = load_outcome(triangle_fixture());
  EXPECT_EQ(outcome.exit, ExitCode::ok) << outcome.message;
  EXPECT_TRUE(outcome.warnings.empty()) << outcome.all();
  EXPECT_EQ(outcome.scene.triangles.size(), 1u);
}

TEST(GltfFault, SkippedGeometryIsCountedAndTheRestIsDrawn) {
  GltfFixture gltf = triangle_fixture();
  gltf.json["accessors"][1] = {{"bufferView", gltf.add_view<uint16_t>({0, 1, 2, 0, 1, 1, 2, 2, 2})},
                               {"type", "SCALAR"},
                               {"componentType", 5123},
                               {"count", 9}};
  gltf.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"mode", 1}});
  const LoadOutcome outcome = load_outcome(gltf);
  EXPECT_EQ(outcome.scene.triangles.size(), 1u);
  EXPECT_EQ(outcome.scene.facts.skipped_triangles, 2u);
  EXPECT_EQ(outcome.scene.facts.skipped_primitives, 1u);
}

TEST(GltfFault, LimitsAreTold) {
  LoadOptions options;
  options.limits.triangles = 0;
  EXPECT_TRUE(load_outcome(triangle_fixture(), options).tells("--limit-triangles"));
  options = {};
  options.limits.nodes = 0;
  EXPECT_TRUE(load_outcome(triangle_fixture(), options).tells("--limit-nodes"));
  options = {};
  options.limits.buffer_bytes = 40;
  EXPECT_EQ(load_outcome(triangle_fixture(), options).exit, ExitCode::bad_input);
}

}  // namespace

}  // namespace halflight
