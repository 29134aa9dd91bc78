# PyTorch's C++ library (Debian: libtorch-dev) for src/materialgan, where LACQUER_MATERIALGAN asks for it. LACQUER_HAS_TORCH says
# whether it is there. Only the program lacquer-materialgan and its tests are linked with it.
set(LACQUER_MATERIALGAN AUTO CACHE STRING "Generator of materials, with libtorch: ON, OFF, or AUTO: if it is found")
set_property(CACHE LACQUER_MATERIALGAN PROPERTY STRINGS AUTO ON OFF)
set(LACQUER_HAS_TORCH 0)
if(LACQUER_MATERIALGAN)
    # Trap: its package file asks for CMake policies and for libraries of its own in the tone of the top level.
    find_package(Torch 1.13 QUIET)
    if(Torch_FOUND)
        set(LACQUER_HAS_TORCH 1)
        add_library(lacquer_torch INTERFACE)
        target_include_directories(lacquer_torch SYSTEM INTERFACE ${TORCH_INCLUDE_DIRS})
        target_link_libraries(lacquer_torch INTERFACE ${TORCH_LIBRARIES})
        message(STATUS "MaterialGAN: libtorch ${Torch_VERSION}")
    elseif(LACQUER_MATERIALGAN STREQUAL AUTO)
        message(STATUS "MaterialGAN: off (libtorch-dev not found)")
    else()
        message(FATAL_ERROR "LACQUER_MATERIALGAN is ON, and libtorch 1.13 or later was not found. Install Debian's package "
            "libtorch-dev (0.33 GB), or configure with -DLACQUER_MATERIALGAN=AUTO")
    endif()
endif()
