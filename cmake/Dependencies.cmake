# Every third-party library, all from Debian 12. Each is an imported target, treated as a system header.

# Projects that have this one as a subdirectory see the targets, too.
set(CMAKE_FIND_PACKAGE_TARGETS_GLOBAL ON)
find_package(Threads REQUIRED)
find_package(ZLIB REQUIRED)
find_package(TBB REQUIRED)
find_package(fmt REQUIRED)
find_package(glm REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
# Embree 4 where it is found, else 3. Only src/pbrt/accel/embree.cpp knows which.
find_package(embree 4 QUIET)
if(NOT embree_FOUND)
    find_package(embree 3 REQUIRED)
endif()
find_package(OpenEXR REQUIRED)
find_package(PNG REQUIRED)
find_package(OpenImageIO REQUIRED)
find_package(Ceres REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(pugixml REQUIRED)
# Tags of the card that photographs of samples have around them; only src/capture/card/tags.cpp knows.
find_package(apriltag REQUIRED)
include(OpenImageDenoise)
include(OpenMpi)
include(LibTorch)

# Trap: in debug builds TBB's target defines a macro for all that use it, and modules without it could not share precompiled
# headers with them.
set_target_properties(TBB::tbb PROPERTIES INTERFACE_COMPILE_DEFINITIONS "")

# NanoVDB is headers only, without a package file; what its files may be packed with is zlib and Blosc.
find_path(NANOVDB_INCLUDE_DIR nanovdb/NanoVDB.h REQUIRED)
find_path(BLOSC_INCLUDE_DIR blosc.h REQUIRED)
find_library(BLOSC_LIBRARY blosc REQUIRED)
add_library(lacquer_nanovdb INTERFACE)
target_include_directories(lacquer_nanovdb SYSTEM INTERFACE ${NANOVDB_INCLUDE_DIR} ${BLOSC_INCLUDE_DIR})
target_link_libraries(lacquer_nanovdb INTERFACE ${BLOSC_LIBRARY})

# Trap: OpenImageIO's target lists /usr/include/opencv4, which exists only where OpenCV is installed.
get_target_property(oiio_includes OpenImageIO::OpenImageIO INTERFACE_INCLUDE_DIRECTORIES)
list(FILTER oiio_includes EXCLUDE REGEX opencv)
set_target_properties(OpenImageIO::OpenImageIO PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${oiio_includes}")

if(LACQUER_PYTHON)
    # Debian's own, which has its numpy, rather than one that happens to come first in the PATH.
    if(NOT Python3_EXECUTABLE AND EXISTS /usr/bin/python3)
        set(Python3_EXECUTABLE /usr/bin/python3 CACHE FILEPATH "Interpreter that the module of Python is for")
    endif()
    find_package(Python3 COMPONENTS Interpreter Development.Module REQUIRED)
    find_package(pybind11 2.10 REQUIRED)
endif()
if(LACQUER_TESTS)
    find_package(GTest REQUIRED)
endif()
if(LACQUER_BENCH)
    find_package(benchmark REQUIRED)
endif()

# The plots of the comparison's report. One file, which becomes part of the executable and then of each report.
find_file(LACQUER_CHARTJS NAMES chart.min.js Chart.min.js PATH_SUFFIXES share/javascript/chart.js
    DOC "Chart.js 3 as one minified file for browsers")
if(NOT LACQUER_CHARTJS)
    message(FATAL_ERROR "Chart.js was not found. Install Debian's package libjs-chart.js, or point at a copy: "
        "-DLACQUER_CHARTJS=/path/to/chart.min.js")
endif()
configure_file(${LACQUER_CHARTJS} ${PROJECT_BINARY_DIR}/data/report/chart.js COPYONLY)
