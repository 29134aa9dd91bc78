# Profile-guided optimisation by Clang: what is inlined, unrolled and laid out together follows how often renders run it,
# and virtual calls whose targets are mostly the same become direct ones. The counts are of the compiler's intermediate
# code (-fprofile-generate; counts of the source, -fprofile-instr-generate, know nothing of virtual calls). They stand in
# the repository, since they are some hundred kilobytes, hold for any machine, and save who builds a second build;
# scripts/make-profile makes them anew. They belong to functions by name and structure: one that has changed since has
# none. Names without linkage include that of the file that is compiled, so that the counts fit builds that compile a
# folder at a time (LACQUER_GROUP_FOLDERS), as the presets do: the file's own name alone, not where the build stands.
# Bits of images do not depend on them.
set(LACQUER_PROFILE auto CACHE STRING
    "use: optimise by the counts of the repository (Clang 14 or later, Release, LACQUER_GROUP_FOLDERS); make: count; none; auto: use or none")
set_property(CACHE LACQUER_PROFILE PROPERTY STRINGS auto use make none)
set(lacquer_profile ${LACQUER_PROFILE})
if(LACQUER_PROFILE STREQUAL auto)
    # Not in other projects, whose sources would be compiled by these counts, too; nor beside counts that somebody names.
    set(lacquer_profile use)
    if(NOT PROJECT_IS_TOP_LEVEL OR "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_RELEASE}" MATCHES "-fprofile")
        set(lacquer_profile none)
    endif()
endif()

set(lacquer_profile_compiler FALSE)
if(CMAKE_CXX_COMPILER_ID STREQUAL Clang AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 14
        AND CMAKE_BUILD_TYPE STREQUAL Release AND LACQUER_GROUP_FOLDERS AND NOT LACQUER_SANITIZE)
    set(lacquer_profile_compiler TRUE)
endif()

set(lacquer_profile_names "SHELL:-mllvm -static-func-full-module-prefix=false")
if(lacquer_profile STREQUAL make)
    if(NOT lacquer_profile_compiler)
        message(FATAL_ERROR "LACQUER_PROFILE=make needs Clang 14 or later, CMAKE_BUILD_TYPE=Release, "
            "LACQUER_GROUP_FOLDERS=ON and no sanitizers")
    endif()
    target_compile_options(lacquer_options INTERFACE -fprofile-generate ${lacquer_profile_names})
    target_link_options(lacquer_options INTERFACE -fprofile-generate)
elseif(lacquer_profile STREQUAL use AND lacquer_profile_compiler)
    set(lacquer_profile_archive ${PROJECT_SOURCE_DIR}/cmake/renders.profdata.tar.xz)
    set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${lacquer_profile_archive})
    # Named by its content, so that all is compiled anew when it changes.
    file(SHA256 ${lacquer_profile_archive} lacquer_profile_hash)
    string(SUBSTRING ${lacquer_profile_hash} 0 12 lacquer_profile_hash)
    set(lacquer_profile_folder ${PROJECT_BINARY_DIR}/profile/${lacquer_profile_hash})
    if(NOT EXISTS ${lacquer_profile_folder}/renders.profdata)
        # Others are of no use any more; and a name of its own until it is whole.
        file(REMOVE_RECURSE ${PROJECT_BINARY_DIR}/profile)
        file(ARCHIVE_EXTRACT INPUT ${lacquer_profile_archive} DESTINATION ${PROJECT_BINARY_DIR}/profile/unpacked)
        file(RENAME ${PROJECT_BINARY_DIR}/profile/unpacked ${lacquer_profile_folder})
    endif()
    target_compile_options(lacquer_options INTERFACE
        $<$<COMPILE_LANGUAGE:CXX>:-fprofile-use=${lacquer_profile_folder}/renders.profdata>
        $<$<COMPILE_LANGUAGE:CXX>:${lacquer_profile_names}>
        # Functions that no training render runs, or that have changed.
        -Wno-profile-instr-unprofiled -Wno-profile-instr-out-of-date -Wno-backend-plugin)
elseif(NOT lacquer_profile MATCHES "^(use|none)$")
    message(FATAL_ERROR "LACQUER_PROFILE is \"${LACQUER_PROFILE}\"; expected auto, use, make or none")
endif()
