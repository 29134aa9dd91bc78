// Phase function "mixture": of several kinds of particles.
//
//   "string phases" []  required  earlier slabs (of a slab) or media (of a medium), whose phase functions are
//                                 mixed
//   "float weights" []  equal     fractions of the extinction
#include "pbrt/phases/mixture.h"

#include <fmt/format.h>

#include "pbrt/core/check.h"
#include "pbrt/core/params.h"
#include "pbrt/phases/isotropic.h"

namespace lacquer {

MixturePhase::MixturePhase(std::span<const PhaseFunction* const> parts, std::span<const float> weights,
                           const SampledWavelengths& lambda)
    : parts_(parts), weights_(weights), lambda_(lambda) {
    LACQUER_CHECK(!parts.empty() && parts.size() == weights.size());
    float sum = 0;
    for (size_t i = 0; i < parts.size(); ++i) {
        sum += std::max(0.f, weights[i]);
        isDirectional_ |= parts[i]->HasDirectionalExtinction();
        hasAlbedos_ |= parts[i]->HasDirectionalAlbedo();
        isChromatic_ |= parts[i]->IsChromatic();
    }
    if (sum > 0) scale_ = 1 / sum;
}

float MixturePhase::Share(size_t i) const {
    return scale_ > 0 ? std::max(0.f, weights_[i]) * scale_ : 1 / float(parts_.size());
}

float MixturePhase::PartExtinction(size_t i, Vec3 w) const {
    return isDirectional_ ? Share(i) * parts_[i]->Extinction(w) : Share(i);
}

float MixturePhase::PartScattering(size_t i, Vec3 w) const {
    return hasAlbedos_ ? PartExtinction(i, w) * parts_[i]->Albedo(w) : PartExtinction(i, w);
}

SampledSpectrum MixturePhase::SpectralPartScattering(size_t i, Vec3 w) const {
    if (!hasAlbedos_) return SampledSpectrum(PartExtinction(i, w));
    const DirectionalFactors along = parts_[i]->FactorsAlong(w, lambda_);
    return Share(i) * along.extinction * along.albedo;
}

float MixturePhase::Extinction(Vec3 w) const {
    if (!isDirectional_) return 1;
    float sum = 0;
    for (size_t i = 0; i < parts_.size(); ++i) sum += PartExtinction(i, w);
    return sum;
}

float MixturePhase::Albedo(Vec3 w) const {
    if (!hasAlbedos_) return 1;
    float sum = 0;
    for (size_t i = 0; i < parts_.size(); ++i) sum += PartScattering(i, w);
    return std::min(sum / Extinction(w), 1.f);
}

DirectionalFactors MixturePhase::FactorsAlong(Vec3 w, const SampledWavelengths& lambda) const {
    SampledSpectrum extinction(0), scattered(0);
    for (size_t i = 0; i < parts_.size(); ++i) {
        const DirectionalFactors along = parts_[i]->FactorsAlong(w, lambda);
        extinction += Share(i) * along.extinction;
        scattered += Share(i) * along.extinction * along.albedo;
    }
    return {extinction, Min(SafeDivide(scattered, extinction), SampledSpectrum(1))};
}

PhaseValue MixturePhase::Evaluate(Vec3 wo, Vec3 wi) const {
    float p = 0, pdf = 0, pdfReverse = 0, total_o = 0, total_i = 0;
    for (size_t k = 0; k < parts_.size(); ++k) {
        const PhaseValue value = parts_[k]->Evaluate(wo, wi);
        const float scattered_o = PartScattering(k, wo);
        const float scattered_i = isDirectional_ ? PartScattering(k, wi) : scattered_o;
        p += scattered_o * value.p;
        pdf += scattered_o * value.pdf;
        pdfReverse += scattered_i * value.pdfReverse;
        total_o += scattered_o;
        total_i += scattered_i;
    }
    return {p / total_o, pdf / total_o, pdfReverse / total_i};
}

SpectralPhaseValue MixturePhase::EvaluateSpectral(Vec3 wo, Vec3 wi) const {
    SpectralPhaseValue sum;
    SampledSpectrum total_o(0), total_i(0);
    for (size_t k = 0; k < parts_.size(); ++k) {
        const SpectralPhaseValue value = parts_[k]->EvaluateSpectral(wo, wi);
        const SampledSpectrum scattered_o = SpectralPartScattering(k, wo),
                              scattered_i = SpectralPartScattering(k, wi);
        sum.p += scattered_o * value.p;
        sum.pdf += scattered_o * value.pdf;
        sum.pdfReverse += scattered_i * value.pdfReverse;
        total_o += scattered_o;
        total_i += scattered_i;
    }
    return {sum.p / total_o, sum.pdf / total_o, sum.pdfReverse / total_i};
}

template <class Scattering>
const PhaseFunction& MixturePhase::SamplePart(Rng& rng, float total, const Scattering& scattering) const {
    // A part without a share is never the last one standing.
    float left = rng.Uniform() * total;
    size_t chosen = parts_.size();
    for (size_t i = 0; i < parts_.size(); ++i) {
        const float scattered = scattering(i);
        if (!(scattered > 0)) continue;
        chosen = i;
        if (left < scattered) break;
        left -= scattered;
    }
    LACQUER_DCHECK(chosen < parts_.size());
    return *parts_[std::min(chosen, parts_.size() - 1)];
}

PhaseSample MixturePhase::Sample(Vec3 wo, Rng& rng) const {
    const float total = Extinction(wo) * Albedo(wo);
    const PhaseFunction& part = SamplePart(rng, total, [&](size_t i) { return PartScattering(i, wo); });
    const Vec3 wi = part.Sample(wo, rng).wi;
    const PhaseValue value = Evaluate(wo, wi);
    return {wi, value.pdf > 0 ? value.p / value.pdf : 0.f, value.pdf, value.pdfReverse};
}

Vec3 MixturePhase::SampleAt(int wavelength, Vec3 wo, Rng& rng) const {
    if (!hasAlbedos_) {
        const auto extinction = [&](size_t i) { return PartExtinction(i, wo); };
        return SamplePart(rng, Extinction(wo), extinction).SampleAt(wavelength, wo, rng);
    }
    const auto scattering = [&](size_t i) { return SpectralPartScattering(i, wo)[wavelength]; };
    float total = 0;
    for (size_t i = 0; i < parts_.size(); ++i) total += scattering(i);
    return SamplePart(rng, total, scattering).SampleAt(wavelength, wo, rng);
}

namespace {

/// Phase functions that one mixture may have, mixtures in it included: they are made anew at each hit.
constexpr int kMaxParts = 64;

class MixtureModel final : public PhaseModel {
  public:
    MixtureModel(std::vector<const PhaseModel*> parts, std::vector<float> weights)
        : parts_(std::move(parts)), weights_(std::move(weights)) {}

