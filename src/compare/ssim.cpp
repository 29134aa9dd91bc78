#include "compare/ssim.h"

#include <array>
#include <cmath>

#include "pbrt/core/check.h"

namespace lacquer::compare {
namespace {

constexpr double kDeviation = 1.5;
/// Squares of 0.01 and 0.03 of the range, which keep flat and dark windows finite.
constexpr double kMeanConstant = 1e-4, kVarianceConstant = 9e-4;

std::array<double, kSsimWindow> Weights() {
    std::array<double, kSsimWindow> weights{};
    double sum = 0;
    for (int i = 0; i < kSsimWindow; ++i) {
        const double x = i - kSsimWindow / 2;
        sum += weights[size_t(i)] = std::exp(-x * x / (2 * kDeviation * kDeviation));
    }
    for (double& weight : weights) weight /= sum;
    return weights;
}

/// Values in rows.
struct Field {
    int width, height;
    std::vector<double> values;

    Field(int w, int h) : width(w), height(h), values(size_t(w) * size_t(h)) {}
    double& At(int x, int y) { return values[size_t(y) * size_t(width) + size_t(x)]; }
    double At(int x, int y) const { return values[size_t(y) * size_t(width) + size_t(x)]; }
};

Field ChannelOf(const Image& image, const std::string& name) {
    const int channel = image.FindChannel(name);
    LACQUER_CHECK(channel >= 0);
    Field field(image.Resolution().x, image.Resolution().y);
    for (size_t i = 0; i < field.values.size(); ++i)
        field.values[i] = double(image.Pixels()[i * size_t(image.NumChannels()) + size_t(channel)]);
    return field;
}

Field Product(const Field& a, const Field& b) {
    Field product(a.width, a.height);
    for (size_t i = 0; i < product.values.size(); ++i) product.values[i] = a.values[i] * b.values[i];
    return product;
}

/// Weighted means over the windows within the field.
Field WindowMeans(const Field& field) {
    static const std::array<double, kSsimWindow> weights = Weights();
    Field rows(field.width - kSsimWindow + 1, field.height);
    for (int y = 0; y < rows.height; ++y)
        for (int x = 0; x < rows.width; ++x)
            for (int i = 0; i < kSsimWindow; ++i) rows.At(x, y) += weights[size_t(i)] * field.At(x + i, y);
    Field means(rows.width, field.height - kSsimWindow + 1);
    for (int y = 0; y < means.height; ++y)
        for (int x = 0; x < means.width; ++x)
            for (int i = 0; i < kSsimWindow; ++i) means.At(x, y) += weights[size_t(i)] * rows.At(x, y + i);
    return means;
}

double SsimOfChannel(const Field& a, const Field& b) {
    const Field meanA = WindowMeans(a), meanB = WindowMeans(b), squareA = WindowMeans(Product(a, a)),
                squareB = WindowMeans(Product(b, b)), product = WindowMeans(Product(a, b));
    double sum = 0;
    for (size_t i = 0; i < meanA.values.size(); ++i) {
        const double ma = meanA.values[i], mb = meanB.values[i];
        const double va = squareA.values[i] - ma * ma, vb = squareB.values[i] - mb * mb,
                     covariance = product.values[i] - ma * mb;
        sum += (2 * ma * mb + kMeanConstant) * (2 * covariance + kVarianceConstant) /
               ((ma * ma + mb * mb + kMeanConstant) * (va + vb + kVarianceConstant));
    }
    return sum / double(meanA.values.size());
}

}  // namespace

double Ssim(const Image& image, const Image& reference, const std::vector<std::string>& channels) {
    LACQUER_CHECK(image.Resolution() == reference.Resolution() && image.Resolution().x >= kSsimWindow &&
                  image.Resolution().y >= kSsimWindow && !channels.empty());
    double sum = 0;
    for (const std::string& name : channels)
        sum += SsimOfChannel(ChannelOf(image, name), ChannelOf(reference, name));
    return sum / double(channels.size());
}

}  // namespace lacquer::compare
