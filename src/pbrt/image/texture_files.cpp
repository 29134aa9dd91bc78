#include "pbrt/image/texture_files.h"

#include <sys/stat.h>

#include <algorithm>
#include <cstring>
#include <filesystem>

#include <fmt/format.h>

#include "pbrt/core/progress.h"
#include "pbrt/image/image_cache.h"
#include "pbrt/image/image_file.h"
#include "pbrt/image/texture_source.h"

namespace lacquer {

namespace {

namespace fs = std::filesystem;

/// A larger part of the memory than this is no array: it would keep many small images from being one.
constexpr size_t kLargestShare = 8;

/// FNV-1a, the same on all machines.
uint64_t HashText(const std::string& text) {
    uint64_t hash = 0xcbf29ce484222325;
    for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
    return hash;
}

int64_t Nanoseconds(const timespec& time) { return int64_t(time.tv_sec) * 1000000000 + time.tv_nsec; }

const char* NameOf(WrapMode wrap) {
    switch (wrap) {
        case WrapMode::Repeat:
            return "repeat";
        case WrapMode::Clamp:
            return "clamp";
        case WrapMode::Black:
            return "black";
        case WrapMode::OctahedralSphere:
            break;
    }
    return "octahedralsphere";
}

std::string NameOf(ColorEncoding encoding) {
    if (encoding.kind == ColorEncoding::Kind::Gamma) return fmt::format("gamma {}", encoding.gamma);
    return encoding.kind == ColorEncoding::Kind::SRGB ? "sRGB" : "linear";
}

/// Why nothing can be written into `folder`, which is made if need be; empty if it can.
std::string WhyNotWritable(const std::string& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) return error.message();
    if (!fs::is_directory(folder, error)) return "it is no folder";
    return access(folder.c_str(), W_OK | X_OK) == 0 ? "" : std::strerror(errno);
}

/// Tells of the rows that are read; two times all of them.
class Progress {
  public:
    Progress(Observer* observer, const std::string& path, int rows) : observer_(observer) {
        if (observer_)
            observer_->Begin(fmt::format("Preparing {}", fs::path(path).filename().string()), 2 * rows, "");
    }
    ~Progress() {
        if (observer_) observer_->End();
    }
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;
    void Advance() {
        if (observer_) observer_->Advance(1);
    }

  private:
    Observer* observer_;
};

}  // namespace

TextureFiles::TextureFiles(const TextureMemory& memory, Observer* observer)
    : memory_(memory), observer_(observer) {
    tiles_.SetLimit(memory_.bytes);
}

TextureFiles::~TextureFiles() {
    std::error_code ignored;
    if (isTemporary_) fs::remove_all(folder_, ignored);
}

std::optional<TextureFiles::Origin> TextureFiles::OriginOf(const TextureImage& image) {
    struct stat status;
    if (stat(image.path.c_str(), &status) != 0) return std::nullopt;
    std::error_code error;
    const fs::path absolute = fs::canonical(image.path, error);
    if (error) return std::nullopt;
    const std::string use =
        fmt::format("{}; {}; {}", absolute.string(), NameOf(image.encoding), NameOf(image.wrap));
    // A version of the file's contents, one for each way in which the pyramids of this program change.
    constexpr int kVersion = 2;
    return Origin{image, fmt::format("{}-{:016x}.tx", absolute.stem().string().substr(0, 100), HashText(use)),
                  fmt::format("Lacquer texture {}; {} bytes; {} {}; {}", kVersion, int64_t(status.st_size),
                              Nanoseconds(status.st_mtim), Nanoseconds(status.st_ctim), use)};
}

bool TextureFiles::Reserve(size_t bytes) {
    const std::lock_guard lock(mutex_);
    if (bytes > memory_.bytes / kLargestShare || resident_ + bytes > memory_.bytes / 4 * 3) return false;
    resident_ += bytes;
    tiles_.SetLimit(memory_.bytes - resident_);
    return true;
}

void TextureFiles::Release(size_t bytes) {
    const std::lock_guard lock(mutex_);
    resident_ -= bytes;
    tiles_.SetLimit(memory_.bytes - resident_);
}

