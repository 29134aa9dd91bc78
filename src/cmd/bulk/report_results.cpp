// The numbers of the report as JSON.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bulk/ensembles/structure.h"
#include "bulk/table/bulk_problem.h"
#include "cmd/bulk/report.h"
#include "cmd/bulk/report_parts.h"
#include "cmd/bulk/report_sentences.h"

namespace lacquer::cmd {
namespace {

using namespace bulk;
using Json = nlohmann::ordered_json;

/// C, um^2 for each particle, from k^2 C.
void PutCrossSections(Json* entry, const ScatteringAverage& average, double k2) {
    Put(entry, "c_ext", average.extinction, 1 / k2);
    Put(entry, "c_sca", average.scattering, 1 / k2);
    Put(entry, "c_abs", average.absorption, 1 / k2);
}

/// dC/dOmega for each particle [um^2/sr]: the parts that the mode has, the standard error of the file's own,
/// and what theories without clusters say.
/// @param independent  of this wavelength
Json PartsOf(const BulkComputation& computation, const ScatteringAverage& independent, size_t w, double k2) {
    Json parts = Json::object();
    const auto add = [&](const char* name, const ScatteringAverage& average) {
        parts[name] = Short(average.intensity, 1 / k2);
    };
    const BulkSettings& settings = computation.Settings();
    if (settings.method == BulkMethod::Clusters) {
        add("total", computation.AverageAt(w, AverageMode::Aggregate));
        if (settings.mode != AverageMode::Aggregate) {
            add("coherent", computation.AverageAt(w, AverageMode::Chapter));
            add("incoherent", computation.AverageAt(w, AverageMode::Medium));
        }
        parts["error"] = Short(computation.AverageAt(w).intensityError, 1 / k2);
    }
    add("independent", independent);
    const bool isMedium = settings.method == BulkMethod::Structure ||
                          (settings.method == BulkMethod::Clusters && settings.mode == AverageMode::Medium);
    if (isMedium && VolumeFractionOf(computation.Settings().ensemble) > 0)
        add("structure", computation.WithoutClusters(w, BulkMethod::Structure));
    return parts;
}

Json WavelengthOf(const BulkComputation& computation, const BulkTable& table, size_t w) {
    const bool hasClusters = computation.Settings().method == BulkMethod::Clusters;
    const double k = WavenumberOf(computation.Settings(), table.wavelengths[w]), k2 = k * k;
    const double perMillimetre =
        CoefficientOfUnit(computation.Settings(), computation.GetEnsemble(), table.wavelengths[w]);
    Json entry = WavelengthHead(computation, w);
    entry["sigma_s"] = Short(table.sigmaS[w]);
    entry["sigma_a"] = Short(table.sigmaA[w]);
    entry["g"] = Short(table.g[w]);
    if (hasClusters) {
        const ScatteringAverage average = computation.AverageAt(w);
        Put(&entry, "sigma_s", {table.sigmaS[w], table.errorSigmaS[w]});
        Put(&entry, "sigma_a", {table.sigmaA[w], table.errorSigmaA[w]});
        Put(&entry, "g", {table.g[w], ErrorOfG(computation, table, w)});
        PutCrossSections(&entry, average, k2);
        entry["phase_error"] = ShortError(table.errorPhase[w], 1);
        entry["optical_depth"] = Short(OpticalDepthOfBall(computation, table, w));
        entry["history"] = HistoryOf(computation, w, k2);
    }
    entry["phase"] = Short(table.phase[w]);
    const ScatteringAverage independent = computation.WithoutClusters(w, BulkMethod::Independent);
    entry["independent"] = IndependentOf(independent, table.angles, k2, perMillimetre);
    entry["parts"] = PartsOf(computation, independent, w, k2);
    return entry;
}

/// g(r) and S(q) of realisations, beside those of spheres that all have the mean volume.
Json PairsOf(const BulkComputation& computation) {
    const Ensemble& ensemble = computation.GetEnsemble();
    const BulkSettings& settings = computation.Settings();
    const double fraction = VolumeFractionOf(computation.Settings().ensemble);
    if (settings.method != BulkMethod::Clusters || !(ensemble.BallRadius() > 0) || !(fraction > 0) ||
        settings.ensemble.count < 2)
        return nullptr;
    const double diameter = 2 * std::cbrt(fraction / ensemble.NumberDensity() * 3 / (4 * std::numbers::pi));
    constexpr int kNumQ = 60, kNumR = 50;
    constexpr double kMaxQ = 15, kMaxR = 5;  // times the diameter, and over it
    std::vector<double> q, r;
    for (int i = 1; i <= kNumQ; ++i) q.push_back(kMaxQ * i / kNumQ / diameter);
    // Centres of whole spheres stay a radius away from the wall.
    const double radius =
        ensemble.BallRadius() - (settings.ensemble.arrangement == Arrangement::Cut ? 0 : diameter / 2);
    const double width = std::min(kMaxR * diameter, 2 * radius) / kNumR;
    StructureSums sums(q, width, kNumR);
    // As many as were solved, if they are not too many to look at all pairs again.
    constexpr double kMaxPairs = 1e6;
    constexpr int kMaxRealizations = 200;
    const double pairs = 0.5 * settings.ensemble.count * settings.ensemble.count;
    const int count =
        std::min({computation.NumRealizations(), kMaxRealizations, std::max(2, int(kMaxPairs / pairs))});
    for (int i = 0; i < count; ++i) {
        std::vector<Point> centers;
        for (const Particle& particle : ensemble.Realize(settings.seed, uint64_t(i)))
            centers.push_back(particle.center);
        sums.Add(centers);
    }
    std::vector<double> theory, pairTheory;
    for (double& each : q) theory.push_back(PercusYevickStructureFactor(fraction, each *= diameter));
    for (int i = 0; i < kNumR; ++i) {
        r.push_back((i + 0.5) * width / diameter);
        pairTheory.push_back(PercusYevickPairDistribution(fraction, r.back()));
    }
    return {{"realisations", count},
            {"diameter", Short(diameter)},
            {"volume_fraction", Short(fraction)},
            {"q_diameter", Short(q)},
            {"s", Short(sums.StructureFactor())},
            {"s_percus_yevick", Short(theory)},
            {"distance", Short(r)},
            {"g", Short(sums.PairDistribution(radius))},
            {"g_percus_yevick", Short(pairTheory)}};
}

Json SizesOf(const std::vector<SizeResult>& sizes) {
    Json out = Json::array();
    if (sizes.size() < 2) return out;
    for (const SizeResult& size : sizes) {
        Json values = Json::array();
        for (size_t w = 0; w < size.sigmaS.size(); ++w) {
            Json entry = Json::object();
            Put(&entry, "sigma_s", size.sigmaS[w]);
            Put(&entry, "sigma_a", size.sigmaA[w]);
            Put(&entry, "g", size.g[w]);
            values.push_back(std::move(entry));
        }
        out.push_back({{"count", size.count},
                       {"ball_radius", Short(size.ballRadius)},
                       {"wavelengths", std::move(values)}});
    }
    return out;
}

}  // namespace

Json BulkReportResults(const BulkComputation& computation, const BulkTable& table,
                       const BulkReportContext& context) {
    const bool hasClusters = computation.Settings().method == BulkMethod::Clusters;
    Json results = ReportHead(computation, table, CaveatsOf(computation, table), context);
    results["summary"] = SummaryOf(computation, table);
    results["verdict"] = VerdictOn(computation, table);
    if (hasClusters) {
        PutRealizations(&results, computation);
        results["ball_radius"] = Short(computation.GetEnsemble().BallRadius());
    }
    results["angles"] = Short(table.angles);
    results["wavelengths"] = Json::array();
    for (size_t w = 0; w < table.wavelengths.size(); ++w)
        results["wavelengths"].push_back(WavelengthOf(computation, table, w));
    results["pairs"] = PairsOf(computation);
    results["cluster"] = ClusterOf(computation);
    results["sizes"] = SizesOf(context.sizes);
    results["thumbnails"] = Json::array();
    return results;
}

}  // namespace lacquer::cmd
