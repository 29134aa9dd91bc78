#include "compare/fingerprint.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include "pbrt/core/params.h"
#include "pbrt/core/rng.h"

namespace lacquer {

namespace {

namespace fs = std::filesystem;

uint64_t HashOfText(uint64_t h, const std::string& text) {
    for (const char c : text) h = Hash(h, c);
    return h;
}

/// Everything between quotes.
std::vector<std::string> QuotedStrings(const std::string& text) {
    std::vector<std::string> strings;
    for (size_t open = text.find('"'); open != std::string::npos;) {
        const size_t close = text.find('"', open + 1);
        if (close == std::string::npos) break;
        strings.push_back(text.substr(open + 1, close - open - 1));
        open = text.find('"', close + 1);
    }
    return strings;
}

class Fingerprint {
  public:
    explicit Fingerprint(const std::string& directory) : files_(directory) {}

    uint64_t OfSceneFile(const std::string& path) {
        uint64_t h = HashOfText(1, path);
        if (!seen_.insert(path).second) return h;
        std::ifstream in(path, std::ios::binary);
        if (!in) return h;
        const std::string text(std::istreambuf_iterator<char>(in), {});
        h = HashOfText(h, text);
        for (const std::string& name : QuotedStrings(text)) {
            const std::string file = files_.Resolve(name);
            std::error_code error;
            if (!fs::is_regular_file(file, error)) continue;
            h = Hash(h, fs::path(file).extension() == ".pbrt" ? OfSceneFile(file) : OfOtherFile(file));
        }
        return h;
    }

  private:
    static uint64_t OfOtherFile(const std::string& path) {
        std::error_code error;
        const auto size = uint64_t(fs::file_size(path, error));
        const auto time = int64_t(fs::last_write_time(path, error).time_since_epoch().count());
        return Hash(HashOfText(2, path), size, time);
    }

    FileResolver files_;
    std::set<std::string> seen_;
};

}  // namespace

uint64_t FingerprintOfScene(const std::vector<std::string>& paths) {
    uint64_t h = 0;
    for (const std::string& path : paths)
        h = Hash(h, Fingerprint(fs::path(path).parent_path().string()).OfSceneFile(path));
    return h;
}

}  // namespace lacquer
