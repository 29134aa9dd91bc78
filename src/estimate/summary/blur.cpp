#include "estimate/summary/summary.h"

namespace lacquer::estimate {
namespace {

constexpr double kBlurWeights[3] = {6. / 16, 4. / 16, 1. / 16};

/// out_j = sum of weights of in at j - 2 step ... j + 2 step, for a line that is continued at its ends.
void BlurLine(size_t n, size_t step, const double* in, double* padded, double* out) {
    const size_t margin = 2 * step;
    std::fill(padded, padded + margin, in[0]);
    std::copy(in, in + n, padded + margin);
    std::fill(padded + margin + n, padded + 2 * margin + n, in[n - 1]);
    const double* p = padded + margin;
    for (size_t j = 0; j < n; ++j)
        out[j] = kBlurWeights[0] * p[j] + kBlurWeights[1] * (p[j + step] + *(p + j - step)) +
                 kBlurWeights[2] * (p[j + 2 * step] + *(p + j - 2 * step));
}

/// The adjoint: spread over the continued line, whose ends then count for the first and the last.
void SpreadLine(size_t n, size_t step, const double* by, double* padded, double* out) {
    const size_t margin = 2 * step, all = n + 2 * margin;
    // Where nothing is known, zeros: the transpose of a symmetric filter is the filter.
    std::fill(padded, padded + all + 2 * margin, 0.);
    std::copy(by, by + n, padded + 2 * margin);
    const double* p = padded + margin;
    const auto at = [&](size_t j) {
        return kBlurWeights[0] * p[j] + kBlurWeights[1] * (p[j + step] + *(p + j - step)) +
               kBlurWeights[2] * (p[j + 2 * step] + *(p + j - 2 * step));
    };
    double left = 0, right = 0;
    for (size_t j = 0; j < margin; ++j) {
        left += at(j);
        right += at(margin + n + j);
    }
    for (size_t j = 0; j < n; ++j) out[j] = at(margin + j);
    out[0] += left;
    out[n - 1] += right;
}

using LineFilter = void (*)(size_t, size_t, const double*, double*, double*);

/// Rows, then columns; both through the same filter, as the adjoint of a product of commuting filters allows.
void FilterImage(int size, int step, LineFilter filter, std::span<const double> in,
                 std::vector<double>* out) {
    const size_t n = size_t(size);
    out->resize(n * n);
    std::vector<double> padded(n + 8 * size_t(step)), line(n), filtered(n);
    for (size_t i = 0; i < n; ++i) filter(n, size_t(step), &in[i * n], padded.data(), &(*out)[i * n]);
    for (size_t j = 0; j < n; ++j) {
        for (size_t i = 0; i < n; ++i) line[i] = (*out)[i * n + j];
        filter(n, size_t(step), line.data(), padded.data(), filtered.data());
        for (size_t i = 0; i < n; ++i) (*out)[i * n + j] = filtered[i];
    }
}

}  // namespace

void BinomialBlur(int size, int step, std::span<const double> in, std::vector<double>* out) {
    FilterImage(size, step, BlurLine, in, out);
}

void BinomialBlurAdjoint(int size, int step, std::span<const double> by, std::vector<double>* out) {
    FilterImage(size, step, SpreadLine, by, out);
}

}  // namespace lacquer::estimate
