#include "measure/bsdf_survey.h"

#include <algorithm>
#include <cmath>

#include "layered/layered_bxdf.h"
#include "pbrt/core/check.h"

namespace lacquer::measure {

namespace {

/// Batches (one sample at each set of wavelengths) for each sample per pixel that was asked for.
constexpr int64_t kSamplesAtWi = 4096, kBatchesAtWi = 1024, kBatchesByAngle = 128;
constexpr int kReciprocityPairs = 256, kReciprocityBatches = 64;

const layered::LayeredBxDF* LayeredAt(const BsdfSubject& bsdf, int64_t i) {
    return dynamic_cast<const layered::LayeredBxDF*>(&bsdf.At(i));
}

class BsdfSurvey {
  public:
    BsdfSurvey(const BsdfSurveyOptions& options, const std::vector<NamedBsdf>& estimators, Observer& observer)
        : o_(options), estimators_(estimators), observer_(observer) {
        r_.thetaDeg = o_.thetaDeg;
        r_.phiDeg = o_.phiDeg;
        r_.w = DirectionAt(o_.thetaDeg, o_.phiDeg);
        r_.resolution = o_.resolution;
        r_.seed = o_.seed;
        // Each pixel takes all wavelengths equally often, and at least twice, for an error.
        r_.samplesPerPixel = std::max(2, (o_.samples + BsdfSubject::kNumSets - 1) / BsdfSubject::kNumSets) *
                             BsdfSubject::kNumSets;
        r_.histogramSamples = int64_t(r_.samplesPerPixel) * o_.resolution * o_.resolution;
        for (double angle = 0; angle < 86; angle += 5) r_.anglesDeg.push_back(angle);
        r_.lossAnglesDeg = {0, 30, 60, 80};
        r_.transmits = Any(First().Flags(), Lobes::Transmission);
        r_.isStochastic = First().IsStochastic();
    }

    BsdfResult Run() {
        SurveySamples();
        for (size_t i = 0; i < estimators_.size(); ++i) SurveyEstimator(i);
        SurveyInterfaces();
        return std::move(r_);
    }

  private:
    const BsdfSubject& First() const { return *estimators_[0].bsdf; }
    /// A query with a seed of its own.
    LobeQuery Query(const BsdfSubject& bsdf, Vec3 w, TransportMode mode, uint64_t purpose) const {
        return {bsdf, w, mode, Hash(uint64_t(o_.seed), purpose, int(mode)), &observer_};
    }
    Vec3 AtAngle(size_t i) const {
        // Light from below stays below.
        const double thetaDeg = std::max(0.01, r_.anglesDeg[i]);
        return DirectionAt(r_.w.z > 0 ? thetaDeg : 180 - thetaDeg, r_.phiDeg);
    }
    int64_t SamplesAtWi() const { return kSamplesAtWi * o_.samples; }
    int64_t BatchesAtWi() const { return kBatchesAtWi * o_.samples; }
    int64_t BatchesByAngle() const { return kBatchesByAngle * o_.samples; }

    void SurveySamples() {
        const BsdfSubject& bsdf = First();
        const int64_t angles = int64_t(r_.anglesDeg.size());
        observer_.Begin(
            "samples",
            r_.histogramSamples + 2 * BsdfSubject::kNumSets * (SamplesAtWi() + angles * BatchesByAngle()),
            "samples");
        r_.sampled = SampleLobe(Query(bsdf, r_.w, TransportMode::Importance, 1), SamplesAtWi());
        r_.sampledFurnace = SampleLobe(Query(bsdf, r_.w, TransportMode::Radiance, 2), SamplesAtWi());
        r_.histogram = SampleImages(Query(bsdf, r_.w, TransportMode::Importance, 3), r_.resolution,
                                    r_.histogramSamples, &r_.density);
        for (size_t i = 0; i < r_.anglesDeg.size(); ++i) {
            r_.sampledByAngle.push_back(
                SampleLobe(Query(bsdf, AtAngle(i), TransportMode::Importance, 100 + i), BatchesByAngle()));
            r_.sampledFurnaceByAngle.push_back(
                SampleLobe(Query(bsdf, AtAngle(i), TransportMode::Radiance, 200 + i), BatchesByAngle()));
        }
        observer_.End();
    }

