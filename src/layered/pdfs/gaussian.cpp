// Pdf "gaussian": a closed form, without random numbers, for the density with which light leaves a stack.
//
// It is a sum of
// - the exact density of the first interface;
// - a lobe for each interface that unscattered light comes back from, or passes as the last one. wo and wi
//   are both bent into the stack, each at the most probable facets, and with them go the covariances of what
//   other facets do; then the facet that joins the two beams has a Gaussian density whose covariance is its
//   own one and those of both beams. This is the integral over the inner directions in the Gaussian model of
//   half-vector sampling (paths/half_vectors/half_vector.h). Where an interface has the tails of Trowbridge
//   and Reitz, the lobe has them, too;
// - a cosine lobe, refracted out, with the energy that is left: scattered light, diffuse layers, long paths.
#include "layered/estimator.h"
#include "layered/slopes/facet_map.h"
#include "layered/slopes/facet_slopes.h"
#include "pbrt/scattering/microfacet.h"

namespace lacquer::layered {
namespace {

// Directions are turned up, as in facet_map.h; `planar` is their part in the surface.

/// An interface as the lobes see it, from the side that a beam comes from.
struct Boundary {
    enum class Kind { Specular, Rough, Diffuse } kind = Kind::Diffuse;
    float eta = 0;          ///< rough ones: index beyond over index on this side; 0 if opaque
    Slope mean;             ///< rough ones: of the facets' slopes
    Symmetric2 covariance;  ///< ... and about it; of Trowbridge and Reitz' distribution the ellipse over 2
    float tails = 0;        ///< trace of the covariance where it has heavy tails

    float Trace() const { return covariance.Trace(); }
};

Boundary BoundaryOf(const StackInterface& interface, bool isFromAbove) {
    Boundary boundary;
    if (interface.isSpecular) {
        boundary.kind = Boundary::Kind::Specular;
        return boundary;
    }
    const auto* surface = std::get_if<MicrofacetSurface>(&interface.model);
    if (!surface) return boundary;
    boundary.kind = Boundary::Kind::Rough;
    if (surface->eta > 0) boundary.eta = isFromAbove ? surface->eta : 1 / surface->eta;
    boundary.covariance = FacetCovariance(interface, *surface);
    if (interface.hasOwnFrame) boundary.mean = PlanarPart(interface.frame.z) * (1 / interface.frame.z.z);
    if (surface->model == MicrofacetModel::TrowbridgeReitz) boundary.tails = boundary.Trace();
    return boundary;
}

/// Projected area of the facets that w sees, nearly; |cos| where nothing is hidden.
/// [Heitz 2014] for Trowbridge and Reitz.
float VisibleArea(const Boundary& boundary, Vec3 w) {
    if (boundary.kind != Boundary::Kind::Rough) return w.z;
    const Slope p = PlanarPart(w);
    // Beckmann's facets: the same form with the same value in the horizon.
    const float alpha2 = (boundary.tails > 0 ? 2 : 2 * InvPi) * Dot(p, boundary.covariance * p);
    return 0.5f * (w.z + std::sqrt(w.z * w.z + alpha2));
}

/// The slope of facets that w most probably meets and the covariance about it: that of
/// exp(-(m - mean)^T C^-1 (m - mean) / 2) (1 + s.m), s being the slope of w, by its peak: with v = m - mean
/// and s' = s/(1 + s.mean) that is v = t C s', t (1 + t s'^T C s') = 1.
struct VisibleSlopePeak {
    Slope mode;
    Symmetric2 covariance;

