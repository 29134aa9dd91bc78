#include "measure/bsdf_subject.h"

#include "measure/sample_materials.h"
#include "pbrt/core/color_space.h"
#include "pbrt/core/rng.h"
#include "pbrt/core/sampling.h"

namespace lacquer::measure {

namespace {

/// Where in [0,1) a set of wavelengths begins. The first wavelengths of all sets are spread evenly, for what
/// is dispersive and has no others; and so are all of them, which lie an eighth apart within a set.
float PositionOfSet(int set) {
    constexpr int kSets = BsdfSubject::kNumSets;
    static_assert(kSets == kNumWavelengths);
    return float(set) / kSets + (float(set) + 0.5f) / (kSets * kNumWavelengths);
}

SampledSpectrum Observe(const DenselySampledSpectrum& observer, const SampledWavelengths& lambda) {
    const SampledSpectrum white = ColorSpace::SRGB().Illuminant().Sample(lambda);
    return SafeDivide(observer.Sample(lambda) * white, lambda.Pdf());
}

}  // namespace

BsdfSubject::BsdfSubject(const Material& material, Point2 uv, const FileLoc& loc,
                         std::optional<bool> isStochastic) {
    const TextureContext context = ContextAt(uv);
    const glm::mat3& rgbFromXyz = ColorSpace::SRGB().RGBFromXYZ();
    for (const Material* chosen : SampleMaterials(material, context)) {
        glm::dvec3 white(0);
        for (int set = 0; set < kNumSets; ++set) {
            SampledWavelengths lambda = SampledWavelengths::SampleVisible(PositionOfSet(set));
            const BxDF* bxdf = chosen->MakeBxDF(context, lambda, arena_);
            if (!bxdf) throw SceneError(loc, "this material scatters nothing: there is nothing to show");
            bxdfs_.push_back(bxdf);
            flags_ = flags_ | bxdf->Flags();
            const SampledSpectrum x = Observe(CieX(), lambda), y = Observe(CieY(), lambda),
                                  z = Observe(CieZ(), lambda);
            const auto row = [&](int c) {
                return x * rgbFromXyz[0][c] + y * rgbFromXyz[1][c] + z * rgbFromXyz[2][c];
            };
            weights_.push_back({row(0), row(1), row(2)});
            const ColorWeights& w = weights_.back();
            white += glm::dvec3(double(w.r.Sum()), double(w.g.Sum()), double(w.b.Sum())) / double(kNumSets);
        }
        // White is white exactly: what the few wavelengths miss of the sums is divided out.
        for (size_t i = weights_.size() - kNumSets; i < weights_.size(); ++i) {
            weights_[i].r /= float(white.x);
            weights_[i].g /= float(white.y);
            weights_[i].b /= float(white.z);
        }
    }
    isStochastic_ = isStochastic ? *isStochastic : FindNoise();
}

RGB BsdfSubject::ToRGB(SampledSpectrum value, int64_t i) const {
    const ColorWeights& w = weights_[size_t(i % int64_t(weights_.size()))];
    return {(w.r * value).Sum(), (w.g * value).Sum(), (w.b * value).Sum()};
}

ColorMean BsdfSubject::Evaluate(Vec3 wo, Vec3 wi, TransportMode mode, int64_t numBatches, Rng& rng,
                                double scale) const {
    ColorMean mean;
    for (int64_t batch = 0; batch < numBatches; ++batch) {
        glm::dvec3 value(0);
        for (int64_t i = batch * kNumSets; i < (batch + 1) * kNumSets; ++i) {
            const BxDFContext context{.mode = mode, .rng = &rng, .needsPdf = false};
            value += glm::dvec3(ToRGB(At(i).Evaluate(wo, wi, context).f, i)) * (scale / kNumSets);
        }
        mean.Add(value);
    }
    return mean;
}

bool BsdfSubject::FindNoise() const {
    Rng rng(Hash(2)), first(Hash(3)), second(Hash(4));
    constexpr int kPairs = 256;
    for (int64_t i = 0; i < kPairs; ++i) {
        const Vec3 wo = SampleUniformSphere(rng.Uniform2D()), wi = SampleUniformSphere(rng.Uniform2D());
        const SampledSpectrum a = At(i).Evaluate(wo, wi, {.rng = &first}).f;
        if (!(a == At(i).Evaluate(wo, wi, {.rng = &second}).f)) return true;
    }
    return false;
}

}  // namespace lacquer::measure
