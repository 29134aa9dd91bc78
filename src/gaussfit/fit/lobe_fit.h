// From a model to its table: slices over all parameters, their best mixtures, and polynomials through those.
#pragma once

#include "gaussfit/fit/slice_mixture.h"
#include "pbrt/core/progress.h"

namespace lacquer::gaussfit {

/// What a fit covers and how finely. The defaults are those of the tables in data/lobes.
struct LobeFitOptions {
    double alphaMin = 0.005, alphaSplit = 0.1, alphaMax = 1;  ///< patches below and above the split
    double etaMin = 1.05, etaMax = 2.5;                       ///< larger index over the smaller one
    double maxThetaDeg = 88;                                  ///< of w [degrees], except for Leaving
    double maxSine = 0.995;                   ///< of the refracted specular direction, for Leaving
    int alphas = 10, etas = 10, thetas = 20;  ///< slices of one patch along each axis
    SliceOptions slice;
    int mixtureSteps = 200;   ///< see FitSlice
    int rounds = 3;           ///< of sharing out slices to the fitted mixtures and fitting again
    double smoothing = 1e-5;  ///< see PolynomialFitProblem
};

/// A slice with the best mixture for it alone.
struct SliceFit {
    SlicePoint point;
    Slice slice;
    SliceMixture best;
};

/// How far a table is from the best mixture of a slice.
struct LobeError {
    double meanInSigmas =
        0;  ///< distance of the means of the whole mixtures over the slice's deviation along x
    double logL11 = 0,
           logL22 = 0;          ///< |log| of the quotients of the whole mixtures' deviations along x and y
    double lostLikelihood = 0;  ///< LogLikelihood() of the best mixture minus that of the table's [nat]
    /// Part of the slice that the table\'s lobes do not cover: 1 - Overlap(). Most of it is what no Gaussians
    /// can fit.
    double uncovered = 0;
};
LobeError ErrorOf(const SliceFit& fit, const SliceMixture& fitted);

/// Root of mean square, and maximum, of each of these.
struct LobeErrorSummary {
    LobeError rms, max;
    int count = 0;
};
LobeErrorSummary Summarize(const std::vector<LobeError>& errors);

struct LobeFitResult {
    LobeTable table;
    LobeErrorSummary training;                ///< at the slices that were fitted
    double sliceSeconds = 0, fitSeconds = 0;  ///< of the clock on the wall
};

/// The slice's place for coordinates in [0, 1] within the ranges of `options`: eta and alpha by their roots'
/// position, the angle denser near its end. @param patch  0 below the split, 1 above it
SlicePoint PointAt(const LobeModel& model, const LobeFitOptions& options, int patch, double eta, double alpha,
                   double theta);

/// Tabulates and fits one slice.
SliceFit FitSliceAt(const LobeModel& model, const SlicePoint& point, const LobeFitOptions& options);

/// Fits a model's table. Runs in parallel; the result does not depend on the number of threads. Errors:
/// FileError (with the model's name) if the fit left the ranges that tables allow; FitStopped if the observer
/// asked to stop.
LobeFitResult FitLobes(const LobeModel& model, const LobeFitOptions& options, Observer* observer);

/// Errors of a table over its whole range, at points between those of the fit.
struct LobeSurvey {
    std::vector<double> etas;    ///< index on the far side over index on the side of w; {1} for reflections
    std::vector<double> alphas;  ///< ascending, over both patches
    std::vector<double> angles;  ///< positions of PointAt() in [0, 1]
    std::vector<SliceFit> fits;  ///< [eta][alpha][angle]
    std::vector<LobeError> errors;  ///< of the fits

    size_t Index(size_t eta, size_t alpha, size_t angle) const {
        return (eta * alphas.size() + alpha) * angles.size() + angle;
    }
};
/// Slices at `etas` (1 for reflections) x `alphas` x `angles` points. Runs in parallel.
LobeSurvey SurveyTable(const LobeTable& table, const LobeFitOptions& options, int etas, int alphas,
                       int angles);

/// Thrown by FitLobes() when Observer::ShouldStop() said so.
class FitStopped : public std::exception {
  public:
    const char* what() const noexcept override { return "the fit was stopped"; }
};

}  // namespace lacquer::gaussfit
