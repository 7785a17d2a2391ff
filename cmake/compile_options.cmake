# halflight_options: what every target of ours is compiled with. Third-party headers stay out of the warnings.
add_library(halflight_options INTERFACE)
target_include_directories(halflight_options INTERFACE ${PROJECT_SOURCE_DIR}/renderer ${PROJECT_SOURCE_DIR}/shaders)
target_compile_options(halflight_options INTERFACE
  -Wall -Wextra -Wshadow -Wnon-virtual-dtor -Wno-unused-parameter
  # Plain loops vectorise once errno and trapping semantics are out of the way; -ffast-math was measured slower.
  -fno-math-errno -fno-trapping-math)

# Any x86-64 of the last ten years runs the program; wider vectors are chosen at run time (Highway, Embree).
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  target_compile_options(halflight_options INTERFACE -march=x86-64-v2)
endif()

# One multiply-add contraction policy: the same picture whether the compiler fuses or not.
target_compile_options(halflight_options INTERFACE -ffp-contract=off)

if(HALFLIGHT_SANITIZE)
  add_compile_options(-fsanitize=${HALFLIGHT_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${HALFLIGHT_SANITIZE})
endif()

# A second build of the same file costs nothing where ccache is installed.
find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()
