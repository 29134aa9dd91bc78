#include "battery.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "cpu_time.h"

namespace lacquer::bench {
namespace {

constexpr size_t kBlocks = NoiseSums::kBlocks;
constexpr int kEstimatesPerTurn = 64;

/// Sums over the estimates of one estimator on one query.
struct Contender {
    const layered::LayeredEstimator* estimator;
    std::array<NoiseSums::Cell, kBlocks> blocks{};
    std::vector<double> seconds{};  ///< of each turn

    /// Where the stack frames lie changes the time of a walk, which has 20 kB in its own, by up to a tenth,
    /// and a change elsewhere in a program moves them [Mytkowicz et al. 2009]. So they lie elsewhere in each
    /// turn.
    void TurnAtRandomAddress(const layered::Stack& stack, const layered::test::RandomQuery& query,
                             uint64_t seed, size_t turn) {
        volatile char* const padding = static_cast<char*>(
            __builtin_alloca(16 + 16 * (Hash(seed, turn, seconds.size(), estimator) % 256)));
        padding[0] = 0;
        Turn(stack, query, seed, turn);
    }
    void Turn(const layered::Stack& stack, const layered::test::RandomQuery& query, uint64_t seed,
              size_t turn) {
        NoiseSums::Cell& cell = blocks[turn % kBlocks];
        Rng rng(Hash(seed, turn));
        const BxDFContext context{TransportMode::Radiance, Lobes::BothSides, &rng};
        const double start = CpuSeconds();
        for (int i = 0; i < kEstimatesPerTurn; ++i) {
            const double x = double(
                estimator->Evaluate(stack, query.wo, query.wi, context, layered::kMaxPathVertices).Average());
            cell.sum += x;
            cell.squares += x * x;
        }
        seconds.push_back(CpuSeconds() - start);
        cell.count += kEstimatesPerTurn;
    }
    double Variance(const std::array<double, kBlocks>& times, double floor) const {
        NoiseSums::Cell all;
        for (size_t i = 0; i < kBlocks; ++i) {
            all.count += times[i] * blocks[i].count;
            all.sum += times[i] * blocks[i].sum;
            all.squares += times[i] * blocks[i].squares;
        }
        const double mean = all.sum / all.count;
        return std::max(0., all.squares / all.count - mean * mean) + Sqr(floor);
    }
};

double Median(std::vector<double> values) {
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

double Quantile(std::vector<double> values, double q) {
    std::sort(values.begin(), values.end());
    const double at = q * double(values.size() - 1);
    const size_t below = size_t(at), above = std::min(below + 1, values.size() - 1);
    return std::lerp(values[below], values[above], at - double(below));
}

/// Standard error of the logarithm of the quotient of two variances, blocks drawn with replacement. Both get
/// the same blocks, since they had the same random numbers.
double NoiseOfLogRatio(const Contender& a, const Contender& b, const BatteryOptions& options, uint64_t seed) {
    Rng rng(Hash(seed));
    double sum = 0, squares = 0;
    for (int i = 0; i < options.numReplicas; ++i) {
        std::array<double, kBlocks> times{};
        for (size_t k = 0; k < kBlocks; ++k) ++times[rng.UniformInt(kBlocks)];
        const double x = std::log(a.Variance(times, options.floor) / b.Variance(times, options.floor));
        sum += x;
        squares += x * x;
    }
    const double n = options.numReplicas;
    return std::sqrt(std::max(0., squares / n - Sqr(sum / n)));
}

}  // namespace

EfficiencyRatio MeasureEfficiency(const layered::test::RandomQuery& query, uint64_t seed, uint64_t round,
                                  double seconds, const Candidate& baseline, const Candidate& candidate,
                                  const BatteryOptions& options) {
    Arena arena;
    const layered::Stack stack = query.row.Build(arena);
    const uint64_t numbers = Hash(seed, round);
    std::array<Contender, 2> both = {Contender{baseline.estimator}, Contender{candidate.estimator}};
    // Tables that an estimator makes at its first use, and the caches, are not measured.
    for (const Contender& contender : both) Contender{contender.estimator}.Turn(stack, query, numbers, 0);
    double used = 0;
    std::vector<double> quotients;
    for (size_t turn = 0; turn < kBlocks || used < 2 * seconds; ++turn) {
        for (size_t k = 0; k < 2; ++k) both[(k + turn) % 2].TurnAtRandomAddress(stack, query, numbers, turn);
        const double a = both[0].seconds.back(), b = both[1].seconds.back();
        used += a + b;
        quotients.push_back(a / b);
    }
    std::array<double, kBlocks> once;
    once.fill(1);
    EfficiencyRatio ratio;
    ratio.variance = both[0].Variance(once, options.floor) / both[1].Variance(once, options.floor);
    ratio.time = Median(quotients);
    ratio.value = ratio.variance * ratio.time;
    ratio.noise = NoiseOfLogRatio(both[0], both[1], options, numbers);
    ratio.hasSameEstimates = std::equal(both[0].blocks.begin(), both[0].blocks.end(), both[1].blocks.begin(),
                                        [](const NoiseSums::Cell& a, const NoiseSums::Cell& b) {
                                            return a.sum == b.sum && a.squares == b.squares;
                                        });
    return ratio;
}

namespace {

/// What is known of all queries.
class Battery {
  public:
    Battery(const Candidate& baseline, const Candidate& candidate, const BatteryOptions& options)
        : baseline_(baseline), candidate_(candidate), options_(options) {
        for (int i = 0; i < options.numQueries; ++i)
            queries_.push_back(layered::test::MakeRandomQuery(Hash(options.seed, i), options.isTurned));
        ratios_.resize(queries_.size());
        order_.resize(queries_.size());
        std::iota(order_.begin(), order_.end(), size_t(0));
    }

