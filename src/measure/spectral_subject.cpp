#include "measure/spectral_subject.h"

#include <algorithm>
#include <cmath>

#include "measure/sample_materials.h"

namespace lacquer::measure {

SpectralSubject::SpectralSubject(const Material& material, Point2 uv, std::span<const float> wavelengths,
                                 const FileLoc& loc)
    : numWavelengths_(wavelengths.size()) {
    const TextureContext context = ContextAt(uv);
    for (const Material* chosen : SampleMaterials(material, context))
        variants_.push_back(MakeVariant(*chosen, context, wavelengths, loc));
}

SpectralSubject::Variant SpectralSubject::MakeVariant(const Material& material, const TextureContext& context,
                                                      std::span<const float> wavelengths,
                                                      const FileLoc& loc) {
    Variant groups;
    const auto make = [&](size_t first, size_t count, bool* disperses) {
        SampledSpectrum at;
        for (int lane = 0; lane < kNumWavelengths; ++lane)
            at.Set(lane, wavelengths[first + std::min(size_t(lane), count - 1)]);
        SampledWavelengths lambda = SampledWavelengths::At(at);
        const BxDF* bxdf = material.MakeBxDF(context, lambda, arena_);
        if (!bxdf) throw SceneError(loc, "this material scatters nothing: there is nothing to show");
        *disperses = count > 1 && lambda.SecondaryTerminated();
        if (!*disperses) groups.push_back({bxdf, first, count});
    };
    for (size_t first = 0; first < wavelengths.size(); first += kNumWavelengths) {
        const size_t count = std::min(size_t(kNumWavelengths), wavelengths.size() - first);
        bool disperses = false, ignored = false;
        make(first, count, &disperses);
        for (size_t i = first; disperses && i < first + count; ++i) make(i, 1, &ignored);
    }
    return groups;
}

void SpectralSubject::Evaluate(Vec3 wo, Vec3 wi, TransportMode mode, int64_t numSamples, Rng& rng,
                               std::span<double> mean, std::span<double> error, Observer& observer) const {
    // `error` holds the sums of squared deviations until the end [Welford 1962].
    std::fill(mean.begin(), mean.end(), 0.0);
    std::fill(error.begin(), error.end(), 0.0);
    for (int64_t sample = 0; sample < numSamples && !observer.ShouldStop(); ++sample)
        for (const Group& group : VariantOf(sample)) {
            const BxDFContext context{.mode = mode, .rng = &rng, .needsPdf = false};
            const SampledSpectrum f = group.bxdf->Evaluate(wo, wi, context).f;
            for (size_t lane = 0; lane < group.count; ++lane) {
                const size_t i = group.first + lane;
                const double before = double(f[int(lane)]) - mean[i];
                mean[i] += before / double(sample + 1);
                error[i] += before * (double(f[int(lane)]) - mean[i]);
            }
        }
    const auto n = double(numSamples);
    for (double& e : error) e = numSamples > 1 ? std::sqrt(e / (n - 1) / n) : std::nan("");
}

const BxDF* SpectralSubject::Together(int64_t i) const {
    const Variant& variant = VariantOf(i);
    return variant.size() == 1 ? variant[0].bxdf : nullptr;
}

}  // namespace lacquer::measure
