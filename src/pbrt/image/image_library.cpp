// Loads OpenImageIO by the first image file that needs it: its module, unless the program is linked with it.
#include "pbrt/image/image_library.h"

#include <cctype>
#include <string>

#include "pbrt/core/loaded_module.h"

/// Null unless the program is linked with the module's own objects, as it is with the installed library
/// (docs/library.md).
extern "C" [[gnu::weak]] decltype(LacquerOpenImageIO) LacquerOpenImageIO;

namespace lacquer {

namespace {

constexpr const char* kModule = "liblacquer_openimageio.so";
constexpr const char* kPurpose = "which reads and writes images other than EXR and plain PNG";

const ImageLibrary& Load() {
    auto* make = &LacquerOpenImageIO;
    if (!make)
        make = reinterpret_cast<decltype(make)>(FunctionOfModule(kModule, "LacquerOpenImageIO", kPurpose));
    const ImageLibrary* const library = make(ImageLibrary::kVersion);
    if (!library) RefuseModule(kModule, kPurpose, "it is of another version of Lacquer");
    return *library;
}

}  // namespace

const ImageLibrary& LoadImageLibrary() {
    static const ImageLibrary& library = Load();
    return library;
}

std::string OneLine(const std::string& message) {
    std::string line;
    for (char c : message) {
        const bool blank = std::iscntrl(static_cast<unsigned char>(c)) || c == ' ';
        if (!blank)
            line += c;
        else if (!line.empty() && line.back() != ' ')
            line += ' ';
    }
    while (!line.empty() && line.back() == ' ') line.pop_back();
    return line.empty() ? "the data are incomplete or make no sense" : line;
}

}  // namespace lacquer
