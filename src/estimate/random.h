// Random numbers of the estimation, in double, by counter: what is drawn depends on what it is drawn for,
// never on the order in which threads come.
#pragma once

#include <algorithm>
#include <cstdint>

#include "estimate/linear_algebra.h"
#include "estimate/normal_distribution.h"
#include "pbrt/core/rng.h"

namespace lacquer::estimate {

/// The stream of random numbers that belongs to (seed, chain, step) or whatever else counts. A stream that is
/// made again gives the same numbers again, so no state of a generator needs to be kept.
class Random {
  public:
    template <class... Counters>
    explicit Random(uint64_t seed, Counters... counters) : rng_(Hash(seed, counters...)) {}
    /// In (0, 1), with 52 bits: neither end, so that quantiles are finite.
    double Uniform() { return (double(rng_.NextBits() >> 12) + 0.5) * 0x1p-52; }
    /// In [0, count), count > 0.
    size_t Index(size_t count) { return std::min(count - 1, size_t(Uniform() * double(count))); }
    double Normal() { return NormalQuantile(Uniform()); }
    Vector Normals(Eigen::Index count) {
        Vector z(count);
        for (double& value : z) value = Normal();
        return z;
    }
    uint64_t Bits() { return rng_.NextBits(); }

  private:
    Rng rng_;
};

}  // namespace lacquer::estimate