    VisibleSlopePeak(const Boundary& boundary, Vec3 w) {
        constexpr float kMinCos = 1e-3f;
        const Slope s = PlanarPart(w) * (1 / std::max(w.z, kMinCos));
        const Slope tilt = s * (1 / std::max(1 + Dot(s, boundary.mean), kMinCos));
        const Slope spread = boundary.covariance * tilt;
        const float q = Dot(tilt, spread), t = ModeOfVisible(q);
        mode = boundary.mean + t * spread;
        covariance = boundary.covariance.PlusSquare(-t * t / (1 + t * t * q), spread);
    }
};

/// A density over slopes with covariance (or ellipse) c, centred: Gaussian, or with the tails of Trowbridge
/// and Reitz' distribution where most of the spread has them. 0 where there is no spread: a specular path.
float LobeDensity(Slope m, Symmetric2 c, float tails) {
    constexpr float kMinTrace = 1e-12f;
    const float trace = c.Trace();
    if (!(trace > kMinTrace)) return 0;
    const Symmetric2 precision = c.Inverse();
    const float q = Dot(m, precision * m);
    const float peak = Inv2Pi * std::sqrt(std::max(precision.Determinant(), 0.f));
    return peak * (tails > 0.5f * trace ? 1 / Sqr(1 + 0.5f * q) : std::exp(-0.5f * q));
}

/// Light of one outside direction on its way into the stack.
struct Beam {
    Vec3 w;                 ///< mean direction, unit
    Symmetric2 covariance;  ///< of its planar part
    Rng* rng = nullptr;     ///< for polished interfaces that are stacks themselves; nothing else draws
    float tails = 0;        ///< what of the covariance's trace is due to facets with heavy tails
    float energy = 1;       ///< the part of it that gets here
    float widening = 1;     ///< solid angle here per solid angle outside, as facets are met from either side

    float Trace() const { return covariance.Trace(); }
    void PassSlab(const Slab& slab) {
        if (slab.Scatters()) energy *= slab.Cross(w, 1).pdfBoundary;
    }
    /// Goes through a boundary; energy 0 where nothing does. @return index beyond over index on this side
    float Pass(const StackInterface& interface, const Boundary& boundary, bool isFromAbove) {
        return boundary.kind == Boundary::Kind::Specular ? PassSpecular(interface, isFromAbove)
                                                         : PassRough(boundary);
    }

  private:
    float PassSpecular(const StackInterface& interface, bool isFromAbove) {
        // The last one of all numbers chooses transmission where there is any.
        const BxDFContext context{TransportMode::Importance, Lobes::BothSides, rng};
        const std::optional<BxDFSample> sample =
            interface.Sample(isFromAbove ? w : -w, {OneMinusEpsilon, Point2(0.5f)}, context);
        if (!sample || !sample->IsTransmission()) {
            energy = 0;
            return 1;
        }
        const Vec3 next = Upward(sample->wi);
        Refract(next, sample->eta, w.z / next.z);
        energy *= sample->pdf;
        return sample->eta;
    }
    float PassRough(const Boundary& boundary) {
        const VisibleSlopePeak facets(boundary, w);
        const float eta = boundary.eta;
        FacetDeflection deflection;
        if (!FacetMap(w, eta).Deflection(facets.mode, &deflection)) {
            energy = 0;
            return eta;
        }
        // The planar part beyond is (p - m D)/eta, D being the length times the cosine of the facet.
        const float swing2 = Sqr(deflection.length * deflection.cosFacet);
        covariance = covariance + facets.covariance * swing2;
        tails += boundary.tails * swing2;
        energy *= 1 - FresnelDielectric(deflection.cosW, eta);
        Refract(deflection.u, eta, VisibleArea(boundary, w) / VisibleArea(boundary, deflection.u));
        return eta;
    }
    void Refract(Vec3 next, float eta, float areas) {
        const float shrink = 1 / Sqr(eta);
        covariance = covariance * shrink;
        tails *= shrink;
        widening *= areas * shrink;
        w = next;
    }
};

/// Mean over a cosine lobe of what a boundary lets through. @param eta  index beyond over index on this side
float MeanTransmittance(float eta) {
    // Fresnel's value at normal incidence, and what grazing directions add to it; within 0.02.
    const float r = (1 - eta) / (1 + eta), entering = 1 - r * r - 0.05f;
    return eta < 1 ? eta * eta * entering : entering;
}

/// The density of a walk that starts against wo, by the beams of wo and wi.
class ExitDensity {
  public:
    ExitDensity(const Stack& stack, Vec3 wo, Vec3 wi, Rng* rng)
        : stack_(stack),
          isFromAbove_(wo.z > 0),
          isReflection_(SameHemisphere(wo, wi)),
          camera_{Upward(wo), {}, rng},
          light_{Upward(wi), {}, rng},
          wi_(light_.w) {}

