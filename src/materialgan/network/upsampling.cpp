#include "materialgan/network/upsampling.h"

#include <ATen/Parallel.h>

namespace lacquer::materialgan {
namespace {

/// Of one dimension: x(i-1) + 3 x(i) and 3 x(i) + x(i+1) in turn, zeros beyond the ends.
Tensor DoubleAlong(const Tensor& x, int64_t dimension) {
    const int64_t n = x.size(dimension);
    std::vector<int64_t> padding(size_t(2 * (x.dim() - dimension)));
    padding[padding.size() - 2] = padding[padding.size() - 1] = 1;
    const Tensor padded = torch::constant_pad_nd(x, padding);
    const Tensor even = torch::add(padded.narrow(dimension, 0, n), x, 3),
                 odd = torch::add(padded.narrow(dimension, 2, n), x, 3);
    std::vector<int64_t> shape = x.sizes().vec();
    shape[size_t(dimension)] = 2 * n;
    return torch::stack({even, odd}, dimension + 1).view(shape);
}

/// Sizes of InterleaveAndFilter(): the result is 2h x 2w, its parts are (h+1) x (w+1).
struct PlaneSize {
    int64_t h, w;
    int64_t Parts() const { return 4 * (h + 1) * (w + 1); }
    int64_t Result() const { return 4 * h * w; }
};

/// out(j) = row(j) + 3 row(j+1) + 3 row(j+2) + row(j+3), all of them rows of `width` numbers, `factor` times.
void FilterRows(const float* rows, int64_t stride, int64_t width, float factor, float* out) {
    const float *a = rows, *b = a + stride, *c = b + stride, *d = c + stride;
    for (int64_t i = 0; i < width; ++i) out[i] = factor * ((a[i] + d[i]) + 3 * (b[i] + c[i]));
}

/// One map: columns of each row are interleaved and filtered into `work`, then rows into the result.
/// @param work  2h+3 rows of 2w, the first of them 0, and behind them a row of 2w+3
void FilterPlane(PlaneSize size, const float* parts, float* work, float* out) {
    const int64_t h = size.h, w = size.w, partSize = (h + 1) * (w + 1);
    float* row = work + (2 * h + 3) * 2 * w;
    for (int64_t r = 0; r <= 2 * h + 1; ++r) {
        const float *even = parts + 2 * (r % 2) * partSize + (r / 2) * (w + 1), *odd = even + partSize;
        row[0] = 0;
        for (int64_t i = 0; i <= w; ++i) {
            row[2 * i + 1] = even[i];
            row[2 * i + 2] = odd[i];
        }
        FilterRows(row, 1, 2 * w, 1, work + (r + 1) * 2 * w);
    }
    for (int64_t r = 0; r < 2 * h; ++r) FilterRows(work + r * 2 * w, 2 * w, 2 * w, 1.f / 16, out + r * 2 * w);
}

/// Its adjoint.
/// @param work  2h+5 rows of 2w, the first two and the last three of them 0, and 4w+8 zeros behind them
void FilterPlaneAdjoint(PlaneSize size, const float* byOut, float* work, float* byParts) {
    const int64_t h = size.h, w = size.w, partSize = (h + 1) * (w + 1);
    std::copy(byOut, byOut + size.Result(), work + 2 * 2 * w);
    float* line = work + (2 * h + 5) * 2 * w;
    float* filtered = line + 2 * w + 6;
    for (int64_t r = 0; r <= 2 * h + 1; ++r) {
        // The filter is symmetric: row r of what was interleaved goes into rows r-2 to r+1 of the result.
        FilterRows(work + r * 2 * w, 2 * w, 2 * w, 1.f / 16, line + 2);
        FilterRows(line, 1, 2 * w + 2, 1, filtered);
        float *even = byParts + 2 * (r % 2) * partSize + (r / 2) * (w + 1), *odd = even + partSize;
        for (int64_t i = 0; i <= w; ++i) {
            even[i] = filtered[2 * i];
            odd[i] = filtered[2 * i + 1];
        }
    }
}

/// body(plane, work) for all planes on the threads of libtorch, with zeroed memory for each thread.
template <class Body>
void ForPlanes(int64_t count, int64_t workSize, const Body& body) {
    at::parallel_for(0, count, 1, [&](int64_t begin, int64_t end) {
        std::vector<float> work(size_t(workSize), 0.f);
        for (int64_t plane = begin; plane < end; ++plane) body(plane, work.data());
    });
}

/// N x 4C x (h+1) x (w+1) to N x C x 2h x 2w.
Tensor FilteredParts(const Tensor& given) {
    const Tensor parts = given.contiguous();
    const PlaneSize size{parts.size(2) - 1, parts.size(3) - 1};
    const int64_t n = parts.size(0), maps = parts.size(1) / 4;
    Tensor result = torch::empty({n, maps, 2 * size.h, 2 * size.w}, parts.options());
    const float* from = parts.data_ptr<float>();
    float* to = result.data_ptr<float>();
    ForPlanes(n * maps, (2 * size.h + 4) * 2 * size.w + 3, [&](int64_t plane, float* work) {
        FilterPlane(size, from + plane * size.Parts(), work, to + plane * size.Result());
    });
    return result;
}

/// And its adjoint.
Tensor FilteredPartsAdjoint(const Tensor& given) {
    const Tensor byOut = given.contiguous();
    const PlaneSize size{byOut.size(2) / 2, byOut.size(3) / 2};
    const int64_t n = byOut.size(0), maps = byOut.size(1);
    Tensor result = torch::empty({n, 4 * maps, size.h + 1, size.w + 1}, byOut.options());
    const float* from = byOut.data_ptr<float>();
    float* to = result.data_ptr<float>();
    ForPlanes(n * maps, (2 * size.h + 7) * 2 * size.w + 12, [&](int64_t plane, float* work) {
        FilterPlaneAdjoint(size, from + plane * size.Result(), work, to + plane * size.Parts());
    });
    return result;
}

/// The filter, or its adjoint: each is the other's derivative, so that derivatives have derivatives, which
/// the regularisations of a GAN need.
template <bool isAdjoint>
class PartsFunction : public torch::autograd::Function<PartsFunction<isAdjoint>> {
  public:
    static Tensor forward(torch::autograd::AutogradContext*, const Tensor& x) {
        return isAdjoint ? FilteredPartsAdjoint(x) : FilteredParts(x);
    }
    static torch::autograd::variable_list backward(torch::autograd::AutogradContext*,
                                                   const torch::autograd::variable_list& gradients) {
        return {PartsFunction<!isAdjoint>::apply(gradients[0])};
    }
};

}  // namespace

Tensor UpsampleImage(const Tensor& x) { return DoubleAlong(DoubleAlong(x, 2), 3) / 16; }

Tensor SplitKernel(const Tensor& kernel) {
    const int64_t out = kernel.size(0), in = kernel.size(1);
    // Taps of x(m-1) and x(m): for even results the first and the last, for odd ones none and the middle.
    const Tensor taps = torch::tensor({0, 2, 3, 1});
    const Tensor padded = torch::constant_pad_nd(kernel, {0, 1, 0, 1});
    return padded.index_select(2, taps)
        .index_select(3, taps)
        .view({out, in, 2, 2, 2, 2})
        .permute({0, 2, 4, 1, 3, 5})
        .reshape({4 * out, in, 2, 2});
}

Tensor UpsampleAndConvolve(const Tensor& x, const Tensor& split) {
    return InterleaveAndFilter(torch::conv2d(x, split, {}, 1, 1));
}

Tensor InterleaveAndFilter(const Tensor& parts) { return PartsFunction<false>::apply(parts); }

}  // namespace lacquer::materialgan
