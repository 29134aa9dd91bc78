// How far an image is from a reference, per pixel and over a rectangle.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pbrt/image/image.h"

namespace lacquer::compare {

/// Of a value a and its reference b:
enum class Metric {
    MAE,   ///< mean of |a - b|
    MSE,   ///< mean of (a - b)^2
    MRSE,  ///< mean of (a - b)^2 / (b^2 + kRelativeEpsilon)
    RMSE,  ///< square root of MSE
};

/// Keeps the relative error of dark pixels finite, as in [Rousselle et al. 2011]; 0.01 is the usual value in
/// papers on denoising and sampling. Well below a reference of 0.1 the error is an absolute one.
inline constexpr double kRelativeEpsilon = 0.01;

/// "MAE", "MSE", "MRSE", "RMSE".
std::vector<std::string> MetricNames();
/// By its name; empty if there is no such metric.
std::optional<Metric> ParseMetric(const std::string& name);

/// The error of every pixel: |a - b| for MAE and RMSE, else the squared or relative squared difference.
/// @param channels  compared, by name; both images have them, and have one size. The result has these only.
/// NaN and infinite values give NaN or infinity. The data window is that of `image`.
Image ErrorMap(const Image& image, const Image& reference, Metric metric,
               const std::vector<std::string>& channels);

/// The metric of each channel over a rectangle of a map of that metric, in double.
/// @param pixels  counted in the map's own pixels from its corner; inside it and not empty
std::vector<double> ErrorOver(const Image& map, Metric metric, const Bounds2i& pixels);

/// One number for several channels: their mean, of which a root is taken last.
double MeanOfErrors(const std::vector<double>& channels, Metric metric);

/// How many values are NaN, and how many infinite, and the first of them.
struct NonFinite {
    int64_t nan = 0, inf = 0;
    Int2 pixel{0};        ///< of the first, in the image's own pixels; rows first
    std::string channel;  ///< of the first
    bool Any() const { return nan + inf > 0; }
};
NonFinite FindNonFinite(const Image& image, const std::vector<std::string>& channels);

}  // namespace lacquer::compare
