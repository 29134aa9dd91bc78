// Doubling of images and feature maps with the filter of StyleGAN2 [Karras et al. 2020]: [1,3,3,1] in both
// directions, divided by 16 (a gain of 4).
#pragma once

#include "materialgan/network/tensors.h"

namespace lacquer::materialgan {

/// Twice the size: zeros in between, two before and one behind, and the filter.
Tensor UpsampleImage(const Tensor& x);

/// A kernel of 3 x 3 (out x in x 3 x 3) for UpsampleAndConvolve(): the transposed convolution of stride 2
/// falls apart into four convolutions of up to 2 x 2, one for each parity of row and column of the result.
/// They are one of four times the maps, (4 out) x in x 2 x 2, in the order (out, row's parity, column's).
Tensor SplitKernel(const Tensor& kernel);
/// N x out x 2H x 2W. Six times as fast as a transposed convolution and a convolution with the filter, and
/// half of the operations that a convolution with the filter's kernel folded in takes.
Tensor UpsampleAndConvolve(const Tensor& x, const Tensor& split);

/// Maps of which each texel has four parts, N x (4 C) x (H+1) x (W+1), as one of twice the size, filtered and
/// without its border: N x C x 2H x 2W.
Tensor InterleaveAndFilter(const Tensor& parts);

}  // namespace lacquer::materialgan
