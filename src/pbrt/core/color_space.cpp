#include "pbrt/core/color_space.h"

#include <cctype>

#include "pbrt/core/embedded.h"

namespace lacquer {

namespace {

constexpr int kResolution = 64;
constexpr size_t kTableFloats = size_t(kResolution) + 3 * size_t(kResolution) * kResolution * kResolution * 3;

/// An RGB value as a spectrum: scale * polynomial, times an illuminant where it is emission.
class RGBSpectrum final : public Spectrum {
  public:
    RGBSpectrum(float scale, SigmoidPolynomial polynomial, const DenselySampledSpectrum* illuminant)
        : scale_(scale), polynomial_(polynomial), illuminant_(illuminant) {}
    float Evaluate(float lambda) const override {
        const float s = scale_ * polynomial_.Evaluate(lambda);
        return illuminant_ ? s * illuminant_->Evaluate(lambda) : s;
    }
    SampledSpectrum Sample(const SampledWavelengths& lambda) const override {
        const SampledSpectrum s = polynomial_.Sample(lambda) * scale_;
        return illuminant_ ? s * illuminant_->Sample(lambda) : s;
    }
    float MaxValue() const override {
        return scale_ * polynomial_.MaxValue() * (illuminant_ ? illuminant_->MaxValue() : 1.f);
    }

