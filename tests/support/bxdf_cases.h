// The BxDFs that the conformance suite examines: one row for each set-up, and the directions they are looked
// at from.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "pbrt/base/bxdf.h"
#include "pbrt/core/arena.h"

namespace lacquer::test {

/// One set-up. The name has letters, digits and underscores only.
struct BxDFCase {
    std::string name;
    std::function<const BxDF*(const SampledWavelengths&, Arena&)> make;
    bool lossless = false;    ///< everything that arrives leaves again, whatever the direction
    double tolerance = 2e-5;  ///< relative rounding of f and pdf: an ulp over the width of the narrowest lobe
    bool stochastic = false;  ///< Evaluate() is right in expectation only, and its pdf is an approximation
    /// Sample() draws from the generator, too: its map from u has no Jacobian, and the way back no density.
    bool takesMoreNumbers = false;
    /// Sample() makes its direction of all three numbers: its map from two of them has no Jacobian.
    bool takesThreeNumbers = false;
    /// The frame follows the ray (fibres), so that there is nothing that could be looked at from both ends.
    bool isOneWay = false;
    /// The energy of this place may be above 1: what stands out of the surface takes light from places beside
    /// it. Its mean over places is checked elsewhere.
    bool sharesLight = false;
    int numSamples = 300000;  ///< of the statistical checks; see the power statements in bxdf_checks.h
};

/// All rows. A new model adds a line to the table in bxdf_cases.cpp.
const std::vector<BxDFCase>& BxDFCases();

struct NamedDirection {
    const char* name;
    Vec3 w;
};
/// Normal incidence, 45 degrees, cosine 0.05, and from below; none in a plane of symmetry of an anisotropic
/// lobe.
const std::vector<NamedDirection>& OutgoingDirections();

/// Both directions of transport, which the suite goes through for each row and direction.
inline constexpr TransportMode kTransportModes[] = {TransportMode::Radiance, TransportMode::Importance};

/// Lambertian reflection whose Evaluate() has noise of mean 1 and an approximate pdf: what a stochastic model
/// looks like.
class NoisyDiffuse final : public BxDF {
  public:
    explicit NoisyDiffuse(float reflectance) : reflectance_(reflectance) {}
    Lobes Flags() const override { return Lobes::DiffuseReflection; }
    BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const override;
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const override;

  private:
    float reflectance_;
};

}  // namespace lacquer::test
