#include "pbrt/core/file_name.h"

#include <mutex>
#include <unordered_set>

namespace lacquer {

namespace {

/// Never destroyed, for errors may outlive whatever else is static.
class Names {
  public:
    const std::string& Keep(std::string_view name) {
        const std::lock_guard lock(mutex_);
        return *names_.emplace(name).first;  // nodes of a set stay where they are
    }

  private:
    std::mutex mutex_;
    std::unordered_set<std::string> names_;
};

}  // namespace

const std::string* FileName::Empty() {
    static const std::string& empty = *new std::string;
    return &empty;
}

FileName::FileName(std::string_view name) {
    static Names& names = *new Names;
    if (!name.empty()) name_ = &names.Keep(name);
}

}  // namespace lacquer