    /// [1/sr], without the first interface's own scattering. Positive.
    float Sum() {
        float lobes = 0;
        const int last = stack_.Last();
        for (int k = 0; k <= last && camera_.energy > 0; ++k) {
            const StackInterface& interface = stack_.interfaces[size_t(isFromAbove_ ? k : last - k)];
            const Boundary boundary = BoundaryOf(interface, isFromAbove_);
            Account(k, boundary, ReflectedShare(interface, boundary));
            if (isReflection_ && k > 0) lobes += ReflectedLobe(interface, boundary);
            if (!interface.transmits || boundary.kind == Boundary::Kind::Diffuse) break;
            if (k == last) {
                lobes += TransmittedLobe(interface, boundary);
                break;
            }
            const float eta = camera_.Pass(interface, boundary, isFromAbove_);
            index_ *= eta;
            const Slab& slab = stack_.slabs[size_t(isFromAbove_ ? k : last - k - 1)];
            camera_.PassSlab(slab);
            if (!isReflection_) continue;
            light_.Pass(interface, boundary, isFromAbove_);
            if (k == 0) exitWeight_ = light_.energy / MeanTransmittance(eta);
            light_.PassSlab(slab);
        }
        return lobes + Remainder();
    }

  private:
    /// The part of the light that a boundary reflects into lobes, as the walk draws it.
    float ReflectedShare(const StackInterface& interface, const Boundary& boundary) const {
        if (boundary.kind == Boundary::Kind::Specular) {
            const BxDFContext context{TransportMode::Importance, Lobes::BothSides, camera_.rng};
            const std::optional<BxDFSample> sample =
                interface.Sample(isFromAbove_ ? camera_.w : -camera_.w, {0, Point2(0.5f)}, context);
            return sample && sample->IsReflection() ? sample->pdf : 0;
        }
        if (boundary.kind == Boundary::Kind::Diffuse) return 0;
        return boundary.eta > 0 ? FresnelDielectric(camera_.w.z, boundary.eta) : 1;
    }
    /// Of the light that boundary k reflects, the part that gets straight out.
    float EscapingShare(const Boundary& boundary) const {
        // Where light comes from a denser medium, or is spread over the horizon, the rest is trapped: in
        // planar coordinates, what lies outside of a disk.
        const float edge = std::min(1.f, 1 / index_);
        const Slope p = PlanarPart(camera_.w);
        const float centre = std::min(std::sqrt(Dot(p, p)) / edge, 1.f);
        const float variance = camera_.Trace() + 2 * Sqr(camera_.w.z) * boundary.Trace();
        const float room = Sqr((1 - centre) * edge) / std::max(variance, 1e-9f);
        // Right for centres in the middle and at the edge of the disk.
        return 1 - (1 - 0.5f * centre) * std::exp(-0.5f * room);
    }
    void Account(int k, const Boundary& boundary, float reflectedShare) {
        // A first boundary that is diffuse keeps its light out, too.
        if (k == 0)
            lobeEnergy_ += boundary.kind == Boundary::Kind::Diffuse ? 1 : reflectedShare;
        else if (reflectedShare > 0)
            lobeEnergy_ += Sqr(camera_.energy) * reflectedShare * EscapingShare(boundary);
    }

    float ReflectedLobe(const StackInterface& interface, const Boundary& boundary) const {
        if (boundary.kind == Boundary::Kind::Diffuse || !(light_.energy > 0)) return 0;
        const Vec3 a = camera_.w, b = light_.w;
        const JoiningFacet joint(-1, a, b);
        const Slope m = joint.FacetSlope();
        const float inv2 = 1 / Sqr(joint.Sum());
        const Symmetric2 c = boundary.covariance + (camera_.covariance + light_.covariance) * inv2;
        const float tails = boundary.tails + (camera_.tails + light_.tails) * inv2;
        float share = 1;
        if (boundary.kind == Boundary::Kind::Specular)
            share = ReflectedShare(interface, boundary);
        else if (boundary.eta > 0)
            share = FresnelDielectric(SafeSqrt(0.5f + 0.5f * Dot(a, b)), boundary.eta);
        // D/(4 area) of a reflection; slopes are 1/cos^4 of the facet wider than solid angles times cosines.
        return camera_.energy * light_.energy * light_.widening * share * Sqr(1 + Dot(m, m)) *
               LobeDensity(m - boundary.mean, c, tails) / (4 * VisibleArea(boundary, a));
    }

