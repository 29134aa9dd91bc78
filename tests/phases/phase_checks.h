// What every phase function must hold, as checks that say yes or no.
#pragma once

#include <fmt/format.h>

#include <vector>

#include "pbrt/base/phase_function.h"
#include "pbrt/core/sampling.h"
#include "support/lanes.h"
#include "support/statistics.h"

namespace lacquer::test {

/// Wavelengths of Four().
inline constexpr int kNumTested = 4;
/// 450, 550, 650 and 750 nm in turn. @param first  of these
inline SampledWavelengths Four(int first = 0) {
    const auto nm = [first](int i) { return 450 + 100 * float((first + i) % kNumTested); };
    return SampledWavelengths::At(Lanes(nm(0), nm(1), nm(2), nm(3)));
}

/// What a phase function is at one of the wavelengths.
class AtWavelength final : public PhaseFunction {
  public:
    AtWavelength(const PhaseFunction& phase, int wavelength) : phase_(phase), wavelength_(wavelength) {}
    PhaseValue Evaluate(Vec3 wo, Vec3 wi) const override {
        const SpectralPhaseValue value = phase_.EvaluateSpectral(wo, wi);
        return {value.p[wavelength_], value.pdf[wavelength_], value.pdfReverse[wavelength_]};
    }
    PhaseSample Sample(Vec3 wo, Rng& rng) const override {
        const Vec3 wi = phase_.SampleAt(wavelength_, wo, rng);
        const PhaseValue value = Evaluate(wo, wi);
        return {wi, value.p / value.pdf, value.pdf, value.pdfReverse};
    }
    float Extinction(Vec3 w) const override { return phase_.FactorsAlong(w, Four()).extinction[wavelength_]; }
    float Albedo(Vec3 w) const override { return phase_.FactorsAlong(w, Four()).albedo[wavelength_]; }
    bool HasDirectionalExtinction() const override { return phase_.HasDirectionalExtinction(); }

  private:
    const PhaseFunction& phase_;
    int wavelength_;
};

/// Cells of the sphere about an axis, in t = 1 - cos and azimuth.
struct SphereGrid {
    Frame frame;
    std::vector<double> edges;  ///< of t, from 0 to 2
    int numAzimuths = 8;
    int subT = 16, subAzimuth = 2;  ///< points per cell of quadratures

    /// Cells that resolve lobes of any width along the axis.
    static SphereGrid Geometric(Vec3 axis) {
        SphereGrid grid{.frame = Frame::FromZ(axis), .edges = {0}};
        constexpr int kCells = 48;
        for (int i = 0; i <= kCells; ++i) grid.edges.push_back(2 * std::pow(1e-11, 1 - double(i) / kCells));
        return grid;
    }
    /// For lobes that change with the azimuth at any distance from either end of the axis.
    static SphereGrid Fine(Vec3 axis, int pointsPerAzimuth = 80) {
        SphereGrid grid{.frame = Frame::FromZ(axis), .edges = {0}, .numAzimuths = 12};
        grid.subAzimuth = pointsPerAzimuth;
        constexpr int kNear = 12, kFar = 36;
        constexpr double kEnd = 0.05;
        const auto nearStep = [](int i) { return kEnd * std::pow(1e-5, 1 - double(i) / kNear); };
        for (int i = 0; i < kNear; ++i) grid.edges.push_back(nearStep(i));
        for (int i = 0; i <= kFar; ++i) grid.edges.push_back(kEnd + (2 - 2 * kEnd) * double(i) / kFar);
        for (int i = kNear; i-- > 0;) grid.edges.push_back(2 - nearStep(i));
        grid.edges.push_back(2);
        return grid;
    }
    size_t NumCells() const { return (edges.size() - 1) * size_t(numAzimuths); }

