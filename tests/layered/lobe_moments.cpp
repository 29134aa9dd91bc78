#include "layered/lobe_moments.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "pbrt/core/sampling.h"
#include "pbrt/scattering/fresnel.h"

namespace lacquer::layered::test {

namespace {

constexpr double kSphere = 4 * double(Pi);
constexpr float kPeakCosine = 0.97f, kGrazingCosine = 0.35f;
/// What exact estimates may differ by: rounding of float arithmetic along a path.
constexpr double kRounding = 2e-6;

}  // namespace

std::string MomentName(int moment) {
    constexpr const char* kNames[] = {"albedo", "peak", "grazing", "x", "y", "x^2 - y^2"};
    if (moment >= 2 * kWeightsPerSide) return fmt::format("lane {}", moment - 2 * kWeightsPerSide);
    return fmt::format("{} {}", moment < kWeightsPerSide ? "above" : "below",
                       kNames[moment % kWeightsPerSide]);
}

// ---- Moments --------------------------------------------------------------------------------------------

Moments::Moments(const Stack& stack, Vec3 wo) {
    const size_t side = wo.z > 0 ? 0 : 1;
    peaks_[side] = {-wo.x, -wo.y, wo.z};
    const std::optional<Refraction> refracted =
        stack.eta == 1 ? std::nullopt : Refract(wo, {0, 0, 1}, stack.eta);
    peaks_[1 - side] = refracted ? Normalize(refracted->w) : -wo;
}

void Moments::Add(Vec3 wi, SampledSpectrum value) {
    ++count_;
    if (!value.IsValid()) {
        ++numInvalid_;
        return;
    }
    const size_t side = wi.z > 0 ? 0 : 1, first = side * kWeightsPerSide;
    const double v = double(value.Average());
    AddTo(first, v);
    if (Dot(wi, peaks_[side]) > kPeakCosine) AddTo(first + 1, v);
    if (std::abs(wi.z) < kGrazingCosine) AddTo(first + 2, v);
    AddTo(first + 3, v * double(wi.x));
    AddTo(first + 4, v * double(wi.y));
    AddTo(first + 5, v * double(wi.x * wi.x - wi.y * wi.y));
    for (int lane = 0; lane < kNumWavelengths; ++lane)
        AddTo(size_t(2 * kWeightsPerSide + lane), double(value[lane]));
    AddTo(kNumMoments, v);
}

void Moments::Add(const Moments& others) {
    count_ += others.count_;
    numInvalid_ += others.numInvalid_;
    for (size_t i = 0; i < sums_.size(); ++i) {
        sums_[i] += others.sums_[i];
        squares_[i] += others.squares_[i];
    }
}

double Moments::StandardError(int moment) const {
    if (count_ < 2) return 0;
    const double mean = Mean(moment), variance = squares_[size_t(moment)] / count_ - mean * mean;
    return std::sqrt(std::max(0., variance) / (count_ - 1));
}

// ---- Guide ----------------------------------------------------------------------------------------------

GuideDensity::GuideDensity(const std::vector<Vec3>& directions, const std::vector<double>& weights,
                           bool transmits) {
    std::vector<Item> items;
    for (size_t i = 0; i < directions.size(); ++i)
        if (weights[i] > 0) items.push_back({EqualAreaSphereToSquare(directions[i]), weights[i]});
    double total = 0;
    for (const Item& item : items) total += item.weight;
    for (Item& item : items) item.weight /= total;
    treeShare_ = items.empty() ? 0 : 0.7;
    upShare_ = transmits ? 0.5 : 0.9;
    nodes_.emplace_back();
    if (!items.empty()) Split(0, items, Point2(0), 1, 0);
}

void GuideDensity::Split(int node, const std::vector<Item>& items, Point2 corner, float size, int depth) {
    constexpr size_t kMaxItems = 40;
    constexpr int kMaxDepth = 12;
    for (const Item& item : items) nodes_[size_t(node)].mass += item.weight;
    if (items.size() <= kMaxItems || depth == kMaxDepth) return;

    const int child = int(nodes_.size());
    nodes_[size_t(node)].child = child;
    nodes_.resize(nodes_.size() + 4);
    const float half = size / 2;
    std::array<std::vector<Item>, 4> parts;
    for (const Item& item : items)
        parts[size_t(item.p.x >= corner.x + half) + 2 * size_t(item.p.y >= corner.y + half)].push_back(item);
    for (int i = 0; i < 4; ++i)
        Split(child + i, parts[size_t(i)], corner + half * Point2(float(i & 1), float(i >> 1)), half,
              depth + 1);
}

double GuideDensity::TreeDensity(Vec3 w) const {
    Point2 p = EqualAreaSphereToSquare(w);
    int node = 0;
    double scale = 1 / kSphere;
    while (nodes_[size_t(node)].child >= 0) {
        p *= 2.f;
        const int x = p.x >= 1, y = p.y >= 1;
        p -= Point2(float(x), float(y));
        node = nodes_[size_t(node)].child + x + 2 * y;
        scale *= 4;
    }
    return nodes_[size_t(node)].mass * scale;
}

double GuideDensity::Pdf(Vec3 w) const {
    const double lobe = (w.z > 0 ? upShare_ : 1 - upShare_) * std::abs(double(w.z)) / double(Pi);
    return (1 - treeShare_) * lobe + (treeShare_ > 0 ? treeShare_ * TreeDensity(w) : 0);
}

GuideDensity::GuidedDirection GuideDensity::Sample(Rng& rng) const {
    Vec3 w;
    do {
        if (double(rng.Uniform()) >= treeShare_) {
            w = SampleCosineHemisphere(rng.Uniform2D());
            if (double(rng.Uniform()) >= upShare_) w.z = -w.z;
            continue;
        }
        int node = 0;
        Point2 corner(0);
        float size = 1;
        while (nodes_[size_t(node)].child >= 0) {
            const int child = nodes_[size_t(node)].child;
            double u = double(rng.Uniform()) * nodes_[size_t(node)].mass;
            int i = 0;
            // The last part with any mass takes what rounding leaves.
            for (int k = 0; k < 4; ++k) {
                const double mass = nodes_[size_t(child + k)].mass;
                if (!(mass > 0)) continue;
                i = k;
                if (u < mass) break;
                u -= mass;
            }
            size /= 2;
            corner += size * Point2(float(i & 1), float(i >> 1));
            node = child + i;
        }
        w = EqualAreaSquareToSphere(corner + size * rng.Uniform2D());
    } while (w.z == 0);
    return {w, Pdf(w)};
}

// ---- The two ways ---------------------------------------------------------------------------------------

Moments MomentsByWalks(const LobeQuery& query, int numWalks, uint64_t seed, bool withSpecular) {
    Moments moments(query.stack, query.wo);
    Rng rng(seed);
    for (int i = 0; i < numWalks; ++i) {
        const auto exit = AnalogWalk(query.stack, query.wo, query.mode, query.maxVertices, rng);
        if (exit && (withSpecular || !exit->isSpecular))
            moments.Add(exit->wi, exit->weight);
        else
            moments.AddNothing();
    }
    return moments;
}

Moments MomentsBySamples(const BxDF& bxdf, const LobeQuery& query, Lobes sides, int numSamples,
                         uint64_t seed) {
    Moments moments(query.stack, query.wo);
    VisitSamples(bxdf, query.wo, query.mode, sides, numSamples, seed,
                 [&](const std::optional<BxDFSample>& sample) {
                     if (sample)
                         moments.Add(sample->wi, sample->weight);
                     else
                         moments.AddNothing();
                 });
    return moments;
}

GuideDensity GuideOf(const LobeQuery& query, uint64_t seed) {
    constexpr int kNumWalks = 6000;
    std::vector<Vec3> directions;
    std::vector<double> weights;
    bool transmits = true;
    for (const StackInterface& interface : query.stack.interfaces)
        transmits &= Any(interface.bxdf->Flags(), Lobes::Transmission);
    Rng rng(seed);
    for (int i = 0; i < kNumWalks; ++i) {
        const auto exit = AnalogWalk(query.stack, query.wo, query.mode, query.maxVertices, rng);
        if (!exit || exit->isSpecular) continue;
        directions.push_back(exit->wi);
        weights.push_back(double(exit->weight.Average()));
    }
    // A stack that nothing passes has only the side of wo.
    GuideDensity guide(directions, weights, transmits || query.wo.z < 0);
    return guide;
}

// ---- Comparison -----------------------------------------------------------------------------------------

Comparison Compare(const Moments& found, const Moments& expected) {
    Comparison c;
    const double albedo = expected.Albedo(), error = std::hypot(found.AlbedoError(), expected.AlbedoError());
    const auto z = [&](double difference, double a, double b) {
        // What both have exactly may differ by rounding. And where a part of the lobe met none of the rare
        // bright values, it borrows from the error of the whole: its own would be too small.
        constexpr double kBorrowed = 0.2;
        const double sigma =
            std::hypot(std::hypot(a, b), std::hypot(kRounding * std::max(albedo, 1e-30), kBorrowed * error));
        return difference / sigma;
    };
    for (int i = 0; i < kNumMoments; ++i)
        c.z[size_t(i)] =
            z(found.Mean(i) - expected.Mean(i), found.StandardError(i), expected.StandardError(i));
    if (albedo > 0) {
        c.albedoExcess = found.Albedo() / albedo - 1;
        c.albedoExcessError = error / albedo;
    }
    return c;
}

double Comparison::WorstZ() const {
    double worst = 0;
    for (const double x : z)
        if (!(std::abs(x) <= worst)) worst = std::abs(x);
    return worst;
}

std::string Comparison::Describe(const Moments& found, const Moments& expected) const {
    int worst = 0;
    for (int i = 1; i < kNumMoments; ++i)
        if (!(std::abs(z[size_t(i)]) <= std::abs(z[size_t(worst)]))) worst = i;
    return fmt::format(
        "{}: {:.6g} +- {:.2g}, walks {:.6g} +- {:.2g} ({:+.1f} sigma); albedo {:.6g} {:+.2f} % +- {:.2f} %",
        MomentName(worst), found.Mean(worst), found.StandardError(worst), expected.Mean(worst),
        expected.StandardError(worst), z[size_t(worst)], found.Albedo(), 100 * albedoExcess,
        100 * albedoExcessError);
}

}  // namespace lacquer::layered::test
