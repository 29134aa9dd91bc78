#include "pbrt/scattering/bssrdf_table.h"

#include <cmath>
#include <map>
#include <mutex>

#include "pbrt/core/math.h"
#include "pbrt/scattering/fresnel.h"

namespace lacquer {
namespace {

constexpr int kNumBeamSteps = 100;  // along the beam
constexpr double kPi = 3.14159265358979323846;

/// Depth reached with probability (step + 1/2) / kNumBeamSteps at the given extinction.
double Depth(int step, double sigma_t) { return -std::log(1 - (step + 0.5) / kNumBeamSteps) / sigma_t; }

double HenyeyGreenstein(double cosTheta, double g) {
    // The angle between directions that both point away: straight on is -1.
    const double d = 1 + g * g + 2 * g * cosTheta;
    return (1 - g * g) / (4 * kPi * d * std::sqrt(d));
}

template <size_t N>
double Polynomial(double x, const double (&c)[N]) {
    double sum = 0;
    for (size_t i = N; i-- > 0;) sum = sum * x + c[i];
    return sum;
}

}  // namespace

float FresnelMoment1(float eta) {
    constexpr double kBelow[] = {0.45966, -1.73965, 3.37668, -3.904945, 2.49277, -0.68441};
    constexpr double kAbove[] = {-4.61686, 11.1136, -10.4646, 5.11455, -1.27198, 0.12746};
    return float(eta < 1 ? Polynomial(double(eta), kBelow) : Polynomial(double(eta), kAbove));
}

float FresnelMoment2(float eta) {
    constexpr double kBelow[] = {0.27614, -0.87350, 1.12077, -0.65095, 0.07883, 0.04860};
    constexpr double kAbove[] = {-547.033, 404.557, -189.519, 54.9327, -9.00603, 0.63942};
    constexpr double kInverse[] = {0, 458.843, -218.725, 45.3087};
    const double x = double(eta);
    return float(x < 1 ? Polynomial(x, kBelow) : Polynomial(x, kAbove) + Polynomial(1 / x, kInverse));
}

double BeamDiffusionMultiple(double sigma_s, double sigma_a, double g, double eta, double r) {
    const double sigmaPrime_s = sigma_s * (1 - g), sigmaPrime_t = sigma_a + sigmaPrime_s;
    const double albedoPrime = sigmaPrime_s / sigmaPrime_t;
    // Grosjean's diffusion coefficient, effective extinction, and the mirror plane above the boundary.
    const double D = (2 * sigma_a + sigmaPrime_s) / (3 * sigmaPrime_t * sigmaPrime_t);
    const double sigma_tr = std::sqrt(sigma_a / D);
    const double F1 = double(FresnelMoment1(float(eta))), F2 = double(FresnelMoment2(float(eta)));
    const double mirror = -2 * D * (1 + 3 * F2) / (1 - 2 * F1);
    const double weightFluence = (1 - 2 * F1) / 4, weightFlux = (1 - 3 * F2) / 2;

    double sum = 0;
    for (int i = 0; i < kNumBeamSteps; ++i) {
        // A source on the beam, and its image above the boundary.
        const double z_r = Depth(i, sigmaPrime_t), z_v = 2 * mirror - z_r;
        const double d_r = std::sqrt(r * r + z_r * z_r), d_v = std::sqrt(r * r + z_v * z_v);
        const double decay_r = std::exp(-sigma_tr * d_r) / d_r, decay_v = std::exp(-sigma_tr * d_v) / d_v;
        const double fluence = (decay_r - decay_v) / (4 * kPi * D);
        const double flux = (z_r * (1 + sigma_tr * d_r) * decay_r / (d_r * d_r) -
                             z_v * (1 + sigma_tr * d_v) * decay_v / (d_v * d_v)) /
                            (4 * kPi);
        // Near the beam, diffusion overestimates: the empirical factor of [Habel et al. 2013].
        const double kappa = 1 - std::exp(-2 * sigmaPrime_t * (d_r + z_r));
        sum += kappa * (fluence * weightFluence + flux * weightFlux);
    }
    return albedoPrime * albedoPrime * sum / kNumBeamSteps;
}

double BeamDiffusionSingle(double sigma_s, double sigma_a, double g, double eta, double r) {
    const double sigma_t = sigma_a + sigma_s;
    // Shallower than this, the light is reflected back totally.
    const double tCritical = r * std::sqrt(std::max(0., eta * eta - 1));
    double sum = 0;
    for (int i = 0; i < kNumBeamSteps; ++i) {
        const double t = tCritical + Depth(i, sigma_t), d = std::sqrt(r * r + t * t), cosTheta = t / d;
        const double transmitted = 1 - double(FresnelDielectric(-float(cosTheta), float(eta)));
        sum += std::exp(-sigma_t * (d + tCritical)) / (d * d) * HenyeyGreenstein(cosTheta, g) * transmitted *
               cosTheta;
    }
    return sigma_s / sigma_t * sum / kNumBeamSteps;
}

BssrdfTable::BssrdfTable(float g, float eta)
    : profile_(size_t(kNumAlbedos) * kNumRadii), cdf_(profile_.size()) {
    const double gLimited = double(std::clamp(g, -kMaxG, kMaxG));
    // Radii grow by a constant factor; albedos crowd towards 1, where the effective albedo is steep.
    radii_[0] = 0;
    radii_[1] = 2.5e-3f;
    for (size_t i = 2; i < radii_.size(); ++i) radii_[i] = radii_[i - 1] * 1.2f;
    for (int i = 0; i < kNumAlbedos; ++i)
        albedos_[size_t(i)] = float((1 - std::exp(-8. * i / (kNumAlbedos - 1))) / (1 - std::exp(-8.)));

    for (int i = 0; i < kNumAlbedos; ++i) {
        const double albedo = double(albedos_[size_t(i)]);
        for (int j = 0; j < kNumRadii; ++j) {
            const double r = double(radii_[size_t(j)]);
            const double exitance = BeamDiffusionSingle(albedo, 1 - albedo, gLimited, double(eta), r) +
                                    BeamDiffusionMultiple(albedo, 1 - albedo, gLimited, double(eta), r);
            profile_[At(i, j)] = float(2 * kPi * r * exitance);
        }
        effectiveAlbedos_[size_t(i)] =
            IntegrateCatmullRom(radii_, std::span(profile_).subspan(At(i, 0), kNumRadii),
                                std::span(cdf_).subspan(At(i, 0), kNumRadii));
    }
}

std::shared_ptr<const BssrdfTable> BssrdfTable::Shared(float g, float eta) {
    static std::mutex mutex;
    static std::map<std::pair<float, float>, std::weak_ptr<const BssrdfTable>> tables;
    const std::lock_guard lock(mutex);
    std::weak_ptr<const BssrdfTable>& known = tables[{g, eta}];
    std::shared_ptr<const BssrdfTable> table = known.lock();
    if (!table) known = table = std::make_shared<const BssrdfTable>(g, eta);
    return table;
}

float BssrdfTable::InvertEffectiveAlbedo(float share) const {
    return std::clamp(InvertCatmullRom(albedos_, effectiveAlbedos_, share), 0.f, 1.f);
}

BssrdfSlice::BssrdfSlice(const BssrdfTable& table, float albedo)
    : table_(&table),
      weights_(
          *CatmullRomWeights(table.albedos_, albedo > 0 ? std::min(albedo, table.albedos_.back()) : 0.f)) {
    const float share =
        std::max(0.f, weights_.Sum([&](int i) { return table.effectiveAlbedos_[size_t(i)]; }));
    effectiveAlbedo_ = std::min(share, 1.f);
    scale_ = share > 1 ? 1 / share : 1.f;
}

float BssrdfSlice::Profile(float r) const {
    // The first piece of the table is nearly a straight line from 0: the quotient has a limit.
    const float optical = std::max(r, 1e-3f * table_->radii_[1]);
    const std::optional<SplineWeights> w = CatmullRomWeights(table_->radii_, optical);
    if (!w) return 0;
    const float value = weights_.Sum(
        [&](int i) { return w->Sum([&](int j) { return table_->profile_[table_->At(i, j)]; }); });
    // Splines can swing below zero.
    return std::max(0.f, scale_ * value / (2 * Pi * optical));
}

float BssrdfSlice::SampleRadius(float u) const {
    const auto cdf = [&](int j) {
        return weights_.Sum([&](int i) { return table_->cdf_[table_->At(i, j)]; });
    };
    const auto profile = [&](int j) {
        return weights_.Sum([&](int i) { return table_->profile_[table_->At(i, j)]; });
    };
    if (!(effectiveAlbedo_ > 0)) return 0;
    const float target = u * cdf(BssrdfTable::kNumRadii - 1);
    const int j = FindInterval(BssrdfTable::kNumRadii, [&](int k) { return cdf(k) <= target; });
    const float r0 = table_->radii_[size_t(j)], r1 = table_->radii_[size_t(j) + 1];
    const HermiteCubic piece = CatmullRomPiece(table_->radii_, profile, j);
    return Lerp(piece.InvertIntegral((target - cdf(j)) / (r1 - r0)), r0, r1);
}

}  // namespace lacquer
