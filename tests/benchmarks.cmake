# halflight_benchmark: run by hand, never by ctest (docs/performance.md).
add_executable(halflight_benchmark benchmarks/main.cpp benchmarks/rays.cpp benchmarks/steps.cpp)
target_include_directories(halflight_benchmark PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
target_link_libraries(halflight_benchmark PRIVATE halflight_session)
