#include "layered/lobes/belcour_lobes.h"

#include "layered/lobes/facet_albedo.h"
#include "layered/lobes/layer_operators.h"
#include "pbrt/core/sampling.h"

namespace lacquer::layered {

// ---- Adding layers ------------------------------------------------------------------------------------

/// Adds layer after layer, in the order in which wo meets them [Belcour 2018]. What lies above is
/// known by the energies and the spreads of the light that passes it down and up, and that it throws back.
class LayerAdder {
  public:
    LayerAdder(const Stack& stack, Vec3 wo, Rng* rng, BelcourLobes* lobes)
        : stack_(stack),
          rng_(rng),
          lobes_(*lobes),
          model_(lobes->model_),
          isFromAbove_(wo.z > 0),
          cosOutside_(std::max(std::abs(wo.z), 1e-3f)),  // what follows divides by it
          cos_(cosOutside_) {}

    void Run() {
        const int last = stack_.Last();
        for (int k = 0; k <= last; ++k) {
            const int at = isFromAbove_ ? k : last - k;
            const StackInterface& interface = stack_.interfaces[size_t(at)];
            const InterfaceOperators down = OperatorsOf(interface, isFromAbove_, cos_, 0, rng_);
            if (k == 0)
                lobes_.first_ = down.reflected + down.diffuse;
            else
                Reflect(down);
            if (!interface.transmits || !Pass(interface, down)) return;
            if (k == last) {
                lobes_.Add({down_.energy, AlphaOf(model_, down_.spread), true});
                return;
            }
            Cross(stack_.slabs[size_t(isFromAbove_ ? at : at - 1)]);
        }
    }

  private:
    struct Beam {
        SampledSpectrum energy{1};
        float spread = 0;  ///< as seen from outside
    };

    /// The spread of a mirror of this alpha at the present depth. A tilt of its facets turns the planar part
    /// of the direction by twice the cosine, which a refraction multiplies by the index.
    float MirrorSpread(float alpha) const { return SpreadOf(model_, alpha * index_ * cos_ / cosOutside_); }

    /// The lobe of light that this interface reflects, and all it does with what is above.
    void Reflect(const InterfaceOperators& layer) {
        const float mirror = MirrorSpread(layer.alpha);
        if (layer.reflected) {
            const float through = WideThroughNarrow(mirror + down_.spread);
            const SampledSpectrum again = Min(layer.reflected * up_.reflected, SampledSpectrum(0.999f));
            const SampledSpectrum sum = SampledSpectrum(1) / (SampledSpectrum(1) - again);
            const SampledSpectrum energy = down_.energy * layer.reflected * sum * up_.energy;
            const float spread =
                down_.spread + mirror + up_.spread + (again * sum).Average() * (mirror + up_.reflectedSpread);
            lobes_.Add({energy * through, AlphaOf(model_, spread), false});
            // What is too steep to leave comes back from all directions.
            AddDiffuse(energy * (1 - through), layer.reflected);
        }
        if (layer.diffuse) AddDiffuse(down_.energy, layer.diffuse);
    }

    /// Light that a mirror or a diffuse layer gives a cosine lobe, again and again until it leaves.
    void AddDiffuse(SampledSpectrum arriving, SampledSpectrum reflectance) {
        const SampledSpectrum again = Min(reflectance * diffuseUp_.reflected, SampledSpectrum(0.999f));
        lobes_.diffuse_ += arriving * reflectance * diffuseUp_.energy / (SampledSpectrum(1) - again);
    }

    /// Light on its way up is as wide as the mirror has made it, and the more of it is reflected totally: the
    /// smallest quotient, of all interfaces on its way, of the parts that wide and narrow beams have let
    /// through.
    float WideThroughNarrow(float spread) const {
        const float alpha = AlphaOf(model_, spread);
        float smallest = 1;
        for (int k = 0; k < numPassed_ && alpha > 0; ++k) {
            const Passed& p = passed_[size_t(k)];
            // The planar part varies by sqrt(2) alpha cos/index; facets turn by that over cos.
            const float tilt = std::min(2 * alpha * cosOutside_ / (p.index * p.cos), 1.f);
            const SampledSpectrum wide =
                OperatorsOf(*p.interface, !isFromAbove_, p.cos, tilt, rng_).transmitted;
            if (p.narrow > 0) smallest = std::min(smallest, wide.Average() / p.narrow);
        }
        return smallest;
    }

