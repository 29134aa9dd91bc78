#include "cmd/materialgan/map_files.h"

#include <fmt/format.h>

#include <filesystem>

#include "capture/svbrdf/maps_file.h"
#include "cmd/command_support.h"
#include "materialgan/generator_config.h"
#include "pbrt/image/image.h"

namespace lacquer::cmd {
namespace {

struct MapImage {
    const char* name;
    size_t first, numChannels;  ///< of the maps
};
constexpr MapImage kMapImages[] = {{"dif.png", capture::kAlbedo, 3},
                                   {"nom.png", capture::kNormal, 2},
                                   {"rgh.png", capture::kRoughness, 1},
                                   {"spe.png", capture::kSpecular, 3}};

std::string PathIn(const std::string& folder, const char* name) {
    return (std::filesystem::path(folder) / name).string();
}

/// Errors: FileError for an image that is no square map, or lacks channels. One grey is a colour, too.
void CheckMapImage(const MapImage& part, const Image& image, const std::string& path) {
    const Int2 size = image.Resolution();
    if (size.x != size.y)
        throw FileError(path, fmt::format("has {} x {} pixels, and squares are needed", size.x, size.y));
    if (size.x > materialgan::GeneratorConfig::kMaxResolution)
        throw FileError(path, fmt::format("has {} x {} pixels, and generators make up to {} x {}", size.x,
                                          size.y, materialgan::GeneratorConfig::kMaxResolution,
                                          materialgan::GeneratorConfig::kMaxResolution));
    const bool isGrey = image.NumChannels() == 1 && part.first != capture::kNormal;
    if (!isGrey && image.NumChannels() < 3)
        throw FileError(path, fmt::format("has {} channels, and 3 are needed", image.NumChannels()));
    if (image.HasNonFinite()) throw FileError(path, "has values that are not finite");
}

}  // namespace

capture::Maps ReadMapImages(const std::string& folder) {
    capture::Maps maps;
    for (const MapImage& part : kMapImages) {
        const std::string path = PathIn(folder, part.name);
        const Image image = ReadImage(path, {}, {});
        CheckMapImage(part, image, path);
        const Int2 size = image.Resolution();
        if (maps.size == 0) maps = capture::Maps(size.x);
        if (size.x != maps.size)
            throw FileError(path, fmt::format("has {} x {} pixels, and {} has {} x {}", size.x, size.y,
                                              kMapImages[0].name, maps.size, maps.size));
        for (size_t c = 0; c < part.numChannels; ++c)
            for (size_t i = 0; i < maps.NumTexels(); ++i) {
                const int channel = std::min(int(c), image.NumChannels() - 1);
                const Int2 p{int(i) % size.x, int(i) / size.x};
                maps.Channel(part.first + c)[i] = 2 * double(image.Get(p, channel)) - 1;
            }
    }
    return maps;
}

void WriteMapImages(const capture::Maps& maps, const std::string& folder) {
    MakeOutputFolder(folder);
    capture::WriteEncodedMaps(maps, folder);
}

}  // namespace lacquer::cmd
