#include "compare/metrics.h"

#include <array>
#include <cmath>

#include "pbrt/core/check.h"

namespace lacquer::compare {
namespace {

struct NamedMetric {
    const char* name;
    Metric metric;
};
constexpr std::array kNamedMetrics{NamedMetric{"MAE", Metric::MAE}, NamedMetric{"MSE", Metric::MSE},
                                   NamedMetric{"MRSE", Metric::MRSE}, NamedMetric{"RMSE", Metric::RMSE}};

std::vector<int> IndicesOf(const Image& image, const std::vector<std::string>& channels) {
    std::vector<int> indices;
    for (const std::string& channel : channels) {
        indices.push_back(image.FindChannel(channel));
        LACQUER_CHECK(indices.back() >= 0);
    }
    return indices;
}

double ErrorOf(double a, double b, Metric metric) {
    const double difference = a - b;
    switch (metric) {
        case Metric::MSE:
            return difference * difference;
        case Metric::MRSE:
            return difference * difference / (b * b + kRelativeEpsilon);
        case Metric::MAE:
        case Metric::RMSE:
            break;
    }
    return std::abs(difference);
}

}  // namespace

std::vector<std::string> MetricNames() {
    std::vector<std::string> names;
    for (const NamedMetric& entry : kNamedMetrics) names.emplace_back(entry.name);
    return names;
}

std::optional<Metric> ParseMetric(const std::string& name) {
    for (const NamedMetric& entry : kNamedMetrics)
        if (name == entry.name) return entry.metric;
    return {};
}

Image ErrorMap(const Image& image, const Image& reference, Metric metric,
               const std::vector<std::string>& channels) {
    LACQUER_CHECK(image.Resolution() == reference.Resolution());
    const std::vector<int> a = IndicesOf(image, channels), b = IndicesOf(reference, channels);
    Image map(image.Resolution(), channels);
    map.dataWindow = image.dataWindow;
    map.fullResolution = image.fullResolution;
    for (int y = 0; y < map.Resolution().y; ++y)
        for (int x = 0; x < map.Resolution().x; ++x)
            for (size_t c = 0; c < channels.size(); ++c)
                map.Set({x, y}, int(c),
                        float(ErrorOf(double(image.Get({x, y}, a[c])), double(reference.Get({x, y}, b[c])),
                                      metric)));
    return map;
}

std::vector<double> ErrorOver(const Image& map, Metric metric, const Bounds2i& pixels) {
    LACQUER_CHECK(!pixels.IsEmpty() && pixels.Intersect({{0, 0}, map.Resolution()}) == pixels);
    std::vector<double> sums(size_t(map.NumChannels()), 0.0);
    for (int y = pixels.min.y; y < pixels.max.y; ++y)
        for (int x = pixels.min.x; x < pixels.max.x; ++x)
            for (int c = 0; c < map.NumChannels(); ++c) {
                const auto error = double(map.Get({x, y}, c));
                sums[size_t(c)] += metric == Metric::RMSE ? error * error : error;
            }
    for (double& sum : sums) {
        sum /= double(pixels.Area());
        if (metric == Metric::RMSE) sum = std::sqrt(sum);
    }
    return sums;
}

double MeanOfErrors(const std::vector<double>& channels, Metric metric) {
    const bool isRoot = metric == Metric::RMSE;
    double mean = 0;
    for (const double error : channels) mean += (isRoot ? error * error : error) / double(channels.size());
    return isRoot ? std::sqrt(mean) : mean;
}

NonFinite FindNonFinite(const Image& image, const std::vector<std::string>& channels) {
    const std::vector<int> indices = IndicesOf(image, channels);
    NonFinite found;
    for (int y = 0; y < image.Resolution().y; ++y)
        for (int x = 0; x < image.Resolution().x; ++x)
            for (size_t c = 0; c < channels.size(); ++c) {
                const float value = image.Get({x, y}, indices[c]);
                if (std::isfinite(value)) continue;
                if (!found.Any()) {
                    found.pixel = {x, y};
                    found.channel = channels[c];
                }
                ++(std::isnan(value) ? found.nan : found.inf);
            }
    return found;
}

}  // namespace lacquer::compare
