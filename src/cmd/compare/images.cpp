#include "cmd/compare/images.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "compare/color_map.h"

namespace lacquer::cmd {

namespace {

/// Crops of fewer pixels a side than this are enlarged.
constexpr int kSmallCrop = 200;
/// Errors above this part of all are as bright as they get.
constexpr double kBrightestError = 0.99;

/// A part of `image`, each pixel a square of `scale` x `scale`.
Image Crop(const Image& image, const Bounds2i& pixels, int scale) {
    Image crop(Int2(pixels.Width(), pixels.Height()) * scale, {"R", "G", "B"});
    crop.SetColorSpace(image.ColorSpace());
    for (int y = 0; y < crop.Resolution().y; ++y)
        for (int x = 0; x < crop.Resolution().x; ++x)
            for (int c = 0; c < 3; ++c) crop.Set({x, y}, c, image.Get(pixels.min + Int2(x, y) / scale, c));
    return crop;
}

std::vector<float> RootMeanSquares(const compare::CandidateResult& result,
                                   const compare::Reference& reference) {
    std::vector<float> errors;
    for (const Image& image : result.images) {
        const std::vector<float> squares = compare::SquaredErrors(image, reference.image);
        errors.resize(squares.size(), 0.f);
        for (size_t i = 0; i < squares.size(); ++i) errors[i] += squares[i] / float(result.images.size());
    }
    for (float& e : errors) e = std::sqrt(e);
    return errors;
}

/// Those of a box of an image that is `width` wide.
std::vector<float> Inside(const std::vector<float>& values, int width, const Bounds2i& pixels) {
    std::vector<float> inside;
    for (int y = pixels.min.y; y < pixels.max.y; ++y)
        for (int x = pixels.min.x; x < pixels.max.x; ++x)
            inside.push_back(values[size_t(y) * size_t(width) + size_t(x)]);
    return inside;
}

float BrightestError(std::vector<float> errors) {
    const auto at = errors.begin() + ptrdiff_t(kBrightestError * double(errors.size() - 1));
    std::nth_element(errors.begin(), at, errors.end());
    return *at;
}

}  // namespace

std::string FileWord(std::string name) {
    for (char& c : name)
        if (!std::isalnum((unsigned char)c) && c != '-' && c != '_' && c != '.') c = '-';
    return name;
}

Image ErrorMapOf(const compare::CandidateResult& result, const compare::Reference& reference) {
    const Image& like = result.images[0];
    Image map(like.Resolution(), {"Y"});
    map.dataWindow = like.dataWindow;
    map.fullResolution = like.fullResolution;
    map.Pixels() = RootMeanSquares(result, reference);
    return map;
}

Image ColoursOnly(const Image& image) { return image.Part({{0, 0}, image.Resolution()}, {0, 1, 2}); }

std::vector<std::string> WriteCrops(const CompareVariant& variant, const std::vector<compare::Box>& boxes,
                                    Int2 origin, const std::string& folder) {
    std::vector<std::string> names;
    const auto write = [&](const Image& image, const std::string& name) {
        WriteImage(image, folder + "/" + name);
        names.push_back(name);
    };
    const int width = variant.reference.image.Resolution().x;
    for (const compare::Box& box : boxes) {
        const Bounds2i pixels{box.pixels.min - origin, box.pixels.max - origin};
        const int scale = std::max(1, kSmallCrop / std::min(pixels.Width(), pixels.Height()));
        const std::string start = fmt::format("{}{}-", variant.filePrefix, FileWord(box.name));
        write(Crop(variant.reference.image, pixels, scale), start + "reference.png");
        std::vector<std::vector<float>> errors;
        float largest = 0;
        for (const compare::CandidateResult& result : variant.results) {
            errors.push_back(Inside(RootMeanSquares(result, variant.reference), width, pixels));
            largest = std::max(largest, BrightestError(errors.back()));
        }
        for (size_t i = 0; i < errors.size(); ++i) {
            const std::string label = FileWord(variant.results[i].candidate.Label());
            write(Crop(variant.results[i].images[0], pixels, scale), start + label + ".png");
            const Image map = compare::ColoredErrors(errors[i], {pixels.Width(), pixels.Height()}, largest);
            write(Crop(map, {{0, 0}, map.Resolution()}, scale), start + label + "-error.png");
        }
    }
    return names;
}

}  // namespace lacquer::cmd
