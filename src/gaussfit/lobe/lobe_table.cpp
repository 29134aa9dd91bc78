#include "gaussfit/lobe/lobe_table.h"

#include <fmt/format.h>

#include <cstring>

#include "pbrt/core/error.h"

namespace lacquer::gaussfit {

namespace {

using Factors = std::array<std::array<float, LobePatch::kFields>, LobeTable::kMaxComponents>;

/// All factors of a patch at one point, for kComponents components. What lies side by side in memory, the
/// angles' polynomials with their fields, is summed over eta and alpha in whole SIMD registers first; the
/// angle comes last.
template <int kEtaDegree, int kComponents>
void FactorsAt(const float* control, const LobeCoordinates<float>& at, Factors* factors) {
    constexpr int kPerPoint = kComponents * LobePatch::kFields, kLanes = 8;
    constexpr int kRow = (kLobeThetaDegree + 1) * kPerPoint;
    using Lanes = float __attribute__((vector_size(sizeof(float) * kLanes)));
    static_assert(kRow % kLanes == 0);
    using Row = std::array<Lanes, kRow / kLanes>;

    const auto byEta = BernsteinBasis<kEtaDegree>(at.eta);
    const auto byAlpha = BernsteinBasis<kLobeAlphaDegree>(at.alpha);
    Row sum{};
    for (const float etaValue : byEta) {
        Row plane{};
        for (const float alphaValue : byAlpha)
            for (Lanes& lanes : plane) {
                Lanes values;
                std::memcpy(&values, control, sizeof(values));
                control += kLanes;
                lanes += alphaValue * values;
            }
        for (size_t i = 0; i < sum.size(); ++i) sum[i] += etaValue * plane[i];
    }

    const auto byTheta = BernsteinBasis<kLobeThetaDegree>(at.theta);
    std::array<float, kRow> row;
    std::memcpy(row.data(), sum.data(), sizeof(row));
    for (size_t c = 0; c < kComponents; ++c)
        for (size_t f = 0; f < LobePatch::kFields; ++f) {
            float value = 0;
            for (size_t k = 0; k <= kLobeThetaDegree; ++k)
                value += byTheta[k] * row[k * kPerPoint + c * LobePatch::kFields + f];
            (*factors)[c][f] = value;
        }
}

void FactorsAt(const LobeModel& model, const LobePatch& patch, const LobeCoordinates<float>& at,
               Factors* factors) {
    static_assert(LobeTable::kMaxComponents == 2);
    const float* control = patch.control.data();
    if (model.Transmits()) {
        if (model.numComponents == 1) return FactorsAt<kLobeEtaDegree, 1>(control, at, factors);
        return FactorsAt<kLobeEtaDegree, 2>(control, at, factors);
    }
    if (model.numComponents == 1) return FactorsAt<0, 1>(control, at, factors);
    FactorsAt<0, 2>(control, at, factors);
}

// Ranges are met up to rounding, as of 1/eta.
constexpr double kSlack = 1e-5;

void RequireRange(bool isGood, const std::string& path, const std::string& what) {
    if (!isGood) throw FileError(path, fmt::format("value out of range: {}", what));
}

void CheckPatch(const LobeTable::Content& c, const LobePatch& patch, const std::string& path) {
    RequireRange(patch.alphaMin > 0 && patch.alphaMin < patch.alphaMax && patch.alphaMax <= 10, path,
                 fmt::format("alpha from {} to {}", patch.alphaMin, patch.alphaMax));
    const size_t expected = size_t(c.NumControlPoints()) * size_t(c.FieldsPerPoint());
    if (patch.control.size() != expected)
        throw FileError(
            path, fmt::format("{} control values in a patch, expected {}", patch.control.size(), expected));
    for (size_t i = 0; i < patch.control.size(); ++i) {
        const float value = patch.control[i];
        const auto check = [&](bool isGood, const char* name) {
            RequireRange(isGood, path, fmt::format("control value {} of {}, number {}", value, name, i));
        };
        switch (i % LobePatch::kFields) {
            case LobePatch::Mean:
                check(std::abs(value) < 1e3f, "the mean");
                break;
            case LobePatch::L11:
                check(value > 0 && value < 1e4f, "L11");
                break;
            case LobePatch::L22:
                check(value > 0 && value < 1e4f, "L22");
                break;
            case LobePatch::Weight:
                check(value >= 0 && value <= 1, "a weight");
                break;
        }
    }
}

}  // namespace

LobeTable::LobeTable(Content content, const std::string& path) : content_(std::move(content)) {
    const Content& c = content_;
    RequireRange(c.etaMin >= 1 && c.etaMin <= c.etaMax && c.etaMax <= 10, path,
                 fmt::format("eta from {} to {}", c.etaMin, c.etaMax));
    if (c.model->Transmits()) RequireRange(c.etaMin < c.etaMax, path, "no range of eta");
    RequireRange(c.grazingCosineMin > 0 && c.grazingCosineMin < 1, path,
                 fmt::format("grazing cosine {}", c.grazingCosineMin));
    RequireRange(!c.patches.empty(), path, "no patches");
    for (size_t i = 0; i < c.patches.size(); ++i) {
        CheckPatch(c, c.patches[i], path);
        if (i > 0)
            RequireRange(c.patches[i].alphaMin == c.patches[i - 1].alphaMax, path, "a gap between patches");
        maps_.emplace_back(c.DomainOf(c.patches[i]));
    }
    alphaMin_ = float(c.patches.front().alphaMin * (1 - kSlack));
    alphaMax_ = float(c.patches.back().alphaMax * (1 + kSlack));
    etaMin_ = float(c.etaMin * (1 - kSlack));
    etaMax_ = float(c.etaMax * (1 + kSlack));
    grazingCosineMin_ = float(c.grazingCosineMin * (1 - kSlack));
}

bool LobeTable::Reaches(const LobeQuery<float>& q) const {
    // Comparisons are written so that NaN fails them.
    if (!(q.alpha >= alphaMin_ && q.alpha <= alphaMax_ && q.cosTheta > 0)) return false;
    const LobeEvent event = content_.model->event;
    if (event == LobeEvent::Reflection) return q.cosTheta >= grazingCosineMin_;
    if (event == LobeEvent::Entering)
        return q.eta >= etaMin_ && q.eta <= etaMax_ && q.cosTheta >= grazingCosineMin_;
    const float index = 1 / q.eta;
    if (!(index >= etaMin_ && index <= etaMax_)) return false;
    const float cos2Theta_t = 1 - (1 - q.cosTheta) * (1 + q.cosTheta) * index * index;
    return cos2Theta_t >= grazingCosineMin_ * grazingCosineMin_;
}

bool LobeTable::Find(const LobeQuery<float>& query, std::array<LobeShape<float>, kMaxComponents>* shapes,
                     std::array<float, kMaxComponents>* weights) const {
    if (!Reaches(query)) return false;
    const LobeBasis<float> basis = LobeBasisOf(content_.model->event, query);
    size_t index = 0;
    while (index + 1 < content_.patches.size() && query.alpha >= float(content_.patches[index].alphaMax))
        ++index;
    const LobePatch& patch = content_.patches[index];
    const LobeCoordinates<float> at = maps_[index](query, basis);

    Factors factors;
    FactorsAt(*content_.model, patch, at, &factors);
    const size_t count = size_t(content_.model->numComponents);
    for (size_t i = 0; i < count; ++i) {
        const auto& f = factors[i];
        (*shapes)[i] = {basis.shape.mean * f[LobePatch::Mean], basis.shape.l11 * f[LobePatch::L11],
                        basis.shape.l22 * f[LobePatch::L22]};
    }
    (*weights)[0] = count == 1 ? 1 : factors[0][LobePatch::Weight];
    (*weights)[1] = count == 1 ? 0 : 1 - (*weights)[0];
    return true;
}

bool LobeTable::Find(float alpha, float eta, Vec3 w, GaussianMixture* lobe) const {
    std::array<LobeShape<float>, kMaxComponents> shapes;
    std::array<float, kMaxComponents> weights;
    if (!Find(LobeQuery<float>{alpha, eta, std::abs(w.z)}, &shapes, &weights)) return false;

    // Turn from the plane of incidence, in which the slope of w points along +x whatever the sign of w.z.
    const float x = std::copysign(1.f, w.z) * w.x, y = std::copysign(1.f, w.z) * w.y;
    const float square = x * x + y * y;
    const float scale = square > 0 ? 1 / std::sqrt(square) : 0;
    const float ex = square > 0 ? x * scale : 1, ey = y * scale;

    lobe->count = content_.model->numComponents;
    for (size_t i = 0; i < size_t(lobe->count); ++i) {
        const LobeShape<float>& s = shapes[i];
        const float along = s.l11 * s.l11, across = s.l22 * s.l22;
        lobe->parts[i] = {{s.mean * ex, s.mean * ey},
                          {along * ex * ex + across * ey * ey, (along - across) * ex * ey,
                           along * ey * ey + across * ex * ex}};
        lobe->weights[i] = weights[i];
    }
    return true;
}

}  // namespace lacquer::gaussfit
