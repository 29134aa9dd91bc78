// What a correct BxDF must satisfy: the checks C1 to C11, for one BxDF, one outgoing direction and one
// transport mode. The conformance suite applies them to every row of bxdf_cases.h; the negative controls
// apply them to broken BxDFs.
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "support/bxdf_cases.h"
#include "support/statistics.h"

namespace lacquer::test {

/// One case to examine.
struct BxDFSetup {
    const BxDF& bxdf;
    Vec3 wo;
    TransportMode mode = TransportMode::Radiance;
    bool lossless = false;
    double tolerance = 2e-5;
    bool stochastic = false;
    bool takesMoreNumbers = false;
    bool takesThreeNumbers = false;
    bool isOneWay = false;
};

/// The numbers of one Sample().
inline BxDFRandom Draw(Rng& rng) {
    const float lobe = rng.Uniform();
    return {lobe, rng.Uniform2D()};
}

/// C1: finite and not negative, also at degenerate directions (in the surface, along wo, against wo) and at
/// the corners of the square of random numbers; zero for directions in the surface.
testing::AssertionResult IsFiniteEverywhere(const BxDFSetup& s);
/// C2: zero outside of the declared lobes and of the sides asked for; samples only in declared lobes, each of
/// one side and one kind, on the side that they claim.
testing::AssertionResult KeepsToItsLobes(const BxDFSetup& s);
/// C5: weight * pdf = f |cos| and the same pdf, for both sides together and each alone; pdfReverse is the pdf
/// of the exchanged directions. Not for samples with pdfExact = false: for these C8 must hold.
testing::AssertionResult RecordIsConsistent(const BxDFSetup& s);
/// C6: f(wo, wi, mode) = f(wi, wo, !mode), for pairs that Sample() makes and for any pairs: three quarters of
/// them within the tolerance, all within 100 times it (of at least 1e-3). Stochastic models: in the mean,
/// each of a few pairs at 6 standard errors. Not for models that are one-way.
testing::AssertionResult HasAdjoint(const BxDFSetup& s);
/// C9: the area on the sphere that a small square of random numbers is mapped to, by central differences, is
/// 1/pdf. For each side alone, so that no probability of a lobe enters. Tolerance 2.5 %: differences with two
/// steps that do not agree to 1 % (at kinks and edges) are left out. Only for exact pdfs.
testing::AssertionResult JacobianIsPdf(const BxDFSetup& s);
/// C10: the same arguments and generator state give the same bits, also when asked from other threads in
/// another order.
testing::AssertionResult IsReproducible(const BxDFSetup& s);
/// C11: who has no use for a sample's densities gets the same sample without them: lobe, index and direction
/// to the bit, the weight within 0.1 %, or within 1 % from degenerate directions. In one of 200 draws the
/// density may have been rounded to nothing.
testing::AssertionResult SamplesAlikeWithoutPdf(const BxDFSetup& s);

/// Integrals over the sphere of wi of what Evaluate() returns, by adaptive quadrature in (cos theta, phi).
struct SphereIntegrals {
    static constexpr int kNumCos = 80, kNumPhi = 160;
    std::vector<double> pdf;  ///< [kNumCos][kNumPhi] integral of the pdf over each cell
    double total = 0;         ///< integral of the pdf
    Vec3 moment{0};           ///< integral of pdf * wi
    double error = 0;         ///< what Integrate() was asked for
    double reflected = 0;     ///< integral of f |cos| cos^2, mean of the wavelengths
};
/// @param seed   of the samples that are drawn to find narrow lobes: parts of cells are halved until each has
/// few of them
/// @param error  by which two levels may differ in a part of a cell (absolute); the true error is some tenths
/// of it
SphereIntegrals Integrate(const BxDFSetup& s, uint64_t seed, double error = 4e-6);

/// Checks that share one set of samples.
///
/// Power, at 300,000 samples and the significance 1e-3 / 1500 of one check (threshold about 5 standard
/// errors):
///  - a pdf too large by 5 %: the coarse grid has a non-centrality of 750 at 200 degrees of freedom (37
///  sigma); C4 sees it at more
///    than 100 sigma where no draw fails;
///  - a smooth tilt of the pdf by 2 % (pdf (1 + 0.02 x), 1 % rms): moments at 5.5 sigma, seen in two runs
///    of three; at a million samples 10 sigma, seen always (the negative control). The grids alone need ten
///    times as many;
///  - a misplaced narrow peak: the fine grid at any width above 0.01 rad, the half-vector's Jacobian below
///  that (C9);
///  - a gain of 1.02 on a lossless model: no noise at all for constant weights.
struct Survey {
    Outcome fineGrid;       ///< C3: chi-square on 80 x 160 cells in (cos theta, phi)
    Outcome coarseGrid;     ///< C3: chi-square on 10 x 20 cells
    Outcome moments;        ///< C3: means of x, y, z of the samples
    Outcome normalization;  ///< C4: integral of pdf = fraction of draws that succeed
    Outcome albedo;         ///< C7: at most 1; 1 if lossless (radiance scaled by eta^2 at refraction)
    Outcome reflected;      ///< C8: scattered radiance for L(w) = w.z^2 by the two ways
};
constexpr int kOutcomesPerSurvey = 6;
/// The p-value below which an outcome fails. All outcomes of the suite (rows, directions, modes) are one
/// family, which has a failure by chance in one of a thousand runs.
double ConformanceAlpha();
Survey TakeSurvey(const BxDFSetup& s, const SphereIntegrals& integrals, int numSamples, uint64_t seed);

}  // namespace lacquer::test
