#include "bulk/ensembles/ensemble.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "bulk/ensembles/hard_spheres.h"
#include "bulk/ensembles/structure.h"
#include "pbrt/core/check.h"
#include "pbrt/core/error.h"

namespace lacquer::bulk {
namespace {

[[noreturn]] void NoRoom(const EnsembleSettings& settings) {
    throw SceneError(
        {}, fmt::format("{} particles at a volume fraction of {:.3g} find no places in this arrangement; "
                        "hard spheres alone do to about 0.5",
                        settings.count, VolumeFractionOf(settings)));
}

std::vector<double> RadiiOf(const std::vector<Particle>& particles) {
    std::vector<double> radii;
    for (const Particle& particle : particles) radii.push_back(particle.radius);
    return radii;
}

void Place(const HardSpheres& spheres, std::vector<Particle>* particles) {
    for (size_t i = 0; i < particles->size(); ++i) (*particles)[i].center = spheres.Centers()[i];
}

}  // namespace

double VolumeFractionOf(const EnsembleSettings& settings) {
    double fraction = 0;
    for (const Species& species : settings.species) fraction += species.volumeFraction;
    return fraction;
}

Ensemble::Ensemble(EnsembleSettings settings) : settings_(std::move(settings)) {
    LACQUER_CHECK(!settings_.species.empty());
    for (const Species& species : settings_.species) {
        shares_.push_back(species.volumeFraction / species.radius.MeanVolume());
        numberDensity_ += shares_.back();
    }
    for (double& share : shares_)
        share = numberDensity_ > 0 ? share / numberDensity_ : 1 / double(shares_.size());
    const bool hasBall =
        settings_.arrangement != Arrangement::Gaussian && settings_.arrangement != Arrangement::List;
    if (hasBall && numberDensity_ > 0)
        ballRadius_ = std::cbrt(settings_.count / numberDensity_ * 3 / (4 * std::numbers::pi));
}

std::vector<Particle> Ensemble::Realize(uint64_t seed, uint64_t realization) const {
    Random random(Hash(seed, realization));
    std::vector<Particle> particles = Arrange(random);
    const bool hasShape =
        settings_.arrangement == Arrangement::List || settings_.arrangement == Arrangement::Gaussian;
    if (!settings_.isOriented && !hasShape) return particles;
    const Eigen::Matrix3d rotation = settings_.isOriented ? random.RotationKeepingAxis() : random.Rotation();
    for (Particle& particle : particles) particle.center = rotation * particle.center;
    return particles;
}

std::vector<Particle> Ensemble::Arrange(Random& random) const {
    switch (settings_.arrangement) {
        case Arrangement::Uniform:
        case Arrangement::PoissonDisc:
            return InBall(random);
        case Arrangement::Cut:
            return CutFromBox(random);
        case Arrangement::Clumped:
            return AboutParents(random);
        case Arrangement::Gaussian:
            return AboutOrigin(random);
        case Arrangement::List:
            break;
    }
    return settings_.particles;
}

// Species by their shares, as evenly as whole numbers allow; larger ones first, which are harder to place.
std::vector<Particle> Ensemble::SampleParticles(int count, Random& random) const {
    std::vector<Particle> particles;
    const double offset = random.Uniform();
    double sum = 0;
    int drawn = 0;
    for (size_t s = 0; s < shares_.size(); ++s) {
        sum += shares_[s];
        const int upTo = s + 1 == shares_.size() ? count : int(std::floor(sum * count + offset));
        for (; drawn < std::min(upTo, count); ++drawn)
            particles.push_back({Point(0, 0, 0), settings_.species[s].radius.Sample(random), int(s)});
    }
    std::stable_sort(particles.begin(), particles.end(),
                     [](const Particle& a, const Particle& b) { return a.radius > b.radius; });
    return particles;
}

std::vector<Particle> Ensemble::InBall(Random& random) const {
    std::vector<Particle> particles = SampleParticles(settings_.count, random);
    const bool isDisc = settings_.arrangement == Arrangement::PoissonDisc;
    HardSpheres spheres({Domain::Kind::Ball, ballRadius_}, RadiiOf(particles),
                        isDisc ? settings_.minDistance : 1);
    if (!(isDisc ? spheres.AddAll(random) : spheres.AddAllByGrowth(random))) NoRoom(settings_);
    if (!isDisc) spheres.Move(random, settings_.movesPerSphere);
    Place(spheres, &particles);
    return particles;
}

std::vector<Particle> Ensemble::CutFromBox(Random& random) const {
    constexpr double kSideOverRadius = 2.5;
    const Domain box{Domain::Kind::PeriodicBox, kSideOverRadius * ballRadius_};
    // Numbers fluctuate in an endless medium, in this box as in any: by the compressibility, which is S(0). A
    // fixed number would leave too little light straight on.
    double fraction = 0;
    for (const Species& species : settings_.species) fraction += species.volumeFraction;
    const double mean = numberDensity_ * box.Volume();
    const double deviation = std::sqrt(mean * PercusYevickStructureFactor(fraction, 0));
    const double drawn = mean + deviation * random.Normal();
    const int count = std::max(0, int(std::floor(drawn + random.Uniform())));
    std::vector<Particle> particles = SampleParticles(count, random);
    HardSpheres spheres(box, RadiiOf(particles));
    if (!spheres.AddAllByGrowth(random)) NoRoom(settings_);
    spheres.Move(random, settings_.movesPerSphere);
    const Point middle = box.RandomPoint(random);
    std::vector<Particle> inside;
    for (size_t i = 0; i < particles.size(); ++i) {
        const Point center = box.Displacement(middle, spheres.Centers()[i]);
        if (center.norm() <= ballRadius_)
            inside.push_back({center, particles[i].radius, particles[i].species});
    }
    return inside;
}

// A cluster process without overlaps: parents uniform in the ball, children normal about a random one.
std::vector<Particle> Ensemble::AboutParents(Random& random) const {
    std::vector<Particle> particles = SampleParticles(settings_.count, random);
    double meanRadius = 0;
    for (const Particle& particle : particles) meanRadius += particle.radius / double(particles.size());
    std::vector<Point> parents;
    const int numParents = std::max(1, settings_.count / std::max(1, settings_.children));
    for (int i = 0; i < numParents; ++i) parents.push_back(random.InBall(ballRadius_));
    HardSpheres spheres({Domain::Kind::Ball, ballRadius_}, RadiiOf(particles));
    constexpr int kMaxTries = 100000;
    int tries = 0;
    while (spheres.Count() < int(particles.size())) {
        const Point& parent = parents[random.Index(parents.size())];
        if (spheres.AddAt(parent + settings_.spread * meanRadius * random.NormalPoint())) tries = 0;
        if (++tries > kMaxTries) NoRoom(settings_);
    }
    Place(spheres, &particles);
    return particles;
}

std::vector<Particle> Ensemble::AboutOrigin(Random& random) const {
    std::vector<Particle> particles = SampleParticles(settings_.count, random);
    constexpr double kCut = 3;
    const double reach =
        kCut * settings_.deviations.maxCoeff() + (particles.empty() ? 0 : particles[0].radius);
    HardSpheres spheres({Domain::Kind::Ball, 2 * reach}, RadiiOf(particles));
    constexpr int kMaxTries = 100000;
    int tries = 0;
    while (spheres.Count() < int(particles.size())) {
        const Point z = random.NormalPoint();
        if (z.cwiseAbs().maxCoeff() > kCut) continue;
        if (spheres.AddAt(settings_.deviations.cwiseProduct(z))) tries = 0;
        if (++tries > kMaxTries) NoRoom(settings_);
    }
    Place(spheres, &particles);
    return particles;
}

}  // namespace lacquer::bulk
