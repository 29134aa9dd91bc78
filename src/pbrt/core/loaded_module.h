// Parts of the program that are shared objects of their own, loaded when they are needed.
#pragma once

#include <string>
#include <vector>

namespace lacquer {

/// The function of a module, which is loaded by the first call and stays. By its name alone, since the run
/// path of the program, or of Python's module, has the folder (cmake/Install.cmake). Errors: FileError about
/// the module with the folders searched and the linker's reason.
/// @param module    "liblacquer_NAME.so"
/// @param function  that it exports
/// @param purpose   what it does, for the message: "which reads images"
void* FunctionOfModule(const std::string& module, const std::string& function, const std::string& purpose);

/// Throws what FunctionOfModule() does. @param problem  why the module is of no use
[[noreturn]] void RefuseModule(const std::string& module, const std::string& purpose,
                               const std::string& problem);

/// Where the dynamic linker looks for modules: for what this program, or the shared object with this code,
/// loads by its name.
std::vector<std::string> ModuleFolders();

}  // namespace lacquer
