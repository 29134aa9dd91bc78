// Data files that the build makes part of the executable (cmake/EmbedFiles.cmake).
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace lacquer {

struct EmbeddedFile {
    const char* name;  ///< path below data/, for example "spectra/observer/cie1931.txt"
    const char* begin;
    const char* end;
};

/// The bytes of an embedded file. Errors: an unknown name is a programmer's error (std::logic_error).
std::string_view EmbeddedData(std::string_view name);
/// The same of another list, that of some target (lacquer_embed).
std::string_view EmbeddedData(const EmbeddedFile* files, std::string_view name);
/// True if the executable holds that file.
bool HasEmbeddedData(std::string_view name);
/// Names of all embedded files below `folder` ("spectra/metals/"), without the folder.
std::vector<std::string> EmbeddedNames(std::string_view folder);

/// Rows of numbers of an embedded text file: '#' starts a comment, a leading word is skipped, all rows have
/// the same length.
std::vector<std::vector<double>> EmbeddedTable(std::string_view name);

}  // namespace lacquer
