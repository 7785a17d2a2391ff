# halflight_benchmark: run by hand, never by ctest (docs/performance.md).
find_package(TinyGLTF REQUIRED)
add_executable(halflight_benchmark
  benchmarks/adaptive.cpp
  benchmarks/curves.cpp
  benchmarks/generated_scenes.cpp
  benchmarks/interaction.cpp
  benchmarks/load.cpp
  benchmarks/main.cpp
  benchmarks/outside.cpp
  benchmarks/rays.cpp
  benchmarks/scale.cpp
  benchmarks/steps.cpp
  benchmarks/time_to_error.cpp)
target_include_directories(halflight_benchmark PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
target_link_libraries(halflight_benchmark PRIVATE halflight_app halflight_viewer TinyGLTF::TinyGLTF embree)
target_compile_definitions(halflight_benchmark PRIVATE
  HALFLIGHT_PROGRAM="$<TARGET_FILE:halflight>"
  HALFLIGHT_VIEWS="${CMAKE_CURRENT_SOURCE_DIR}/views.json")
