# Language, warnings, optimisation, sanitizers and the compiler cache; the target lacquer::options carries them.

if(NOT CMAKE_BUILD_TYPE)
    set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_CXX_EXTENSIONS OFF)

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
    # Precompiled headers are only cacheable when ccache may ignore their time stamps.
    set(CMAKE_CXX_COMPILER_LAUNCHER
        ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime
        ${CCACHE_PROGRAM})
endif()

# How code is made, of the headers' inline functions too. Programs that link the installed library take these over
# (Install.cmake): they compile the same functions, and the linker keeps one copy of each.
#
# No errno and no floating-point traps: square roots and comparisons stay single instructions.
# Everything else of IEEE arithmetic is kept; NaN and infinity are tested for.
set(lacquer_arithmetic -fno-math-errno -fno-trapping-math)
set(lacquer_machine $<$<BOOL:${LACQUER_NATIVE}>:-march=native>)

add_library(lacquer_options INTERFACE)
add_library(lacquer::options ALIAS lacquer_options)
target_compile_features(lacquer_options INTERFACE cxx_std_20)
target_compile_options(lacquer_options INTERFACE
    # A project that has this one as a subdirectory has warnings of its own.
    "$<$<BOOL:${PROJECT_IS_TOP_LEVEL}>:-Wall;-Wextra;-Wshadow;-Wconversion;-Wdouble-promotion>"
    "$<$<BOOL:${LACQUER_WERROR}>:-Werror>"
    ${lacquer_arithmetic}
    # Flow analyses of GCC 12 that cry wolf after inlining (std::optional, std::string); the sanitizers see the real ones.
    # And that vectors wider than the machine's registers are passed by memory: see pbrt/core/vector_calls.h.
    "$<$<CXX_COMPILER_ID:Clang>:-Wno-psabi>"
    "$<$<CXX_COMPILER_ID:GNU>:-Wno-psabi;-fpch-preprocess;-Wno-maybe-uninitialized;-Wno-stringop-overflow;-Wno-stringop-overread;-Wno-dangling-pointer;-Wno-array-bounds;-Wno-restrict>")
target_compile_options(lacquer_options INTERFACE ${lacquer_machine})
if(CMAKE_CXX_COMPILER_ID STREQUAL Clang)
    # Precompiled headers are only cacheable without their time stamp.
    target_compile_options(lacquer_options INTERFACE "$<$<COMPILE_LANGUAGE:CXX>:SHELL:-Xclang -fno-pch-timestamp>")
endif()
set(LACQUER_SANITIZE_EXCEPT "" CACHE STRING "Checks of these sanitizers that are left out, as for -fno-sanitize=")
if(LACQUER_SANITIZE)
    # Not in targets with the property LACQUER_UNSANITIZED: programs that compute much while building.
    set(sanitized "$<NOT:$<BOOL:$<TARGET_PROPERTY:LACQUER_UNSANITIZED>>>")
    target_compile_options(lacquer_options INTERFACE
        $<${sanitized}:-fsanitize=${LACQUER_SANITIZE}> -fno-sanitize-recover=all -fno-omit-frame-pointer
        # What the address sanitizer finds as well, at the first access; a sixth of the compile time.
        $<${sanitized}:-fno-sanitize=null,object-size,nonnull-attribute,returns-nonnull-attribute>)
    if(LACQUER_SANITIZE_EXCEPT)
        target_compile_options(lacquer_options INTERFACE $<${sanitized}:-fno-sanitize=${LACQUER_SANITIZE_EXCEPT}>)
    endif()
    target_link_options(lacquer_options INTERFACE $<${sanitized}:-fsanitize=${LACQUER_SANITIZE}>)
endif()

# lacquer_cold(TARGET): optimises code that runs little and costs much to compile (command lines, JSON, GoogleTest) as
# LACQUER_COLD_OPTIMIZATION says.
#
# An inline function that such a file and the library both keep out of line is linked once, and the linker takes the first
# copy that it meets: in `lacquer` that of the command, since its objects stand before the library's, in a benchmark that of
# the library. So what is hot must not depend on a copy out of line: keep loops in .cpp files of the library, and measure
# with `lacquer` what a benchmark alone has shown.
set(LACQUER_COLD_OPTIMIZATION "" CACHE STRING "Optimisation of commands and tests, for example -O0; empty: as all else")
function(lacquer_cold target)
    target_compile_options(${target} PRIVATE ${LACQUER_COLD_OPTIMIZATION})
endfunction()

# For builds that only look at what fits do with wrong input: no render runs them (cmake/Modules.cmake).
set(LACQUER_NUMERICS_OPTIMIZATION "" CACHE STRING "Optimisation of fits; empty: as all else")

# lacquer_group_folders(TARGET [APART FOLDER...]): compiles the files of each folder of the target as one where
# LACQUER_GROUP_FOLDERS is on, so that they parse the same headers once, but for those that stand in a folder named. Names
# without linkage have to differ within a folder then, or have a namespace of their file's.
option(LACQUER_GROUP_FOLDERS "Compile a folder at a time: a third of the time for all, more for one file" OFF)
function(lacquer_group_folders target)
    if(LACQUER_GROUP_FOLDERS)
        set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
        if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
            # It takes every file for a header that is not compiled by itself.
            target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
        endif()
        # Once all folders have added their files.
        cmake_language(EVAL CODE "cmake_language(DEFER CALL lacquer_name_groups ${target} ${ARGN})")
    endif()
endfunction()
function(lacquer_name_groups target)
    cmake_parse_arguments(PARSE_ARGV 1 group "" "" APART)
    get_target_property(sources ${target} SOURCES)
    get_target_property(home ${target} SOURCE_DIR)
    foreach(source IN LISTS sources)
        cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${home})
        cmake_path(GET source PARENT_PATH folder)
        cmake_path(RELATIVE_PATH folder BASE_DIRECTORY ${PROJECT_SOURCE_DIR})
        if(source MATCHES "[.]cpp$" AND NOT folder IN_LIST group_APART)
            string(MAKE_C_IDENTIFIER ${folder} group)
            set_source_files_properties(${source} TARGET_DIRECTORY ${target} PROPERTIES UNITY_GROUP ${group})
        endif()
    endforeach()
endfunction()
