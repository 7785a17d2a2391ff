# halflight_benchmark: run by hand, never by ctest (docs/performance.md).
add_executable(halflight_benchmark benchmarks/main.cpp 
  benchmarks/adaptive.cpp benchmarks/interaction.cpp benchmarks/rays.cpp benchmarks/steps.cpp)
target_include_directories(halflight_benchmark PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
target_link_libraries(halflight_benchmark PRIVATE halflight_app halflight_viewer)
target_compile_definitions(halflight_benchmark PRIVATE HALFLIGHT_VIEWS="${CMAKE_CURRENT_SOURCE_DIR}/views.json")
