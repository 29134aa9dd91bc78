// Directions out of a stack by its lobes, with their exact density.
#pragma once

#include "layered/lobes/belcour_lobes.h"

namespace lacquer::layered {

/// Draws from what the first interface reflects, if its density is exact, or else from the lobes, as often as
/// their energies are. For one stack and one wo.
class LobeSampler {
  public:
    /// True if nothing is missed: all that the lobes leave out is not specular, so at most the first
    /// interface that wo meets is smooth, with the stack's normal, and its own density is exact, so that what
    /// it reflects can be drawn by it.
    static bool FindsAllLight(const Stack& stack, Vec3 wo);

    /// @param hasSpecularLobes  those below the first interface are drawn, too
    LobeSampler(const Stack& stack, Vec3 wo, const BxDFContext& context, bool hasSpecularLobes);

    /// The density of directions that are not specular [1/sr]; no random numbers. Positive but for directions
    /// into a stack that lets nothing through.
    float Pdf(Vec3 wi) const;

    struct Drawn {
        Vec3 wi;
        float pdf;        ///< [1/sr]; of a specular direction its probability
        bool isSpecular;  ///< then `energy` is all light that leaves along wi, else it is not set
        SampledSpectrum energy{0};
    };
    /// Empty where facets have nothing to give.
    std::optional<Drawn> Sample(const BxDFRandom& u) const;

    const BelcourLobes& Lobes() const { return lobes_; }

  private:
    BxDFContext ReflectionOnly() const;
    std::optional<Drawn> SampleSpecular(bool isTransmitted, float probability) const;

    const StackInterface& first_;
    Vec3 wo_;
    BxDFContext context_;
    BelcourLobes lobes_;
    bool hasSpecularLobes_;
    // Probabilities: reflected by the first interface or in a specular lobe, transmitted in one. The rest is
    // for the other lobes.
    float firstShare_ = 0, specularBelowShare_ = 0;
};

}  // namespace lacquer::layered
