# lacquer_add_module(NAME [APART FOLDER...]): the library lacquer_NAME of a folder of src, whose files the folders below add
# to it. Folders are compiled as one (lacquer_group_folders) but for those named.
#
# All modules are OBJECT libraries: static registration (LACQUER_REGISTER) would be lost in STATIC ones. What links one of
# them gets its headers; executables name every module whose code they contain.
set(LACQUER_COMMON_HEADERS <algorithm> <array> <functional> <map> <memory> <optional> <span> <string> <vector>
    <fmt/format.h> ${PROJECT_SOURCE_DIR}/src/pbrt/core/transform.h)
# Fits, which LACQUER_NUMERICS_OPTIMIZATION is for. (Clusters of spheres are solved before some wrong inputs show.)
set(LACQUER_NUMERICS estimate estimate_mode estimate_scene capture)
function(lacquer_add_module name)
    cmake_parse_arguments(PARSE_ARGV 1 module "" "" APART)
    add_library(lacquer_${name} OBJECT)
    lacquer_group_folders(lacquer_${name} APART ${module_APART})
    # GCC limits how much inlining may enlarge a large file, which small ones are free of: without this option renders take
    # 7 to 9 % longer where folders are compiled as one.
    if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND NOT name MATCHES "cmd$")
        target_compile_options(lacquer_${name} PRIVATE "SHELL:--param large-unit-insns=1000000")
    endif()
    target_include_directories(lacquer_${name} PUBLIC ${PROJECT_SOURCE_DIR}/src)
    target_link_libraries(lacquer_${name} PUBLIC lacquer::options)
    # The module of Python is a shared object of the same object files. Hidden names are called directly, as in programs.
    if(LACQUER_PYTHON AND NOT name MATCHES "cmd$")
        set_target_properties(lacquer_${name} PROPERTIES
            POSITION_INDEPENDENT_CODE ON CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
    endif()
    # Four precompiled headers: of the library, of the commands (command lines, JSON), of libtorch, and of the tests.
    if(name STREQUAL pbrt)
        target_precompile_headers(lacquer_pbrt PRIVATE ${LACQUER_COMMON_HEADERS})
    elseif(name STREQUAL cmd)
        target_precompile_headers(lacquer_cmd PRIVATE ${LACQUER_COMMON_HEADERS} <CLI/CLI.hpp> <nlohmann/json.hpp>)
    elseif(name STREQUAL materialgan)
        target_precompile_headers(lacquer_materialgan PRIVATE ${LACQUER_COMMON_HEADERS} <torch/torch.h>)
    elseif(name MATCHES "_cmd$")
        target_precompile_headers(lacquer_${name} REUSE_FROM lacquer_cmd)
    elseif(LACQUER_NUMERICS_OPTIMIZATION AND name IN_LIST LACQUER_NUMERICS)
        target_compile_options(lacquer_${name} PRIVATE ${LACQUER_NUMERICS_OPTIMIZATION})
        # Clang wants headers that were compiled with the same optimisation.
        if(name STREQUAL estimate)
            target_precompile_headers(lacquer_estimate PRIVATE ${LACQUER_COMMON_HEADERS})
        else()
            target_precompile_headers(lacquer_${name} REUSE_FROM lacquer_estimate)
        endif()
    else()
        target_precompile_headers(lacquer_${name} REUSE_FROM lacquer_pbrt)
    endif()
endfunction()

# What programs load while they run (src/pbrt/image/openimageio), and their run path to it; Install.cmake sets that of installed
# ones.
set(LACQUER_LOADED_FOLDER ${PROJECT_BINARY_DIR}/lib/lacquer)
list(APPEND CMAKE_BUILD_RPATH ${LACQUER_LOADED_FOLDER})
