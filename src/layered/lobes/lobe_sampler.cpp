#include "layered/lobes/lobe_sampler.h"

namespace lacquer::layered {

namespace {

/// True if the interface's density is exactly that of its draws, as that of models in closed form is.
bool HasExactDensity(const StackInterface& interface) {
    return interface.isSpecular || !std::holds_alternative<std::monostate>(interface.model);
}

}  // namespace

bool LobeSampler::FindsAllLight(const Stack& stack, Vec3 wo) {
    if (stack.Last() < 1) return false;
    const int outer = stack.OuterTowards(wo), next = outer == 0 ? 1 : outer - 1;
    const StackInterface& first = stack.interfaces[size_t(outer)];
    if (!HasExactDensity(first)) return false;
    if (!first.isSpecular) return true;
    // What a mirror of its own normal does to a direction and to the one back has different shares.
    return first.HasUnperturbedNormal() && !stack.interfaces[size_t(next)].hasSpecular;
}

LobeSampler::LobeSampler(const Stack& stack, Vec3 wo, const BxDFContext& context, bool hasSpecularLobes)
    : first_(stack.interfaces[size_t(stack.OuterTowards(wo))]),
      wo_(wo),
      context_(context),
      lobes_(stack, wo, context.rng),
      hasSpecularLobes_(hasSpecularLobes) {
    // A part of the draws for what the lobes know badly.
    constexpr float kMinShare = 0.05f;
    float first = HasExactDensity(first_) ? lobes_.EnergyOfFirst() : 0, below = 0;
    if (first > 0) first = std::max(first, kMinShare * lobes_.EnergyOfRough());
    if (hasSpecularLobes_) {
        first += lobes_.SpecularEnergy(false).Average();
        below = lobes_.SpecularEnergy(true).Average();
    }
    const float rough = std::max(lobes_.EnergyOfRough(), kMinShare * (first + below) + 1e-4f);
    firstShare_ = first / (first + below + rough);
    specularBelowShare_ = below / (first + below + rough);
}

BxDFContext LobeSampler::ReflectionOnly() const {
    BxDFContext reflection = context_;
    reflection.sides = Lobes::Reflection;
    reflection.needsPdf = true;
    return reflection;
}

float LobeSampler::Pdf(Vec3 wi) const {
    float pdf = (1 - firstShare_ - specularBelowShare_) * lobes_.Pdf(wi);
    if (!first_.isSpecular && SameHemisphere(wo_, wi))
        pdf += firstShare_ * first_.Evaluate(wo_, wi, ReflectionOnly()).pdf;
    return pdf;
}

std::optional<LobeSampler::Drawn> LobeSampler::SampleSpecular(bool isTransmitted, float probability) const {
    Drawn drawn{.wi = {-wo_.x, -wo_.y, wo_.z}, .pdf = probability, .isSpecular = true};
    if (isTransmitted) {
        const float x = -wo_.x / lobes_.Eta(), y = -wo_.y / lobes_.Eta(), z2 = 1 - x * x - y * y;
        if (!(z2 > 0)) return std::nullopt;
        drawn.wi = {x, y, std::copysign(std::sqrt(z2), -wo_.z)};
        drawn.energy = lobes_.SpecularEnergy(true);
        return drawn;
    }
    if (const auto s = first_.Sample(wo_, BxDFRandom{0, Point2(0.5f)}, ReflectionOnly());
        s && s->IsSpecular()) {
        drawn.energy = s->weight * s->pdf;
        drawn.wi = s->wi;  // of a perturbed normal, it takes the deeper mirrors' light along
    }
    if (hasSpecularLobes_) drawn.energy += lobes_.SpecularEnergy(false);
    return drawn;
}

std::optional<LobeSampler::Drawn> LobeSampler::Sample(const BxDFRandom& u) const {
    float lobe = u.lobe;
    Vec3 wi;
    if (lobe < firstShare_) {
        if (first_.isSpecular) return SampleSpecular(false, firstShare_);
        const auto s = first_.Sample(wo_, {lobe / firstShare_, u.direction}, ReflectionOnly());
        if (!s) return std::nullopt;
        wi = s->wi;
    } else if (lobe < firstShare_ + specularBelowShare_) {
        return SampleSpecular(true, specularBelowShare_);
    } else {
        const float taken = firstShare_ + specularBelowShare_;
        lobe = std::min((lobe - taken) / (1 - taken), OneMinusEpsilon);
        const std::optional<Vec3> drawn = lobes_.SampleDirection(lobe, u.direction);
        if (!drawn) return std::nullopt;
        wi = *drawn;
    }
    if (wi.z == 0) return std::nullopt;
    const float pdf = Pdf(wi);
    if (!(pdf > 0)) return std::nullopt;
    return Drawn{.wi = wi, .pdf = pdf, .isSpecular = false};
}

}  // namespace lacquer::layered