    /// The lowest of the queries, by what is known of them, once more.
    /// @return how many
    size_t Measure(uint64_t round, double share, double seconds) {
        const size_t count = size_t(std::ceil(share * double(order_.size())));
        for (size_t i = 0; i < count; ++i) {
            const size_t k = order_[i];
            ratios_[k] = MeasureEfficiency(queries_[k], Hash(options_.seed, k), round, seconds, baseline_,
                                           candidate_, options_);
        }
        std::sort(order_.begin(), order_.end(),
                  [&](size_t a, size_t b) { return ratios_[a].value < ratios_[b].value; });
        return count;
    }

    void Print() const {
        std::vector<double> values;
        for (const EfficiencyRatio& ratio : ratios_) values.push_back(ratio.value);
        fmt::print("percentile  efficiency  interval\n");
        for (const double percent : {0., 0.5, 1., 2., 5., 25., 50., 75., 95.}) {
            const Interval interval = IntervalOf(percent / 100);
            fmt::print("{:>10g} {:>11.3f}  [{:.3f}, {:.3f}]\n", percent, Quantile(values, percent / 100),
                       interval.low, interval.high);
        }
        const auto below = std::count_if(values.begin(), values.end(), [](double x) { return x < 0.95; });
        const auto same =
            std::count_if(ratios_.begin(), ratios_.end(), [](auto& r) { return r.hasSameEstimates; });
        double sum = 0;
        for (const double x : values) sum += std::log(x);
        fmt::print("geometric mean {:.3f}; {} of {} below 0.95; {} are left to {}\n",
                   std::exp(sum / double(values.size())), below, values.size(), same, baseline_.name);
        fmt::print("\nthe worst {}: efficiency (of it variance, time; error of the variance's log), query\n",
                   options_.numWorst);
        for (size_t i = 0; i < std::min(size_t(options_.numWorst), order_.size()); ++i) {
            const EfficiencyRatio& r = ratios_[order_[i]];
            fmt::print("{:.3f} ({:.3f}, {:.3f}; {:.3f}{}) #{} {}\n", r.value, r.variance, r.time, r.noise,
                       r.hasSameEstimates ? ", same" : "", order_[i], queries_[order_[i]].Describe());
        }
    }

  private:
    /// Both which queries were drawn and what was measured of each are left to chance.
    Interval IntervalOf(double quantile) const {
        Rng rng(Hash(options_.seed, quantile));
        std::vector<double> replicas;
        for (int i = 0; i < options_.numReplicas; ++i) {
            std::vector<double> values;
            for (size_t k = 0; k < ratios_.size(); ++k) {
                const EfficiencyRatio& r = ratios_[rng.UniformInt(uint32_t(ratios_.size()))];
                const Point2 u = rng.Uniform2D();
                const double normal =
                    std::sqrt(-2 * std::log(1 - double(u.x))) * std::cos(2 * double(Pi) * double(u.y));
                values.push_back(r.value * std::exp(r.noise * normal));
            }
            replicas.push_back(Quantile(values, quantile));
        }
        return CentralInterval(replicas, 0.95);
    }

    const Candidate &baseline_, &candidate_;
    const BatteryOptions& options_;
    std::vector<layered::test::RandomQuery> queries_;
    std::vector<EfficiencyRatio> ratios_;
    std::vector<size_t> order_;  ///< from the lowest ratio on
};

}  // namespace

void RunBattery(const Candidate& baseline, const Candidate& candidate, const BatteryOptions& options) {
    fmt::print(
        "\nbattery: efficiency, 1 / (variance * CPU time), of {} over that of {}; {} random queries, seed "
        "{}\n",
        candidate.name, baseline.name, options.numQueries, options.seed);
    Battery battery(baseline, candidate, options);
    // Shares of all queries, and how much longer each of them is measured.
    const struct { double share, times; } rounds[] = {{1, 1}, {0.2, 4}, {0.05, 16}};
    for (size_t i = 0; i < std::size(rounds); ++i) {
        const size_t count = battery.Measure(i, rounds[i].share, rounds[i].times * options.seconds);
        fmt::print("round {}: {} queries, {:g} s for each estimator\n", i + 1, count,
                   rounds[i].times * options.seconds);
        std::fflush(stdout);
    }
    battery.Print();
}

}  // namespace lacquer::bench