    /// Through the last boundary.
    float TransmittedLobe(const StackInterface& interface, const Boundary& boundary) {
        if (boundary.kind == Boundary::Kind::Specular) {
            camera_.Pass(interface, boundary, isFromAbove_);
            lobeEnergy_ += camera_.energy;
            if (isReflection_) return 0;
            return camera_.energy * wi_.z *
                   LobeDensity(PlanarPart(wi_ - camera_.w), camera_.covariance, camera_.tails);
        }
        // [Walter et al. 2007] eq. 17, 21; facets that do not quite join the two directions still stand for
        // others that do.
        constexpr float kMin = 0.1f;
        const Vec3 a = camera_.w;
        const float eta = boundary.eta, y = Dot(a, wi_), sign = eta > 1 ? -1.f : 1.f;
        lobeEnergy_ += camera_.energy * (1 - FresnelDielectric(a.z, eta));
        if (isReflection_) return 0;
        const float least = kMin * std::abs(1 - eta);
        const JoiningFacet joint(eta, a, wi_, least);
        const float dotA = std::max(sign * (1 - eta * y), least), dotI = std::max(sign * (y - eta), least);
        const float length2 = std::max(1 + eta * eta - 2 * eta * y, Sqr(1 - eta));
        const Slope m = joint.FacetSlope();
        const float inv2 = 1 / Sqr(joint.Sum());
        return camera_.energy * (1 - FresnelDielectric(dotA / std::sqrt(length2), eta)) * dotA * dotI *
               Sqr(eta * (1 + Dot(m, m)) / length2) *
               LobeDensity(m - boundary.mean, boundary.covariance + camera_.covariance * inv2,
                           boundary.tails + camera_.tails * inv2) /
               VisibleArea(boundary, a);
    }

    /// All other light, in a cosine lobe; where light passes, half on either side. Besides a constant, since
    /// values off the lobes are estimates with much noise, which the weights should leave to Sample(); where
    /// most light is in the cosine lobe, they are not.
    float Remainder() const {
        constexpr float kOffLobes = 0.05f, kMin = 1e-3f;
        bool transmits = true;
        for (const StackInterface& interface : stack_.interfaces) transmits &= interface.transmits;
        const float energy = std::clamp(1 - lobeEnergy_, 0.f, 1.f);
        return energy * (transmits ? 0.5f : 1.f) * exitWeight_ * wi_.z * InvPi + kOffLobes * (1 - energy) +
               kMin;
    }

    const Stack& stack_;
    bool isFromAbove_, isReflection_;
    Beam camera_, light_;
    Vec3 wi_;
    float index_ = 1;  ///< where the beams are, over that outside
    float lobeEnergy_ = 0;
    float exitWeight_ = 1;  ///< of diffuse light towards wi; 1 in the mean over a cosine lobe
};

class GaussianPdf final : public LayeredPdf {
  public:
    float Evaluate(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                   int maxVertices) const override {
        float pdf = 0;
        if (SameHemisphere(wo, wi) || stack.Last() == 0) {
            BxDFContext single = context;
            single.sides = Lobes::BothSides;
            single.needsPdf = true;
            pdf = stack.interfaces[size_t(stack.OuterTowards(wo))].Pdf(wo, wi, single);
        }
        if (stack.Last() > 0 && maxVertices > 1) pdf += ExitDensity(stack, wo, wi, context.rng).Sum();
        // A polished interface alone has none, and some draws of a stack are beyond single precision.
        constexpr float kLow = 1e-6f, kHigh = 1e30f;
        return pdf > kLow ? std::min(pdf, kHigh) : kLow;
    }
};

}  // namespace

LACQUER_REGISTER(LayeredPdfKind, "gaussian", MakePdf<GaussianPdf>);

}  // namespace lacquer::layered
