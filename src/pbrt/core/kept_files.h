// What is made from files, each time once, and kept from one scene to the next.
#pragma once

#include <sys/stat.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace lacquer {

/// Tells versions of a file apart.
struct FileStamp {
    uint64_t device = 0, number = 0;
    int64_t bytes = -1, modified = 0;  ///< [ns]
    bool operator==(const FileStamp&) const = default;

    /// All the same for files that are not there.
    static FileStamp Of(const std::string& path) {
        struct stat s;
        if (stat(path.c_str(), &s) != 0) return {};
        return {uint64_t(s.st_dev), uint64_t(s.st_ino), int64_t(s.st_size),
                int64_t(s.st_mtim.tv_sec) * 1000000000 + s.st_mtim.tv_nsec};
    }
};

/// Values by keys. Within a scene a file is read once, whatever happens to it; the next scene reads it again
/// only if it has changed. Thread-safe; different values are made in parallel.
template <class Key, class Value>
class KeptFiles {
  public:
    /// @param forget  hears of every value that is not kept any longer
    explicit KeptFiles(std::function<void(const Value&)> forget = {}) : forget_(std::move(forget)) {}

    /// The value of `key`, made from the file at `path` by `make` if need be. What `make` throws passes
    /// through; the next call tries again.
    template <class Make>
    std::shared_ptr<const Value> Get(const Key& key, const std::string& path, const Make& make) {
        std::shared_ptr<Entry> entry;
        {
            const std::lock_guard lock(mutex_);
            std::shared_ptr<Entry>& slot = entries_[key];
            if (!slot) slot = std::make_shared<Entry>();
            entry = slot;
        }
        const std::lock_guard lock(entry->mutex);
        if (entry->value && entry->scene != scene_ && entry->stamp != FileStamp::Of(path))
            Forget(entry.get());
        if (!entry->value) {
            entry->stamp = FileStamp::Of(path);
            entry->value = std::make_shared<const Value>(make());
        }
        entry->scene = scene_;
        return entry->value;
    }

    /// Not while values are asked for.
    void BeginScene() { ++scene_; }
    /// Forgets what this scene has not asked for.
    void DropUnused() {
        std::erase_if(entries_, [&](const auto& item) {
            Entry& entry = *item.second;
            if (entry.scene == scene_) return false;
            Forget(&entry);
            return true;
        });
    }

  private:
    struct Entry {
        std::mutex mutex;
        std::shared_ptr<const Value> value;
        FileStamp stamp;
        int64_t scene = -1;  ///< the last one that has asked for it
    };
    void Forget(Entry* entry) {
        if (entry->value && forget_) forget_(*entry->value);
        entry->value.reset();
    }

    std::function<void(const Value&)> forget_;
    std::mutex mutex_;
    std::map<Key, std::shared_ptr<Entry>> entries_;
    int64_t scene_ = 0;
};

}  // namespace lacquer
