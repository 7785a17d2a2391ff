# Every library the program stands on, found in one place. Debian 12 and 13 are both supported.
find_package(Threads REQUIRED)
find_package(glm REQUIRED)
find_package(TBB REQUIRED)
find_package(fmt REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(OpenEXR REQUIRED)
find_package(glfw3 REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(IMGUI REQUIRED IMPORTED_TARGET imgui)

find_package(embree 4 QUIET)
if(NOT embree_FOUND)
  find_package(embree 3 REQUIRED)
endif()
message(STATUS "Embree ${embree_VERSION}")

# Optional codecs: a file that requires a missing one is refused by the extension's name.
find_package(draco QUIET)
find_package(meshoptimizer QUIET)
pkg_check_modules(WEBP IMPORTED_TARGET libwebp)

find_path(STB_INCLUDE_DIR stb_image.h PATH_SUFFIXES stb REQUIRED)
