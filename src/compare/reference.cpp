#include "compare/reference.h"

#include <fmt/format.h>

#include <algorithm>

#include "compare/running_variance.h"
#include "pbrt/core/check.h"

namespace lacquer::compare {

const std::vector<std::string>& NoiseChannels() {
    static const std::vector<std::string> names{"MeanVariance.R", "MeanVariance.G", "MeanVariance.B",
                                                "MeanVariance.Y"};
    return names;
}

bool Reference::NoiseIsKnown() const {
    return std::all_of(NoiseChannels().begin(), NoiseChannels().end(),
                       [&](const std::string& name) { return image.FindChannel(name) >= 0; });
}

Reference ReferenceOfParts(const std::vector<Image>& parts) {
    LACQUER_CHECK(parts.size() >= 2);
    const Image& first = parts[0];
    std::vector<std::string> channels{"R", "G", "B"};
    channels.insert(channels.end(), NoiseChannels().begin(), NoiseChannels().end());
    Reference reference;
    reference.image = Image(first.Resolution(), channels);
    reference.image.dataWindow = first.dataWindow;
    reference.image.fullResolution = first.fullResolution;
    reference.image.SetColorSpace(first.ColorSpace());
    const ColorSpace& space = first.ColorSpaceOrSRGB();
    for (int y = 0; y < first.Resolution().y; ++y)
        for (int x = 0; x < first.Resolution().x; ++x) {
            RunningVariance spread[4];
            for (const Image& part : parts) {
                const RGB rgb(part.Get({x, y}, 0), part.Get({x, y}, 1), part.Get({x, y}, 2));
                for (int c = 0; c < 3; ++c) spread[c].Add(double(rgb[c]));
                spread[3].Add(double(space.Luminance(rgb)));
            }
            for (int c = 0; c < 3; ++c) reference.image.Set({x, y}, c, float(spread[c].Mean()));
            for (int c = 0; c < 4; ++c) reference.image.Set({x, y}, 3 + c, float(spread[c].VarianceOfMean()));
        }
    return reference;
}

namespace {

void CheckPlace(const std::string& path, const Image& file, const Image& like) {
    const Int2 size = like.Resolution();
    const bool isFullFrame = file.Resolution() == like.fullResolution;
    if (!file.HasRGB() || (!isFullFrame && file.Resolution() != size))
        throw FileError(
            path, fmt::format("is {} x {} pixels with {} channels; a reference for this scene has "
                              "R, G and B in {} x {} pixels",
                              file.Resolution().x, file.Resolution().y, file.NumChannels(), size.x, size.y));
    const Int2 place = file.dataWindow.min;
    if (!isFullFrame && !file.dataWindow.IsEmpty() && place != like.dataWindow.min)
        throw FileError(
            path, fmt::format("begins at x {}, y {} of its frame; the scene's pixels begin at x {}, y {}",
                              place.x, place.y, like.dataWindow.min.x, like.dataWindow.min.y));
}

/// The same colours in another space.
void ConvertColors(Image* image, const ColorSpace& to) {
    const ColorSpace& from = image->ColorSpaceOrSRGB();
    for (int y = 0; y < image->Resolution().y; ++y)
        for (int x = 0; x < image->Resolution().x; ++x) {
            const Int2 p(x, y);
            const RGB rgb = to.ToRGB(from.ToXYZ({image->Get(p, 0), image->Get(p, 1), image->Get(p, 2)}));
            for (int c = 0; c < 3; ++c) image->Set(p, c, rgb[c]);
        }
    image->SetColorSpace(&to);
}

}  // namespace

Reference ReadReference(const std::string& path, const Image& like) {
    const Image file = ReadImage(path, {ColorEncoding::Kind::SRGB, 1}, {});
    CheckPlace(path, file, like);
    const bool changesColors =
        file.ColorSpace() && like.ColorSpace() && file.ColorSpace() != like.ColorSpace();
    std::vector<int> channels{0, 1, 2};
    for (const std::string& name : NoiseChannels())
        if (file.FindChannel(name) >= 0 && !changesColors) channels.push_back(file.FindChannel(name));
    const Int2 size = like.Resolution(), offset = file.Resolution() == size ? Int2(0) : like.dataWindow.min;
    Reference reference;
    reference.image = file.Part({offset, offset + size}, channels);
    reference.image.dataWindow = like.dataWindow;
    reference.image.fullResolution = like.fullResolution;
    if (reference.image.HasNonFinite())
        throw FileError(path, "has pixels that are NaN or infinite; a reference has none");
    if (changesColors) ConvertColors(&reference.image, *like.ColorSpace());
    return reference;
}

}  // namespace lacquer::compare
