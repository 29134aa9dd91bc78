#include "cmd/sandbox.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/landlock.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>

#include "cmd/choices.h"
#include "pbrt/core/error.h"
#include "pbrt/core/loaded_module.h"

namespace lacquer::cmd {
namespace {

namespace fs = std::filesystem;

// Rights that later kernels have added are not in the headers of earlier ones.
constexpr uint64_t kRefer = 1 << 13, kTruncate = 1 << 14;
constexpr uint64_t kOfFiles =
    LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_EXECUTE | kTruncate;
constexpr uint64_t kReading = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR;
constexpr uint64_t kWriting = kReading | LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_REMOVE_DIR |
                              LANDLOCK_ACCESS_FS_REMOVE_FILE | LANDLOCK_ACCESS_FS_MAKE_DIR |
                              LANDLOCK_ACCESS_FS_MAKE_REG | kTruncate;
/// All that the first version of Landlock knows.
constexpr uint64_t kFirstVersion = (1 << 13) - 1;

/// What libraries read after the start: others of them, what processors and memory are, the time zone.
constexpr const char* kSystem[] = {
    "/usr",         "/lib",          "/lib64",       "/etc/ld.so.cache",        "/etc/localtime",
    "/dev/urandom", "/proc/meminfo", "/proc/sys/vm", "/sys/devices/system/cpu", "/sys/kernel/mm"};

[[noreturn]] void Refuse(const char* what) {
    throw FileError("--sandbox", fmt::format("{}: {}; it needs Linux 5.13 or later, with Landlock", what,
                                             std::strerror(errno)));
}

/// The rights over files that a sandbox takes away, of those that the kernel knows.
uint64_t HandledRights() {
    const long version = syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
    if (version < 1) Refuse("this system cannot confine a program");
    return kFirstVersion | (version >= 2 ? kRefer : 0) | (version >= 3 ? kTruncate : 0);
}

/// A set of rules, which is an open file.
class Rules {
  public:
    Rules() : handled_(HandledRights()) {
        const landlock_ruleset_attr attributes = {.handled_access_fs = handled_};
        rules_ = int(syscall(SYS_landlock_create_ruleset, &attributes, sizeof attributes, 0));
        if (rules_ < 0) Refuse("this system cannot confine a program");
    }
    Rules(const Rules&) = delete;
    Rules& operator=(const Rules&) = delete;
    ~Rules() { close(rules_); }

    void Allow(const std::string& path, uint64_t rights) {
        const int file = open(path.c_str(), O_PATH | O_CLOEXEC);
        if (file < 0) return;
        struct stat status;
        if (fstat(file, &status) == 0 && !S_ISDIR(status.st_mode)) rights &= kOfFiles;
        const landlock_path_beneath_attr rule = {.allowed_access = rights & handled_, .parent_fd = file};
        const long result = syscall(SYS_landlock_add_rule, rules_, LANDLOCK_RULE_PATH_BENEATH, &rule, 0);
        close(file);
        if (result != 0) Refuse(("cannot allow " + path).c_str());
    }
    void Enter() {
        if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 ||
            syscall(SYS_landlock_restrict_self, rules_, 0) != 0)
            Refuse("this program cannot be confined");
    }

  private:
    uint64_t handled_;
    int rules_;
};

}  // namespace

void AddSandboxOptions(CLI::App& app, SandboxOptions& options) {
    CLI::Option* flag = app.add_flag("--sandbox", options.isOn,
                                     "For scenes of strangers: reads nothing outside of their folders, and "
                                     "writes nothing outside of those of "
                                     "the outputs that the command line names");
    app.add_option("--sandbox-read", options.read, "Folder that may be read as well; may be repeated")
        ->type_name(kFolder)
        ->needs(flag)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

void EnterSandbox(const AllowedPaths& allowed) {
    Rules rules;
    for (const char* path : kSystem) rules.Allow(path, kReading);
    rules.Allow("/dev/null", kWriting);
    for (const std::string& folder : ModuleFolders())
        if (fs::path(folder).is_absolute()) rules.Allow(folder, kReading);
    for (const std::string& path : allowed.read) rules.Allow(path, kReading);
    for (const std::string& path : allowed.write) rules.Allow(path, kWriting);
    rules.Enter();
}

std::string FolderOfFile(const std::string& path) {
    if (path.empty()) return {};
    const std::string folder = fs::path(path).parent_path().string();
    return folder.empty() ? "." : folder;
}

std::vector<std::string> FoldersOfScenes(const std::vector<std::string>& scenes) {
    std::vector<std::string> folders;
    for (const std::string& scene : scenes) folders.push_back(scene == "-" ? "." : FolderOfFile(scene));
    if (scenes.empty()) folders.emplace_back(".");
    return folders;
}

}  // namespace lacquer::cmd
