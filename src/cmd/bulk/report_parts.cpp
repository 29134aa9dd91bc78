#include "cmd/bulk/report_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "bulk/table/bulk_problem.h"
#include "cmd/bulk/report_sentences.h"
#include "cmd/version.h"

namespace lacquer::cmd {

using namespace bulk;
namespace {
using Json = nlohmann::ordered_json;
}  // namespace

double Short(double value) {
    return std::isfinite(value) ? std::strtod(fmt::format("{:.5e}", value).c_str(), nullptr) : value;
}
Json Short(const std::vector<double>& values, double scale) {
    Json out = Json::array();
    for (const double value : values) out.push_back(Short(scale * value));
    return out;
}

namespace {

Json SpeciesOf(const EnsembleComputation& computation) {
    const BulkSettings& settings = computation.Settings();
    Json out = Json::array();
    for (size_t s = 0; s < settings.ensemble.species.size(); ++s) {
        const Species& species = settings.ensemble.species[s];
        Json n = Json::array(), k = Json::array();
        for (const double w : settings.wavelengths) {
            const Complex index = settings.indices[s].At(w);
            n.push_back(Short(index.real()));
            k.push_back(Short(index.imag()));
        }
        out.push_back({{"name", species.name},
                       {"volume_fraction", Short(species.volumeFraction)},
                       {"number_share", Short(computation.GetEnsemble().NumberShare(int(s)))},
                       {"mean_radius", Short(species.radius.Moment(1))},
                       {"largest_radius", Short(species.radius.Largest())},
                       {"n", n},
                       {"k", k}});
    }
    return out;
}

}  // namespace

double ShortError(double error, double value) {
    constexpr double kRounding = 1e-9;
    return error <= kRounding * std::abs(value) ? 0 : Short(error);
}

void Put(Json* entry, const std::string& key, const ScatteringAverage::Value& value, double scale) {
    (*entry)[key] = Short(scale * value.mean);
    (*entry)[key + "_error"] = ShortError(scale * value.error, scale * value.mean);
}

Json HistoryOf(const EnsembleComputation& computation, size_t w, double k2) {
    Json out = Json::array();
    for (const ConvergencePoint& point : computation.History(w)) {
        Json entry{{"realisations", point.numRealizations}};
        Put(&entry, "c_ext", point.extinction, 1 / k2);
        Put(&entry, "c_sca", point.scattering, 1 / k2);
        Put(&entry, "g", point.g);
        out.push_back(std::move(entry));
    }
    return out;
}

Json IndependentOf(const ScatteringAverage& average, const std::vector<double>& angles, double k2,
                   double perMillimetre) {
    return {{"c_ext", Short(average.extinction.mean / k2)},
            {"c_sca", Short(average.scattering.mean / k2)},
            {"g", Short(average.g.mean)},
            {"sigma_s", Short(average.scattering.mean * perMillimetre)},
            {"sigma_a", Short(average.absorption.mean * perMillimetre)},
            {"phase", Short(average.intensity, 1 / NormOfPhase(angles, average.intensity))}};
}

Json ClusterOf(const EnsembleComputation& computation) {
    if (computation.Settings().method != BulkMethod::Clusters) return nullptr;
    constexpr size_t kMaxSpheres = 3000;
    std::vector<Particle> particles = computation.GetEnsemble().Realize(computation.Settings().seed, 0);
    const size_t count = particles.size();
    if (count == 0) return nullptr;
    if (count > kMaxSpheres) particles.resize(kMaxSpheres);
    Json spheres = Json::array();
    for (const Particle& p : particles)
        spheres.push_back(
            {Short(p.center.x()), Short(p.center.y()), Short(p.center.z()), Short(p.radius), p.species});
    return {{"count", count}, {"spheres", std::move(spheres)}};
}

Json ReportHead(const EnsembleComputation& computation, const BulkHead& table,
                std::vector<std::string> warnings, const BulkReportContext& context) {
    constexpr double kBlue = 400, kRed = 700;  // [nm]
    if (table.wavelengths.front() > kBlue || table.wavelengths.back() < kRed)
        warnings.push_back("The wavelengths do not span 400 to 700 nm: beyond them scenes use the nearest.");
    return {{"schema", "lacquer-bulk-report-1"},
            {"version", kVersion},
            {"title", NamesOfSpecies(computation)},
            {"command", context.command},
            {"input", context.input},
            {"warnings", warnings},
            {"mode", table.mode},
            {"host_index", computation.Settings().hostIndex},
            {"species", SpeciesOf(computation)}};
}

void PutRealizations(Json* results, const EnsembleComputation& computation) {
    (*results)["realisations"] = computation.NumRealizations();
    (*results)["refused"] = computation.NumRefused();
    (*results)["worst_energy_error"] = computation.WorstEnergyError();
}

Json WavelengthHead(const EnsembleComputation& computation, size_t w) {
    const BulkSettings& settings = computation.Settings();
    const double x = computation.Wavenumber(w) * LargestRadius(settings);
    const bool hasClusters = settings.method == BulkMethod::Clusters;
    return {{"wavelength", settings.wavelengths[w]},
            {"largest_size_parameter", Short(x)},
            {"degree", MieDegree(x) + (hasClusters ? settings.realization.extraDegree : 0)}};
}

}  // namespace lacquer::cmd
