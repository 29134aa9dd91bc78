// The mode "medium" gives the light that a ball of the medium scatters beside its mean field, and what its
// particles absorb. Where the ball is thick that light was scattered several times on its way out. But energy
// is conserved: both together are what the mean field loses. For a ray at the distance b (radii) from the
// middle that is 1 - exp(-t sqrt(1 - b^2)), if t is the optical thickness across the middle, and so
//
//   C_sca + C_abs = pi R^2 LostShare(t),   LostShare(t) = 2 int_0^1 b (1 - exp(-t sqrt(1 - b^2))) db
//                                                       = 1 - 2 (1 - (1 + t) exp(-t)) / t^2,         (1)
//
// which has one solution t. Random walks in a ball of this t that absorbs nothing tell the shares q_n that
// leave it after n events. With an albedo w each event leaves w of the light:
//
//   C_sca / (C_sca + C_abs) = sum_n q_n w^n,                                                          (2)
//
// again with one solution. What leaves after n events has the moment (mean of P_l of the cosine to the first
// direction) y_l^n if y_l is that of one event, were it not for where it leaves: light that was deflected
// less has another way out. So the moment of all, m_l, is
//
//   m_l = sum_n s_n y_l^n + d_l,    s_n = q_n w^n / sum_n q_n w^n,                                    (3)
//
// with the small difference d_l from the walks themselves; they need p, so (2) and (3) are solved a few
// times.
#include "bulk/table/ball_inversion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "bulk/ensembles/random.h"
#include "pbrt/core/check.h"
#include "pbrt/core/rng.h"
#include "pbrt/scattering/bulk_table.h"

