# Tests of scene.
halflight_unit_test(scene_brdf halflight_scene)
halflight_unit_test(scene_shading halflight_scene)
halflight_unit_test(scene_camera halflight_scene)
halflight_unit_test(scene_framing halflight_scene)
halflight_unit_test(scene_gltf_files halflight_scene nlohmann_json::nlohmann_json)
halflight_unit_test(scene_gltf_animation halflight_scene nlohmann_json::nlohmann_json)
halflight_unit_test(scene_gltf_geometry halflight_scene nlohmann_json::nlohmann_json)
halflight_unit_test(scene_gltf_materials halflight_scene nlohmann_json::nlohmann_json)

# Malformed input: one executable from malformed/NAME.cpp, labelled so that the sanitizers' run can pick them.
function(halflight_malformed_test name)
  add_executable(test_malformed_${name} malformed/${name}.cpp)
  target_include_directories(test_malformed_${name} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
  target_link_libraries(test_malformed_${name} PRIVATE ${ARGN} GTest::gtest GTest::gtest_main)
  target_compile_definitions(test_malformed_${name} PRIVATE
    HALFLIGHT_SHARED_DATA="${PROJECT_SOURCE_DIR}/../shared/data"
    HALFLIGHT_MALFORMED_FOLDER="${CMAKE_CURRENT_SOURCE_DIR}/malformed")
  gtest_discover_tests(test_malformed_${name} TEST_PREFIX "malformed.${name}." DISCOVERY_TIMEOUT 60
                       PROPERTIES LABELS malformed)
endfunction()

halflight_malformed_test(gltf_faults halflight_scene nlohmann_json::nlohmann_json)
halflight_malformed_test(gltf_file_faults halflight_scene nlohmann_json::nlohmann_json)
halflight_malformed_test(shared_files halflight_scene nlohmann_json::nlohmann_json)
halflight_unit_test(scene_brdf_batch halflight_scene)
