#include "compare/reference.h"

#include <fmt/format.h>

#include "pbrt/core/check.h"

namespace lacquer {

const std::vector<std::string>& NoiseChannels() {
    static const std::vector<std::string> names{"MeanVariance.R", "MeanVariance.G", "MeanVariance.B",
                                                "MeanVariance.Y"};
    return names;
}

bool Reference::NoiseIsKnown() const { return image.FindChannel(NoiseChannels()[0]) >= 0; }

namespace {

/// Mean and sum of squared deviations [Welford 1962].
struct Spread {
    double mean = 0, m2 = 0;
    int count = 0;
    void Add(double x) {
        const double delta = x - mean;
        mean += delta / ++count;
        m2 += delta * (x - mean);
    }
    double VarianceOfMean() const { return m2 / (count - 1.0) / count; }
};

}  // namespace

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
    const ColorSpace& space = first.ColorSpace() ? *first.ColorSpace() : ColorSpace::SRGB();
    for (int y = 0; y < first.Resolution().y; ++y)
        for (int x = 0; x < first.Resolution().x; ++x) {
            Spread spread[4];
            for (const Image& part : parts) {
                const RGB rgb(part.Get({x, y}, 0), part.Get({x, y}, 1), part.Get({x, y}, 2));
                for (int c = 0; c < 3; ++c) spread[c].Add(double(rgb[c]));
                spread[3].Add(double(space.Luminance(rgb)));
            }
            for (int c = 0; c < 3; ++c) reference.image.Set({x, y}, c, float(spread[c].mean));
            for (int c = 0; c < 4; ++c) reference.image.Set({x, y}, 3 + c, float(spread[c].VarianceOfMean()));
        }
    return reference;
}

Reference ReadReference(const std::string& path, const Image& like) {
    const Image file = ReadImage(path, {ColorEncoding::Kind::SRGB, 1}, {});
    const Int2 size = like.Resolution();
    const bool isFullFrame = file.Resolution() == like.fullResolution;
    if (!file.HasRGB() || (!isFullFrame && file.Resolution() != size))
        throw FileError(
            path, fmt::format("is {} x {} pixels with {} channels; a reference for this scene has R, G "
                              "and B in {} x {} pixels",
                              file.Resolution().x, file.Resolution().y, file.NumChannels(), size.x, size.y));
    if (file.HasNonFinite())
        throw FileError(path, "has pixels that are NaN or infinite; a reference has none");
    Reference reference;
    std::vector<std::string> channels{"R", "G", "B"};
    std::vector<int> sources{0, 1, 2};
    for (const std::string& name : NoiseChannels())
        if (file.FindChannel(name) >= 0) {
            channels.push_back(name);
            sources.push_back(file.FindChannel(name));
        }
    reference.image = Image(size, channels);
    reference.image.dataWindow = like.dataWindow;
    reference.image.fullResolution = like.fullResolution;
    reference.image.SetColorSpace(file.ColorSpace());
    reference.image.metadata = file.metadata;
    const Int2 offset = file.Resolution() == size ? Int2(0) : like.dataWindow.min;
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x)
            for (size_t c = 0; c < sources.size(); ++c)
                reference.image.Set({x, y}, int(c), file.Get(Int2(x, y) + offset, sources[c]));
    return reference;
}

}  // namespace lacquer