    void SurveyEstimator(size_t index) {
        const BsdfSubject& bsdf = *estimators_[index].bsdf;
        const uint64_t purpose = 1000 * (index + 1);
        const int64_t pixels = int64_t(r_.resolution) * r_.resolution * (r_.transmits ? 2 : 1);
        const int64_t angles = int64_t(r_.anglesDeg.size());
        EstimatorResult e;
        e.name = estimators_[index].name;
        observer_.Begin(e.name,
                        pixels * r_.samplesPerPixel +
                            2 * BsdfSubject::kNumSets * (BatchesAtWi() + angles * BatchesByAngle()),
                        "samples");
        const LobeQuery query = Query(bsdf, r_.w, TransportMode::Importance, purpose);
        e.lobe = EvaluateImages(query, r_.resolution, r_.samplesPerPixel, index == 0 ? &r_.pdf : nullptr);
        e.reflection = Compare(e.lobe.reflection, r_.histogram.reflection);
        if (r_.transmits) e.transmission = Compare(e.lobe.transmission, r_.histogram.transmission);
        const auto integrate = [&](Vec3 w, TransportMode mode, uint64_t number, const SampledLobe& lobe,
                                   int64_t batches) {
            const LobeQuery q = Query(bsdf, w, mode, purpose + number);
            return IntegrateLobe(q, LearnGuide(q, lobe), lobe.eta, batches);
        };
        e.energy = integrate(r_.w, TransportMode::Importance, 1, r_.sampled, BatchesAtWi());
        e.furnace = integrate(r_.w, TransportMode::Radiance, 2, r_.sampledFurnace, BatchesAtWi());
        for (size_t i = 0; i < r_.anglesDeg.size(); ++i) {
            e.energyByAngle.push_back(integrate(AtAngle(i), TransportMode::Importance, 100 + i,
                                                r_.sampledByAngle[i], BatchesByAngle()));
            e.furnaceByAngle.push_back(integrate(AtAngle(i), TransportMode::Radiance, 200 + i,
                                                 r_.sampledFurnaceByAngle[i], BatchesByAngle()));
        }
        e.reciprocity = MeasureReciprocity(
            bsdf, r_.w, r_.sampled.eta, kReciprocityPairs,
            bsdf.IsStochastic() ? std::clamp(2 * o_.samples, 8, kReciprocityBatches) : 1, query.seed);
        e.cost = MeasureCost(query, r_.sampled);
        observer_.End();
        r_.estimators.push_back(std::move(e));
    }

    void SurveyInterfaces() {
        const auto* layered = LayeredAt(First(), 0);
        if (!layered) return;
        for (int i = 0; i <= layered->GetStack().Last(); ++i) {
            InterfaceLoss loss;
            loss.index = i;
            const bool transmits = layered->GetStack().interfaces[size_t(i)].transmits;
            for (const double angle : r_.lossAnglesDeg) {
                loss.fromAbove.push_back(LossOf(i, angle));
                if (transmits) loss.fromBelow.push_back(LossOf(i, 180 - angle));
            }
            r_.interfaces.push_back(std::move(loss));
        }
    }

    /// 1 - what an interface sends on of light from this angle, mean of the wavelengths.
    double LossOf(int index, double thetaDeg) const {
        constexpr int kSamples = 1 << 14;
        Rng rng(Hash(uint64_t(o_.seed), 7, index, thetaDeg));
        const Vec3 w = DirectionAt(thetaDeg, r_.phiDeg);
        double sum = 0;
        for (int i = 0; i < kSamples; ++i) {
            const auto* layered = LayeredAt(First(), i);
            if (!layered) continue;
            const BxDFContext context{.mode = TransportMode::Importance, .rng = &rng};
            const auto sample = layered->GetStack().interfaces[size_t(index)].Sample(w, context);
            if (sample && IsUsable(sample->weight)) sum += double(sample->weight.Average());
        }
        return 1 - sum / kSamples;
    }

    const BsdfSurveyOptions& o_;
    const std::vector<NamedBsdf>& estimators_;
    Observer& observer_;
    BsdfResult r_;
};

}  // namespace

BsdfResult SurveyBsdf(const BsdfSurveyOptions& options, const std::vector<NamedBsdf>& estimators,
                      Observer* observer) {
    LACQUER_CHECK(!estimators.empty());
    Observer nobody;
    return BsdfSurvey(options, estimators, observer ? *observer : nobody).Run();
}

bool IsLayered(const BsdfSubject& bsdf) {
    for (int i = 0; i < bsdf.NumVariants(); ++i)
        if (LayeredAt(bsdf, int64_t(i) * BsdfSubject::kNumSets)) return true;
    return false;
}

Vec3 DirectionAt(double thetaDeg, double phiDeg) {
    const double theta = thetaDeg * double(Pi) / 180, phi = phiDeg * double(Pi) / 180;
    const glm::dvec3 w(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
    return Normalize(Vec3(w));
}

}  // namespace lacquer::measure