  private:
    float scale_;
    SigmoidPolynomial polynomial_;
    const DenselySampledSpectrum* illuminant_;
};

bool IsGray(RGB rgb) { return rgb.x == rgb.y && rgb.y == rgb.z; }

/// The factor that brings the largest component to one half, where the polynomials are smoothest.
struct Scaled {
    float scale;
    RGB rgb;
};
Scaled Normalize(RGB rgb, SpectrumKind kind) {
    if (kind == SpectrumKind::Albedo) return {1, rgb};
    const float scale = 2 * std::max({rgb.x, rgb.y, rgb.z});
    return {scale, scale > 0 ? rgb / scale : RGB(0)};
}

struct Definition {
    const char* name;
    float primaries[6];
    const char* illuminant;
};
// Primaries as CIE xy: [IEC 61966-2-1], [SMPTE EG 432-1], [ITU-R BT.2020], [SMPTE ST 2065-1].
constexpr Definition kDefinitions[] = {
    {"srgb", {.64f, .33f, .3f, .6f, .15f, .06f}, "stdillum-D65"},
    {"dci-p3", {.68f, .32f, .265f, .69f, .15f, .06f}, "stdillum-D65"},
    {"rec2020", {.708f, .292f, .17f, .797f, .131f, .046f}, "stdillum-D65"},
    {"aces2065-1", {.7347f, .2653f, 0, 1, .0001f, -.077f}, "illum-acesD60"},
};

const std::vector<std::unique_ptr<ColorSpace>>& Spaces() {
    static const std::vector<std::unique_ptr<ColorSpace>> spaces = [] {
        const auto* table = reinterpret_cast<const float*>(EmbeddedData("rgb_tables.bin").data());
        std::vector<std::unique_ptr<ColorSpace>> result;
        for (const Definition& d : kDefinitions) {
            result.push_back(std::make_unique<ColorSpace>(d.name, d.primaries, d.illuminant, table));
            table += kTableFloats;
        }
        return result;
    }();
    return spaces;
}

}  // namespace

float SigmoidPolynomial::MaxValue() const {
    float result = std::max(Evaluate(kLambdaMin), Evaluate(kLambdaMax));
    const float extremum = -c1 / (2 * c0);
    if (extremum >= kLambdaMin && extremum <= kLambdaMax) result = std::max(result, Evaluate(extremum));
    return result;
}

const ColorSpace* ColorSpace::Find(std::string_view name) {
    const auto equal = [](char a, char b) {
        return std::tolower((unsigned char)a) == std::tolower((unsigned char)b);
    };
    for (const auto& space : Spaces())
        if (std::equal(name.begin(), name.end(), space->name_.begin(), space->name_.end(), equal))
            return space.get();
    return nullptr;
}

const ColorSpace& ColorSpace::SRGB() { return *Spaces()[0]; }

std::vector<std::string> ColorSpace::Names() {
    std::vector<std::string> names;
    for (const Definition& d : kDefinitions) names.emplace_back(d.name);
    return names;
}

const ColorSpace* ColorSpace::FromChromaticities(const float chromaticities[8]) {
    for (const auto& space : Spaces()) {
        float difference = 0;
        for (int i = 0; i < 8; ++i)
            difference = std::max(difference, std::abs(chromaticities[i] - space->chromaticities_[i]));
        if (difference < 1e-3f) return space.get();
    }
    return nullptr;
}

ColorSpace::ColorSpace(const char* name, const float primaries[6], const char* illuminant, const float* table)
    : name_(name), table_(table) {
    illuminant_ = std::make_unique<DenselySampledSpectrum>(*NamedSpectrum(illuminant));
    illuminant_->Scale(kCieYIntegral / InnerProduct(*illuminant_, CieY()));
    const XYZ white = SpectrumToXYZ(*illuminant_);
    // The columns of XYZFromRGB are the primaries, each scaled so that R = G = B = 1 is the white.
    const glm::dmat3 columns{glm::dvec3(FromChromaticity({primaries[0], primaries[1]}, 1.f) * primaries[1]),
                             glm::dvec3(FromChromaticity({primaries[2], primaries[3]}, 1.f) * primaries[3]),
                             glm::dvec3(FromChromaticity({primaries[4], primaries[5]}, 1.f) * primaries[5])};
    const glm::dvec3 scales = glm::inverse(columns) * glm::dvec3(white / white.y);
    const glm::dmat3 matrix{columns[0] * scales.x, columns[1] * scales.y, columns[2] * scales.z};
    xyzFromRgb_ = glm::mat3(matrix);
    rgbFromXyz_ = glm::mat3(glm::inverse(matrix));
    std::copy(primaries, primaries + 6, chromaticities_);
    const Point2 xy = Chromaticity(white);
    chromaticities_[6] = xy.x;
    chromaticities_[7] = xy.y;
}

float ColorSpace::Luminance(RGB rgb) const {
    return xyzFromRgb_[0][1] * rgb.x + xyzFromRgb_[1][1] * rgb.y + xyzFromRgb_[2][1] * rgb.z;
}

SigmoidPolynomial ColorSpace::ToPolynomial(RGB rgb) const {
    rgb = glm::clamp(rgb, 0.f, 1.f);
    if (IsGray(rgb)) {
        const float r = rgb.x;
        if (r <= 0) return {0, 0, -Infinity};
        if (r >= 1) return {0, 0, Infinity};
        return {0, 0, (r - 0.5f) / std::sqrt(r * (1 - r))};
    }
    const int largest = rgb.x > rgb.y ? (rgb.x > rgb.z ? 0 : 2) : (rgb.y > rgb.z ? 1 : 2);
    const float z = rgb[largest];
    const float x = rgb[(largest + 1) % 3] * (kResolution - 1) / z;
    const float y = rgb[(largest + 2) % 3] * (kResolution - 1) / z;
    const int xi = std::min(int(x), kResolution - 2), yi = std::min(int(y), kResolution - 2);
    const int zi = FindInterval(kResolution, [&](int i) { return table_[i] < z; });
    const float dx = x - float(xi), dy = y - float(yi), dz = (z - table_[zi]) / (table_[zi + 1] - table_[zi]);
    const float* coefficients = table_ + kResolution;
    const auto at = [&](int i, int dxi, int dyi, int dzi) {
        const int cell =
            ((largest * kResolution + zi + dzi) * kResolution + yi + dyi) * kResolution + xi + dxi;
        return coefficients[3 * cell + i];
    };
    float c[3];
    for (int i = 0; i < 3; ++i)
        c[i] = Lerp(
            dz, Lerp(dy, Lerp(dx, at(i, 0, 0, 0), at(i, 1, 0, 0)), Lerp(dx, at(i, 0, 1, 0), at(i, 1, 1, 0))),
            Lerp(dy, Lerp(dx, at(i, 0, 0, 1), at(i, 1, 0, 1)), Lerp(dx, at(i, 0, 1, 1), at(i, 1, 1, 1))));
    return {c[0], c[1], c[2]};
}

std::unique_ptr<Spectrum> ColorSpace::MakeSpectrum(RGB rgb, SpectrumKind kind) const {
    const Scaled scaled = Normalize(rgb, kind);
    if (kind != SpectrumKind::Illuminant && IsGray(rgb)) return std::make_unique<ConstantSpectrum>(rgb.x);
    return std::make_unique<RGBSpectrum>(scaled.scale, ToPolynomial(scaled.rgb),
                                         kind == SpectrumKind::Illuminant ? illuminant_.get() : nullptr);
}

SampledSpectrum SampleRGB(const ColorSpace& space, RGB rgb, SpectrumKind kind,
                          const SampledWavelengths& lambda) {
    rgb = kind == SpectrumKind::Albedo ? glm::clamp(rgb, 0.f, 1.f) : glm::max(rgb, 0.f);
    // As MakeSpectrum() has them, and most textures of one channel.
    if (kind != SpectrumKind::Illuminant && IsGray(rgb)) return SampledSpectrum(rgb.x);
    const Scaled scaled = Normalize(rgb, kind);
    const SampledSpectrum s = space.ToPolynomial(scaled.rgb).Sample(lambda) * scaled.scale;
    return kind == SpectrumKind::Illuminant ? s * space.Illuminant().Sample(lambda) : s;
}

XYZ SpectrumToXYZ(const Spectrum& s) {
    return XYZ(InnerProduct(CieX(), s), InnerProduct(CieY(), s), InnerProduct(CieZ(), s)) / kCieYIntegral;
}

Point2 Chromaticity(XYZ xyz) {
    const float sum = xyz.x + xyz.y + xyz.z;
    return sum == 0 ? Point2(0) : Point2(xyz.x / sum, xyz.y / sum);
}

XYZ FromChromaticity(Point2 xy, float Y) {
    if (xy.y == 0) return XYZ(0);
    return {xy.x * Y / xy.y, Y, (1 - xy.x - xy.y) * Y / xy.y};
}

}  // namespace lacquer
