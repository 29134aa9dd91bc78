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

/// The value at x, in units of the distance between nodes, of the polynomial through all entry paths.
SampledSpectrum PathAt(const float* paths, SampledSpectrum x) {
    // (x - j) for the nodes j, their products from both ends, and those of the nodes' distances.
    constexpr int kCount = Grid::kEntryPaths;
    constexpr std::array<float, kCount> kScale = {1 / 720.f, -1 / 120.f, 1 / 48.f, -1 / 36.f,
                                                  1 / 48.f,  -1 / 120.f, 1 / 720.f};
    std::array<SampledSpectrum, kCount> above;
    above[kCount - 1] = SampledSpectrum(1);
    for (int j = kCount - 1; j > 0; --j)
        above[size_t(j - 1)] = above[size_t(j)] * (x - SampledSpectrum(float(j)));
    SampledSpectrum below(1), sum(0);
    for (int j = 0; j < kCount; ++j) {
        sum += below * above[size_t(j)] * (kScale[size_t(j)] * paths[j]);
        below *= x - SampledSpectrum(float(j));
    }
    return sum;
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

CoatCurves::CoatCurves(MicrofacetModel model, float alpha, float eta)
    : model_(model), alpha_(alpha), eta_(eta) {
    const Coat::Surroundings tables(model, alpha, eta);
    for (size_t k = 0; k < entry_.size(); ++k)
        Store(tables.At<Row>(k * Grid::kEntryChannels, kEntryRow), entry_[k].data());
    for (size_t k = 0; k < back_.size(); k += 8)
        Store(tables.At<Row>(kBackTable + k, kBackRow), back_.data() + k);
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
        reflectance_ = MakeReflectance(curves_->back_.data());
        probabilityBack_ = curves_->back_.back();
        return;
    }
    surroundings_ = Surroundings(model, alpha, eta);
    std::array<float, Grid::kReturnChannels> back;
    for (size_t k = 0; k < back.size(); k += 8)
        Store(surroundings_.At<Row>(kBackTable + k, kBackRow), back.data() + k);
    reflectance_ = MakeReflectance(back.data());
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

SampledSpectrum Coat::Product(const CoatTransmittance& a, const CoatTransmittance& b) const {
    const float clear = a.clear * b.clear;
    if (isClear_) return SampledSpectrum(clear);
    std::array<float, Grid::kEntryPaths> paths;
    for (size_t j = 0; j < paths.size(); ++j) paths[j] = a.paths[j] + b.paths[j];
    const SampledSpectrum x =
        (isGray_ ? SampledSpectrum(Grid::EntryTauCoordinate(tau_[0])) : Map(tau_, Grid::EntryTauCoordinate)) *
        float(Grid::kEntryPaths - 1);
    // No path is shorter than the slab is thick.
    const SampledSpectrum depth = tau_ * Max(PathAt(paths.data(), x), SampledSpectrum(2));
    if (isGray_) return SampledSpectrum(clear * Exp(-depth[0]));
    return clear * Exp(-depth);
}

/// @param back  R without a slab, and the mean paths
SampledSpectrum Coat::MakeReflectance(const float* back) const {
    const float clear = back[0];
    if (isClear_) return SampledSpectrum(clear);
    const float* const paths = back + 1;
    const auto attenuated = [&](float tau) {
        const Stencil at(Grid::ReturnTauCoordinate(tau), Grid::kReturnPaths);
        float path = 0;
        for (size_t k = 0; k < 4; ++k) path += at.weights[k] * paths[size_t(at.first) + k];
        return clear * Exp(-tau * path);
    };
    return isGray_ ? SampledSpectrum(attenuated(tau_[0])) : Map(tau_, attenuated);
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
