// Phase function "bulk": a table that "lacquer bulk" has computed from particles (docs/bulk.md).
//
//   "string bulk"  required  the file, which has the coefficients of its medium or slab, too: sigma_a,
//                            sigma_s, sigma_t, albedo, g and preset may not stand beside it
//   "vector3 orientation", "string orientationmap": as for "sggx"; the axis of an oriented ensemble, for the
//                            files of those only
#include "pbrt/phases/bulk.h"

#include <fmt/format.h>

#include "pbrt/core/params.h"
#include "pbrt/phases/oriented_file.h"

namespace lacquer {
namespace {

PhaseNumbers NumbersOf(const BulkTable& table) {
    PhaseNumbers numbers;
    numbers.wavelengths.assign(table.wavelengths.begin(), table.wavelengths.end());
    numbers.angles.assign(table.angles.begin(), table.angles.end());
    for (const std::vector<double>& row : table.phase)
        numbers.values.insert(numbers.values.end(), row.begin(), row.end());
    return numbers;
}

/// @param values  one for each wavelength of the table
DenselySampledSpectrum SpectrumOf(const BulkTable& table, const std::vector<double>& values) {
    return DenselySampledSpectrum([&](float lambda) {
        const std::vector<double>& nodes = table.wavelengths;
        const double at = std::clamp(double(lambda), nodes.front(), nodes.back());
        const size_t above = size_t(std::lower_bound(nodes.begin(), nodes.end(), at) - nodes.begin());
        if (above == 0) return float(values[0]);
        const double x = (at - nodes[above - 1]) / (nodes[above] - nodes[above - 1]);
        return float((1 - x) * values[above - 1] + x * values[above]);
    });
}

/// "below 450 nm", "above 650 nm" or both: what the eye sees, and the table does not have. Empty: nothing.
std::string MissingRange(const BulkHead& table) {
    constexpr double kFirst = 400, kLast = 700;
    const double first = table.wavelengths.front(), last = table.wavelengths.back();
    std::string missing;
    if (first > kFirst) missing = fmt::format("below {} nm", first);
    if (last < kLast) missing += fmt::format("{}above {} nm", missing.empty() ? "" : " and ", last);
    return missing;
}

}  // namespace

BulkPhaseModel::BulkPhaseModel(const BulkHead& head, const std::string& path, const FileLoc& loc,
                               DenselySampledSpectrum sigmaA, DenselySampledSpectrum sigmaS)
    : sigmaA_(std::move(sigmaA)), sigmaS_(std::move(sigmaS)), hostIndex_(head.hostIndex) {
    if (const std::string missing = MissingRange(head); !missing.empty())
        warnings_.push_back(
            {Diagnostic::Severity::Warning, loc,
             fmt::format("{} has nothing {}; the nearest of its wavelengths stands for others", path,
                         missing)});
}

DenselySampledSpectrum BulkPhaseModel::SigmaT() const {
    return DenselySampledSpectrum(
        [&](float lambda) { return sigmaA_.Evaluate(lambda) + sigmaS_.Evaluate(lambda); });
}

DenselySampledSpectrum BulkPhaseModel::Albedo() const {
    return DenselySampledSpectrum([&](float lambda) {
        const float scattered = sigmaS_.Evaluate(lambda), all = sigmaA_.Evaluate(lambda) + scattered;
        return all > 0 ? scattered / all : 0.f;
    });
}

IsotropicBulkModel::IsotropicBulkModel(const BulkTable& table, const std::string& path, const FileLoc& loc)
    : BulkPhaseModel(table, path, loc, SpectrumOf(table, table.sigmaA), SpectrumOf(table, table.sigmaS)),
      phase_(NumbersOf(table)) {}

OrientedBulkModel::OrientedBulkModel(const OrientedBulkTable& table, const std::string& path,
                                     const FileLoc& loc, Orientation orientation, OrientedPhaseTable phase)
    : BulkPhaseModel(table, path, loc, DenselySampledSpectrum([&](float lambda) {
                         return phase.MeanExtinction(lambda) * (1 - phase.LargestAlbedo());
                     }),
                     DenselySampledSpectrum(
                         [&](float lambda) { return phase.MeanExtinction(lambda) * phase.LargestAlbedo(); })),
      phase_(std::move(phase)),
      orientation_(std::move(orientation)) {}

void RefuseBesideBulk(const Params& params) {
    if (!params.Has("bulk")) return;
    for (const char* other : {"sigma_a", "sigma_s", "sigma_t", "albedo", "g", "preset"})
        if (params.Has(other))
            params.Fail(other,
                        fmt::format("\"{}\" is given beside \"bulk\", which says it as well; remove one "
                                    "of them",
                                    other));
}

namespace {

/// Floats have room for any scale and density; see ReadCoefficients().
void RequireModerate(const std::vector<double>& sigma, const std::string& path) {
    constexpr double kMaxSigma = 1e30;
    if (const double largest = *std::max_element(sigma.begin(), sigma.end()); largest > kMaxSigma)
        throw SceneError({path, 0, 0},
                         fmt::format("a coefficient is {} per mm; expected at most {}", largest, kMaxSigma));
}

std::unique_ptr<PhaseModel> CreateIsotropic(const PhaseArgs& args, const BulkTable& table,
                                            const std::string& path, const FileLoc& loc) {
    for (const std::string_view name : {Orientation::kParameter, Orientation::kMapParameter})
        if (args.params.Has(name))
            args.params.Fail(name, fmt::format("\"{}\" has no effect: the file of \"bulk\" is of an "
                                               "isotropic medium; expected that of an oriented ensemble",
                                               name));
    if (const std::string why = WhyTooNarrow(NumbersOf(table)); !why.empty())
        throw SceneError({path, 0, 0}, why);
    for (const auto* list : {&table.sigmaA, &table.sigmaS}) RequireModerate(*list, path);
    return std::make_unique<IsotropicBulkModel>(table, path, loc);
}

std::unique_ptr<PhaseModel> CreateOriented(const PhaseArgs& args, OrientedBulkTable table,
                                           const std::string& path, const FileLoc& loc) {
    for (const auto* rows : {&table.sigmaA, &table.sigmaS})
        for (const std::vector<double>& row : *rows) RequireModerate(row, path);
    Orientation orientation = Orientation::Read(args);
    ReadOrientedPhase(path, loc, &table);
    return std::make_unique<OrientedBulkModel>(table, path, loc, std::move(orientation));
}

std::unique_ptr<PhaseModel> Create(const PhaseArgs& args) {
    const Params& params = args.params;
    if (!params.GetOptionalString("bulk"))
        params.Fail("bulk", "the phase function \"bulk\" needs \"string bulk\", a file of \"lacquer bulk\"");
    const std::string path = params.PathOf("bulk");
    const FileLoc loc = params.LocOf("bulk");
    auto table = ReadBulkFile(path, loc);
    if (auto* oriented = std::get_if<OrientedBulkTable>(&table))
        return CreateOriented(args, std::move(*oriented), path, loc);
    return CreateIsotropic(args, std::get<BulkTable>(table), path, loc);
}

constexpr std::string_view kParameters[] = {"bulk", Orientation::kParameter, Orientation::kMapParameter};
constexpr PhasePlugin kPlugin{Create, kParameters};

}  // namespace

LACQUER_REGISTER(PhaseKind, "bulk", &kPlugin);

}  // namespace lacquer
