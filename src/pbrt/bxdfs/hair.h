// Scattering by a hair or another thin dielectric fibre.
#pragma once

#include <array>

#include "pbrt/base/bxdf.h"

namespace lacquer {

/// Paths of light through the fibre that are told apart, by the number of segments inside: reflection (0),
/// transmission (1), one inner reflection (2), and all longer ones together (3).
inline constexpr int kNumFibrePaths = 4;

/// The far-field model of a rough circular cylinder with tilted scales and an absorbing inside [Marschner et
/// al. 2003], with the energy-conserving lobes of [d'Eon et al. 2011] and the near-field azimuth and the
/// roughness parameters of [Chiang et al. 2016]. The local x axis runs along the fibre. With sigma_a = 0
/// everything is scattered, nothing lost.
///
/// f has the reciprocal of |cos theta_i| in it, so that f |cos theta_i| is what the fibre scatters: its
/// surface is a placeholder without an orientation of its own. Both sides of that surface are one lobe,
/// declared as reflection and transmission; only the directions' sides tell them apart. f(wo, wi) is not
/// f(wi, wo): absorption and offset are those of wo, as in pbrt-v4, in both modes.
class HairBxDF final : public BxDF {
  public:
    struct Parameters {
        float h = 0;              ///< offset across the fibre in [-1,1]: the sine of the angle of incidence
        float eta = 1.55f;        ///< index of refraction inside, > 0
        SampledSpectrum sigma_a;  ///< absorption in units of the inverse radius, in [0, 1e6]
        float beta_m = 0.3f;      ///< longitudinal roughness in [0.01,1]
        float beta_n = 0.3f;      ///< azimuthal roughness in [0.01,1]
        float alpha = 0;          ///< tilt of the scales [radians]
    };
    explicit HairBxDF(const Parameters& parameters);

    Lobes Flags() const override { return Lobes::GlossyReflection | Lobes::GlossyTransmission; }
    BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const override;
    float Pdf(Vec3 wo, Vec3 wi, const BxDFContext& context) const override;
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const override;

    /// The absorption with which a mass of fibres of this azimuthal roughness has the given colour [Chiang et
    /// al. 2016, eq. 9]: a fit. Domain: reflectance in [0,1].
    static SampledSpectrum SigmaAFromReflectance(SampledSpectrum reflectance, float beta_n);
    /// Absorption of the pigments of hair by their concentrations, as linear sRGB [d'Eon et al. 2011].
    static RGB SigmaAFromMelanin(float eumelanin, float pheomelanin);

  private:
    using PathSpectra = std::array<SampledSpectrum, kNumFibrePaths>;
    using PathWeights = std::array<float, kNumFibrePaths>;

    /// What follows from wo alone.
    struct Outgoing {
        float sinTheta, cosTheta, phi;
        float gamma_t;          ///< angle of refraction in the normal plane
        PathSpectra A;          ///< attenuation along each kind of path
        PathWeights weights{};  ///< probabilities with which paths are drawn
    };
    Outgoing At(Vec3 wo) const;
    PathSpectra Attenuations(float cosTheta_o, SampledSpectrum T) const;

    /// Inclination of the cone of path p: that of wo turned by the scales.
    struct Inclination {
        float sine, cosine;
    };
    Inclination Tilted(int p, const Outgoing& o) const;
    /// Azimuth of the centre of the lobe of path p, relative to wo.
    float LobeAzimuth(int p, float gamma_t) const;
    /// Density of the direction by path p [1/sr].
    float Density(int p, const Outgoing& o, Vec3 wi, float phi) const;
    /// f |cos theta_i| and pdf.
    struct Scattered {
        SampledSpectrum f;
        float pdf = 0;
    };
    Scattered Scatter(const Outgoing& o, Vec3 wi) const;
    float PdfOf(const Outgoing& o, Vec3 wi) const;
    /// False for directions in the surface, and for sides that were not asked for.
    static bool IsAskedFor(Vec3 wo, Vec3 wi, const BxDFContext& context);

    /// Longitudinal lobe of a variance.
    struct Longitudinal {
        float v, inverseV, norm;  ///< norm: 1 / (v (1 - exp(-2 / v)))
    };
    std::array<Longitudinal, 3> longitudinal_;  ///< of paths 0, 1, and 2 and more
    std::array<Inclination, 3> tilt_;           ///< sine and cosine by which paths 0, 1, 2 are turned
    float h_, eta_, gamma_o_;
    SampledSpectrum sigma_a_;
    float s_, logisticNorm_;  ///< scale of the logistic, 1 / its mass in [-pi, pi]
};

}  // namespace lacquer
