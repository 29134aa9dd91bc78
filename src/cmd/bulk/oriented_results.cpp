// The numbers of the report of an oriented ensemble as JSON.
#include <algorithm>
#include <numbers>

#include "bulk/table/bulk_problem.h"
#include "cmd/bulk/report.h"
#include "cmd/bulk/report_parts.h"
#include "cmd/bulk/report_sentences.h"
#include "pbrt/scattering/oriented_table.h"

namespace lacquer::cmd {
namespace {

using namespace bulk;
using Json = nlohmann::ordered_json;

/// Incidences whose phase function is shown: those next to 0, 30, 60 and 90 degrees.
std::vector<size_t> ShownIncidences(const OrientedBulkTable& table) {
    std::vector<size_t> shown;
    const size_t last = table.NumIncidences() - 1;
    for (size_t third = 0; third <= 3; ++third) {
        const size_t incidence = (third * last + 1) / 3;
        if (shown.empty() || shown.back() != incidence) shown.push_back(incidence);
    }
    return shown;
}

/// p in the plane of the axis and the incident light: angles to the axis from 0 to 360 degrees, up to 180 on
/// the side of the incident azimuth.
Json SliceOf(const OrientedBulkTable& table, size_t w, size_t incidence) {
    const OrientedGrid grid(table);
    std::vector<double> angles, values;
    const auto add = [&](double angle, size_t j, size_t azimuth) {
        angles.push_back(angle);
        values.push_back(double(table.phase[w][grid.Index(incidence, j) + azimuth]));
    };
    for (size_t j = 0; j < grid.NumAngles(); ++j) add(table.angles[j], j, 0);
    for (size_t j = grid.NumAngles() - 1; j-- > 1;) add(360 - table.angles[j], j, grid.NumAzimuths() - 1);
    return {{"incidence", Short(table.angles[incidence])}, {"angles", Short(angles)}, {"p", Short(values)}};
}

/// Coefficients as the file has them, albedo and g for each incidence, with standard errors.
Json IncidencesOf(const OrientedComputation& computation, const OrientedBulkTable& table, size_t w,
                  double perMillimetre) {
    Json out = Json::array();
    const std::vector<OrientedMeans> means = computation.MeansOfIncidences(w);
    for (size_t i = 0; i < means.size(); ++i) {
        Json entry{{"angle", Short(table.angles[i])}};
        Put(&entry, "sigma_t", means[i].sum, perMillimetre);
        Put(&entry, "sigma_s", means[i].scattering, perMillimetre);
        Put(&entry, "sigma_a", means[i].absorption, perMillimetre);
        Put(&entry, "albedo", means[i].albedo);
        Put(&entry, "g", means[i].g);
        out.push_back(std::move(entry));
    }
    return out;
}

Json WavelengthOf(const OrientedComputation& computation, const OrientedBulkTable& table,
                  const BulkComputation& alone, size_t w) {
    const double k = computation.Wavenumber(w), k2 = k * k;
    const double perMillimetre =
        CoefficientOfUnit(computation.Settings(), computation.GetEnsemble(), table.wavelengths[w]);
    const OrientedMeans means = computation.MeansOverIncidences(w);
    Json entry = WavelengthHead(computation, w);
    Put(&entry, "sigma_s", means.scattering, perMillimetre);
    Put(&entry, "sigma_a", means.absorption, perMillimetre);
    Put(&entry, "g", means.g);
    Put(&entry, "albedo", means.albedo);
    Put(&entry, "c_ext", means.extinction, 1 / k2);
    Put(&entry, "c_sca", means.scattering, 1 / k2);
    entry["phase_error"] = table.errorPhase.empty() ? 0 : ShortError(table.errorPhase[w], 1);
    entry["reciprocity_change"] = Short(table.errorReciprocity[w]);
    entry["history"] = HistoryOf(computation, w, k2);
    entry["incidences"] = IncidencesOf(computation, table, w, perMillimetre);
    entry["slices"] = Json::array();
    for (const size_t incidence : ShownIncidences(table))
        entry["slices"].push_back(SliceOf(table, w, incidence));
    const ScatteringAverage independent = alone.WithoutClusters(w, BulkMethod::Independent);
    std::vector<double> angles;
    for (const double theta : EvenAngles(int(independent.intensity.size()) - 1))
        angles.push_back(theta * 180 / std::numbers::pi);
    entry["independent"] = IndependentOf(independent, angles, k2, perMillimetre);
    return entry;
}

}  // namespace

Json OrientedReportResults(const OrientedComputation& computation, const OrientedBulkTable& table,
                           const BulkReportContext& context) {
    BulkSettings settings = computation.Settings();
    settings.method = BulkMethod::Independent;
    const BulkComputation alone(settings);
    Json results = ReportHead(computation, table, CaveatsOf(computation), context);
    results["summary"] = SummaryOf(computation, table);
    results["verdict"] = VerdictOn(computation, table);
    PutRealizations(&results, computation);
    results["ball_radius"] = 0;
    results["oriented"] = {{"incidences", table.NumIncidences()},
                           {"angles", table.angles.size()},
                           {"azimuths", table.numAzimuths}};
    results["angles"] = Short(alone.Table().angles);
    results["wavelengths"] = Json::array();
    for (size_t w = 0; w < table.wavelengths.size(); ++w)
        results["wavelengths"].push_back(WavelengthOf(computation, table, alone, w));
    results["pairs"] = nullptr;
    results["cluster"] = ClusterOf(computation);
    results["sizes"] = Json::array();
    results["thumbnails"] = Json::array();
    return results;
}

}  // namespace lacquer::cmd
