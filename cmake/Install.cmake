# What `cmake --install` puts in place: the programs, the library with its headers and package file, the module of Python,
# documents, scenes, manual pages and completions. docs/library.md says how others use it.

include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# ---- The library: one archive of all modules but the commands ----

add_library(lacquer_archive STATIC)
set_target_properties(lacquer_archive PROPERTIES OUTPUT_NAME lacquer EXPORT_NAME archive LINKER_LANGUAGE CXX)
foreach(module ${LACQUER_LIBRARY_MODULES})
    target_sources(lacquer_archive PRIVATE $<FILTER:$<TARGET_OBJECTS:lacquer_${module}>,EXCLUDE,[.][gp]ch$>)
endforeach()
# Rather than the module that our programs load: where another's program stands, nobody knows.
target_sources(lacquer_archive PRIVATE $<TARGET_OBJECTS:lacquer_openimageio>)
# Headers name fmt and GLM; the rest is for the linker. Blosc has no package file (Dependencies.cmake).
target_link_libraries(lacquer_archive
    PUBLIC fmt::fmt glm::glm Threads::Threads
    PRIVATE TBB::tbb embree OpenEXR::OpenEXR PNG::PNG ZLIB::ZLIB OpenImageIO::OpenImageIO ${CMAKE_DL_LIBS}
    INTERFACE blosc)
if(LACQUER_HAS_OIDN)
    target_link_libraries(lacquer_archive PRIVATE OpenImageDenoise)
endif()
target_include_directories(lacquer_archive INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/lacquer>)
target_compile_features(lacquer_archive INTERFACE cxx_std_20)
target_compile_options(lacquer_archive INTERFACE ${lacquer_arithmetic} ${lacquer_machine})

install(TARGETS lacquer_archive EXPORT LacquerTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
foreach(module ${LACQUER_LIBRARY_MODULES})
    # Fitting of lobes and modes of posteriors need Ceres and are no part of the archive; the reader of JSON and what stands
    # behind ImageLibrary show their libraries.
    install(DIRECTORY ${PROJECT_SOURCE_DIR}/src/${module} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/lacquer
        FILES_MATCHING PATTERN *.h PATTERN gaussfit/fit EXCLUDE PATTERN estimate/mode EXCLUDE
        PATTERN estimate/scene EXCLUDE PATTERN image/openimageio EXCLUDE
        PATTERN core/json_reader.h EXCLUDE)
endforeach()

set(package ${CMAKE_INSTALL_LIBDIR}/cmake/Lacquer)
install(EXPORT LacquerTargets NAMESPACE Lacquer:: DESTINATION ${package})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/LacquerConfig.cmake.in
    ${PROJECT_BINARY_DIR}/LacquerConfig.cmake INSTALL_DESTINATION ${package})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/LacquerConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/LacquerConfig.cmake ${PROJECT_BINARY_DIR}/LacquerConfigVersion.cmake
    DESTINATION ${package})

# ---- Programs, documents, scenes ----

set(LACQUER_MODULE_FOLDER ${CMAKE_INSTALL_LIBDIR}/lacquer)
file(RELATIVE_PATH from_programs /${CMAKE_INSTALL_BINDIR} /${LACQUER_MODULE_FOLDER})
set_target_properties(lacquer gaussfit PROPERTIES INSTALL_RPATH "$ORIGIN/${from_programs}")
install(TARGETS lacquer gaussfit RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS lacquer_openimageio_module LIBRARY DESTINATION ${LACQUER_MODULE_FOLDER})
if(LACQUER_HAS_MPI)
    install(TARGETS lacquer_mpi_module LIBRARY DESTINATION ${LACQUER_MODULE_FOLDER})
endif()
install(FILES README.md LICENSE NOTICE DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/lacquer)
if(LACQUER_HAS_TORCH)
    set_target_properties(lacquer-materialgan PROPERTIES INSTALL_RPATH "$ORIGIN/${from_programs}")
    install(TARGETS lacquer-materialgan RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
    install(DIRECTORY data/materialgan DESTINATION ${CMAKE_INSTALL_DATADIR}/lacquer)
endif()
# For Blender's preferences; see docs/blender.md.
install(DIRECTORY addons/blender/lacquer_export DESTINATION ${CMAKE_INSTALL_DATADIR}/lacquer/blender
    FILES_MATCHING PATTERN *.py PATTERN __pycache__ EXCLUDE)

# ---- The module of Python: a component of its own, for packages of its own ----

if(LACQUER_PYTHON)
    # Where the interpreter looks below /usr/local: in dist-packages if it is Debian's, else in site-packages.
    execute_process(COMMAND ${Python3_EXECUTABLE} -c
        "import site; print('dist' if any(p.endswith('dist-packages') for p in site.getsitepackages()) else 'site')"
        OUTPUT_VARIABLE kind OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
    set(LACQUER_PYTHON_FOLDER lib/python${Python3_VERSION_MAJOR}.${Python3_VERSION_MINOR}/${kind}-packages CACHE STRING
        "Where the module of Python is installed, below the prefix or absolute")
    # With what it loads beside it, for it may be installed alone.
    set_target_properties(lacquer_python PROPERTIES INSTALL_RPATH "$ORIGIN")
    install(TARGETS lacquer_python lacquer_openimageio_module
        LIBRARY DESTINATION ${LACQUER_PYTHON_FOLDER}/lacquer COMPONENT python)
    install(DIRECTORY src/python/lacquer DESTINATION ${LACQUER_PYTHON_FOLDER} COMPONENT python
        FILES_MATCHING PATTERN *.py PATTERN *.pyi PATTERN py.typed PATTERN __pycache__ EXCLUDE)
    install(DIRECTORY examples DESTINATION ${CMAKE_INSTALL_DOCDIR} USE_SOURCE_PERMISSIONS COMPONENT python)
endif()

# ---- Manual pages and completions: the programs print them from their tables of options ----

set(man ${CMAKE_INSTALL_MANDIR}/man1)
set(bash ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
set(zsh ${CMAKE_INSTALL_DATADIR}/zsh/site-functions)
set(fish ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
set(help_files "")
set(programs lacquer gaussfit)
if(LACQUER_HAS_TORCH)
    list(APPEND programs lacquer-materialgan)
endif()
foreach(program IN LISTS programs)
    foreach(format_and_file man/${program}.1 bash/${program} zsh/_${program} fish/${program}.fish)
        cmake_path(GET format_and_file PARENT_PATH format)
        set(file ${PROJECT_BINARY_DIR}/help/${format_and_file})
        add_custom_command(OUTPUT ${file}
            COMMAND ${CMAKE_COMMAND} -E make_directory ${PROJECT_BINARY_DIR}/help/${format}
            COMMAND ${program} --help-as ${format} > ${file}
            DEPENDS ${program} VERBATIM)
        install(FILES ${file} DESTINATION ${${format}})
        list(APPEND help_files ${file})
    endforeach()
endforeach()
add_custom_target(lacquer_help ALL DEPENDS ${help_files})
