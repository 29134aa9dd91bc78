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

Coat::Coat(MicrofacetModel model, float alpha, float eta, SampledSpectrum tau)
    : tables_(TablesOf(model)),
      alpha_(alpha),
      eta_(eta),
      atAlpha_(Grid::AlphaCoordinate(alpha), Grid::kAlpha),
      atEta_(Grid::EtaCoordinate(eta), Grid::kEta),
      tau_(tau),
      isClear_(!tau),
      isGray_(tau == SampledSpectrum(tau[0])) {}

CoatTransmittance Coat::Transmittance(float cosTheta) const {
    CoatTransmittance result;
    if (alpha_ == 0) {
        result.clear = 1 - FresnelDielectric(cosTheta, eta_);
        result.paths.fill(1 / std::sqrt(1 - (1 - cosTheta) * (1 + cosTheta) / (eta_ * eta_)));
        return result;
    }
    const Stencil atCos(Grid::CosCoordinate(cosTheta), Grid::kCos);
    Row sum{};
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
            const int row = (atAlpha_.first + i) * Grid::kEta + atEta_.first + j;
            const float* nodes = tables_ + size_t(row * Grid::kCos + atCos.first) * Grid::kEntryChannels;
            const auto node = [&](int k) { return Load<Row>(nodes + k * Grid::kEntryChannels); };
            const Row value = node(0) * atCos.weights[0] + node(1) * atCos.weights[1] +
                              node(2) * atCos.weights[2] + node(3) * atCos.weights[3];
            sum += value * (atAlpha_.weights[size_t(i)] * atEta_.weights[size_t(j)]);
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

const float* Coat::ReturnRow(int i, int j) const {
    const int row = (atAlpha_.first + i) * Grid::kEta + atEta_.first + j;
    return tables_ + Grid::kEntryFloats + size_t(row * Grid::kReturnChannels);
}

SampledSpectrum Coat::Reflectance() const {
    Row low{}, high{};
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
            const float* row = ReturnRow(i, j);
            const float weight = atAlpha_.weights[size_t(i)] * atEta_.weights[size_t(j)];
            low += Load<Row>(row) * weight;
            high += Load<Row>(row + 8) * weight;
        }
    const float clear = low[0];
    if (isClear_) return SampledSpectrum(clear);
    std::array<float, Grid::kReturnPaths> paths;
    for (size_t k = 0; k < paths.size(); ++k) paths[k] = k < 7 ? low[k + 1] : high[k - 7];

    const auto attenuated = [&](float tau) {
        const Stencil at(Grid::ReturnTauCoordinate(tau), Grid::kReturnPaths);
        float path = 0;
        for (size_t k = 0; k < 4; ++k) path += at.weights[k] * paths[size_t(at.first) + k];
        return clear * Exp(-tau * path);
    };
    return isGray_ ? SampledSpectrum(attenuated(tau_[0])) : Map(tau_, attenuated);
}

// ---- Of walks -----------------------------------------------------------------------------------------

float Coat::InterpolateDensity(float cosTheta, int channel) const {
    const Stencil atCos(Grid::CosCoordinate(cosTheta), Grid::kCos);
    const float* nodes =
        tables_ + Grid::kEntryFloats + Grid::kReturnFloats + channel * Grid::kCos + atCos.first;
    Cosines sum{};
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
            const int row = (atAlpha_.first + i) * Grid::kEta + atEta_.first + j;
            const float* at = nodes + row * Grid::kDensityChannels * Grid::kCos;
            sum += Load<Cosines>(at) * (atAlpha_.weights[size_t(i)] * atEta_.weights[size_t(j)]);
        }
    float value = 0;
    for (size_t k = 0; k < 4; ++k) value += sum[k] * atCos.weights[k];
    return std::max(value, 0.f);
}

float Coat::ProbabilityIn(float cosTheta) const {
    if (alpha_ == 0) return 1 - FresnelDielectric(cosTheta, eta_);
    return InterpolateDensity(cosTheta, 0);
}

float Coat::PdfOut(float cosTheta) const {
    const float out =
        alpha_ == 0 ? cosTheta * (1 - FresnelDielectric(cosTheta, eta_)) : InterpolateDensity(cosTheta, 1);
    return out * InvPi / (eta_ * eta_);
}

float Coat::ProbabilityBack() const {
    float sum = 0;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            sum += atAlpha_.weights[size_t(i)] * atEta_.weights[size_t(j)] *
                   ReturnRow(i, j)[Grid::kReturnChannels - 1];
    return sum;
}

}  // namespace lacquer::layered
