#include "denoise/patch_weights.h"

#include <algorithm>
#include <cmath>

#include "pbrt/core/math.h"

namespace lacquer::denoise {
namespace {

/// Squared difference of two pixels in units of its variance, less what noise makes of equal ones
/// [Rousselle et al. 2012, eq. 3]; the mean over the channels.
template <size_t N>
float Distance(const Guide<N>& guide, Int2 p, Int2 q, float k2) {
    const auto &u = guide.values.Clamped(p.x, p.y), &v = guide.values.Clamped(q.x, q.y);
    const auto &a = guide.variances.Clamped(p.x, p.y), &b = guide.variances.Clamped(q.x, q.y);
    constexpr float kTiny = 1e-10f;  // of a squared value, where nothing varies
    float sum = 0;
    for (size_t c = 0; c < N; ++c)
        sum += (Sqr(u[c] - v[c]) - (a[c] + std::min(a[c], b[c]))) / (kTiny + k2 * (a[c] + b[c]));
    return sum / float(N);
}

/// Means over squares of a patch's size, of distances that are known in a margin of its radius.
void MeanOverPatches(const std::vector<float>& distances, Int2 size, int radius, std::vector<float>* rows,
                     std::vector<float>* means) {
    const int width = size.x + 2 * radius, height = size.y + 2 * radius, side = 2 * radius + 1;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < size.x; ++x) {
            float sum = 0;
            for (int i = 0; i < side; ++i) sum += distances[size_t(y) * size_t(width) + size_t(x + i)];
            (*rows)[size_t(y) * size_t(size.x) + size_t(x)] = sum;
        }
    const float scale = 1 / float(side * side);
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            float sum = 0;
            for (int i = 0; i < side; ++i) sum += (*rows)[size_t(y + i) * size_t(size.x) + size_t(x)];
            (*means)[size_t(y) * size_t(size.x) + size_t(x)] = scale * sum;
        }
}

}  // namespace

template <size_t N>
PatchWeights::PatchWeights(const Guide<N>& guide, const Bounds2i& tile, const PatchOptions& options)
    : tile_(tile), radius_(options.windowRadius) {
    const Int2 size(tile.Width(), tile.Height()), image = guide.values.Size();
    const int side = 2 * radius_ + 1, r = options.patchRadius;
    const float k2 = Sqr(options.bandwidth);
    weights_.resize(size_t(side) * size_t(side) * size_t(tile.Area()));
    std::vector<float> distances(size_t(size.x + 2 * r) * size_t(size.y + 2 * r));
    std::vector<float> rows(size_t(size.x) * size_t(size.y + 2 * r)), means(size_t(tile.Area()));
    float* out = weights_.data();
    for (int dy = -radius_; dy <= radius_; ++dy)
        for (int dx = -radius_; dx <= radius_; ++dx, out += means.size()) {
            float* distance = distances.data();
            for (int y = tile.min.y - r; y < tile.max.y + r; ++y)
                for (int x = tile.min.x - r; x < tile.max.x + r; ++x)
                    *distance++ = Distance(guide, {x, y}, {x + dx, y + dy}, k2);
            MeanOverPatches(distances, size, r, &rows, &means);
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x) {
                    const Int2 q = tile.min + Int2(x + dx, y + dy);
                    const size_t i = size_t(y) * size_t(size.x) + size_t(x);
                    const bool isInside = q.x >= 0 && q.y >= 0 && q.x < image.x && q.y < image.y;
                    out[i] = isInside ? Exp(-std::max(0.f, means[i])) : 0.f;
                }
        }
}

template PatchWeights::PatchWeights(const Guide<3>&, const Bounds2i&, const PatchOptions&);
template PatchWeights::PatchWeights(const Guide<kNumFeatures>&, const Bounds2i&, const PatchOptions&);

}  // namespace lacquer::denoise
