#include "pbrt/bxdfs/flake_optics.h"

#include <array>

#include "pbrt/scattering/fresnel.h"

namespace lacquer {

FlakeOptics FlakeOptics::Metal(SampledSpectrum eta, SampledSpectrum k, const std::optional<ThinFilm>& film,
                               float spread) {
    FlakeOptics optics(film, spread);
    optics.eta_ = eta;
    optics.k_ = k;
    if (film) optics.metalUnderFilm_ = film->MetalUnder(eta, k);
    return optics;
}

FlakeOptics FlakeOptics::Plate(float eta, const std::optional<ThinFilm>& film, float spread) {
    FlakeOptics optics(film, spread);
    optics.isPlate_ = true;
    optics.plateEta_ = eta;
    return optics;
}

SampledSpectrum FlakeOptics::Reflectance(float cosTheta_i, int kind) const {
    // The medians of eight parts of a normal variable, of the same probability each, with a variance of 1.
    constexpr std::array<float, kThicknesses> kNormal = {-1.66297f, -0.96166f, -0.52983f, -0.17052f,
                                                         0.17052f,  0.52983f,  0.96166f,  1.66297f};
    std::optional<ThinFilm> film = film_;
    if (NumKinds() > 1) film = film_->Scaled(1 + spread_ * kNormal[size_t(kind)]);
    if (!isPlate_)
        return film ? film->OnConductor(cosTheta_i, *metalUnderFilm_)
                    : FresnelConductor(cosTheta_i, eta_, k_);
    const SampledSpectrum face = film ? film->OnDielectric(cosTheta_i, plateEta_).reflected
                                      : SampledSpectrum(FresnelDielectric(cosTheta_i, plateEta_));
    // Both faces, with all reflections between them, without interference: the plate is thick.
    return 2 * face / (1 + face);
}

SampledSpectrum FlakeOptics::MeanReflectance(float cosTheta_i) const {
    SampledSpectrum sum(0);
    for (int kind = 0; kind < NumKinds(); ++kind) sum += Reflectance(cosTheta_i, kind);
    return sum / float(NumKinds());
}

}  // namespace lacquer
