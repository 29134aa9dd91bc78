#include "layered/analog_walk.h"

#include <cmath>

namespace lacquer::layered::test {

namespace {

double UniformDouble(Rng& rng) { return double(rng.NextBits() >> 11) * 0x1p-53; }

bool IsGray(SampledSpectrum s) { return s.MinComponent() == s.MaxComponent(); }

/// True if a walk is the same at all wavelengths but for its weight.
bool HasGraySlabs(const Stack& stack) {
    for (const Slab& slab : stack.slabs)
        if (!IsGray(slab.opticalThickness) || (slab.phase && slab.phase->IsChromatic())) return false;
    return true;
}

bool SameSign(float a, float b) { return (a > 0 && b > 0) || (a < 0 && b < 0); }

/// An event at an interface, in the stack's frame.
std::optional<BxDFSample> SampleInterface(const StackInterface& interface, Vec3 wo, TransportMode mode,
                                          Rng& rng) {
    const Frame& frame = interface.frame;
    const Vec3 local{Dot(wo, frame.x), Dot(wo, frame.y), Dot(wo, frame.z)};
    if (!SameSign(local.z, wo.z)) return std::nullopt;
    const float lobe = rng.Uniform();
    const BxDFRandom u{lobe, rng.Uniform2D()};
    std::optional<BxDFSample> s = interface.bxdf->Sample(local, u, {mode, Lobes::BothSides, &rng});
    if (!s) return std::nullopt;
    const Vec3 localIn = s->wi;
    s->wi = localIn.x * frame.x + localIn.y * frame.y + localIn.z * frame.z;
    if (!SameSign(localIn.z, s->wi.z)) return std::nullopt;
    // Radiance takes the cosine of wi with the perturbed normal, importance, as its adjoint, that of wo.
    if (mode == TransportMode::Importance) s->weight *= std::abs((local.z * s->wi.z) / (wo.z * localIn.z));
    return s;
}

/// What is known of a walk.
struct Walk {
    Vec3 direction{0, 0, -1};  ///< of flight
    SampledSpectrum weight{1};
    double etaScale = 1;  ///< squared index here over that outside, where weights are radiance
    int numVertices = 0;
    bool isSpecular = true;

    /// Ends the walk with the probability that its energy is gone; false if it ended.
    bool Survives(Rng& rng) {
        if (!(weight.MaxComponent() > 0)) return false;
        const double energy = double(weight.MaxComponent()) * etaScale;
        if (energy >= 1) return true;
        if (UniformDouble(rng) >= energy) return false;
        weight *= float(1 / energy);
        return true;
    }
};

/// Flights and scatterings in a slab from its boundary on. @return false if the walk ended inside
bool CrossSlab(const Slab& slab, int lane, int maxVertices, Walk& walk, Rng& rng) {
    const double thickness = double(slab.opticalThickness[lane]);
    if (thickness == 0) return true;
    for (double depth = walk.direction.z < 0 ? 0 : 1;;) {
        // The length of a flight [thickness of the slab] has an exponential law.
        const double relative = slab.phase ? double(slab.phase->Extinction(walk.direction)) : 1;
        const double length = -std::log1p(-UniformDouble(rng)) / (thickness * relative);
        depth -= double(walk.direction.z) * length;
        if (!(depth > 0 && depth < 1)) return true;

        // A collision: absorbed or scattered.
        if (++walk.numVertices > maxVertices || !slab.phase) return false;
        walk.weight *= slab.albedo * slab.phase->Albedo(walk.direction);
        if (!walk.Survives(rng)) return false;
        // All phase functions are drawn exactly: no weight.
        walk.direction = slab.phase->SampleAt(lane, -walk.direction, rng);
        walk.isSpecular = false;
        if (!walk.Survives(rng)) return false;
    }
}

}  // namespace

std::optional<AnalogExit> AnalogWalk(const Stack& stack, Vec3 wo, TransportMode mode, int maxVertices,
                                     Rng& rng, std::vector<AnalogVisit>* visits) {
    if (wo.z == 0) return std::nullopt;
    const int lane = HasGraySlabs(stack) ? -1 : int(rng.UniformInt(kNumWavelengths));
    Walk walk;
    walk.direction = -wo;
    if (lane >= 0) {
        walk.weight = SampledSpectrum(0);
        walk.weight.Set(lane, 1);
    }

    const int last = int(stack.interfaces.size()) - 1;
    for (int i = wo.z > 0 ? 0 : last;;) {
        // Meet interface i.
        if (++walk.numVertices > maxVertices) return std::nullopt;
        if (visits) visits->push_back({i, -walk.direction, double(walk.weight.Average()) * walk.etaScale});
        const auto s = SampleInterface(stack.interfaces[size_t(i)], -walk.direction, mode, rng);
        if (!s) return std::nullopt;
        walk.direction = s->wi;
        walk.weight *= s->weight;
        walk.isSpecular &= s->IsSpecular();
        if (mode == TransportMode::Radiance && s->IsTransmission()) walk.etaScale *= double(Sqr(s->eta));

        // Leave, or go through the slab on that side to the interface beyond or back to this one.
        const bool up = walk.direction.z > 0;
        if (up ? i == 0 : i == last) {
            const float scale = lane >= 0 ? float(kNumWavelengths) : 1.f;
            return AnalogExit{walk.direction, walk.weight * scale, walk.numVertices, walk.isSpecular};
        }
        if (!walk.Survives(rng)) return std::nullopt;
        const int slab = up ? i - 1 : i;
        if (!CrossSlab(stack.slabs[size_t(slab)], std::max(lane, 0), maxVertices, walk, rng))
            return std::nullopt;
        i = walk.direction.z > 0 ? slab : slab + 1;
    }
}

}  // namespace lacquer::layered::test
