// Searches orders of the Sobol points by which pairs of dimensions are well distributed together, and prints
// the matrices of src/pbrt/samplers/joint_orders.cpp: sobol_orders [FIRST_SEED [LAST_SEED]], a second or two
// each; 1 to 240 by default, of which 123 is the best.
//
// Orders are found one after the other, those of the dimensions that paths use most first, and column by
// column: each column is the one for which as many points as it completes have the least noise with all
// orders before. Ties are broken at random. The best of all seeds has the least noise in all, over numbers of
// points.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <random>
#include <vector>

#include "pbrt/samplers/joint_orders.h"
#include "samplers/net_gains.h"

namespace lacquer {
namespace {

using test::BitMatrix;
using test::MeanGain;
using test::PairOfDimensions;

constexpr int kBits = JointOrders::kBits, kCount = 13;
/// How much the dimensions of a path count: the position in the pixel (0), wavelengths (2), time (3), lens
/// (4), and at its first vertex, with or without a flight through a medium before it, a light (6, 7), a point
/// on it (7, 8), a lobe (9, 10) and a direction (10, 11). Those that count little have an order in the
/// search, but none in the sampler.
constexpr std::array<double, kCount> kWeights{1.2, 0.3, 1, 0.2, 0.4, 0.2, 1, 1, 0.8, 1, 1, 0.8, 0.3};
constexpr std::array<int, kCount> kByWeight{0, 2, 6, 7, 9, 10, 8, 11, 4, 1, 12, 3, 5};
/// Columns that are tried, at random where there are more; interactions of three pairs are looked at for so
/// few points.
constexpr int kMaxBitsOfThree = 8;
constexpr uint32_t MaxTries(int m) { return m <= 8 ? 128 : 64; }

struct Chosen {
    int dimension;
    PairOfDimensions pair;
};

BitMatrix Identity() {
    BitMatrix matrix{};
    for (size_t row = 0; row < matrix.size(); ++row) matrix[row] = uint32_t(1) << row;
    return matrix;
}

/// Noise of interactions between two pairs, of two, three and four of their dimensions.
double Noise(const PairOfDimensions& a, const PairOfDimensions& b, int m) {
    using Three = std::array<const BitMatrix*, 3>;
    double three = 0;
    for (const Three& dimensions :
         {Three{&a.x, &a.y, &b.x}, Three{&a.x, &a.y, &b.y}, Three{&a.x, &b.x, &b.y}, Three{&a.y, &b.x, &b.y}})
        three += MeanGain(dimensions, m, 3);
    return MeanGainAcross(a, b, m) + 0.12 * three + 0.2 * MeanGain(std::array{&a.x, &a.y, &b.x, &b.y}, m, 2);
}

/// Of one dimension of each of three pairs.
double Noise(const PairOfDimensions& a, const PairOfDimensions& b, const PairOfDimensions& c, int m) {
    double sum = 0;
    for (const BitMatrix* i : {&a.x, &a.y})
        for (const BitMatrix* j : {&b.x, &b.y})
            for (const BitMatrix* k : {&c.x, &c.y}) sum += MeanGain(std::array{i, j, k}, m, 2);
    return sum / 8;
}

/// Of a new order with all before it. More than `most` may be any number above that.
double Noise(const BitMatrix& order, int dimension, const std::vector<Chosen>& before, int m, double most) {
    const PairOfDimensions pair(order);
    const auto weight = [&](const Chosen& c) { return kWeights[size_t(c.dimension)]; };
    const double own = kWeights[size_t(dimension)];
    double sum = 0;
    for (const Chosen& c : before) {
        sum += own * weight(c) * Noise(c.pair, pair, m);
        if (sum > most) return sum;
    }
    for (size_t i = 0; m <= kMaxBitsOfThree && i < before.size(); ++i)
        for (size_t j = 0; j < i; ++j)
            sum += 0.25 * own * weight(before[i]) * weight(before[j]) *
                   Noise(before[i].pair, before[j].pair, pair, m);
    return sum;
}

BitMatrix FindOrder(int dimension, const std::vector<Chosen>& before, std::mt19937* rng) {
    BitMatrix order = Identity();
    for (int m = 2; m <= kBits; ++m) {
        const uint32_t all = uint32_t(1) << (m - 1);
        const auto withColumn = [&](uint32_t column) {
            BitMatrix matrix = order;
            for (int row = 0; row < m - 1; ++row) matrix[size_t(row)] |= (column >> row & 1) << (m - 1);
            return matrix;
        };
        double least = std::numeric_limits<double>::max();
        std::vector<uint32_t> best;
        for (uint32_t i = 0; i < std::min(all, MaxTries(m)); ++i) {
            const uint32_t column = all <= MaxTries(m) ? i : uint32_t((*rng)()) % all;
            const double noise = Noise(withColumn(column), dimension, before, m, least);
            constexpr double kSame = 1e-9;
            if (noise < least - kSame) {
                least = noise;
                best.clear();
            }
            if (noise <= least + kSame) best.push_back(column);
        }
        order = withColumn(best[(*rng)() % best.size()]);
    }
    return order;
}

std::vector<Chosen> FindOrders(unsigned seed) {
    std::mt19937 rng(seed);
    std::vector<Chosen> orders{{kByWeight[0], PairOfDimensions(Identity())}};
    for (size_t i = 1; i < kByWeight.size(); ++i)
        orders.push_back({kByWeight[i], PairOfDimensions(FindOrder(kByWeight[i], orders, &rng))});
    return orders;
}

/// Means of interactions of two pairs and of three, added up over numbers of points.
double TotalNoise(const std::vector<Chosen>& orders) {
    double total = 0;
    for (int m = 2; m <= 10; ++m) {
        double two = 0, sumOfTwo = 0, three = 0, sumOfThree = 0;
        for (size_t i = 0; i < orders.size(); ++i)
            for (size_t j = 0; j < i; ++j) {
                const double ij =
                    kWeights[size_t(orders[i].dimension)] * kWeights[size_t(orders[j].dimension)];
                two += ij * Noise(orders[i].pair, orders[j].pair, m);
                sumOfTwo += ij;
                for (size_t k = 0; k < j; ++k) {
                    const double ijk = ij * kWeights[size_t(orders[k].dimension)];
                    three += ijk * Noise(orders[i].pair, orders[j].pair, orders[k].pair, m);
                    sumOfThree += ijk;
                }
            }
        // Numbers of samples that are asked for most, at most: 16, 64 and 256.
        const double weight = m % 2 || m == 2 ? 0.3 : m == 10 ? 0.6 : m == 6 ? 1.2 : 1;
        constexpr double kOfIndependent = 1.68;  // of Noise() of two pairs
        total += weight * (two / sumOfTwo / kOfIndependent + 0.3 * three / sumOfThree);
    }
    return total;
}

void Print(const std::vector<Chosen>& orders) {
    for (const int dimension : JointOrders::kDimensions) {
        const auto order = std::find_if(orders.begin(), orders.end(),
                                        [&](const Chosen& c) { return c.dimension == dimension; });
        std::printf("    {{");
        for (size_t row = 0; row < order->pair.x.size(); ++row)
            std::printf("%s0x%03x", row ? ", " : "", order->pair.x[row]);
        std::printf("}},\n");
    }
}

void Search(int firstSeed, int lastSeed) {
    double least = std::numeric_limits<double>::max();
    std::vector<Chosen> best;
    for (int seed = firstSeed; seed <= lastSeed; ++seed) {
        const std::vector<Chosen> orders = FindOrders(unsigned(seed));
        const double noise = TotalNoise(orders);
        std::fprintf(stderr, "seed %d: %.3f\n", seed, noise);
        if (noise < least) best = orders;
        least = std::min(least, noise);
    }
    Print(best);
}

}  // namespace
}  // namespace lacquer

int main(int argc, char** argv) {
    const int first = argc > 1 ? std::atoi(argv[1]) : 1;
    const int last = argc > 2 ? std::atoi(argv[2]) : argc > 1 ? first : 240;
    lacquer::Search(first, std::max(first, last));
}
