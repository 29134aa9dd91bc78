// What the commands share.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pbrt/core/error.h"
#include "pbrt/core/vec.h"
#include "pbrt/image/texture_memory.h"

namespace lacquer::cmd {

/// Usage error (CLI::ValidationError) for an option's value. @param option  without dashes
[[noreturn]] void BadOption(const std::string& option, const std::string& value, const std::string& expected);

/// pbrt accepts its options with one dash or two, in any case, and with '-' and '_' left out: all spellings
/// of a name become one.
std::string NormalizedName(const std::string& name);

/// The value of an option does not fit the scene. As a SceneError it may name the place in the scene that
/// tells so, but the usage is what is wrong.
class OptionError : public SceneError {
  public:
    explicit OptionError(const SceneError& e) : SceneError(e.Loc(), e.Message()) {}
};

/// "640x360": width and height in pixels, from 1 to 65536, as for films. Errors: usage.
Int2 ParseResolution(const std::string& option, const std::string& text);

/// Tells of a hopeless output folder before the work and not after it. Errors: FileError unless `path` is a
/// folder or can become one.
void CheckOutputFolder(const std::string& path);
/// Makes it, below a folder that exists, unless it is there. Errors: FileError.
void MakeOutputFolder(const std::string& path);
/// As CheckOutputFolder() for a file. Errors: FileError unless its folder exists and can be written into.
void CheckOutputFile(const std::string& path);
/// A file that is to be written, and the option, or whatever else, that names it.
struct NamedOutput {
    std::string option, path;
};
/// Errors: FileError if one of the outputs is a file that is read, or two are the same. Empty paths, pipes
/// and devices are no matter.
void CheckOutputsApart(const std::vector<NamedOutput>& outputs, const std::vector<std::string>& inputs);
/// As CheckOutputFile() for an image. Errors: FileError, also where no image format has such an extension.
void CheckImageOutput(const std::string& path);

/// The limit for image textures, and the folders for those beyond it.
/// @param folder  of tiled files; empty: "lacquer/textures" in the user's cache folder, if there is one;
/// "none": a temporary one
TextureMemory TextureMemoryOf(int megabytes, const std::string& folder);
/// As of the options' defaults.
TextureMemory DefaultTextureMemory();
inline constexpr int kDefaultTextureMegabytes = 512;

/// JSON as text; bytes that are not UTF-8 become U+FFFD. @param indent  -1: all on one line
std::string JsonText(const nlohmann::ordered_json& value, int indent = -1);

/// Writes a file (OutputFile). Errors: FileError.
void WriteText(const std::string& path, const std::string& text);

}  // namespace lacquer::cmd
