#include "layered/random_queries.h"

#include <fmt/format.h>

#include "pbrt/core/sampling.h"

namespace lacquer::layered::test {
namespace {

constexpr float kMinCosine = 0.02f;

float LogUniform(float low, float high, Rng& rng) { return low * std::pow(high / low, rng.Uniform()); }

/// A stack, layer by layer, and its words.
class RandomStack {
  public:
    RandomStack(Rng& rng, bool isTurned) : rng_(rng), isTurned_(isTurned) {
        constexpr float kMixed = 0.1f, kDielectricBase = 0.3f, kMirror = 0.2f;
        const bool isMixed = rng.Uniform() < kMixed;
        model_ = SomeModel();
        const int numCoats = rng.Uniform() < 0.5f ? 1 : 2;
        for (int k = 0; k < numCoats; ++k) {
            AddDielectric();
            AddSlab();
            if (isMixed) model_ = SomeModel();
        }
        const float base = rng.Uniform();
        if (base < kDielectricBase) {
            AddDielectric();
        } else {
            const float alpha = SomeAlpha();
            const bool isMirror = base < kDielectricBase + kMirror;
            const std::string name =
                fmt::format("{} {:.4g}{}", isMirror ? "mirror" : "metal", alpha, ModelName());
            if (isTurned_ && !isMirror)
                Turn(alpha, name, [this](Alphas alphas) { return Metal(alphas, model_); });
            else
                Add(isMirror ? Mirror(alpha, model_) : Metal(alpha, model_), name);
        }
        row_.name = fmt::format("{}", fmt::join(words_, ", "));
    }
    const StackCase& Row() const { return row_; }

  private:
    MicrofacetModel SomeModel() { return rng_.Uniform() < 0.5f ? kGGX : kBeckmann; }
    const char* ModelName() const { return model_ == kGGX ? " ggx" : " beckmann"; }
    float SomeAlpha() { return LogUniform(0.005f, 1, rng_); }
    void Add(Layer layer, std::string word) {
        row_.layers.push_back(std::move(layer));
        words_.push_back(std::move(word));
    }
    void AddDielectric() {
        const float index = LogUniform(1.1f, 2.5f, rng_);
        const float eta = rng_.Uniform() < 0.25f ? 1 / index : index, alpha = SomeAlpha();
        const std::string name = fmt::format("dielectric {:.4g} eta {:.4g}{}", alpha, eta, ModelName());
        if (isTurned_)
            Turn(alpha, name, [=, this](Alphas alphas) { return Dielectric(alphas, eta, model_); });
        else
            Add(Dielectric(alpha, eta, model_), name);
    }
    /// @param make  (Alphas) -> Layer
    template <class Make>
    void Turn(float alpha, const std::string& name, const Make& make) {
        constexpr float kMaxQuotient = 8, kMaxLean = 0.4f;
        const float stretch = rng_.Uniform() < 0.5f ? std::sqrt(LogUniform(1, kMaxQuotient, rng_)) : 1,
                    deg = 360 * rng_.Uniform(), lean = kMaxLean * std::max(0.f, 1.5f * rng_.Uniform() - 0.5f),
                    azimuth = 2 * Pi * rng_.Uniform();
        const Vec3 normal(lean * std::cos(azimuth), lean * std::sin(azimuth), 1);
        Add(Turned(normal, deg, make({alpha * stretch, alpha / stretch})),
            fmt::format("{} stretched {:.3g} turned {:.0f} to ({:.3g}, {:.3g})", name, stretch, deg, normal.x,
                        normal.y));
    }
    void AddSlab() {
        constexpr float kChance = 0.3f;
        if (!(rng_.Uniform() < kChance)) return;
        const float tau = LogUniform(0.01f, 2, rng_);
        const bool isGray = rng_.Uniform() < 0.5f;
        Add(Absorber(isGray ? SampledSpectrum(tau) : Lanes(0.25f * tau, 0.5f * tau, tau, 2 * tau)),
            fmt::format("{} absorber {:.4g}", isGray ? "gray" : "coloured", tau));
    }

    Rng& rng_;
    bool isTurned_;
    MicrofacetModel model_;
    StackCase row_;
    std::vector<std::string> words_;
};

Vec3 SomeDirection(float sign, Rng& rng) {
    const float cos =
        rng.Uniform() < 0.5f ? std::lerp(kMinCosine, 1.f, rng.Uniform()) : LogUniform(kMinCosine, 1, rng);
    const float sin = std::sqrt((1 - cos) * (1 + cos)), phi = 2 * Pi * rng.Uniform();
    return {sin * std::cos(phi), sin * std::sin(phi), sign * cos};
}

/// A direction on a side into which light along wo leaves the stack after entering it. False if it does not.
bool FollowLight(const LayeredBxDF& bxdf, Vec3 wo, Lobes side, Rng& rng, Vec3* wi) {
    constexpr int kMaxTries = 300;
    // With the number that chooses the lobe next to 1 the outermost interface lets light in.
    constexpr float kEnters = 1 - 2 * MachineEpsilon;
    const BxDFContext context{TransportMode::Radiance, side, &rng};
    for (int i = 0; i < kMaxTries; ++i) {
        const auto sample = bxdf.Sample(wo, {kEnters, rng.Uniform2D()}, context);
        if (!sample || sample->IsSpecular() || !(std::abs(sample->wi.z) > kMinCosine)) continue;
        *wi = sample->wi;
        return true;
    }
    return false;
}

std::string Describe(Vec3 w) { return fmt::format("({:.5f}, {:.5f}, {:.5f})", w.x, w.y, w.z); }

}  // namespace

std::string RandomQuery::Describe() const {
    return fmt::format("{}; wo {} wi {} {}", row.name, test::Describe(wo), test::Describe(wi),
                       isOnLobe ? "on" : "off");
}

RandomQuery MakeRandomQuery(uint64_t seed, bool isTurned) {
    Rng rng(Hash(seed, uint64_t(0x7175657279)));
    RandomQuery query{RandomStack(rng, isTurned).Row(), {}, {}};
    Arena arena;
    const LayeredOptions options{.estimator = FindEstimator("bidirectional"), .pdf = FindPdf("approximate")};
    const LayeredBxDF& bxdf = *query.row.MakeBxDF(arena, options);
    const bool transmits = Transmits(bxdf.GetStack());
    const auto isHeads = [&] { return rng.Uniform() < 0.5f; };
    query.wo = SomeDirection(transmits && isHeads() ? -1.f : 1.f, rng);
    const bool passes = transmits && isHeads();
    query.isOnLobe =
        isHeads() &&
        FollowLight(bxdf, query.wo, passes ? Lobes::Transmission : Lobes::Reflection, rng, &query.wi);
    if (!query.isOnLobe) query.wi = SomeDirection(std::copysign(1.f, passes ? -query.wo.z : query.wo.z), rng);
    return query;
}

}  // namespace lacquer::layered::test
