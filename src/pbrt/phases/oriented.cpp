#include "pbrt/phases/oriented.h"

#include "pbrt/core/check.h"
#include "pbrt/phases/microflakes.h"
#include "pbrt/scattering/oriented_table.h"

namespace lacquer {
namespace {

/// 1 - |cos| of the angle to the axis, without cancellation near it.
float OneMinusAbsCos(Vec3 w) { return (w.x * w.x + w.y * w.y) / (1 + std::abs(w.z)); }

/// S of one wavelength, reciprocal to the bit: what the file has is so to its digits.
std::vector<double> ScatteredLight(const OrientedBulkTable& table, const OrientedGrid& grid, size_t row) {
    std::vector<double> scattered(table.phase[row].begin(), table.phase[row].end());
    const size_t perIncidence = grid.Size() / grid.NumIncidences();
    for (size_t i = 0; i < scattered.size(); ++i) scattered[i] *= table.sigmaS[row][i / perIncidence];
    MakeReciprocal(grid, table.sigmaS[row], scattered);
    return scattered;
}

}  // namespace

OrientedPhaseTable::OrientedPhaseTable(const OrientedBulkTable& table)
    : wavelengths_(table.wavelengths.begin(), table.wavelengths.end()),
      numAngles_(table.angles.size()),
      numAzimuths_(size_t(table.numAzimuths)) {
    const OrientedGrid grid(table);
    LACQUER_CHECK(table.phase.size() == wavelengths_.size());
    for (size_t i = 0; i < grid.NumIncidences(); ++i)
        nodes_.push_back(float(2 * Sqr(std::sin(table.angles[i] * (M_PI / 360)))));
    values_.reserve(wavelengths_.size() * grid.Size());
    for (size_t row = 0; row < wavelengths_.size(); ++row) {
        for (const double value : ScatteredLight(table, grid, row)) values_.push_back(float(value));
        const float* values = &values_[row * grid.Size()];
        std::vector<double> extinctions;
        for (size_t i = 0; i < grid.NumIncidences(); ++i) {
            // Integrals of the very numbers that are rendered.
            std::vector<double> sums{0};
            for (size_t j = 0; j < numAngles_; ++j)
                overAzimuth_.push_back(float(grid.OverAzimuth(values + grid.Index(i, j))));
            const float* over = &overAzimuth_[overAzimuth_.size() - numAngles_];
            for (size_t j = 0; j + 1 < numAngles_; ++j) {
                const double range =
                    std::cos(table.angles[j] * (M_PI / 180)) - std::cos(table.angles[j + 1] * (M_PI / 180));
                sums.push_back(sums.back() + 0.5 * (double(over[j]) + double(over[j + 1])) * range);
            }
            for (const double sum : sums) cdf_.push_back(float(sum / sums.back()));
            extinctions.push_back(sums.back() + table.sigmaA[row][i]);
            scattering_.push_back(float(sums.back()));
            extinction_.push_back(float(extinctions.back()));
            largestAlbedo_ = std::max(largestAlbedo_, scattering_.back() / extinction_.back());
        }
        meanExtinction_.push_back(float(grid.MeanOverIncidences(extinctions)));
    }
}

OrientedPhaseTable::Place OrientedPhaseTable::PlaceOf(float lambda) const {
    const int last = int(wavelengths_.size()) - 1;
    if (last <= 0 || !(lambda > wavelengths_.front())) return {};
    if (lambda >= wavelengths_.back()) return {size_t(last), 0};
    const auto i = size_t(FindInterval(last + 1, [&](int k) { return wavelengths_[size_t(k)] <= lambda; }));
    return {i, (lambda - wavelengths_[i]) / (wavelengths_[i + 1] - wavelengths_[i])};
}

OrientedPhaseTable::Node OrientedPhaseTable::FindIncidence(Vec3 w) const {
    const float t = OneMinusAbsCos(w);
    const auto i = size_t(FindInterval(int(nodes_.size()), [&](int k) { return nodes_[size_t(k)] <= t; }));
    return {i, std::clamp((t - nodes_[i]) / (nodes_[i + 1] - nodes_[i]), 0.f, 1.f)};
}

float OrientedPhaseTable::Mixed(const std::vector<float>& values, const Place& at, const Node& node) const {
    const float* row = &values[at.row * NumIncidences() + node.index];
    const float low = Lerp(node.x, row[0], row[1]);
    return at.weight > 0 ? Lerp(at.weight, low, Lerp(node.x, row[NumIncidences()], row[NumIncidences() + 1]))
                         : low;
}

float OrientedPhaseTable::MeanExtinction(const Place& at) const {
    const float low = meanExtinction_[at.row];
    return at.weight > 0 ? Lerp(at.weight, low, meanExtinction_[at.row + 1]) : low;
}

float OrientedPhaseTable::MeanExtinction(float lambda) const { return MeanExtinction(PlaceOf(lambda)); }

OrientedPhaseTable::Pair OrientedPhaseTable::Find(Vec3 n, Vec3 s) const {
    Pair pair{FindIncidence(n), FindIncidence(s), {}};
    // The ensemble has a mirror across the axis: light comes from below.
    if ((n.z < 0) != (s.z < 0)) pair.angle = {numAngles_ - 2 - pair.angle.index, 1 - pair.angle.x};
    const float along = n.x * s.x + n.y * s.y, across = n.x * s.y - n.y * s.x;
    const float phi = std::atan2(std::abs(across), along);
    const float last = float(numAzimuths_ - 1), x = std::clamp(phi * (InvPi * last), 0.f, last);
    pair.azimuth.index = std::min(size_t(x), numAzimuths_ - 2);
    pair.azimuth.x = x - float(pair.azimuth.index);
    return pair;
}

float OrientedPhaseTable::Value(const Place& at, const Pair& pair) const {
    const auto ofRow = [&](size_t row) {
        const auto ofAzimuth = [&](size_t i, size_t j) {
            const float* v =
                Azimuths(row, pair.incidence.index + i, pair.angle.index + j) + pair.azimuth.index;
            return Lerp(pair.azimuth.x, v[0], v[1]);
        };
        const auto ofAngle = [&](size_t i) { return Lerp(pair.angle.x, ofAzimuth(i, 0), ofAzimuth(i, 1)); };
        return Lerp(pair.incidence.x, ofAngle(0), ofAngle(1));
    };
    const float low = ofRow(at.row);
    return at.weight > 0 ? Lerp(at.weight, low, ofRow(at.row + 1)) : low;
}

OrientedPhaseTable::Node OrientedPhaseTable::SampleAngle(size_t row, size_t incidence, float u) const {
    const size_t first = (row * NumIncidences() + incidence) * numAngles_;
    const auto j = size_t(FindInterval(int(numAngles_), [&](int k) { return cdf_[first + size_t(k)] <= u; }));
    const float below = cdf_[first + j], above = cdf_[first + j + 1];
    const float left = std::min((u - below) / (above - below), OneMinusEpsilon);
    return {j, SampleLinear(left, overAzimuth_[first + j], overAzimuth_[first + j + 1])};
}

/// In [0, pi], from what is linear between nodes.
float OrientedPhaseTable::SampleAzimuth(const float* values, float u) const {
    float all = 0;
    for (size_t k = 0; k + 1 < numAzimuths_; ++k) all += values[k] + values[k + 1];
    float left = u * all;
    size_t chosen = 0;
    for (size_t k = 0; k + 1 < numAzimuths_; ++k) {
        const float here = values[k] + values[k + 1];
        if (!(here > 0)) continue;
        chosen = k;
        if (left < here) break;
        left -= here;
    }
    const float here = values[chosen] + values[chosen + 1];
    const float part = here > 0 ? std::clamp(left / here, 0.f, OneMinusEpsilon) : 0.5f;
    return (float(chosen) + SampleLinear(part, values[chosen], values[chosen + 1])) *
           (Pi / float(numAzimuths_ - 1));
}

namespace {

/// True with the share of b in a + b. Takes its part out of u, which is uniform again.
bool ChooseSecond(float a, float b, float& u) {
    const float share = b > 0 ? b / (a + b) : 0.f;
    const bool second = u < share;
    u = std::min(second ? u / share : (u - share) / (1 - share), OneMinusEpsilon);
    return second;
}

}  // namespace

Vec3 OrientedPhaseTable::Sample(const Place& at, Vec3 n, Rng& rng) const {
    // S is a mixture over wavelengths, incidences, angles and azimuths, each by its share.
    float u = rng.Uniform();
    const Node incidence = FindIncidence(n);
    size_t row = at.row;
    if (at.weight > 0 && ChooseSecond((1 - at.weight) * Mixed(scattering_, {row, 0}, incidence),
                                      at.weight * Mixed(scattering_, {row + 1, 0}, incidence), u))
        ++row;
    const float* scattering = &scattering_[row * NumIncidences()];
    size_t i = incidence.index;
    if (ChooseSecond((1 - incidence.x) * scattering[i], incidence.x * scattering[i + 1], u)) ++i;

    const Node angle = SampleAngle(row, i, rng.Uniform());
    const float* over = &overAzimuth_[(row * NumIncidences() + i) * numAngles_];
    size_t j = angle.index;
    float v = rng.Uniform();
    if (ChooseSecond((1 - angle.x) * over[j], angle.x * over[j + 1], v)) ++j;
    const float phi = SampleAzimuth(Azimuths(row, i, j), v) * (u < 0.5f ? 1.f : -1.f);

    const bool isAhead = angle.index + 1 < NumIncidences();
    const size_t node = isAhead ? angle.index : numAngles_ - 2 - angle.index;
    const float t = Lerp(isAhead ? angle.x : 1 - angle.x, nodes_[node], nodes_[node + 1]);
    const float sine = SafeSqrt(t * (2 - t)), flatLength = std::sqrt(n.x * n.x + n.y * n.y);
    const Vec2 azimuth = flatLength > 0 ? Vec2(n.x, n.y) / flatLength : Vec2(1, 0);
    const float c = sine * std::cos(phi), s = sine * std::sin(phi);
    return {c * azimuth.x - s * azimuth.y, c * azimuth.y + s * azimuth.x,
            isAhead == (n.z < 0) ? t - 1 : 1 - t};
}

OrientedPhase::OrientedPhase(const OrientedPhaseTable& table, Vec3 axis, const SampledWavelengths& lambda)
    : table_(table), frame_(FrameAlong(axis)) {
    for (int i = 0; i < kNumWavelengths; ++i) {
        places_[size_t(i)] = table.PlaceOf(lambda[i]);
        isChromatic_ |= places_[size_t(i)] != places_[0];
    }
}

float OrientedPhase::ExtinctionAt(const OrientedPhaseTable::Place& at,
                                  const OrientedPhaseTable::Node& node) const {
    return table_.Extinction(at, node) / table_.MeanExtinction(at);
}

float OrientedPhase::AlbedoAt(const OrientedPhaseTable::Place& at,
                              const OrientedPhaseTable::Node& node) const {
    return std::min(table_.Scattering(at, node) / (table_.Extinction(at, node) * table_.LargestAlbedo()),
                    1.f);
}

PhaseValue OrientedPhase::ValueAt(const OrientedPhaseTable::Place& at, const OrientedPhaseTable::Pair& pair,
                                  const OrientedPhaseTable::Node& reverse) const {
    const float value = table_.Value(at, pair), p = value / table_.Scattering(at, pair.incidence);
    return {p, p, value / table_.Scattering(at, reverse)};
}

PhaseValue OrientedPhase::Evaluate(Vec3 wo, Vec3 wi) const {
    const Vec3 n = -frame_.ToLocal(wo), s = frame_.ToLocal(wi);
    return ValueAt(places_[0], table_.Find(n, s), table_.FindIncidence(s));
}

SpectralPhaseValue OrientedPhase::EvaluateSpectral(Vec3 wo, Vec3 wi) const {
    const Vec3 n = -frame_.ToLocal(wo), s = frame_.ToLocal(wi);
    const OrientedPhaseTable::Pair pair = table_.Find(n, s);
    const OrientedPhaseTable::Node reverse = table_.FindIncidence(s);
    SpectralPhaseValue result;
    for (int i = 0; i < kNumWavelengths; ++i) {
        const PhaseValue value = ValueAt(places_[size_t(i)], pair, reverse);
        result.p.Set(i, value.p);
        result.pdf.Set(i, value.pdf);
        result.pdfReverse.Set(i, value.pdfReverse);
    }
    return result;
}

PhaseSample OrientedPhase::Sample(Vec3 wo, Rng& rng) const {
    return PhaseRecord(*this, wo, SampleAt(0, wo, rng));
}

Vec3 OrientedPhase::SampleAt(int wavelength, Vec3 wo, Rng& rng) const {
    const Vec3 s = table_.Sample(places_[size_t(wavelength)], -frame_.ToLocal(wo), rng);
    return KeepUnit(frame_.FromLocal(s));
}

float OrientedPhase::Extinction(Vec3 w) const {
    return ExtinctionAt(places_[0], table_.FindIncidence(frame_.ToLocal(w)));
}

float OrientedPhase::Albedo(Vec3 w) const {
    return AlbedoAt(places_[0], table_.FindIncidence(frame_.ToLocal(w)));
}

DirectionalFactors OrientedPhase::FactorsAlong(Vec3 w, const SampledWavelengths& lambda) const {
    const OrientedPhaseTable::Node node = table_.FindIncidence(frame_.ToLocal(w));
    DirectionalFactors factors;
    for (int i = 0; i < kNumWavelengths; ++i) {
        const OrientedPhaseTable::Place at = table_.PlaceOf(lambda[i]);
        factors.extinction.Set(i, ExtinctionAt(at, node));
        factors.albedo.Set(i, AlbedoAt(at, node));
    }
    return factors;
}

}  // namespace lacquer
