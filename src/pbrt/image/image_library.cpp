// Loads OpenImageIO by the first image file: its module, unless the program is linked with it.
#include "pbrt/image/image_library.h"

#include <dlfcn.h>
#include <link.h>

#include <cctype>
#include <memory>
#include <string>

#include <fmt/format.h>

#include "pbrt/core/error.h"

/// Null unless the program is linked with the module's own objects, as it is with the installed library
/// (docs/library.md).
extern "C" [[gnu::weak]] decltype(LacquerOpenImageIO) LacquerOpenImageIO;

namespace lacquer {

namespace {

constexpr const char* kModule = "liblacquer_openimageio.so";

[[noreturn]] void Fail(const std::string& problem) {
    throw FileError(
        kModule,
        fmt::format("this part of Lacquer, which reads and writes all images but PFM output, cannot be "
                    "loaded: {} (searched: {})",
                    problem, fmt::join(ImageLibraryFolders(), ", ")));
}

const ImageLibrary& Load() {
    auto* make = &LacquerOpenImageIO;
    if (!make) {
        // By its name alone: the run path of the program, or of Python's module, has the folder
        // (cmake/Install.cmake).
        void* const module = dlopen(kModule, RTLD_NOW | RTLD_LOCAL);
        if (!module) Fail(dlerror());
        make = reinterpret_cast<decltype(make)>(dlsym(module, "LacquerOpenImageIO"));
        if (!make) Fail(dlerror());
    }
    const ImageLibrary* const library = make(ImageLibrary::kVersion);
    if (!library) Fail("it is of another version of Lacquer");
    return *library;
}

}  // namespace

const ImageLibrary& LoadImageLibrary() {
    static const ImageLibrary& library = Load();
    return library;
}

std::vector<std::string> ImageLibraryFolders() {
    Dl_info info;
    link_map* map = nullptr;
    if (dladdr1(kModule, &info, reinterpret_cast<void**>(&map), RTLD_DL_LINKMAP) == 0 || !map) return {};
    const bool isProgram = map->l_name[0] == '\0';
    void* const self = dlopen(isProgram ? nullptr : map->l_name, RTLD_LAZY | RTLD_NOLOAD);
    Dl_serinfo head{};
    if (!self || dlinfo(self, RTLD_DI_SERINFOSIZE, &head) != 0) return {};
    // The structure has its array of folders, and their names, behind it.
    const auto memory = std::make_unique<char[]>(head.dls_size);
    auto* const list = reinterpret_cast<Dl_serinfo*>(memory.get());
    list->dls_size = head.dls_size;
    list->dls_cnt = head.dls_cnt;
    std::vector<std::string> folders;
    if (dlinfo(self, RTLD_DI_SERINFO, list) == 0)
        for (const Dl_serpath* folder = list->dls_serpath; folder != list->dls_serpath + list->dls_cnt;
             ++folder)
            folders.emplace_back(folder->dls_name);
    dlclose(self);
    return folders;
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
