#include "bulk/input/particle_list.h"

#include <cmath>
#include <map>
#include <numeric>

#include "bulk/input/particles_input.h"

namespace lacquer::bulk {
namespace {

class ListReader {
  public:
    ListReader(const ParticlesJson& file, BulkSettings* settings)
        : file_(file), settings_(settings), ensemble_(settings->ensemble) {}

    void Read(const std::string& at) {
        const size_t count = file_.NumItems(at, "a list of particles");
        constexpr int kMinUnknowns = 70;  // of a particle
        if (double(count) * kMinUnknowns > kMaxUnknowns)
            file_.Fail(at, fmt::format("there are {} particles; expected at most {}", count,
                                       int(kMaxUnknowns / kMinUnknowns)));
        std::vector<Particle>& particles = ensemble_.particles;
        for (size_t i = 0; i < count; ++i) {
            const std::string each = fmt::format("{}/{}", at, i);
            file_.CheckKeys(each, {"center", "radius", "species"});
            const std::vector<double> center =
                file_.Numbers(each + "/center", JsonReader::Length{3, "x, y and z"}, -1e12, 1e12);
            Particle particle;
            particle.center = file_.Unit() * Point(center[0], center[1], center[2]);
            particle.species = SpeciesOf(each);
            particle.radius = file_.Has(each + "/radius")
                                  ? file_.Radius(each + "/radius")
                                  : ensemble_.species[size_t(particle.species)].radius.Moment(1);
            if (file_.Has(each + "/radius")) file_.CheckSize(each + "/radius", *settings_, particle.radius);
            particles.push_back(particle);
        }
        ensemble_.count = int(count);
        CheckOverlaps(at);
        TakeRadiiOfList(at);
        if (settings_->mode == AverageMode::Aggregate) MoveToOrigin();
    }

  private:
    /// The middle of the box about all particles becomes the origin. A shift by d takes F(s) for light along
    /// n to exp(i k (n - s).d) F(s): intensities, which are all that the mode Aggregate averages, stay, and
    /// waves about the origin need a degree that goes with the cluster's size only. Means of F over
    /// realisations, in other modes, do depend on the point about which these are turned.
    void MoveToOrigin() {
        Point low = Point::Constant(JsonReader::kInf), high = -low;
        for (const Particle& particle : ensemble_.particles) {
            low = low.cwiseMin((particle.center.array() - particle.radius).matrix());
            high = high.cwiseMax((particle.center.array() + particle.radius).matrix());
        }
        for (Particle& particle : ensemble_.particles) particle.center -= 0.5 * (low + high);
    }
    int SpeciesOf(const std::string& at) const {
        const std::vector<Species>& species = ensemble_.species;
        if (!file_.Has(at + "/species") && species.size() == 1) return 0;
        Choices<int> choices;
        for (size_t i = 0; i < species.size(); ++i) choices.emplace_back(species[i].name, int(i));
        return file_.Choice(at + "/species", choices);
    }
    /// What species are said to be must be what the list has: their radii become those of the list, and their
    /// volume fractions must have its ratios.
    void TakeRadiiOfList(const std::string& at) {
        std::vector<Species>& species = ensemble_.species;
        std::vector<double> volumes(species.size());
        for (size_t i = 0; i < species.size(); ++i) {
            std::map<double, double> counts;
            for (const Particle& particle : ensemble_.particles) {
                if (particle.species != int(i)) continue;
                ++counts[particle.radius];
                volumes[i] += particle.radius * particle.radius * particle.radius;
            }
            if (counts.empty())
                file_.Fail(at,
                           fmt::format("no particle is of the species \"{}\"; expected at least one of each",
                                       species[i].name));
            std::vector<RadiusDistribution::Node> nodes;
            for (const auto& [radius, count] : counts) nodes.push_back({radius, count});
            species[i].radius = RadiusDistribution::Table(std::move(nodes));
        }
        const double all = std::accumulate(volumes.begin(), volumes.end(), 0.),
                     fraction = VolumeFractionOf(ensemble_);
        for (size_t i = 0; i < species.size(); ++i) {
            const double expected = fraction * volumes[i] / all;
            if (std::abs(species[i].volumeFraction - expected) > 0.01 * expected)
                file_.Fail(
                    fmt::format("/species/{}/volume fraction", i),
                    fmt::format("found {:.6g}; expected {:.6g}: of {:.6g} that all species have, as much as "
                                "of the list's volume",
                                species[i].volumeFraction, expected, fraction));
        }
    }
    void CheckOverlaps(const std::string& at) const {
        constexpr double kTouching = 1e-9;
        const std::vector<Particle>& particles = ensemble_.particles;
        for (size_t i = 0; i < particles.size(); ++i)
            for (size_t j = i + 1; j < particles.size(); ++j) {
                const double reach = particles[i].radius + particles[j].radius,
                             distance = (particles[i].center - particles[j].center).norm();
                if (distance < reach * (1 - kTouching))
                    file_.Fail(fmt::format("{}/{}", at, j),
                               fmt::format("this particle, number {}, overlaps number {} by {:.6g} um: their "
                                           "centres are {:.6g} um apart, their radii add up to {:.6g} um",
                                           j + 1, i + 1, reach - distance, distance, reach));
            }
    }

    const ParticlesJson& file_;
    BulkSettings* settings_;
    EnsembleSettings& ensemble_;
};

}  // namespace

void ReadParticleList(const ParticlesJson& file, const std::string& pointer, BulkSettings* settings) {
    ListReader(file, settings).Read(pointer);
}

}  // namespace lacquer::bulk
