#include "layered/stack_cases.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <mutex>

#include "pbrt/bxdfs/conductor.h"
#include "pbrt/bxdfs/dielectric.h"
#include "pbrt/bxdfs/diffuse.h"
#include "pbrt/bxdfs/diffuse_transmission.h"
#include "pbrt/bxdfs/flakes.h"
#include "pbrt/bxdfs/multiscatter_conductor.h"
#include "pbrt/bxdfs/multiscatter_dielectric.h"
#include "pbrt/core/check.h"
#include "pbrt/core/params.h"
#include "pbrt/phases/fibre.h"
#include "pbrt/phases/hg.h"
#include "pbrt/phases/isotropic.h"
#include "pbrt/phases/mixture.h"
#include "pbrt/phases/oriented.h"
#include "pbrt/phases/sggx.h"
#include "pbrt/phases/table.h"
#include "pbrt/phases/vmf.h"
#include "pbrt/scattering/oriented_table.h"
#include "support/material_bxdf.h"

namespace lacquer::layered::test {

namespace {

constexpr size_t kMaxInterfaces = 64;

template <template <class> class Model, class... Args>
BxDF* NewFaceted(Arena& arena, MicrofacetModel model, Alphas alphas, Args... args) {
    if (model == kGGX) return arena.New<Model<TrowbridgeReitz>>(alphas, args...);
    return arena.New<Model<Beckmann>>(alphas, args...);
}

}  // namespace

// ---- Strategies ---------------------------------------------------------------------------------------

namespace {

/// What follows the name in "multiproduct:5" or "pairproduct:all:9": a number is that of events, a word names
/// strategies.
std::vector<Parameter> ParametersOf(const std::string& name) {
    std::vector<Parameter> parameters;
    const std::string prefix = name.starts_with("pair") ? "pair" : "product";
    for (size_t at = name.find(':'); at != std::string::npos;) {
        const size_t end = name.find(':', at + 1);
        const std::string part = name.substr(at + 1, end - at - 1);
        Parameter& p = parameters.emplace_back();
        const bool isNumber = part.find_first_not_of("0123456789") == std::string::npos;
        p.type = isNumber ? "integer" : "string";
        p.name = prefix + (isNumber ? "events" : "strategies");
        p.kind = isNumber ? Parameter::Values::Integers : Parameter::Values::Strings;
        if (isNumber)
            p.integers = {std::stoi(part)};
        else
            p.strings = {part};
        at = end;
    }
    return parameters;
}

/// The object of a kind, with parameters behind its name as above, made at first use and kept.
template <class Kind, class Strategy>
const Strategy* FindStrategy(const std::string& name) {
    static std::mutex mutex;
    static std::map<std::string, std::unique_ptr<const Strategy>> made;
    const std::lock_guard lock(mutex);
    std::unique_ptr<const Strategy>& strategy = made[name];
    if (strategy) return strategy.get();
    const size_t end = std::min(name.find(':'), name.size());
    const auto factory = Registry<Kind>::Find(name.substr(0, end));
    LACQUER_CHECK(factory);
    const Params params("estimator", {}, ParametersOf(name), nullptr);
    strategy = factory(params);
    params.CheckAllUsed();
    return strategy.get();
}

}  // namespace

const LayeredEstimator* FindEstimator(const std::string& name) {
    return FindStrategy<LayeredEstimatorKind, LayeredEstimator>(name);
}
std::vector<std::string> UnbiasedEstimators() {
    std::vector<std::string> names = Registry<LayeredEstimatorKind>::Names();
    std::erase_if(names, [](const std::string& name) {
        return Registry<LayeredEstimatorKind>::TraitsOf(name).isApproximate;
    });
    return names;
}

const LayeredPdf* FindPdf(const std::string& name) { return FindStrategy<LayeredPdfKind, LayeredPdf>(name); }

// ---- Building -----------------------------------------------------------------------------------------

void StackBuilder::AddInterface(BxDF* bxdf, float eta) {
    if (slabs_.size() < interfaces_.size()) slabs_.emplace_back();
    interfaces_.push_back(isTurned_ ? StackInterface(bxdf, frame_) : StackInterface(bxdf));
    bxdfs_.push_back(bxdf);
    eta_ *= eta;
    isTurned_ = false;
}

void StackBuilder::AddSlab(const Slab& slab) {
    LACQUER_CHECK(slabs_.size() + 1 == interfaces_.size());
    slabs_.push_back(slab);
}

void StackBuilder::TurnNext(Vec3 normal, float deg) {
    const Frame projected = Frame::FromZX(Normalize(normal), {1, 0, 0});
    const float c = std::cos(Radians(deg)), s = std::sin(Radians(deg));
    frame_ = {c * projected.x + s * projected.y, c * projected.y - s * projected.x, projected.z};
    isTurned_ = true;
}

StackBuilder::Arrays StackBuilder::ToArena() const {
    LACQUER_CHECK(!interfaces_.empty() && interfaces_.size() <= kMaxInterfaces &&
                  slabs_.size() + 1 == interfaces_.size());
    const auto copy = [this]<class T>(const std::vector<T>& from) {
        auto& to = *arena_.New<std::array<T, kMaxInterfaces>>();
        std::copy(from.begin(), from.end(), to.begin());
        return std::span<T>(to.data(), from.size());
    };
    return {copy(interfaces_), copy(bxdfs_), copy(slabs_)};
}

Stack StackBuilder::Build() const {
    const Arrays arrays = ToArena();
    return {arrays.interfaces, arrays.slabs, eta_};
}

const LayeredBxDF* StackBuilder::BuildBxDF(const LayeredOptions& options) const {
    const Arrays arrays = ToArena();
    const Stack stack{arrays.interfaces, arrays.slabs, eta_};
    return arena_.New<LayeredBxDF>(stack, arrays.interfaces, arrays.bxdfs, options);
}

// ---- Interfaces ---------------------------------------------------------------------------------------

Layer Dielectric(Alphas alphas, float eta, MicrofacetModel model) {
    return [=](StackBuilder& b) {
        b.AddInterface(NewFaceted<DielectricBxDF>(b.Memory(), model, alphas, eta), eta);
    };
}
Layer Dielectric(float alpha, float eta, MicrofacetModel model) {
    return Dielectric(Alphas(alpha, alpha), eta, model);
}
Layer Metal(Alphas alphas, MicrofacetModel model) {
    return [=](StackBuilder& b) {
        b.AddInterface(NewFaceted<ConductorBxDF>(b.Memory(), model, alphas, Lanes(0.8f, 0.75f, 0.3f, 0.15f),
                                                 Lanes(1.6f, 1.7f, 2, 2.8f)));
    };
}
Layer Metal(float alpha, MicrofacetModel model) { return Metal(Alphas(alpha, alpha), model); }
Layer Copper(float alpha, MicrofacetModel model) {
    return [=](StackBuilder& b) {
        b.AddInterface(NewFaceted<ConductorBxDF>(b.Memory(), model, Alphas(alpha, alpha),
                                                 Lanes(0.200438f, 0.924033f, 1.102212f, 1.102212f),
                                                 Lanes(3.912949f, 2.452848f, 2.142188f, 2.142188f)));
    };
}
Layer Mirror(float alpha, MicrofacetModel model) {
    return [=](StackBuilder& b) {
        b.AddInterface(NewFaceted<ConductorBxDF>(b.Memory(), model, Alphas(alpha, alpha), SampledSpectrum(0),
                                                 SampledSpectrum(1)));
    };
}
Layer RescatteringDielectric(Alphas alphas, float eta, MicrofacetModel model) {
    return [=](StackBuilder& b) {
        b.AddInterface(NewFaceted<MultiscatterDielectricBxDF>(b.Memory(), model, alphas, eta), eta);
    };
}
Layer RescatteringMetal(Alphas alphas, MicrofacetModel model) {
    return [=](StackBuilder& b) {
        b.AddInterface(NewFaceted<MultiscatterConductorBxDF>(
            b.Memory(), model, alphas, Lanes(0.8f, 0.75f, 0.3f, 0.15f), Lanes(1.6f, 1.7f, 2, 2.8f)));
    };
}
Layer RescatteringMirror(Alphas alphas, MicrofacetModel model) {
    return [=](StackBuilder& b) {
        b.AddInterface(NewFaceted<MultiscatterConductorBxDF>(b.Memory(), model, alphas, SampledSpectrum(0),
                                                             SampledSpectrum(1)));
    };
}
Layer Diffuse(SampledSpectrum reflectance) {
    return [=](StackBuilder& b) { b.AddInterface(b.Memory().New<DiffuseBxDF>(reflectance)); };
}
Layer Diffuse(float reflectance) { return Diffuse(SampledSpectrum(reflectance)); }
Layer DiffuseSheet(float reflectance, float transmittance) {
    return [=](StackBuilder& b) {
        b.AddInterface(b.Memory().New<DiffuseTransmissionBxDF>(SampledSpectrum(reflectance),
                                                               SampledSpectrum(transmittance)));
    };
}
Layer ThinPane(float eta) {
    const lacquer::test::MaterialFromText material(fmt::format("\"thindielectric\" \"float eta\" {}", eta));
    return [=](StackBuilder& b) { b.AddInterface(material.MakeBxDF(SampledWavelengths(), b.Memory())); };
}
Layer Flakes(float alpha, bool areClear) {
    return [=](StackBuilder& b) {
        // The window and its flakes reflect half of what arrives, or less.
        const FlakesInWindow flakes{FlakeField(7), FlakeWindow(3.3, -1.8, {0.4f, 0}, {0, 0.3f}), 0.01f, 0.5f};
        const FlakeOptics optics = areClear ? FlakeOptics::Plate(1.8f, {}, 0)
                                            : FlakeOptics::Metal(Lanes(1.2f, 1.1f, 0.4f, 0.2f),
                                                                 Lanes(2.3f, 2.5f, 2.9f, 4.1f), {}, 0);
        b.AddInterface(
            b.Memory().New<FlakesBxDF<TrowbridgeReitz>>(Alphas(alpha, alpha), 0.2f, optics, flakes));
    };
}
Layer Nothing() { return Dielectric(0, 1); }
Layer Black() { return Diffuse(0); }
Layer Tilted(Vec3 normal, const Layer& interface) {
    return [=](StackBuilder& b) {
        b.TurnNext(normal, 0);
        interface(b);
    };
}
Layer Turned(Vec3 normal, float deg, const Layer& interface) {
    return [=](StackBuilder& b) {
        b.TurnNext(normal, deg);
        interface(b);
    };
}
Layer Rotated(float deg, const Layer& interface) {
    return [=](StackBuilder& b) {
        b.TurnNext({0, 0, 1}, deg);
        interface(b);
    };
}

// ---- Slabs --------------------------------------------------------------------------------------------

Layer Medium(SampledSpectrum opticalThickness, SampledSpectrum albedo, const PhaseMaker& phase) {
    return [=](StackBuilder& b) { b.AddSlab(Slab(opticalThickness, albedo, phase(b.Memory()))); };
}
Layer Medium(float opticalThickness, float albedo, const PhaseMaker& phase) {
    return Medium(SampledSpectrum(opticalThickness), SampledSpectrum(albedo), phase);
}
Layer Absorber(SampledSpectrum opticalThickness) {
    return [=](StackBuilder& b) { b.AddSlab(Slab(opticalThickness, SampledSpectrum(0), nullptr)); };
}
Layer Absorber(float opticalThickness) { return Absorber(SampledSpectrum(opticalThickness)); }

// ---- Phase functions ----------------------------------------------------------------------------------

PhaseMaker Isotropic() {
    return [](Arena& arena) { return arena.New<IsotropicPhase>(); };
}
PhaseMaker HG(float g) {
    return [=](Arena& arena) { return arena.New<HenyeyGreensteinPhase>(g); };
}
PhaseMaker VMF(float kappa) {
    return [=](Arena& arena) { return arena.New<VonMisesFisherPhase>(kappa); };
}
PhaseMaker Rainbow() {
    static const PhaseTable table = [] {
        constexpr std::array<float, 11> kValues = {0.4f, 0.6f, 0.1f, 0.1f, 0.1f, 0.2f, 0.3f, 0.5f, 1, 3, 9};
        return PhaseTable(kValues);
    }();
    return [](Arena& arena) { return arena.New<TabulatedPhase>(table); };
}
PhaseMaker SpectralRainbow() {
    static const SpectralPhaseTable table(PhaseNumbers{{450, 550, 650},
                                                       {0, 10, 40, 90, 140, 180},
                                                       {20, 9, 2, 0.3f, 0.1f, 0.2f,  //
                                                        1, 1, 2, 1, 1, 4,            //
                                                        0.2f, 0.2f, 0.3f, 1, 4, 3}});
    return [](Arena& arena) {
        return arena.New<SpectralTabulatedPhase>(table, SampledWavelengths::SampleUniform(0.1f, 420, 700));
    };
}
PhaseMaker SggxFibres(Vec3 orientation, float roughness) {
    return [=](Arena& arena) { return arena.New<SggxPhase>(orientation, roughness, false); };
}
PhaseMaker SggxSheets(Vec3 orientation, float roughness) {
    return [=](Arena& arena) { return arena.New<SggxPhase>(orientation, roughness, true); };
}
namespace {

/// Reciprocal, and even across the axis.
OrientedBulkTable EnsembleTable() {
    OrientedBulkTable table;
    table.wavelengths = {550};
    table.numAzimuths = 13;
    for (int j = 0; j < 13; ++j) table.angles.push_back(15 * j);
    const OrientedGrid grid(table);
    std::vector<double> scattered(grid.Size()), sigmaS, sigmaA;
    constexpr double kStep = M_PI / 12;
    for (size_t i = 0; i < grid.NumIncidences(); ++i) {
        const double a = double(i) * kStep;
        for (size_t j = 0; j < 13; ++j)
            for (size_t k = 0; k < 13; ++k) {
                const double b = double(j) * kStep, phi = double(k) * kStep;
                const double cosine = std::cos(a) * std::cos(b) + std::sin(a) * std::sin(b) * std::cos(phi);
                scattered[grid.Index(i, j) + k] =
                    (1.2 - Sqr(std::cos(a))) * (1.2 - Sqr(std::cos(b))) * std::exp(1.5 * cosine) / (4 * M_PI);
            }
        sigmaS.push_back(grid.OverSphere<double>(scattered, i));
        sigmaA.push_back(0.8 * Sqr(std::cos(a)));
    }
    std::vector<float>& p = table.phase.emplace_back();
    for (size_t at = 0; at < scattered.size(); ++at)
        p.push_back(float(scattered[at] / sigmaS[at / (13 * 13)]));
    table.sigmaS.push_back(sigmaS);
    table.sigmaA.push_back(sigmaA);
    return table;
}

}  // namespace

PhaseMaker OrientedEnsemble(Vec3 orientation) {
    static const OrientedPhaseTable table(EnsembleTable());
    return [=](Arena& arena) { return arena.New<OrientedPhase>(table, orientation, SampledWavelengths()); };
}
PhaseMaker Fibres(Vec3 orientation, float stddev) {
    return [=](Arena& arena) { return arena.New<FibrePhase>(orientation, stddev); };
}
PhaseMaker Mixture(float weightA, const PhaseMaker& a, float weightB, const PhaseMaker& b) {
    return [=](Arena& arena) {
        const auto& parts = *arena.New<std::array<const PhaseFunction*, 2>>(
            std::array<const PhaseFunction*, 2>{a(arena), b(arena)});
        const auto& weights = *arena.New<std::array<float, 2>>(std::array<float, 2>{weightA, weightB});
        return arena.New<MixturePhase>(parts, weights);
    };
}

// ---- Rows ---------------------------------------------------------------------------------------------

Stack StackCase::Build(Arena& arena) const {
    StackBuilder builder(arena);
    for (const Layer& layer : layers) layer(builder);
    return builder.Build();
}

const LayeredBxDF* StackCase::MakeBxDF(Arena& arena, const LayeredOptions& options) const {
    StackBuilder builder(arena);
    for (const Layer& layer : layers) layer(builder);
    return builder.BuildBxDF(options);
}

bool Transmits(const Stack& stack) {
    return std::all_of(stack.interfaces.begin(), stack.interfaces.end(),
                       [](const StackInterface& i) { return Any(i.bxdf->Flags(), Lobes::Transmission); });
}

bool IsSpectral(const Stack& stack) {
    const auto varies = [](SampledSpectrum s) { return s.MinComponent() != s.MaxComponent(); };
    return std::any_of(stack.slabs.begin(), stack.slabs.end(),
                       [&](const Slab& s) { return varies(s.opticalThickness) || varies(s.albedo); });
}

const StackCase& FindStackCase(const std::string& name) {
    const auto& rows = StackCases();
    const auto row =
        std::find_if(rows.begin(), rows.end(), [&](const StackCase& c) { return c.name == name; });
    LACQUER_CHECK(row != rows.end());
    return *row;
}

}  // namespace lacquer::layered::test
