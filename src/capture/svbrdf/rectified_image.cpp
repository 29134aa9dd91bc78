#include "capture/svbrdf/rectified_image.h"

#include "capture/svbrdf/svbrdf_model.h"
#include "pbrt/core/check.h"
#include "pbrt/core/parallel.h"

namespace lacquer::capture {

RectifiedImage::RectifiedImage(int n) : size(n) {
    LACQUER_CHECK(n > 0);
    values.resize(3 * NumPixels());
}

RectifiedImage RenderView(const Maps& maps, const ViewSet& views, const View& view) {
    RectifiedImage image(maps.size);
    const auto size = size_t(maps.size);
    ParallelFor(maps.size, [&](int64_t row) {
        const double y = TexelY(int(row), maps.size, views.size);
        for (size_t column = 0; column < size; ++column) {
            const size_t at = size_t(row) * size + column;
            StoredTexel<double> stored;
            for (size_t c = 0; c < kNumChannels; ++c) stored[c] = maps.Channel(c)[at];
            const double x = TexelX(int(column), maps.size, views.size);
            const auto value =
                EncodedValue(stored, GeometryAt(x, y, view.camera, view.light), views.lightPower);
            for (size_t c = 0; c < 3; ++c) image.Channel(c)[at] = value[c];
        }
    });
    return image;
}

double Rmse(const RectifiedImage& a, const RectifiedImage& b) {
    LACQUER_CHECK(a.values.size() == b.values.size() && !a.values.empty());
    double sum = 0;
    for (size_t i = 0; i < a.values.size(); ++i)
        sum += (a.values[i] - b.values[i]) * (a.values[i] - b.values[i]);
    return std::sqrt(sum / double(a.values.size()));
}

RectifiedImage Halved(const RectifiedImage& image) {
    LACQUER_CHECK(image.size % 2 == 0);
    RectifiedImage half(image.size / 2);
    const auto size = size_t(half.size), fine = size_t(image.size);
    for (size_t c = 0; c < 3; ++c)
        for (size_t row = 0; row < size; ++row)
            for (size_t column = 0; column < size; ++column) {
                double sum = 0;
                for (const size_t at : {2 * row * fine + 2 * column, (2 * row + 1) * fine + 2 * column})
                    for (size_t i = 0; i < 2; ++i) sum += std::pow(image.Channel(c)[at + i], kModelGamma);
                half.Channel(c)[row * size + column] = std::pow(sum / 4, 1 / kModelGamma);
            }
    return half;
}

std::vector<RectifiedImage> Halved(std::span<const RectifiedImage> images) {
    std::vector<RectifiedImage> halves;
    halves.reserve(images.size());
    for (const RectifiedImage& image : images) halves.push_back(Halved(image));
    return halves;
}

}  // namespace lacquer::capture
