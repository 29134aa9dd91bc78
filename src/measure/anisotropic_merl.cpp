#include "measure/anisotropic_merl.h"

#include <algorithm>
#include <cstring>

#include "measure/half_difference.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/rng.h"

namespace lacquer::measure {

namespace {

constexpr char kMagic[9] = "ANISMERL";
constexpr uint32_t kVersion = 1;

double MiddleOf(int cell, int count) { return (cell + 0.5) / count; }

}  // namespace

AnisotropicMerlTable TabulateAnisotropicMerl(const BsdfSubject& subject,
                                             AnisotropicMerlTable::Resolution resolution,
                                             const TableOptions& options, Observer* observer) {
    const auto& r = resolution;
    AnisotropicMerlTable table{r, {}};
    const size_t cells = table.NumCells();
    table.values.assign(3 * cells, -1.f);
    const int64_t batches = subject.IsStochastic() ? std::max(1, options.samples) : subject.NumVariants();
    const int64_t jobs = int64_t(r.half) * r.halfAzimuth;
    if (observer) observer->Begin("Tabulating", jobs, "");
    ParallelFor(jobs, [&](int64_t job) {
        Rng rng(Hash(options.seed, job));
        const SphericalAngles half{Sqr(MiddleOf(int(job / r.halfAzimuth), r.half)) * kPi / 2,
                                   MiddleOf(int(job % r.halfAzimuth), r.halfAzimuth) * 2 * kPi};
        size_t cell = size_t(job) * size_t(r.difference) * size_t(r.differenceAzimuth);
        for (int difference = 0; difference < r.difference; ++difference)
            for (int azimuth = 0; azimuth < r.differenceAzimuth; ++azimuth, ++cell) {
                const DirectionPair pair = PairOfAngles(half, {MiddleOf(difference, r.difference) * kPi / 2,
                                                               MiddleOf(azimuth, r.differenceAzimuth) * kPi});
                if (!(pair.wo.z > 0) || !(pair.wi.z > 0)) continue;
                const glm::dvec3 f =
                    subject.Evaluate(pair.wo, pair.wi, TransportMode::Radiance, batches, rng).Mean();
                for (int c = 0; c < 3; ++c)
                    table.values[size_t(c) * cells + cell] = float(std::max(0.0, f[c]));
            }
        if (observer) observer->Advance(1);
    });
    if (observer) observer->End();
    return table;
}

std::string AnisotropicMerlTable::Bytes() const {
    std::string bytes(kMagic, 8);
    const uint32_t head[] = {kVersion,
                             uint32_t(resolution.half),
                             uint32_t(resolution.halfAzimuth),
                             uint32_t(resolution.difference),
                             uint32_t(resolution.differenceAzimuth),
                             3};
    bytes.append(reinterpret_cast<const char*>(head), sizeof(head));
    return bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
}

}  // namespace lacquer::measure
