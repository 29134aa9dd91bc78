// The parts of the native module.
#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <string>
#include <vector>

#include "pbrt/image/image.h"
#include "pbrt/image/texture_memory.h"
#include "pbrt/scene/description.h"

namespace lacquer::python {

/// A scene that has been read. Descriptions are never changed, only replaced, so that threads may share them.
struct ParsedScene {
    std::shared_ptr<const SceneDescription> description;
    std::string name;  ///< for the metadata of images
    double parseSeconds = 0;
    std::vector<std::string> warnings;
};

/// Megabytes, folder that keeps prepared textures, folder for temporary ones.
using TextureFolders = std::tuple<int, std::string, std::string>;
TextureMemory TextureMemoryOf(const TextureFolders& folders);

void DefineImages(pybind11::module_& m);
void DefineScenes(pybind11::module_& m);
void DefineMaterials(pybind11::module_& m);

}  // namespace lacquer::python