    /// Through an interface. False if the mean direction is reflected totally.
    bool Pass(const StackInterface& interface, const InterfaceOperators& layer) {
        if (layer.diffuseBeyond) lobes_.diffuseBelow_ += down_.energy * layer.diffuseBeyond;
        const float cos2 = 1 - (1 - cos_ * cos_) / Sqr(layer.eta);
        if (!(cos2 > 0) || !layer.transmitted) return false;
        const float beyond = std::sqrt(cos2);
        // The planar part beyond is (p - m D)/eta, D = eta cos' - cos (slopes/facet_map.h); seen from outside
        // it is multiplied by all indices again, and a mirror there has 2 cos.
        const float tilt = layer.alpha * index_ * std::abs(layer.eta * beyond - cos_) / (2 * cosOutside_);
        const float refraction = SpreadOf(model_, tilt), mirror = MirrorSpread(layer.alpha);
        index_ *= layer.eta;
        cos_ = beyond;
        const InterfaceOperators up = OperatorsOf(interface, !isFromAbove_, cos_, 0, rng_);
        if (numPassed_ < kMaxPassed)
            passed_[size_t(numPassed_++)] = {&interface, cos_, index_, up.transmitted.Average()};
        // Between what lies above and this interface [Belcour 2018].
        const SampledSpectrum again = Min(up_.reflected * layer.reflected, SampledSpectrum(0.999f));
        const SampledSpectrum sum = SampledSpectrum(1) / (SampledSpectrum(1) - again);
        const float returns = (again * sum).Average() * (up_.reflectedSpread + mirror);
        const SampledSpectrum behind = up.transmitted * up_.reflected * layer.transmitted * sum;
        const float near = up.reflected.Average(), far = behind.Average();
        if (near + far > 0)
            up_.reflectedSpread =
                (near * MirrorSpread(layer.alpha) + far * (2 * refraction + up_.reflectedSpread + returns)) /
                (near + far);
        up_.reflected = up.reflected + behind;
        down_.energy *= layer.transmitted * sum;
        down_.spread += refraction + returns;
        up_.energy *= up.transmitted * sum;
        up_.spread += refraction + returns;
        const DiffuseOperators diffuse = DiffuseOperatorsOf(up);
        const SampledSpectrum cosines =
            SampledSpectrum(1) / (SampledSpectrum(1) - diffuseUp_.reflected * (1 - diffuse.transmitted));
        diffuseUp_.energy *= cosines * diffuse.transmitted;
        diffuseUp_.reflected =
            SampledSpectrum(diffuse.reflected) + diffuseUp_.reflected * cosines * Sqr(diffuse.transmitted);
        return true;
    }

    void Cross(const Slab& slab) {
        const SlabOperators layer = OperatorsOf(slab, cos_);
        lobes_.scattered_ += down_.energy.Average() * layer.scattered;
        const float spread = SpreadOf(model_, AlphaOf(MicrofacetModel::TrowbridgeReitz, layer.spread));
        down_.energy *= layer.transmitted;
        down_.spread += spread;
        up_.energy *= layer.transmitted;
        up_.spread += spread;
        up_.reflected *= layer.transmitted * layer.transmitted;
        up_.reflectedSpread += 2 * spread;
        // A cosine lobe in two parts: what leaves at the middle of the cone of refraction, what is trapped at
        // 60 degrees.
        diffuseUp_.energy *= OperatorsOf(slab, std::sqrt(1 - 0.5f / std::max(Sqr(index_), 1.f))).transmitted;
        const SampledSpectrum trapped = OperatorsOf(slab, 0.5f).transmitted;
        diffuseUp_.reflected *= trapped * trapped;
    }