    const PhaseFunction* Make(const PhaseContext& context, Arena& arena) const override {
        const std::span<const PhaseFunction*> made = arena.NewArray<const PhaseFunction*>(parts_.size());
        for (size_t i = 0; i < parts_.size(); ++i) made[i] = parts_[i]->Make(context, arena);
        return arena.New<MixturePhase>(made, weights_, context.lambda);
    }
    bool IsOriented() const override {
        return std::any_of(parts_.begin(), parts_.end(), [](auto* part) { return part->IsOriented(); });
    }
    bool IsChromatic() const override {
        return std::any_of(parts_.begin(), parts_.end(), [](auto* part) { return part->IsChromatic(); });
    }
    bool HasChromaticExtinction() const override {
        return std::any_of(parts_.begin(), parts_.end(),
                           [](auto* part) { return part->HasChromaticExtinction(); });
    }
    bool IsConstant() const override {
        return std::all_of(parts_.begin(), parts_.end(), [](auto* part) { return part->IsConstant(); });
    }
    int NumParts() const override {
        int sum = 1;
        for (const PhaseModel* part : parts_) sum += part->NumParts();
        return sum;
    }

  private:
    std::vector<const PhaseModel*> parts_;
    std::vector<float> weights_;
};

std::vector<float> ReadWeights(const Params& params, size_t count) {
    std::vector<float> weights = params.GetFloats("weights");
    if (weights.empty() && !params.Has("weights")) return std::vector<float>(count, 1);
    if (weights.size() != count)
        params.Fail("weights", fmt::format("\"float weights\" has {} values for {} phase functions; expected "
                                           "one for each",
                                           weights.size(), count));
    float largest = 0;
    for (const float weight : weights) {
        if (weight < 0) params.Fail("weights", fmt::format("\"float weights\": {} is negative", weight));
        largest = std::max(largest, weight);
    }
    if (largest == 0) params.Fail("weights", "\"float weights\" are all 0; expected a positive one");
    // Neither their sum nor its inverse may leave the range of floats.
    if (!(largest > 1e-30f && largest < 1e30f))
        for (float& weight : weights) weight /= largest;
    return weights;
}

std::unique_ptr<PhaseModel> Create(const PhaseArgs& args) {
    const std::vector<std::string> names = args.params.GetStrings("phases");
    if (names.empty())
        args.params.Fail("phases", fmt::format("a mixture needs \"string phases\": the names of earlier {}",
                                               args.owner.KindOfMany()));
    std::vector<const PhaseModel*> parts;
    int numParts = 1;
    for (const std::string& name : names) {
        const PhaseModel* part = args.owner.Find(args.params, name);
        parts.push_back(part);
        numParts += part ? part->NumParts() : 1;
        if (numParts > kMaxParts)
            args.params.Fail("phases", fmt::format("the mixture has more than {} phase functions, counting "
                                                   "those of mixtures in it",
                                                   kMaxParts));
    }
    std::vector<float> weights = ReadWeights(args.params, names.size());
    if (std::find(parts.begin(), parts.end(), nullptr) != parts.end())
        return MakeIsotropicPhaseModel();  // the scene is not rendered
    return std::make_unique<MixtureModel>(std::move(parts), std::move(weights));
}

constexpr std::string_view kParameters[] = {"phases", "weights"};
constexpr PhasePlugin kPlugin{Create, kParameters};

}  // namespace

LACQUER_REGISTER(PhaseKind, "mixture", &kPlugin);

}  // namespace lacquer
