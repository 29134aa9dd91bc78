#include "capture/card/rectify.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "pbrt/core/check.h"
#include "pbrt/core/parallel.h"

namespace lacquer::capture {

namespace {

using Eigen::Vector2d;

/// Weights of four neighbours at the distance t in [0,1) from the second one [Keys 1981]: a cubic through the
/// values, exact for parabolas.
std::array<float, 4> CubicWeights(double t) {
    return {float(t * (-0.5 + t * (1 - 0.5 * t))), float(1 + t * t * (-2.5 + 1.5 * t)),
            float(t * (0.5 + t * (2 - 1.5 * t))), float(t * t * (-0.5 + 0.5 * t))};
}

class Resampling {
  public:
    Resampling(const Image& photograph, const Intrinsics& intrinsics, const CameraPose& pose,
               const RectifyOptions& options)
        : photograph_(photograph), intrinsics_(intrinsics), pose_(pose), options_(options) {}

    struct Pixel {
        std::array<float, 3> mean{};
        bool isClipped = false, isOutside = false;
    };
    Pixel PixelAt(int column, int row) const {
        const Vector2d center = Project(column + 0.5, row + 0.5);
        const Vector2d across = Project(column + 1., row + 0.5) - Project(column, row + 0.5),
                       down = Project(column + 0.5, row + 1.) - Project(column + 0.5, row);
        const int nx = Count(across), ny = Count(down);
        Pixel pixel;
        const Int2 size = photograph_.Resolution();
        pixel.isOutside = center.x() < 0 || center.y() < 0 || center.x() > size.x || center.y() > size.y;
        std::array<float, 3> sum{};
        for (int j = 0; j < ny; ++j)
            for (int i = 0; i < nx; ++i)
                Add(center + ((i + 0.5) / nx - 0.5) * across + ((j + 0.5) / ny - 0.5) * down, &sum,
                    &pixel.isClipped);
        // The cubic overshoots at edges; there is no negative light.
        for (size_t c = 0; c < 3; ++c) pixel.mean[c] = std::max(0.F, sum[c] / float(nx * ny));
        return pixel;
    }

  private:
    Vector2d Project(double column, double row) const {
        const double scale = options_.squareSize / options_.resolution, half = options_.squareSize / 2;
        return ProjectPoint(intrinsics_, pose_, {column * scale - half, half - row * scale, -options_.depth});
    }
    /// Points along an edge of so many pixels. @param edge  finite; of any photograph at most some thousands
    static int Count(const Vector2d& edge) {
        return int(std::clamp(std::ceil(edge.norm() - 1e-6), 1., 256.));
    }

    void Add(Vector2d p, std::array<float, 3>* sum, bool* isClipped) const {
        const Int2 size = photograph_.Resolution();
        const double x = std::clamp(p.x(), 0., double(size.x)) - 0.5,
                     y = std::clamp(p.y(), 0., double(size.y)) - 0.5;
        const int ix = int(std::floor(x)), iy = int(std::floor(y));
        const std::array<float, 4> wx = CubicWeights(x - ix), wy = CubicWeights(y - iy);
        for (int j = 0; j < 4; ++j)
            for (int i = 0; i < 4; ++i) {
                const Int2 at{std::clamp(ix + i - 1, 0, size.x - 1), std::clamp(iy + j - 1, 0, size.y - 1)};
                const float weight = wx[size_t(i)] * wy[size_t(j)];
                const bool isNear = (i == 1 || i == 2) && (j == 1 || j == 2);
                for (int c = 0; c < 3; ++c) {
                    const float value = photograph_.Get(at, c);
                    (*sum)[size_t(c)] += weight * value;
                    if (isNear && value >= options_.clipped) *isClipped = true;
                }
            }
    }

    const Image& photograph_;
    const Intrinsics& intrinsics_;
    const CameraPose& pose_;
    const RectifyOptions& options_;
};

}  // namespace

RectifiedPhotograph Rectify(const Image& linear, const Intrinsics& intrinsics, const CameraPose& pose,
                            const RectifyOptions& options) {
    LACQUER_CHECK(linear.HasRGB() && options.resolution > 0);
    const int n = options.resolution;
    RectifiedPhotograph result;
    result.linear = Image({n, n}, {"R", "G", "B"});
    const Resampling resampling(linear, intrinsics, pose, options);
    std::atomic<int64_t> numClipped = 0, numOutside = 0;
    ParallelFor(n, [&](int64_t row) {
        for (int column = 0; column < n; ++column) {
            const Resampling::Pixel pixel = resampling.PixelAt(column, int(row));
            numClipped += pixel.isClipped;
            numOutside += pixel.isOutside;
            for (int c = 0; c < 3; ++c) result.linear.Set({column, int(row)}, c, pixel.mean[size_t(c)]);
        }
    });
    result.clippedShare = double(numClipped) / (double(n) * n);
    result.outsideShare = double(numOutside) / (double(n) * n);
    return result;
}

double PixelsAcross(const Intrinsics& intrinsics, std::span<const CameraPose> poses, double squareSize,
                    double depth) {
    double least = std::numeric_limits<double>::max();
    const double h = squareSize / 2;
    for (const CameraPose& pose : poses) {
        const Vector2d a = ProjectPoint(intrinsics, pose, {-h, -h, -depth}),
                       b = ProjectPoint(intrinsics, pose, {h, -h, -depth}),
                       c = ProjectPoint(intrinsics, pose, {h, h, -depth}),
                       d = ProjectPoint(intrinsics, pose, {-h, h, -depth});
        const Vector2d p = c - a, q = d - b;
        least = std::min(least, std::sqrt(std::abs(p.x() * q.y() - p.y() * q.x()) / 2));
    }
    return least;
}

}  // namespace lacquer::capture
