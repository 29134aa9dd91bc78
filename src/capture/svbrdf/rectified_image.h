// Photographs on the grid of the maps, and what the model shows there.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "capture/maps.h"
#include "capture/views.h"

namespace lacquer::capture {

/// A square of encoded values in [0,1], each channel (red, green, blue) together; rows from the top. A value
/// is a linear one to the power of 1/2.2, however the photograph was encoded.
struct RectifiedImage {
    int size = 0;
    std::vector<double> values;

    RectifiedImage() = default;
    /// @param n  above 0
    explicit RectifiedImage(int n);
    size_t NumPixels() const { return size_t(size) * size_t(size); }
    std::span<double> Channel(size_t c) { return std::span(values).subspan(c * NumPixels(), NumPixels()); }
    std::span<const double> Channel(size_t c) const {
        return std::span(values).subspan(c * NumPixels(), NumPixels());
    }
};

/// What the model shows in a view, in double precision.
RectifiedImage RenderView(const Maps& maps, const ViewSet& views, const View& view);

/// Root of the mean squared difference of two images of one size.
double Rmse(const RectifiedImage& a, const RectifiedImage& b);

/// The image with a quarter of the pixels, by means of four linear values. @param image  of an even size
RectifiedImage Halved(const RectifiedImage& image);
/// Each of them.
std::vector<RectifiedImage> Halved(std::span<const RectifiedImage> images);

}  // namespace lacquer::capture
