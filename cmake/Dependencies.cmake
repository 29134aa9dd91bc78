# Every third-party library, all from Debian 12. Each is an imported target, treated as a system header.

find_package(Threads REQUIRED)
find_package(ZLIB REQUIRED)
find_package(TBB REQUIRED)
find_package(fmt REQUIRED)
find_package(glm REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(embree 3 REQUIRED)
find_package(OpenImageIO REQUIRED)
find_package(Ceres REQUIRED)

# Trap: OpenImageIO's target lists /usr/include/opencv4, which exists only where OpenCV is installed.
get_target_property(oiio_includes OpenImageIO::OpenImageIO INTERFACE_INCLUDE_DIRECTORIES)
list(FILTER oiio_includes EXCLUDE REGEX opencv)
set_target_properties(OpenImageIO::OpenImageIO PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${oiio_includes}")

if(LACQUER_TESTS)
    find_package(GTest REQUIRED)
endif()
if(LACQUER_BENCH)
    find_package(benchmark REQUIRED)
endif()
