// The best mixture for one slice alone: what the polynomials of a table are fitted to.
#pragma once

#include <array>

#include "gaussfit/fit/slice.h"
#include "gaussfit/lobe/lobe_table.h"

namespace lacquer::gaussfit {

/// One Gaussian of a slice in the plane of slopes; the mean of y and the covariance are 0.
struct SliceGaussian {
    double weight = 1, meanX = 0, varianceX = 1, varianceY = 1;
};

struct SliceMixture {
    std::array<SliceGaussian, LobeTable::kMaxComponents> parts;
    int count = 1;

    double Pdf(double x, double y) const;
};

/// What a table says, as a mixture; a lobe that was not found has count 0.
SliceMixture MixtureOf(const LobeTable& table, const SlicePoint& point);

/// Mean of the log of the mixture's density over the slice: what maximum likelihood maximises [Xia et al.
/// 2020] eq. 20, there with the opposite sign and as a sum.
double LogLikelihood(const Slice& slice, const SliceMixture& mixture);

/// The part of a slice that it has in common with a mixture, sum of min(slice, mixture): 1 if they are equal.
double Overlap(const Slice& slice, const SliceMixture& mixture);

/// One step of expectation and maximisation [Dempster et al. 1977]: cells are shared out to the parts of
/// `mixture` in proportion to their densities; returns weight, mean and variances of what each got. For one
/// part these are the slice's moments, whatever `mixture` says.
SliceMixture ShareOut(const Slice& slice, const SliceMixture& mixture);

/// The mixture of `count` Gaussians (1 or 2) with the largest likelihood. Of two, part 0 is the narrow one.
/// `steps` of ShareOut() from two wide Gaussians of one mean; 200 of them leave less than 1e-4 to gain.
SliceMixture FitSlice(const Slice& slice, int count, int steps);

}  // namespace lacquer::gaussfit