MipMap TextureFiles::Load(const TextureImage& image, const FileLoc& loc, Observer* progress) {
    const std::optional<Origin> origin = UsesDisk() ? OriginOf(image) : std::nullopt;
    std::unique_ptr<TiledImage> tiles = origin ? Find(*origin) : nullptr;
    const lacquer::ColorSpace* space = nullptr;
    ColorEncoding stored;
    int rows = 0;
    {
        // Small images, and all where no disk is used, become arrays. Only the header tells what is small.
        ImageFile file(image.path, image.encoding, loc, tiles != nullptr);
        const ImageHeader& header = file.Header();
        const int channels = std::min(4, int(header.channels.size()));
        const size_t bytes = PyramidBytes(header.resolution, {header.format, header.encoding, channels});
        if (!origin || Reserve(bytes)) {
            MipMap map = MipMap::Make(file.Read(), image.wrap, image.path, loc);
            if (origin) Release(bytes - map.Bytes());
            return map;
        }
        space = header.colorSpace;
        stored = header.encoding;
        rows = header.resolution.y;
    }
    if (!tiles) tiles = Convert(*origin, rows, loc, progress);
    return MipMap::OnDisk(std::move(tiles), stored, image.wrap, *space);
}

void TextureFiles::Forget(const MipMap& map) {
    if (UsesDisk()) Release(map.Bytes());  // 0 for those on disk
}

const std::string& TextureFiles::Folder() {
    const std::lock_guard lock(mutex_);
    if (!folder_.empty()) return folder_;
    if (!memory_.cacheFolder.empty()) {
        const std::string problem = WhyNotWritable(memory_.cacheFolder);
        if (problem.empty()) return folder_ = memory_.cacheFolder;
        if (memory_.temporaryFolder.empty())
            throw FileError(memory_.cacheFolder,
                            fmt::format("cannot be used as folder of prepared textures: {}", problem));
        if (observer_)
            observer_->Warn(
                fmt::format("prepared textures cannot be kept in {}: {}; they are prepared anew "
                            "for this render only",
                            memory_.cacheFolder, problem));
    }
    MakeTemporaryFolder();
    return folder_;
}

void TextureFiles::MakeTemporaryFolder() {
    std::string name = (fs::path(memory_.temporaryFolder) / "lacquer-textures-XXXXXX").string();
    if (!mkdtemp(name.data()))
        throw FileError(
            memory_.temporaryFolder,
            fmt::format("no folder for prepared textures can be made here: {}", std::strerror(errno)));
    folder_ = name;
    isTemporary_ = true;
}

std::unique_ptr<TiledImage> TextureFiles::Find(const Origin& origin) {
    // A folder that can be read but not written may hold it as well.
    std::string known;
    {
        const std::lock_guard lock(mutex_);
        known = folder_;
    }
    for (const std::string& folder : {memory_.cacheFolder, known}) {
        if (folder.empty()) continue;
        if (auto tiles = tiles_.Open((fs::path(folder) / origin.name).string(), origin.description))
            return tiles;
    }
    return nullptr;
}

std::unique_ptr<TiledImage> TextureFiles::Convert(const Origin& origin, int rows, const FileLoc& loc,
                                                  Observer* observer) {
    const TextureImage& image = origin.image;
    const fs::path folder = Folder(), target = folder / origin.name;
    Progress progress(observer, image.path, rows);
    FileSource source(image.path, image.encoding, loc, [&] { progress.Advance(); });
    const ImageHeader& header = source.Header();
    const TexelFormat format{header.format, header.encoding, source.NumChannels()};
    const TiledLayout layout(header.resolution, format, origin.description);
    try {
        WriteTiledFile(target.string(), layout, source, image.wrap);
    } catch (const FileError& e) {
        if (e.Path() == image.path) throw;
        throw FileError(
            folder.string(),
            fmt::format("the texture {} needs {} MiB here: {}. A render can be given another folder "
                        "with --texture-cache, or more memory with --texture-memory",
                        image.path, (layout.FileBytes() >> 20) + 1, e.Problem()),
            loc);
    }
    const std::optional<Origin> after = OriginOf(image);
    if (!after || after->description != origin.description)
        throw SceneError(loc, fmt::format("{}: the image changed while it was read", image.path));
    auto tiles = tiles_.Open(target.string(), origin.description);
    if (!tiles) throw FileError(target.string(), "cannot be read after it was written", loc);
    return tiles;
}

void TextureFiles::CheckTiles() const {
    if (!tiles_.HasFailed()) return;
    const std::string failure = tiles_.Failure();
    const size_t colon = failure.find(": ");
    throw FileError(failure.substr(0, colon), failure.substr(colon + 2) +
                                                  " (it is made from an image of the scene; the next render "
                                                  "makes it anew)");
}

}  // namespace lacquer
