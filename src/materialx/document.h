// Documents of MaterialX: surfaces, with values and images, as directives of the scene format.
#pragma once

#include <string>
#include <vector>

#include "pbrt/core/error.h"

namespace lacquer::materialx {

/// What a document says, in the scene format.
struct MaterialText {
    std::string text;                    ///< directives of textures and named materials
    std::vector<std::string> materials;  ///< their names, in the order of the document
    std::vector<Diagnostic> warnings;    ///< what has no counterpart, with its place
};

/// Reads a document with surfaces of the kinds `open_pbr_surface` and `standard_surface`. Each becomes a
/// named material "openpbr": of the name of its `surfacematerial`, or its own where it has none. Inputs may
/// have values, images (`image`, `tiledimage`) and constants, multiplied by constants; nodes of other kinds
/// are warned of, and the input keeps its default. Images are named relative to the current folder. Errors:
/// FileError for a file that cannot be read; SceneError with its place for one that is no such document, has
/// no such surface, or names what is not there.
MaterialText ReadDocument(const std::string& path);

/// True for names of documents, by their ending.
bool IsDocumentName(const std::string& path);

}  // namespace lacquer::materialx
