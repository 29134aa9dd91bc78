#include "cmd/bulk/report_sentences.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cmd/bulk/bulk_plan.h"
#include "cmd/page_parts.h"
#include "pbrt/scattering/oriented_table.h"

namespace lacquer::cmd {
namespace {

using namespace bulk;

constexpr double kMicrometresInMillimetre = 1000;

/// Two digits; the sign of percent stays with its number.
std::string Percent(double share) {
    return share == 0 ? "0\u00a0%" : fmt::format("{:.2g}\u00a0%", 100 * share);
}
std::string Change(double share) { return (share < 0 ? "−" : "+") + Percent(std::abs(share)); }

std::string WavelengthsOf(const BulkHead& table) {
    const std::vector<double>& w = table.wavelengths;
    if (w.size() == 1) return fmt::format("at {:g} nm", w[0]);
    return fmt::format("at {} wavelengths from {:g} to {:g} nm", w.size(), w.front(), w.back());
}

std::string ArrangementText(const Ensemble& ensemble) {
    const bool isOriented = ensemble.Settings().isOriented;
    const std::string ball = fmt::format("a ball of {:.3g}\u00a0µm radius", ensemble.BallRadius());
    switch (ensemble.Settings().arrangement) {
        case Arrangement::Uniform:
            return "without order but that they do not overlap, in " + ball;
        case Arrangement::Cut:
            return "without order but that they do not overlap, in " + ball + " cut out of many more";
        case Arrangement::PoissonDisc:
            return "kept apart from each other, in " + ball;
        case Arrangement::Clumped:
            return "in clumps, in " + ball;
        case Arrangement::Gaussian:
            return isOriented ? "normally distributed about an axis that all realisations share"
                              : "normally distributed about a point";
        case Arrangement::List:
            return isOriented ? "in given places, turned at random about their axis"
                              : "in given places, turned at random as a whole";
    }
    return "";
}

const char* AverageText(AverageMode mode) {
    switch (mode) {
        case AverageMode::Aggregate:
            return "The clusters are the scatterers, far apart from each other (mode aggregate).";
        case AverageMode::Medium:
            return "A cluster is a probe of an endless medium: its mean field, which is refraction and "
                   "diffraction by the probe’s shape, does not count (mode medium).";
        case AverageMode::Chapter:
            return "Only the mean field counts (mode chapter), which does not conserve energy.";
    }
    return "";
}

int NumParticles(const EnsembleComputation& computation) {
    const EnsembleSettings& ensemble = computation.Settings().ensemble;
    return ensemble.arrangement == Arrangement::List ? int(ensemble.particles.size()) : ensemble.count;
}

/// The largest standard error over the wavelengths, relative to the values, and where it is.
struct Worst {
    double error = 0;
    size_t wavelength = 0;
};
Worst WorstRelative(const std::vector<double>& errors, const std::vector<double>& values) {
    Worst worst;
    for (size_t w = 0; w < errors.size(); ++w)
        if (const double error = errors[w] / std::abs(values[w]); error > worst.error) worst = {error, w};
    return worst;
}

/// By how much neighbours change sigma_s to first order, in the middle of the wavelengths.
double ChangeByStructure(const BulkComputation& computation) {
    const size_t middle = computation.Settings().wavelengths.size() / 2;
    return computation.WithoutClusters(middle, BulkMethod::Structure).scattering.mean /
               computation.WithoutClusters(middle, BulkMethod::Independent).scattering.mean -
           1;
}

/// The same one in all realisations, wherever it is.
bool IsOneGivenSphere(const BulkComputation& computation) {
    const EnsembleSettings& ensemble = computation.Settings().ensemble;
    return computation.Settings().mode == AverageMode::Aggregate && ensemble.count == 1 &&
           (ensemble.arrangement == Arrangement::Uniform || ensemble.arrangement == Arrangement::List) &&
           ensemble.species.size() == 1 && ensemble.species[0].radius.Nodes().size() == 1;
}

std::string VerdictOnClusters(const BulkComputation& computation, const BulkTable& table) {
    int count = computation.NumRealizations();
    for (size_t w = 0; w < table.wavelengths.size(); ++w) count = std::min(count, computation.NumAveraged(w));
    if (IsOneGivenSphere(computation)) return "Exact: one sphere scatters as Lorenz–Mie theory says.";
    if (count < 3)
        return fmt::format("{} realisation{} cannot tell how accurate this is; it takes three or more.",
                           count, count == 1 ? "" : "s");
    const Worst sigma = WorstRelative(table.errorSigmaS, table.sigmaS);
    double g = 0;
    for (size_t w = 0; w < table.wavelengths.size(); ++w) g = std::max(g, ErrorOfG(computation, table, w));
    const double phase = *std::max_element(table.errorPhase.begin(), table.errorPhase.end());
    const std::string text = fmt::format(
        "One standard error: {} of σₛ (at {:g} nm, the worst), {:.1g} of g, {} of p on average over "
        "directions. "
        "Four times as many realisations as these {} would halve that",
        Percent(sigma.error), table.wavelengths[sigma.wavelength], g, Percent(phase), count);
    return text +
           (CaveatsOf(computation, table).empty() ? "." : "; what no realisations remove is said below.");
}

std::vector<std::string> CaveatsOnSolutions(const EnsembleComputation& computation) {
    if (computation.NumRefused() == 0) return {};
    return {fmt::format("{} of {} solutions did not converge and are in no average.",
                        computation.NumRefused(),
                        size_t(computation.NumRealizations()) * computation.Settings().wavelengths.size())};
}

void CaveatsOnBall(const BulkComputation& computation, std::vector<std::string>* caveats) {
    const Ensemble& ensemble = computation.GetEnsemble();
    const BulkSettings& settings = computation.Settings();
    if (settings.mode != AverageMode::Medium || !(ensemble.BallRadius() > 0)) return;
    double meanRadius = 0;
    for (size_t s = 0; s < settings.ensemble.species.size(); ++s)
        meanRadius += ensemble.NumberShare(int(s)) * settings.ensemble.species[s].radius.Moment(1);
    constexpr double kDiameters = 5;
    if (ensemble.BallRadius() < kDiameters * meanRadius && settings.ensemble.count > 1)
        caveats->push_back(fmt::format(
            "The ball is {:.2g} particles wide: those at its surface have too few neighbours. Five or more "
            "make a medium.",
            ensemble.BallRadius() / meanRadius));
    if (ensemble.Settings().arrangement != Arrangement::Cut && settings.ensemble.count > 1)
        caveats->push_back(
            "The number of particles is the same in each realisation: too little light goes straight on. "
            "Arrangement cut has numbers that fluctuate as in an endless medium.");
}

}  // namespace

std::string NamesOfSpecies(const EnsembleComputation& computation) {
    std::string names;
    for (const Species& species : computation.Settings().ensemble.species)
        names += (names.empty() ? "" : " + ") + species.name;
    return names;
}

double OpticalDepthOfBall(const BulkComputation& computation, const BulkTable& table, size_t wavelength) {
    return 2 * computation.GetEnsemble().BallRadius() / kMicrometresInMillimetre *
           (table.sigmaS[wavelength] + table.sigmaA[wavelength]);
}

double ErrorOfG(const BulkComputation& computation, const BulkTable& table, size_t wavelength) {
    const ScatteringAverage average = computation.AverageAt(wavelength);
    if (!computation.Settings().removesMultipleScattering) return average.g.error;
    // From the ball's to the medium's as that of p.
    const double ofBall =
        NormOfPhase(table.angles, average.intensityError) / NormOfPhase(table.angles, average.intensity);
    return ofBall > 0 ? average.g.error * table.errorPhase[wavelength] / ofBall : 0;
}

std::string SummaryOf(const EnsembleComputation& computation, const BulkHead& table) {
    const BulkSettings& settings = computation.Settings();
    std::string text = fmt::format("Light scattered by {} in a host of index {:g}, {}",
                                   NamesOfSpecies(computation), settings.hostIndex, WavelengthsOf(table));
    if (VolumeFractionOf(computation.Settings().ensemble) > 0)
        text += fmt::format(", {} by volume", Percent(VolumeFractionOf(computation.Settings().ensemble)));
    if (settings.method == BulkMethod::Independent)
        return text + ". Lorenz–Mie theory of each sphere alone, as if they were far apart.";
    if (settings.method == BulkMethod::Structure)
        return text +
               ". Lorenz–Mie theory of each sphere alone times the structure factor of hard spheres by "
               "Percus "
               "and Yevick.";
    const int count = NumParticles(computation), numRealizations = computation.NumRealizations();
    text += fmt::format(". Maxwell’s equations were solved for {} random realisation{} of ", numRealizations,
                        numRealizations == 1 ? "" : "s");
    text += count == 1 ? "one sphere. "
                       : fmt::format("{}{} spheres {}. ",
                                     settings.ensemble.arrangement == Arrangement::Cut ? "about " : "", count,
                                     ArrangementText(computation.GetEnsemble()));
    text += AverageText(settings.mode);
    if (settings.removesMultipleScattering)
        text +=
            " Light that is scattered several times within a probe has been taken out of the file’s numbers.";
    return text;
}

std::string VerdictOn(const BulkComputation& computation, const BulkTable& table) {
    const BulkSettings& settings = computation.Settings();
    if (settings.method == BulkMethod::Clusters) return VerdictOnClusters(computation, table);
    const double fraction = VolumeFractionOf(computation.Settings().ensemble);
    const double change = fraction > 0 ? ChangeByStructure(computation) : 0;
    const double wavelength = table.wavelengths[table.wavelengths.size() / 2];
    if (settings.method == BulkMethod::Independent)
        return fmt::format(
            "Exact for spheres that are far apart, and without noise. At {} by volume their "
            "order alone would change σₛ by {} at {:g} nm.",
            Percent(fraction), Change(change), wavelength);
    return fmt::format(
        "Without noise, and right to first order in the neighbours: their order changes σₛ by "
        "{} at {:g} nm. What near fields change takes clusters to know.",
        Change(change), wavelength);
}

std::string VerdictOn(const OrientedComputation& computation, const OrientedBulkTable& table) {
    constexpr int kNeeded = OrientedSums::kNumGroups + 2;
    int count = computation.NumRealizations();
    for (size_t w = 0; w < table.wavelengths.size(); ++w) count = std::min(count, computation.NumAveraged(w));
    const double changed = *std::max_element(table.errorReciprocity.begin(), table.errorReciprocity.end());
    const std::string reciprocity =
        fmt::format(" Making p reciprocal has changed {} of the light.", Percent(changed));
    if (table.errorSigmaS.empty())
        return fmt::format("{} realisation{} cannot tell how accurate this is; it takes {} or more.", count,
                           count == 1 ? "" : "s", kNeeded) +
               reciprocity;
    const OrientedGrid grid(table);
    std::vector<double> means;
    for (const std::vector<double>& sigma : table.sigmaS) means.push_back(grid.MeanOverIncidences(sigma));
    const Worst sigma = WorstRelative(table.errorSigmaS, means);
    const double phase = *std::max_element(table.errorPhase.begin(), table.errorPhase.end());
    return fmt::format(
               "One standard error: {} of σₛ, the mean over all directions (at {:g} nm, the worst), {} of p "
               "on average. Four times as many realisations as these {} would halve that.",
               Percent(sigma.error), table.wavelengths[sigma.wavelength], Percent(phase), count) +
           reciprocity;
}

std::vector<std::string> CaveatsOf(const OrientedComputation& computation) {
    std::vector<std::string> caveats = CaveatsOnSolutions(computation);
    const BulkSettings& settings = computation.Settings();
    for (const std::string& warning : WarningsOf(settings, PlanOf(settings, computation.Oriented())))
        caveats.push_back(Sentence(warning));
    return caveats;
}

std::vector<std::string> CaveatsOf(const BulkComputation& computation, const BulkTable& table) {
    std::vector<std::string> caveats;
    const BulkSettings& settings = computation.Settings();
    if (settings.method == BulkMethod::Clusters) {
        caveats = CaveatsOnSolutions(computation);
        for (const std::string& warning : WarningsOf(settings, PlanOf(settings)))
            caveats.push_back(Sentence(warning));
        CaveatsOnBall(computation, &caveats);
        if (settings.mode == AverageMode::Chapter) {
            const size_t w = table.wavelengths.size() / 2;
            const ScatteringAverage average = computation.AverageAt(w);
            const double lost =
                1 - (average.scattering.mean + average.absorption.mean) / average.extinction.mean;
            caveats.push_back(
                fmt::format("{} of the extinction at {:g} nm is neither absorbed nor in this table.",
                            Percent(lost), table.wavelengths[w]));
        }
    }
    return caveats;
}

}  // namespace lacquer::cmd
