#include "layered/lambertian/coat_tables.h"

#include "pbrt/core/check.h"
#include "pbrt/core/embedded.h"

namespace lacquer::layered {
namespace {

using Grid = CoatGrid;

/// Eight channels of a node at once.
using Row = float __attribute__((vector_size(32)));
using Cosines = float __attribute__((vector_size(16)));

/// Consecutive numbers of a table, at any address: one unaligned load.
template <class Vector>
Vector Load(const float* at) {
    Vector vector;
    std::memcpy(&vector, at, sizeof(Vector));
    return vector;
}

static_assert(Grid::kEntryChannels == 8 && Grid::kReturnChannels == 16);

const float* TablesOf(MicrofacetModel model) {
    static const float* const tables = [] {
        const std::string_view bytes = EmbeddedData("coat_tables.bin");
        LACQUER_CHECK(bytes.size() == Grid::kModels * Grid::kModelFloats * sizeof(float));
        return reinterpret_cast<const float*>(bytes.data());
    }();
    return model == MicrofacetModel::TrowbridgeReitz ? tables : tables + Grid::kModelFloats;
}

/// The weights of all entry paths in the polynomial through them, by Lagrange.
/// @param x  in units of the distance between nodes
template <class Value>
std::array<Value, Grid::kEntryPaths> PathWeights(Value x) {
    // (x - j) for the nodes j, their products from both ends, and those of the nodes' distances.
    constexpr size_t kCount = Grid::kEntryPaths;
    constexpr std::array<float, kCount> kScale = {1 / 720.f, -1 / 120.f, 1 / 48.f, -1 / 36.f,
                                                  1 / 48.f,  -1 / 120.f, 1 / 720.f};
    std::array<Value, kCount> weights;
    weights[kCount - 1] = Value(1);
    for (size_t j = kCount - 1; j > 0; --j) weights[j - 1] = weights[j] * (x - Value(float(j)));
    Value below(1);
    for (size_t j = 0; j < kCount; ++j) {
        weights[j] = below * weights[j] * kScale[j];
        below = below * (x - Value(float(j)));
    }
    return weights;
}

}  // namespace

Coat::Stencil::Stencil(float coordinate, int count) {
    const float position = coordinate * float(count - 1);
    first = std::clamp(int(position) - 1, 0, count - 4);
    const float x = position - float(first), a = x - 1, b = x - 2, c = x - 3;
    weights = {a * b * c * (-1 / 6.f), x * b * c * 0.5f, x * a * c * -0.5f, x * a * b * (1 / 6.f)};
}

Coat::Surroundings::Surroundings(MicrofacetModel model, float alphaAt, float etaAt)
    : tables(TablesOf(model)),
      alpha(Grid::AlphaCoordinate(alphaAt), Grid::kAlpha),
      eta(Grid::EtaCoordinate(etaAt), Grid::kEta) {}

template <class Vector>
Vector Coat::Surroundings::At(size_t first, size_t distance) const {
    Vector sum{};
    for (size_t i = 0; i < 4; ++i)
        for (size_t j = 0; j < 4; ++j) {
            const size_t row = (size_t(alpha.first) + i) * Grid::kEta + size_t(eta.first) + j;
            sum += Load<Vector>(tables + first + row * distance) * (alpha.weights[i] * eta.weights[j]);
        }
    return sum;
}

namespace {

// Where the tables begin, and how far it is from one boundary to the next.
constexpr size_t kEntryRow = size_t(Grid::kCos) * Grid::kEntryChannels;
constexpr size_t kBackTable = Grid::kEntryFloats, kBackRow = Grid::kReturnChannels;
constexpr size_t kDensityTable = kBackTable + Grid::kReturnFloats,
                 kDensityRow = size_t(Grid::kCos) * Grid::kDensityChannels;

template <class Vector>
void Store(const Vector& vector, float* at) {
    std::memcpy(at, &vector, sizeof(Vector));
}

}  // namespace

std::array<float, Grid::kReturnChannels> Coat::Surroundings::Back() const {
    std::array<float, Grid::kReturnChannels> back;
    for (size_t k = 0; k < back.size(); k += 8) Store(At<Row>(kBackTable + k, kBackRow), back.data() + k);
    return back;
}

CoatCurves::CoatCurves(MicrofacetModel model, float alpha, float eta, float tau)
    : model_(model), alpha_(alpha), eta_(eta), tau_(tau), pathWeights_(Coat::PathWeightsAt(tau)) {
    const Coat::Surroundings tables(model, alpha, eta);
    for (size_t k = 0; k < entry_.size(); ++k)
        Store(tables.At<Row>(k * Grid::kEntryChannels, kEntryRow), entry_[k].data());
    back_ = tables.Back();
    reflectance_ = Coat::ReflectanceAt(tau, back_.data());
    static_assert(Grid::kCos % 4 == 0);
    for (size_t channel = 0; channel < density_.size(); ++channel)
        for (size_t k = 0; k < Grid::kCos; k += 4)
            Store(tables.At<Cosines>(kDensityTable + channel * Grid::kCos + k, kDensityRow),
                  density_[channel].data() + k);
}

Coat::Coat(MicrofacetModel model, float alpha, float eta, SampledSpectrum tau, const CoatCurves* curves)
    : curves_(curves),
      alpha_(alpha),
      eta_(eta),
      tau_(tau),
      isClear_(!tau),
      isGray_(tau == SampledSpectrum(tau[0])) {
    if (curves_) {
        curvesHaveTau_ = isGray_ && tau[0] == curves_->tau_;
        if (curvesHaveTau_)
            reflectance_ = SampledSpectrum(curves_->reflectance_);
        else
            SetReflectance(curves_->back_.data());
        probabilityBack_ = curves_->back_.back();
        return;
    }
    surroundings_ = Surroundings(model, alpha, eta);
    const std::array<float, Grid::kReturnChannels> back = surroundings_.Back();
    SetReflectance(back.data());
    probabilityBack_ = back.back();
}

CoatTransmittance Coat::Transmittance(float cosTheta) const {
    CoatTransmittance result;
    if (alpha_ == 0) {
        result.clear = 1 - FresnelDielectric(cosTheta, eta_);
        result.paths.fill(1 / std::sqrt(1 - (1 - cosTheta) * (1 + cosTheta) / (eta_ * eta_)));
        return result;
    }
    const Stencil atCos(Grid::CosCoordinate(cosTheta), Grid::kCos);
    Row sum{};
    for (size_t k = 0; k < 4; ++k) {
        const size_t node = size_t(atCos.first) + k;
        const Row value = curves_ ? Load<Row>(curves_->entry_[node].data())
                                  : surroundings_.At<Row>(node * Grid::kEntryChannels, kEntryRow);
        sum += value * atCos.weights[k];
    }
    // A cubic may lead below 0 where there is next to no light.
    result.clear = std::max(sum[0], 0.f);
    for (size_t j = 0; j < result.paths.size(); ++j) result.paths[j] = sum[j + 1];
    return result;
}

std::array<float, Grid::kEntryPaths> Coat::PathWeightsAt(float tau) {
    return PathWeights(Grid::EntryTauCoordinate(tau) * float(Grid::kEntryPaths - 1));
}

SampledSpectrum Coat::Product(const CoatTransmittance& a, const CoatTransmittance& b) const {
    const float clear = a.clear * b.clear;
    if (isClear_) return SampledSpectrum(clear);
    const auto depthBy = [&]<class Value>(const std::array<Value, Grid::kEntryPaths>& weights) {
        Value path(0);
        for (size_t j = 0; j < weights.size(); ++j) path = path + weights[j] * (a.paths[j] + b.paths[j]);
        return path;
    };
    // No path is shorter than the slab is thick.
    constexpr float kShortest = 2;
    if (isGray_) {
        const float path = depthBy(curvesHaveTau_ ? curves_->pathWeights_ : PathWeightsAt(tau_[0]));
        return SampledSpectrum(clear * Exp(-tau_[0] * std::max(path, kShortest)));
    }
    const SampledSpectrum x = Map(tau_, Grid::EntryTauCoordinate) * float(Grid::kEntryPaths - 1);
    return clear * Exp(-tau_ * Max(depthBy(PathWeights(x)), SampledSpectrum(kShortest)));
}

float Coat::ReflectanceAt(float tau, const float* back) {
    if (tau == 0) return back[0];
    const Stencil at(Grid::ReturnTauCoordinate(tau), Grid::kReturnPaths);
    float path = 0;
    for (size_t k = 0; k < 4; ++k) path += at.weights[k] * back[1 + size_t(at.first) + k];
    return back[0] * Exp(-tau * path);
}

void Coat::SetReflectance(const float* back) {
    if (isGray_)
        reflectance_ = SampledSpectrum(ReflectanceAt(tau_[0], back));
    else
        reflectance_ = Map(tau_, [&](float tau) { return ReflectanceAt(tau, back); });
}

// ---- Of walks -----------------------------------------------------------------------------------------

float Coat::DensityAt(float cosTheta, size_t channel) const {
    const Stencil atCos(Grid::CosCoordinate(cosTheta), Grid::kCos);
    const auto first = size_t(atCos.first);
    const Cosines nodes =
        curves_ ? Load<Cosines>(curves_->density_[channel].data() + first)
                : surroundings_.At<Cosines>(kDensityTable + channel * Grid::kCos + first, kDensityRow);
    float value = 0;
    for (size_t k = 0; k < 4; ++k) value += nodes[k] * atCos.weights[k];
    return std::max(value, 0.f);
}

float Coat::ProbabilityIn(float cosTheta) const {
    if (alpha_ == 0) return 1 - FresnelDielectric(cosTheta, eta_);
    return DensityAt(cosTheta, 0);
}

float Coat::PdfOut(float cosTheta) const {
    const float out =
        alpha_ == 0 ? cosTheta * (1 - FresnelDielectric(cosTheta, eta_)) : DensityAt(cosTheta, 1);
    return out * InvPi / (eta_ * eta_);
}

}  // namespace lacquer::layered
