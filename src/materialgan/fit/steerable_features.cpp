#include "materialgan/fit/steerable_features.h"

#include <cmath>
#include <numbers>

namespace lacquer::materialgan {
namespace {

constexpr int kOrientations = 4, kRadius = 3;
constexpr double kSigma = 1.2, kMagnitudeFloor = 1e-4;
constexpr int64_t kMinLevelSize = 8;

/// Derivatives of a Gaussian, 2 x 4 kernels of 7 x 7 of unit energy each: first ones, then second ones.
Tensor DerivativeKernels() {
    const int size = 2 * kRadius + 1;
    Tensor kernels = torch::zeros({2 * kOrientations, 1, size, size});
    auto values = kernels.accessor<float, 4>();
    for (int k = 0; k < kOrientations; ++k) {
        const double angle = std::numbers::pi * k / kOrientations;
        for (int y = -kRadius; y <= kRadius; ++y)
            for (int x = -kRadius; x <= kRadius; ++x) {
                const double u = (std::cos(angle) * x + std::sin(angle) * y) / kSigma;
                const double gaussian = std::exp(-0.5 * (x * x + y * y) / (kSigma * kSigma));
                values[k][0][y + kRadius][x + kRadius] = float(-u * gaussian);
                values[kOrientations + k][0][y + kRadius][x + kRadius] = float((u * u - 1) * gaussian);
            }
    }
    // The second derivative of a constant is 0 only without what the window cuts off.
    kernels = kernels - kernels.mean({2, 3}, /*keepdim=*/true);
    return kernels / kernels.square().sum({2, 3}, /*keepdim=*/true).sqrt();
}

Tensor OpponentColours(const Tensor& images) {
    const Tensor r = images.select(1, 0), g = images.select(1, 1), b = images.select(1, 2);
    return torch::stack({(r + g + b) / 3, r - g, (r + g) / 2 - b}, 1);
}

}  // namespace

std::vector<Tensor> SteerableFeatures(const Tensor& images) {
    const Tensor kernels = DerivativeKernels();
    Tensor level = OpponentColours(images);
    std::vector<Tensor> features;
    while (int(features.size()) < kMaxFeatureLevels && level.size(2) >= kMinLevelSize) {
        const int64_t n = level.size(0), size = level.size(2);
        const Tensor padded = torch::replication_pad2d(level, {kRadius, kRadius, kRadius, kRadius});
        const Tensor derivatives =
            torch::conv2d(padded.view({3 * n, 1, size + 2 * kRadius, size + 2 * kRadius}), kernels);
        const std::vector<Tensor> pair = derivatives.split(kOrientations, 1);
        const Tensor magnitude = (pair[0].square() + pair[1].square() + kMagnitudeFloor).sqrt();
        features.push_back(torch::cat({magnitude.reshape({n, 3 * kOrientations, size, size}), level}, 1));
        level = torch::avg_pool2d(level, 2);
    }
    return features;
}

}  // namespace lacquer::materialgan