    const Stack& stack_;
    Rng* rng_;
    BelcourLobes& lobes_;
    MicrofacetModel model_;
    bool isFromAbove_;
    float cosOutside_;
    float cos_, index_ = 1;  ///< of the mean direction here; index here over index outside
    Beam down_;
    struct {
        SampledSpectrum energy{1}, reflected{0};
        float spread = 0, reflectedSpread = 0;
    } up_;  ///< of light from below: what gets out, and what comes down again
    struct {
        SampledSpectrum energy{1}, reflected{0};
    } diffuseUp_;  ///< of a cosine lobe
    /// An interface above, and the mean direction below it.
    struct Passed {
        const StackInterface* interface;
        float cos, index;
        float narrow;  ///< the part of a narrow beam from below that it lets through
    };
    static constexpr int kMaxPassed = 8;
    std::array<Passed, kMaxPassed> passed_;
    int numPassed_ = 0;
};

namespace {

MicrofacetModel ModelOf(const Stack& stack) {
    for (const StackInterface& interface : stack.interfaces)
        if (const auto* surface = std::get_if<MicrofacetSurface>(&interface.model);
            surface && surface->model == MicrofacetModel::TrowbridgeReitz)
            return MicrofacetModel::TrowbridgeReitz;
    return MicrofacetModel::Beckmann;
}

}  // namespace

BelcourLobes::BelcourLobes(const Stack& stack, Vec3 wo, Rng* rng)
    : wo_(wo.z > 0 ? wo : -wo),
      isAbove_(wo.z > 0),
      model_(ModelOf(stack)),
      eta_(wo.z > 0 ? stack.eta : 1 / stack.eta) {
    transmits_ = std::all_of(stack.interfaces.begin(), stack.interfaces.end(),
                             [](const StackInterface& interface) { return interface.transmits; });
    LayerAdder(stack, wo, rng, this).Run();
    Finish();
}

void BelcourLobes::Add(const Lobe& lobe) {
    if (!lobe.energy) return;
    if (numLobes_ < kMaxLobes) {
        lobes_[size_t(numLobes_++)] = lobe;
        return;
    }
    // Beyond that they are too dark to be told apart.
    Lobe& last = lobes_[kMaxLobes - 1];
    last = {last.energy + lobe.energy, std::max(last.alpha, lobe.alpha), lobe.isTransmitted};
}

void BelcourLobes::Finish() {
    // No more than all: the operators are about right only.
    SampledSpectrum sum = diffuse_ + diffuseBelow_;
    for (const Lobe& lobe : Lobes()) sum += lobe.energy;
    const SampledSpectrum room = Max(SampledSpectrum(1) - first_, SampledSpectrum(0));
    const SampledSpectrum scale = Map(sum, [](float x) { return std::max(x, 1e-9f); });
    const SampledSpectrum share = Min(room / scale, SampledSpectrum(1));
    diffuse_ *= share;
    diffuseBelow_ *= share;
    float lobes = 0;
    for (int k = 0; k < numLobes_; ++k) {
        Lobe& lobe = lobes_[size_t(k)];
        lobe.energy *= share;
        if (lobe.alpha < kSmoothAlpha) lobe.alpha = 0;
        if (lobe.alpha == 0) continue;
        lobes += lobe.energy.Average();
        normalisation_[size_t(k)] = 1 / IntegrateFacets(model_, lobe.alpha, 0, wo_.z).reflected;
    }
    rough_ = lobes + diffuse_.Average() + diffuseBelow_.Average() + scattered_;
}

// ---- Lobes --------------------------------------------------------------------------------------------

bool BelcourLobes::ToMirror(Vec3 wi, Vec3* mirrored) const {
    if (!isAbove_) wi = -wi;
    if (wi.z > 0) {
        *mirrored = wi;
        return true;
    }
    const float x = eta_ * wi.x, y = eta_ * wi.y, z2 = 1 - x * x - y * y;
    if (!(z2 > 0)) return false;
    *mirrored = {x, y, std::sqrt(z2)};
    return true;
}

MicrofacetTerms BelcourLobes::TermsOf(float alpha, Vec3 mirrored) const {
    return model_ == MicrofacetModel::Beckmann
               ? ReflectionTerms(Beckmann(alpha, alpha), wo_, mirrored)
               : ReflectionTerms(TrowbridgeReitz(alpha, alpha), wo_, mirrored);
}

SampledSpectrum BelcourLobes::Evaluate(Vec3 wi, TransportMode mode) const {
    const bool isTransmitted = isAbove_ != (wi.z > 0);
    SampledSpectrum f = (isTransmitted ? diffuseBelow_ : diffuse_) * InvPi;
    Vec3 mirrored;
    if (ToMirror(wi, &mirrored))
        for (int k = 0; k < numLobes_; ++k) {
            const Lobe& lobe = lobes_[size_t(k)];
            if (lobe.alpha == 0 || lobe.isTransmitted != isTransmitted) continue;
            // Planar parts are eta times those of wi, and cosines times solid angles eta^2.
            const float scale = isTransmitted ? Sqr(eta_) : 1.f;
            f += lobe.energy * (normalisation_[size_t(k)] * TermsOf(lobe.alpha, mirrored).value * scale);
        }
    return isTransmitted && mode == TransportMode::Radiance ? f / Sqr(eta_) : f;
}

SampledSpectrum BelcourLobes::SpecularEnergy(bool isTransmitted) const {
    SampledSpectrum sum(0);
    for (const Lobe& lobe : Lobes())
        if (lobe.alpha == 0 && lobe.isTransmitted == isTransmitted) sum += lobe.energy;
    return sum;
}

// ---- Sampling -----------------------------------------------------------------------------------------

float BelcourLobes::CosineShare(bool isTransmitted) const {
    if (isTransmitted && !transmits_) return 0;
    // Scattered light leaves on either side; and no direction is left out.
    const float sides = transmits_ ? 0.5f : 1.f, floor = 0.05f * rough_ + 1e-3f;
    return (isTransmitted ? diffuseBelow_ : diffuse_).Average() + sides * (scattered_ + floor);
}

float BelcourLobes::Pdf(Vec3 wi) const {
    const bool isTransmitted = isAbove_ != (wi.z > 0);
    const float cosine = CosineShare(isTransmitted);
    float sum = cosine * std::abs(wi.z) * InvPi, shares = cosine + CosineShare(!isTransmitted);
    Vec3 mirrored;
    const bool hasMirror = ToMirror(wi, &mirrored);
    for (const Lobe& lobe : Lobes()) {
        if (lobe.alpha == 0) continue;
        const float share = lobe.energy.Average();
        shares += share;
        if (!hasMirror || lobe.isTransmitted != isTransmitted) continue;
        const float scale = isTransmitted ? Sqr(eta_) * std::abs(wi.z) / mirrored.z : 1.f;
        sum += share * TermsOf(lobe.alpha, mirrored).pdf * scale;
    }
    return sum / shares;
}

Vec3 BelcourLobes::SampleMirrored(float alpha, Point2 u) const {
    const Vec3 facet = model_ == MicrofacetModel::Beckmann
                           ? Beckmann(alpha, alpha).SampleVisible(wo_, u)
                           : TrowbridgeReitz(alpha, alpha).SampleVisible(wo_, u);
    return Normalize(Reflect(wo_, facet));
}

std::optional<Vec3> BelcourLobes::SampleDirection(float u, Point2 direction) const {
    const float above = CosineShare(false), below = CosineShare(true);
    float shares = above + below;
    for (const Lobe& lobe : Lobes())
        if (lobe.alpha > 0) shares += lobe.energy.Average();
    u *= shares;
    const auto outside = [&](Vec3 w) { return isAbove_ ? w : -w; };
    for (const Lobe& lobe : Lobes()) {
        if (lobe.alpha == 0) continue;
        if (u >= lobe.energy.Average()) {
            u -= lobe.energy.Average();
            continue;
        }
        const Vec3 w = SampleMirrored(lobe.alpha, direction);
        if (!(w.z > 0)) return std::nullopt;
        if (!lobe.isTransmitted) return outside(w);
        const float x = w.x / eta_, y = w.y / eta_, z2 = 1 - x * x - y * y;
        if (!(z2 > 0)) return std::nullopt;
        return outside({x, y, -std::sqrt(z2)});
    }
    const Vec3 w = SampleCosineHemisphere(direction);
    return outside(u < above ? w : -w);
}

}  // namespace lacquer::layered
