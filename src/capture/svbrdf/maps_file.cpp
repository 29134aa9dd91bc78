#include "capture/svbrdf/maps_file.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "capture/svbrdf/svbrdf_model.h"
#include "pbrt/core/check.h"
#include "pbrt/image/image.h"

namespace lacquer::capture {
namespace {

using Decoded = Texel<double>;

std::string In(const std::string& directory, const char* name) {
    return (std::filesystem::path(directory) / name).string();
}

Decoded DecodedAt(const Maps& maps, size_t i) {
    StoredTexel<double> stored;
    for (size_t c = 0; c < kNumChannels; ++c) stored[c] = maps.Channel(c)[i];
    return Decode(stored);
}

/// An image of what `valueOf(texel index, channel)` gives.
template <class Function>
Image ImageOf(int size, const std::vector<std::string>& channels, const Function& valueOf) {
    Image image({size, size}, channels);
    size_t i = 0;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x, ++i)
            for (size_t c = 0; c < channels.size(); ++c) image.Set({x, y}, int(c), float(valueOf(i, c)));
    return image;
}

const std::vector<std::string> kRGB = {"R", "G", "B"};

/// Four images of one size, read and checked.
class MapImages {
  public:
    MapImages(const std::string& directory, const std::array<const char*, 4>& names) {
        for (size_t i = 0; i < 4; ++i) {
            const std::string path = In(directory, names[i]);
            images_[i] = ReadImage(path, {}, {path});
            Check(images_[i], {path}, i == 2 ? 1 : 3);
        }
    }
    int Size() const { return images_[0].Resolution().x; }
    /// A value of the texel of this index.
    double Get(size_t image, size_t texel, size_t channel) const {
        const auto size = size_t(Size());
        return double(images_[image].Get({int(texel % size), int(texel / size)}, int(channel)));
    }

  private:
    void Check(const Image& image, const FileLoc& place, int numChannels) const {
        const Int2 resolution = image.Resolution(), first = images_[0].Resolution();
        if (resolution.x != resolution.y)
            throw SceneError(place, fmt::format("the map has {} x {} texels; expected a square", resolution.x,
                                                resolution.y));
        if (resolution != first)
            throw SceneError(
                place, fmt::format("the map has {0} x {0} texels; expected {1} x {1}, as the albedo has",
                                   resolution.x, first.x));
        if (numChannels == 3 && !image.HasRGB())
            throw SceneError(place, "the map has other channels; expected R, G and B");
        for (int y = 0; y < resolution.y; ++y)
            for (int x = 0; x < resolution.x; ++x)
                for (int c = 0; c < numChannels; ++c)
                    if (const float v = image.Get({x, y}, c); !(v >= 0 && v <= 1))
                        throw SceneError(
                            place,
                            fmt::format("texel {},{} has the value {}; expected one in [0, 1]", x, y, v));
    }
    std::array<Image, 4> images_;
};

/// x and y of a normal that a map has as (n + 1) / 2, whatever its length.
std::array<double, 2> NormalOf(const MapImages& images, size_t i) {
    std::array<double, 3> n;
    for (size_t c = 0; c < 3; ++c) n[c] = 2 * images.Get(1, i, c) - 1;
    const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (!(length > 0)) return {0, 0};
    return {n[0] / length, n[1] / length};
}

void WriteBytes(const Maps& maps, const std::string& path, const auto& valueOf) {
    // Writers of bytes round sRGB values: these are in the middle of what becomes each byte.
    const ColorEncoding srgb{ColorEncoding::Kind::SRGB, 1};
    WriteImage(ImageOf(maps.size, kRGB,
                       [&](size_t i, size_t c) {
                           const double byte = std::floor(255 * ClampTo(valueOf(i, c), 0, 1));
                           return srgb.ToLinear(float(byte / 255));
                       }),
               path);
}

}  // namespace

void WriteLinearMaps(const Maps& maps, const std::string& directory) {
    LACQUER_CHECK(maps.size > 0);
    const auto write = [&](const char* name, const std::vector<std::string>& channels, const auto& valueOf) {
        WriteImage(
            ImageOf(maps.size, channels, [&](size_t i, size_t c) { return valueOf(DecodedAt(maps, i), c); }),
            In(directory, name));
    };
    write("albedo.exr", kRGB, [](const Decoded& t, size_t c) { return t.albedo[c]; });
    write("specular.exr", kRGB, [](const Decoded& t, size_t c) { return t.specular[c]; });
    write("alpha.exr", {"Y"}, [](const Decoded& t, size_t) { return t.alpha; });
    write("normal.exr", kRGB, [](const Decoded& t, size_t c) { return 0.5 * t.normal[c] + 0.5; });
}

Maps ReadLinearMaps(const std::string& directory) {
    const MapImages images(directory, {"albedo.exr", "normal.exr", "alpha.exr", "specular.exr"});
    Maps maps(images.Size());
    for (size_t i = 0; i < maps.NumTexels(); ++i) {
        for (size_t c = 0; c < 3; ++c) {
            maps.Channel(kAlbedo + c)[i] = StoredOf(images.Get(0, i, c));
            maps.Channel(kSpecular + c)[i] = StoredOf(images.Get(3, i, c));
        }
        maps.Channel(kRoughness)[i] = StoredOf(std::sqrt(images.Get(2, i, 0)));
        const auto normal = NormalOf(images, i);
        for (size_t c = 0; c < 2; ++c) maps.Channel(kNormal + c)[i] = normal[c];
    }
    return maps;
}

void WriteEncodedMaps(const Maps& maps, const std::string& directory) {
    LACQUER_CHECK(maps.size > 0);
    const auto stored = [&](size_t first) {
        return [&maps, first](size_t i, size_t c) { return 0.5 * maps.Channel(first + c)[i] + 0.5; };
    };
    WriteBytes(maps, In(directory, "dif.png"), stored(kAlbedo));
    WriteBytes(maps, In(directory, "spe.png"), stored(kSpecular));
    WriteBytes(maps, In(directory, "rgh.png"),
               [&](size_t i, size_t) { return 0.5 * maps.Channel(kRoughness)[i] + 0.5; });
    WriteBytes(maps, In(directory, "nom.png"),
               [&](size_t i, size_t c) { return 0.5 * DecodedAt(maps, i).normal[c] + 0.5; });
}

Maps ReadEncodedMaps(const std::string& directory) {
    const MapImages images(directory, {"dif.png", "nom.png", "rgh.png", "spe.png"});
    Maps maps(images.Size());
    for (size_t i = 0; i < maps.NumTexels(); ++i) {
        for (size_t c = 0; c < 3; ++c) {
            maps.Channel(kAlbedo + c)[i] = 2 * images.Get(0, i, c) - 1;
            maps.Channel(kSpecular + c)[i] = 2 * images.Get(3, i, c) - 1;
        }
        maps.Channel(kRoughness)[i] = 2 * images.Get(2, i, 0) - 1;
        const auto normal = NormalOf(images, i);
        for (size_t c = 0; c < 2; ++c) maps.Channel(kNormal + c)[i] = normal[c];
    }
    return maps;
}

}  // namespace lacquer::capture
