// What a scene of a stranger may touch: --sandbox.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace lacquer::cmd {

/// The options of commands on scenes.
struct SandboxOptions {
    bool isOn = false;
    std::vector<std::string> read;  ///< more folders and files that may be read
};
void AddSandboxOptions(CLI::App& app, SandboxOptions& options);

/// Files and folders, with all that is below. What is not there is left out.
struct AllowedPaths {
    std::vector<std::string> read, write;
};
/// From now on this thread, and those that it starts, open nothing but what is named, and what programs and
/// their libraries need of the system (/usr, /lib, a few devices). Cannot be undone.
/// Errors: FileError where the system cannot do so: Linux before 5.13, or one without Landlock.
void EnterSandbox(const AllowedPaths& allowed);

/// Folders of scene files, which what they name is looked up in.
std::vector<std::string> FoldersOfScenes(const std::vector<std::string>& scenes);
/// "." for a name without a folder, empty for no name.
std::string FolderOfFile(const std::string& path);

}  // namespace lacquer::cmd