    Vec3 Direction(double t, double phi) const {
        const double sine = std::sqrt(t * (2 - t)), x = sine * std::cos(phi), y = sine * std::sin(phi);
        // In double, for the difference from the axis is small.
        const auto component = [&](int k) {
            return float((1 - t) * double(frame.z[k]) + x * double(frame.x[k]) + y * double(frame.y[k]));
        };
        return {component(0), component(1), component(2)};
    }
    size_t CellOf(Vec3 w) const {
        double t = 0, x = 0, y = 0;
        for (int k = 0; k < 3; ++k) {
            t += 0.5 * Sqr(double(w[k]) - double(frame.z[k]));
            x += double(w[k]) * double(frame.x[k]);
            y += double(w[k]) * double(frame.y[k]);
        }
        const auto above = std::upper_bound(edges.begin() + 1, edges.end() - 1, t);
        const double turn = std::atan2(y, x) / (2 * M_PI) + 1;
        const int azimuth = std::min(int((turn - std::floor(turn)) * numAzimuths), numAzimuths - 1);
        return size_t(above - edges.begin() - 1) * size_t(numAzimuths) + size_t(azimuth);
    }
    /// Integrals of f(w) over the cells, by midpoints.
    template <class Function>
    std::vector<double> Integrals(const Function& f) const {
        std::vector<double> cells(NumCells());
        for (size_t i = 0; i + 1 < edges.size(); ++i) {
            const double dt = (edges[i + 1] - edges[i]) / subT;
            const double dPhi = 2 * M_PI / (numAzimuths * subAzimuth);
            for (int j = 0; j < subT; ++j)
                for (int k = 0; k < numAzimuths * subAzimuth; ++k)
                    cells[i * size_t(numAzimuths) + size_t(k / subAzimuth)] +=
                        double(f(Direction(edges[i] + (j + 0.5) * dt, (k + 0.5) * dPhi))) * dt * dPhi;
        }
        return cells;
    }
    template <class Function>
    double Integral(const Function& f) const {
        double sum = 0;
        for (const double cell : Integrals(f)) sum += cell;
        return sum;
    }
};

/// Pearson's test of directions drawn by `sampler` against the pdf of `model`.
inline Outcome SamplesFollow(const PhaseFunction& sampler, const PhaseFunction& model, Vec3 wo,
                             const SphereGrid& grid, uint64_t seed, int numSamples = 200000) {
    std::vector<double> observed(grid.NumCells());
    std::vector<double> expected = grid.Integrals([&](Vec3 wi) { return model.Evaluate(wo, wi).pdf; });
    for (double& cell : expected) cell *= numSamples;
    Rng rng(seed);
    for (int i = 0; i < numSamples; ++i) ++observed[grid.CellOf(sampler.Sample(wo, rng).wi)];
    return ChiSquareTest(observed, expected);
}

/// Largest relative difference of Extinction(wo) Albedo(wo) p(wo, wi) from that with wo and wi exchanged.
inline double ReciprocityError(const PhaseFunction& phase, uint64_t seed) {
    Rng rng(seed);
    double worst = 0;
    for (int i = 0; i < 2000; ++i) {
        const Vec3 wo = SampleUniformSphere(rng.Uniform2D());
        const Vec3 wi = i % 2 ? phase.Sample(wo, rng).wi : SampleUniformSphere(rng.Uniform2D());
        const double there = double(phase.Extinction(wo) * phase.Albedo(wo) * phase.Evaluate(wo, wi).p);
        const double back = double(phase.Extinction(wi) * phase.Albedo(wi) * phase.Evaluate(wi, wo).p);
        if (there != back) worst = std::max(worst, std::abs(there - back) / std::max(there, back));
    }
    return worst;
}

/// Records agree with Evaluate(): the same pdf, weight p / pdf, unit directions; pdfReverse is the pdf of the
/// exchanged pair; p = pdf, for all of ours draw exactly. Finite and positive, also straight on and back.
/// `tolerance` is relative: the same query may be compiled twice with different contractions of products.
inline testing::AssertionResult RecordsAreConsistent(const PhaseFunction& phase, uint64_t seed,
                                                     float tolerance = 1e-5f) {
    const auto fine = [](float x) { return x >= 0 && x <= std::numeric_limits<float>::max(); };
    const auto close = [&](float a, float b) { return std::abs(a - b) <= tolerance * std::max(a, b); };
    Rng rng(seed);
    for (int i = 0; i < 5000; ++i) {
        const Vec3 special[] = {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}, {0.6f, 0, -0.8f}};
        const Vec3 wo = i < 4 ? special[i] : SampleUniformSphere(rng.Uniform2D());
        const PhaseSample sample = phase.Sample(wo, rng);
        for (const Vec3 wi : {sample.wi, wo, -wo, SampleUniformSphere(rng.Uniform2D())}) {
            const PhaseValue value = phase.Evaluate(wo, wi), exchanged = phase.Evaluate(wi, wo);
            if (!fine(value.p) || !close(value.p, value.pdf) || !close(value.pdfReverse, exchanged.pdf))
                return testing::AssertionFailure()
                       << fmt::format("p {} pdf {} reverse {} exchanged {}", value.p, value.pdf,
                                      value.pdfReverse, exchanged.pdf);
        }
        const PhaseValue value = phase.Evaluate(wo, sample.wi);
        if (!close(sample.pdf, value.pdf) || !close(sample.pdfReverse, value.pdfReverse) ||
            !(sample.pdf > 0) || !close(sample.weight, 1) || std::abs(Length(sample.wi) - 1) > 5e-7f ||
            !fine(phase.Extinction(wo)))
            return testing::AssertionFailure()
                   << fmt::format("sample {}: pdf {} and {}, weight {}, length {}", i, sample.pdf, value.pdf,
                                  sample.weight, Length(sample.wi));
    }
    return testing::AssertionSuccess();
}

}  // namespace lacquer::test
