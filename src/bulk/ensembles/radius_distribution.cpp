#include "bulk/ensembles/radius_distribution.h"

#include <algorithm>

#include "pbrt/core/check.h"

namespace lacquer::bulk {
namespace {

constexpr double kCut = 3;  ///< deviations

}  // namespace

RadiusDistribution::RadiusDistribution(Kind kind, double center, double deviation)
    : kind_(kind), center_(center), deviation_(deviation) {
    lowestZ_ = -kCut;
    if (kind == Kind::Normal) lowestZ_ = std::max(lowestZ_, (1e-3 * center - center) / deviation);
    // Simpson's rule in deviations from the middle.
    constexpr int kSteps = 120;
    const double step = (kCut - lowestZ_) / kSteps;
    double sum = 0;
    for (int i = 0; i <= kSteps; ++i) {
        const double z = lowestZ_ + i * step;
        const double simpson = i == 0 || i == kSteps ? 1 : i % 2 == 1 ? 4 : 2;
        nodes_.push_back({RadiusAt(z), simpson * std::exp(-0.5 * z * z)});
        sum += nodes_.back().weight;
    }
    for (Node& node : nodes_) node.weight /= sum;
}

double RadiusDistribution::RadiusAt(double z) const {
    return kind_ == Kind::Normal ? center_ + deviation_ * z : center_ * std::exp(deviation_ * z);
}

RadiusDistribution RadiusDistribution::Constant(double radius) { return Table({{radius, 1}}); }

RadiusDistribution RadiusDistribution::Normal(double mean, double deviation) {
    return deviation > 0 ? RadiusDistribution(Kind::Normal, mean, deviation) : Constant(mean);
}

RadiusDistribution RadiusDistribution::LogNormal(double median, double sigma) {
    return sigma > 0 ? RadiusDistribution(Kind::LogNormal, median, sigma) : Constant(median);
}

RadiusDistribution RadiusDistribution::Table(std::vector<Node> nodes) {
    RadiusDistribution distribution;
    distribution.nodes_ = std::move(nodes);
    double sum = 0;
    for (const Node& node : distribution.nodes_) sum += node.weight;
    LACQUER_CHECK(sum > 0);
    for (Node& node : distribution.nodes_) node.weight /= sum;
    return distribution;
}

double RadiusDistribution::Sample(Random& random) const {
    if (kind_ == Kind::Discrete) {
        double u = nodes_.size() > 1 ? random.Uniform() : 0;
        for (const Node& node : nodes_) {
            if (u < node.weight) return node.radius;
            u -= node.weight;
        }
        return nodes_.back().radius;
    }
    while (true) {
        const double z = random.Normal();
        if (z >= lowestZ_ && z <= kCut) return RadiusAt(z);
    }
}

double RadiusDistribution::Moment(int power) const {
    double sum = 0;
    for (const Node& node : nodes_) sum += node.weight * std::pow(node.radius, power);
    return sum;
}

double RadiusDistribution::MeanVolume() const { return 4 * std::numbers::pi / 3 * Moment(3); }

double RadiusDistribution::Largest() const {
    return std::max_element(nodes_.begin(), nodes_.end(),
                            [](const Node& a, const Node& b) { return a.radius < b.radius; })
        ->radius;
}

}  // namespace lacquer::bulk
