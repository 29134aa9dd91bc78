# The package file of the double, under the names of Open Image Denoise's own.
add_library(OpenImageDenoise INTERFACE IMPORTED)
target_include_directories(OpenImageDenoise INTERFACE ${CMAKE_CURRENT_LIST_DIR}/include)
