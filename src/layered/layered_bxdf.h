// A stack as a BxDF.
#pragma once

#include "layered/estimator.h"

namespace lacquer::layered {

/// The choices that belong to a layered material rather than to its stack. Refers to what the material owns.
struct LayeredOptions {
    const LayeredEstimator* estimator = nullptr;  ///< never null in use
    const LayeredPdf* pdf = nullptr;              ///< never null in use
    int numSamples = 1;                           ///< estimates that one Evaluate() averages, >= 1
    int maxVertices = kMaxPathVertices;           ///< longer paths carry nothing
    bool isTwoSided = false;                      ///< seen from below, the stack is flipped
};

/// All light that a stack scatters. Evaluate() is right in expectation; its pdf is an approximation that
/// Pdf() gives, too, and pdfReverse is left 0. Sample() follows the light through the stack [Guo et al. 2018,
/// sec. 5.1], and the density of what it draws is known only for paths of specular events; or it draws by a
/// closed form or by lobes, where the pdf says so, with their exact density, and a weight that is an estimate
/// (pdfExact is false then, since Evaluate() gives another one).
///
/// Where Flags() has Diffuse and Glossy, the single reflection by the outer interface is glossy, and all else
/// diffuse: Evaluate() with Lobes::Glossy among the sides gives the former alone. Of records without density
/// the lobe says which it is; others (pdf > 0) stand for both.
class LayeredBxDF final : public BxDF {
  public:
    /// @param interfaces, bxdfs  those of the stack, bxdfs[i] being the model of interface i: what
    /// Regularize() changes. All live in the same arena as this object.
    LayeredBxDF(const Stack& stack, std::span<StackInterface> interfaces, std::span<BxDF* const> bxdfs,
                const LayeredOptions& options);

    Lobes Flags() const override { return flags_; }
    BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const override;
    float Pdf(Vec3 wo, Vec3 wi, const BxDFContext& context) const override;
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const override;
    bool CountsVertices() const override { return !isLobes_; }
    void Regularize() override;

    const Stack& GetStack() const { return stack_; }

  private:
    /// Sets what follows from the interfaces' lobes.
    void Classify();
    /// Turns both directions over where the stack does. False for directions in the surface.
    bool FlipDirections(Vec3* wo, Vec3* wi) const;
    bool IsAsked(Vec3 wo, Vec3 wi, const BxDFContext& context) const;
    /// Of Sample(), for directions as the stack sees them.
    float DensityOf(Vec3 wo, Vec3 wi, const BxDFContext& context) const;
    /// True if Sample() draws from lobes.
    bool SamplesLobes(Vec3 wo) const;
    std::optional<BxDFSample> SampleLobes(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const;

    Stack stack_;
    std::span<StackInterface> interfaces_;
    std::span<BxDF* const> bxdfs_;
    LayeredOptions options_;
    Lobes flags_ = Lobes::None, roughLobe_ = Lobes::None;
    bool transmits_ = false, usesClosedForms_ = false;
    bool isLobes_ = false, prefersLobes_ = false;  ///< of the estimator; of the pdf, for this stack
};

}  // namespace lacquer::layered