namespace lacquer::bulk {
namespace {

constexpr double kPi = std::numbers::pi;
/// Light is followed through so many events; what is still in the ball counts as leaving then.
constexpr int kMaxEvents = 400;

std::vector<double> CosinesOf(std::span<const double> angles) {
    std::vector<double> cosines;
    for (const double angle : angles) cosines.push_back(std::cos(angle * kPi / 180));
    return cosines;
}

/// P_0 ... P_degree.
void Legendre(double cosine, std::span<double> values) {
    values[0] = 1;
    if (values.size() > 1) values[1] = cosine;
    for (size_t n = 2; n < values.size(); ++n)
        values[n] = (double(2 * n - 1) * cosine * values[n - 1] - double(n - 1) * values[n - 2]) / double(n);
}

/// Means of P_0 ... over p, linear in the cosine between nodes: two points a step are enough for what p
/// resolves.
std::vector<double> MomentsOf(std::span<const double> cosines, std::span<const double> phase, size_t count) {
    std::vector<double> moments(count, 0.), values(count);
    const double gauss = 0.5 - 0.5 / std::sqrt(3.);
    for (size_t i = 0; i + 1 < cosines.size(); ++i)
        for (const double t : {gauss, 1 - gauss}) {
            Legendre(cosines[i] + t * (cosines[i + 1] - cosines[i]), values);
            const double weight =
                kPi * (cosines[i] - cosines[i + 1]) * (phase[i] + t * (phase[i + 1] - phase[i]));
            for (size_t n = 0; n < count; ++n) moments[n] += weight * values[n];
        }
    const double sum = moments[0];
    for (double& moment : moments) moment /= sum;
    return moments;
}

/// Root of an increasing function.
template <class Function>
double Solve(const Function& function, double value, double low, double high) {
    constexpr int kHalvings = 80;
    for (int i = 0; i < kHalvings; ++i) {
        const double middle = 0.5 * (low + high);
        (function(middle) < value ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

/// Cosines of scattering angles.
class CosineSampler {
  public:
    CosineSampler(std::span<const double> cosines, std::span<const double> phase)
        : cosines_(cosines), phase_(phase), cdf_{0} {
        for (size_t i = 0; i + 1 < cosines.size(); ++i)
            cdf_.push_back(cdf_.back() + 0.5 * (cosines[i] - cosines[i + 1]) * (phase[i] + phase[i + 1]));
    }
    double Sample(Random& random) const {
        const double x = random.Uniform() * cdf_.back();
        const size_t last = cdf_.size() - 2;
        const size_t i =
            std::min(last, size_t(std::upper_bound(cdf_.begin() + 1, cdf_.end(), x) - cdf_.begin()) - 1);
        // Linear between nodes: the root of a t + (b - a) t^2 / 2 = u (a + b) / 2.
        const double a = phase_[i], b = phase_[i + 1];
        const double u = std::clamp((x - cdf_[i]) / (cdf_[i + 1] - cdf_[i]), 0., 1.);
        const double t = u * (a + b) / (a + std::sqrt(a * a + u * (b * b - a * a)));
        return cosines_[i] + std::min(t, 1.) * (cosines_[i + 1] - cosines_[i]);
    }

  private:
    std::span<const double> cosines_, phase_;
    std::vector<double> cdf_;
};

Point Deflected(const Point& d, double cosine, double azimuth) {
    const Point helper = std::abs(d.z()) < 0.7 ? Point(0, 0, 1) : Point(1, 0, 0);
    const Point u = d.cross(helper).normalized(), v = d.cross(u);
    const double sine = std::sqrt(std::max(0., 1 - cosine * cosine));
    return (cosine * d + sine * (std::cos(azimuth) * u + std::sin(azimuth) * v)).normalized();
}

/// What leaves a ball that absorbs nothing, of the light that it scatters: after n events (index n) the
/// share, and the sum of P_l of the directions in which it leaves.
struct Orders {
    std::vector<double> shares;
    std::vector<std::vector<double>> moments;
};

/// @param ofOne  moments of `sampler`. What leaves after one event has moments near them: they replace, as a
///               control variate, those that walks found for the first event of all light.
Orders WalkInBall(double thickness, const CosineSampler& sampler, std::span<const double> ofOne) {
    const size_t numMoments = ofOne.size();
    constexpr int kWalks = 100000;
    Orders orders{std::vector<double>(kMaxEvents + 1, 0.), {}};
    orders.moments.assign(kMaxEvents + 1, {});
    std::vector<double> values(numMoments), first(numMoments, 0.);
    double sum = 0;
    for (int walk = 0; walk < kWalks; ++walk) {
        Random random(Hash(uint64_t(walk), uint64_t(kWalks)));
        const double b = std::sqrt((walk + random.Uniform()) / kWalks), half = std::sqrt(1 - b * b);
        // What passes through is not followed.
        const double weight = -std::expm1(-half * thickness);
        const double flight = -2 / thickness * std::log1p(-weight * random.Uniform());
        Point at(b, 0, flight - half), direction(0, 0, 1);
        int events = 0;
        while (events < kMaxEvents && at.squaredNorm() <= 1) {
            ++events;
            direction = Deflected(direction, sampler.Sample(random), 2 * kPi * random.Uniform());
            if (events == 1) {
                Legendre(direction.z(), values);
                for (size_t l = 0; l < numMoments; ++l) first[l] += weight * values[l];
            }
            at -= 2 / thickness * std::log(1 - random.Uniform()) * direction;
        }
        Legendre(direction.z(), values);
        std::vector<double>& moments = orders.moments[size_t(events)];
        moments.resize(numMoments, 0.);
        orders.shares[size_t(events)] += weight;
        for (size_t l = 0; l < numMoments; ++l) moments[l] += weight * values[l];
        sum += weight;
    }
    for (double& share : orders.shares) share /= sum;
    for (std::vector<double>& moments : orders.moments)
        for (double& moment : moments) moment /= sum;
    if (!orders.moments[1].empty())
        for (size_t l = 0; l < numMoments; ++l)
            orders.moments[1][l] -= orders.shares[1] * (first[l] / sum - ofOne[l]);
    return orders;
}

/// Sum of shares times y^n.
double PowerSum(std::span<const double> shares, double y) {
    double sum = 0;
    for (size_t n = shares.size(); n-- > 0;) sum = sum * y + shares[n];
    return sum;
}

/// As many as are not noise, and at most what p at some hundred angles resolves.
size_t NumMoments(std::span<const double> cosines, std::span<const double> phase) {
    constexpr size_t kFewest = 9, kMost = 65;
    constexpr double kNoise = 0.005;
    const std::vector<double> moments = MomentsOf(cosines, phase, kMost);
    size_t count = kFewest;
    while (count < kMost && std::abs(moments[count]) > kNoise) ++count;
    return count;
}

double ThicknessOf(double lost) {
    constexpr double kThickest = 50;
    return Solve(LostShare, lost, 0, kThickest);
}

double AlbedoOf(const Orders& orders, double scattered, double absorbed) {
    if (absorbed == 0) return 1;
    return Solve([&](double w) { return PowerSum(orders.shares, w); }, scattered / (scattered + absorbed), 0,
                 1);
}

/// (3) for given walks.
struct Deconvolved {
    double single;
    std::vector<double> rise;  ///< of each moment, from that of the ball
};
Deconvolved Deconvolve(const Orders& orders, double albedo, std::span<const double> measured,
                       std::span<const double> ofOne) {
    std::vector<double> shares(orders.shares.size(), 0.), leaving(measured.size(), 0.);
    const double kept = PowerSum(orders.shares, albedo);
    double left = 1 / kept;
    for (size_t n = 1; n < shares.size(); ++n) {
        left *= albedo;
        shares[n] = orders.shares[n] * left;
        for (size_t l = 0; l < orders.moments[n].size(); ++l) leaving[l] += orders.moments[n][l] * left;
    }
    Deconvolved result{shares[1], {}};
    const auto powers = [&](double y) { return PowerSum(shares, y); };
    for (size_t l = 0; l < measured.size(); ++l) {
        const double wanted = measured[l] - (leaving[l] - powers(ofOne[l]));
        const double y = wanted > 0 ? Solve(powers, wanted, 0, 1) : Solve(powers, wanted, -0.5, 0);
        result.rise.push_back(l == 0 ? 0 : y - measured[l]);
    }
    return result;
}

/// Linear: with losses that are larger by their errors, one after the other. By small steps at most, as a
/// ball that is almost black has no room for more, and the same ones at all thicknesses.
void PutErrors(const BallLosses& losses, const CosineSampler& sampler, MediumOfBall* medium) {
    constexpr double kLargestStep = 0.01;
    static_assert(kLargestLostShare + kLargestStep < 0.99, "of which ThicknessOf() must know the thickness");
    const auto add = [&](double scattered, double absorbed, double perStep) {
        const double t = ThicknessOf(scattered + absorbed);
        constexpr double kNoMoments[] = {1};
        const double w = absorbed > 0 ? AlbedoOf(WalkInBall(t, sampler, kNoMoments), scattered, absorbed) : 1;
        medium->scattering.error += perStep * std::abs(t * w - medium->scattering.mean);
        medium->absorption.error += perStep * std::abs(t * (1 - w) - medium->absorption.mean);
    };
    const auto &s = losses.scattered, &a = losses.absorbed;
    const auto stepOf = [&](double error) { return std::min(error, kLargestStep); };
    if (s.error > 0) add(s.mean + stepOf(s.error), a.mean, s.error / stepOf(s.error));
    if (a.error > 0) add(s.mean, a.mean + stepOf(a.error), a.error / stepOf(a.error));
}

}  // namespace

double LostShare(double thickness) {
    // Below it the leading terms of the series: the closed form loses digits.
    constexpr double kSmall = 1e-3;
    const double t = thickness;
    return t < kSmall ? t * (2. / 3 - t / 4) : 1 - 2 * (1 - (1 + t) * std::exp(-t)) / (t * t);
}

MediumOfBall InvertBall(const BallLosses& losses, std::span<const double> angles,
                        std::span<const double> phase) {
    LACQUER_CHECK(losses.scattered.mean > 0 && losses.absorbed.mean >= 0 &&
                  losses.Sum() <= kLargestLostShare && angles.size() == phase.size());
    constexpr int kIterations = 4;
    MediumOfBall medium;
    const double thickness = ThicknessOf(losses.Sum());
    medium.phase.assign(phase.begin(), phase.end());
    const std::vector<double> cosines = CosinesOf(angles);
    const std::vector<double> measured = MomentsOf(cosines, phase, NumMoments(cosines, phase));
    std::vector<double> values(measured.size());
    for (int iteration = 0; iteration < kIterations; ++iteration) {
        const std::vector<double> ofOne = MomentsOf(cosines, medium.phase, measured.size());
        const Orders orders = WalkInBall(thickness, CosineSampler(cosines, medium.phase), ofOne);
        const double albedo = AlbedoOf(orders, losses.scattered.mean, losses.absorbed.mean);
        const Deconvolved found = Deconvolve(orders, albedo, measured, ofOne);
        medium.scattering.mean = thickness * albedo;
        medium.absorption.mean = thickness * (1 - albedo);
        medium.single = found.single;
        for (size_t i = 0; i < cosines.size(); ++i) {
            Legendre(cosines[i], values);
            double value = phase[i];
            for (size_t l = 1; l < values.size(); ++l)
                value += double(2 * l + 1) / (4 * kPi) * found.rise[l] * values[l];
            medium.phase[i] = std::max(0., value);
        }
        const double norm = NormOfPhase(angles, medium.phase);
        for (double& value : medium.phase) value /= norm;
    }
    PutErrors(losses, CosineSampler(cosines, medium.phase), &medium);
    return medium;
}

}  // namespace lacquer::bulk
