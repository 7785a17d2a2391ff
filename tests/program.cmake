# Tests of program: its options, then the shipped binary as its users' scripts see it, then its pictures.
halflight_unit_test(app_options halflight_app)
halflight_unit_test(app_adaptive halflight_app)
halflight_unit_test(app_report_statistics halflight_report)
halflight_unit_test(app_report_race halflight_report)
halflight_unit_test(app_stress halflight_app)

add_executable(test_program unit/app_program.cpp unit/app_compare.cpp unit/app_experiments.cpp)
target_include_directories(test_program PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
add_dependencies(test_program halflight)
target_link_libraries(test_program PRIVATE halflight_scene nlohmann_json::nlohmann_json GTest::gtest GTest::gtest_main)
target_compile_definitions(test_program PRIVATE
  HALFLIGHT_PROGRAM="$<TARGET_FILE:halflight>"
  HALFLIGHT_FIXTURES="${CMAKE_CURRENT_SOURCE_DIR}/pictures/fixtures")
gtest_discover_tests(test_program TEST_PREFIX "program." PROPERTIES LABELS program TIMEOUT 300)

add_executable(picture_check pictures/picture_check.cpp)
target_link_libraries(picture_check PRIVATE halflight_scene)

# halflight_picture_test(NAME ARGUMENTS... [LIT percent] [DISTANCE x] ): the picture of `halflight render ARGUMENTS` under
# egl, osmesa and none is whole, LIT percent of it well above black (60), and its SMAPE against the one by rays at most
# DISTANCE (0.005): a bounded metric, for pixels on a shadow's edge differ between rays and shadow maps.
function(halflight_picture_test name)
  cmake_parse_arguments(PARSE_ARGV 1 test "" "LIT;DISTANCE;EV" "")
  if(NOT test_LIT)
    set(test_LIT 60)
  endif()
  if(NOT test_DISTANCE)
    set(test_DISTANCE 0.005)
  endif()
  add_test(NAME picture.${name}
    COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:halflight> -DCHECK=$<TARGET_FILE:picture_check>
      -DFOLDER=${CMAKE_CURRENT_BINARY_DIR}/pictures -DNAME=${name} -DSIZE=160x120 -DLIT=${test_LIT}
      -DDISTANCE=${test_DISTANCE} -DEV=${test_EV} "-DARGUMENTS=${test_UNPARSED_ARGUMENTS}"
      -P ${CMAKE_CURRENT_SOURCE_DIR}/pictures/picture_test.cmake)
  set_tests_properties(picture.${name} PROPERTIES LABELS picture TIMEOUT 300)
endfunction()

halflight_picture_test(cornell cornell --samples 16 --target discrete)
halflight_picture_test(cornell-direct cornell --samples 16 --target discrete --light direct LIT 45)
halflight_picture_test(cornell-indirect cornell --samples 16 --target discrete --light indirect)
halflight_picture_test(cornell-continuous cornell --samples 16 DISTANCE 0.02)
halflight_picture_test(bedroom bedroom --samples 16 --target discrete LIT 80 DISTANCE 0.1)
halflight_picture_test(reference cornell --samples 1 --technique reference --virtual-lights 256)

# The same for scenes that are no part of the repository, where they lie beside it: NAME FILE-UNDER-DATA ARGUMENTS...
set(shared_data ${PROJECT_SOURCE_DIR}/../shared/data)
function(halflight_shared_picture_test name file)
  if(EXISTS ${shared_data}/${file})
    halflight_picture_test(${name} ${shared_data}/${file} ${ARGN})
  endif()
endfunction()

halflight_shared_picture_test(cornell-bevy gltf/interiors/cornell-bevy/CornellBox.glb --samples 16 --target discrete)
halflight_shared_picture_test(lamp gltf/khronos/LightsPunctualLamp/LightsPunctualLamp.gltf --samples 16 --target discrete LIT 8 DISTANCE 0.02)
halflight_shared_picture_test(alpha gltf/khronos/AlphaBlendModeTest/AlphaBlendModeTest.glb --samples 16 --target discrete)
halflight_shared_picture_test(helmet gltf/khronos/FlightHelmet/FlightHelmet.gltf --samples 16 --target discrete
  --environment ${shared_data}/env/latlong-hdr/venice_sunset_1k.hdr)

# The views of views.json, each looked at: at least 60 % of what is shown is well above black.
# Shadow maps and rays light the surface points a little differently; the cut follows, and with it every later draw: what is
# left to compare is two independent pictures of 16 samples.
file(READ ${CMAKE_CURRENT_SOURCE_DIR}/views.json views)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/views.json)
string(JSON view_count LENGTH "${views}" views)
math(EXPR last_view "${view_count} - 1")
foreach(index RANGE ${last_view})
  string(JSON view MEMBER "${views}" views ${index})
  string(JSON scene GET "${views}" views ${view} scene)
  string(JSON ev GET "${views}" views ${view} ev)
  if(EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/${scene})
    halflight_picture_test(view-${view} --view ${CMAKE_CURRENT_SOURCE_DIR}/views.json\#${view} --samples 16 --target discrete LIT 60 EV ${ev} DISTANCE 0.06)
  endif()
endforeach()
halflight_unit_test(session_unbiased halflight_session)
add_test(NAME full.session_unbiased COMMAND test_session_unbiased)
set_tests_properties(full.session_unbiased PROPERTIES LABELS full TIMEOUT 3600)
halflight_unit_test(session_continuous halflight_session)
target_compile_definitions(test_session_continuous PRIVATE HALFLIGHT_VIEWS="${CMAKE_CURRENT_SOURCE_DIR}/views.json")
add_test(NAME full.session_continuous COMMAND test_session_continuous)
set_tests_properties(full.session_continuous PROPERTIES LABELS full ENVIRONMENT HALFLIGHT_FULL_TESTS=1 TIMEOUT 7200)
