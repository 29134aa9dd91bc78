# Intel Open Image Denoise where it is found: 2, else 1.4 or later, which has cleanAux. Debian 12 has neither. LACQUER_HAS_OIDN
# says which it is. Only src/denoise/oidn.cpp knows it.
find_package(OpenImageDenoise 2 QUIET CONFIG)
if(NOT OpenImageDenoise_FOUND)
    find_package(OpenImageDenoise 1.4 QUIET CONFIG)
endif()
if(TARGET OpenImageDenoise)
    set(LACQUER_HAS_OIDN 1)
    message(STATUS "Open Image Denoise ${OpenImageDenoise_VERSION}: ${OpenImageDenoise_DIR}")
else()
    set(LACQUER_HAS_OIDN 0)
endif()
