#include "pbrt/core/loaded_module.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <link.h>

#include <memory>

#include "pbrt/core/error.h"

namespace lacquer {
namespace {

/// Its address tells the dynamic linker which program or shared object this code is part of.
constexpr char kHere = 0;

}  // namespace

void RefuseModule(const std::string& module, const std::string& purpose, const std::string& problem) {
    throw FileError(module, fmt::format("this part of Lacquer, {}, cannot be loaded: {} (searched: {})",
                                        purpose, problem, fmt::join(ModuleFolders(), ", ")));
}

void* FunctionOfModule(const std::string& module, const std::string& function, const std::string& purpose) {
    void* const handle = dlopen(module.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!handle) RefuseModule(module, purpose, dlerror());
    void* const found = dlsym(handle, function.c_str());
    if (!found) RefuseModule(module, purpose, dlerror());
    return found;
}

std::vector<std::string> ModuleFolders() {
    Dl_info info;
    link_map* map = nullptr;
    if (dladdr1(&kHere, &info, reinterpret_cast<void**>(&map), RTLD_DL_LINKMAP) == 0 || !map) return {};
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

}  // namespace lacquer
