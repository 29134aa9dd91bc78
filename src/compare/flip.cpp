#include "compare/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "compare/tone_map.h"
#include "pbrt/core/check.h"
#include "pbrt/core/parallel.h"

namespace lacquer::compare {
namespace {

/// One number for each pixel.
struct Plane {
    explicit Plane(Int2 size) : resolution(size), values(size_t(size.x) * size_t(size.y)) {}
    float* Row(int y) { return values.data() + size_t(y) * size_t(resolution.x); }
    const float* Row(int y) const { return values.data() + size_t(y) * size_t(resolution.x); }
    Int2 resolution;
    std::vector<float> values;
};

/// Three numbers for each pixel: linear sRGB, YCxCz or L*a*b*.
struct Colors {
    explicit Colors(Int2 size) : planes{Plane(size), Plane(size), Plane(size)} {}
    Vec3 Get(size_t i) const { return {planes[0].values[i], planes[1].values[i], planes[2].values[i]}; }
    void Set(size_t i, Vec3 v) {
        for (int c = 0; c < 3; ++c) planes[size_t(c)].values[i] = v[c];
    }
    Int2 Resolution() const { return planes[0].resolution; }
    std::array<Plane, 3> planes;
};

/// body(i) for all pixels, rows in parallel.
template <class Body>
void ForPixels(Int2 resolution, const Body& body) {
    ParallelFor(resolution.y, [&](int64_t y) {
        const size_t begin = size_t(y) * size_t(resolution.x);
        for (size_t i = begin; i < begin + size_t(resolution.x); ++i) body(i);
    });
}

// ---- Colours ----

/// sRGB primaries with the white D65 [IEC 61966-2-1].
const glm::mat3 kXyzFromRgb(0.4123866f, 0.2126369f, 0.0193306f, 0.3575915f, 0.7151830f, 0.1191972f,
                            0.1804505f, 0.0721802f, 0.9503726f);
const glm::mat3 kRgbFromXyz = glm::inverse(kXyzFromRgb);
const XYZ kWhite = kXyzFromRgb * RGB(1);

/// The opponent space YCxCz, L*a*b* without its curve: filters act on light.
Vec3 OpponentFromRgb(RGB rgb) {
    const Vec3 v = kXyzFromRgb * rgb / kWhite;
    return {116 * v.y - 16, 500 * (v.x - v.y), 200 * (v.y - v.z)};
}

RGB RgbFromOpponent(Vec3 v) {
    const float y = (v.x + 16) / 116;
    return kRgbFromXyz * (Vec3(y + v.y / 500, y, y - v.z / 200) * kWhite);
}

/// L*a*b* with the chroma of the Hunt effect: colours are less vivid where it is dark.
Vec3 HuntLabFromRgb(RGB rgb) {
    const auto curve = [](float t) {
        constexpr float delta = 6.f / 29;
        return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4.f / 29;
    };
    const Vec3 v = kXyzFromRgb * rgb / kWhite;
    const float x = curve(v.x), y = curve(v.y), z = curve(v.z), lightness = 116 * y - 16;
    return {lightness, 0.01f * lightness * 500 * (x - y), 0.01f * lightness * 200 * (y - z)};
}

/// Distance for large differences: lightness and chroma apart.
float HyAB(Vec3 a, Vec3 b) {
    const Vec3 d = a - b;
    return std::abs(d.x) + std::sqrt(d.y * d.y + d.z * d.z);
}

// ---- Separable filters ----

/// Weights from -radius to radius.
using Kernel = std::vector<float>;

template <class Weight>
Kernel MakeKernel(int radius, const Weight& weight) {
    Kernel kernel;
    for (int x = -radius; x <= radius; ++x) kernel.push_back(float(weight(double(x))));
    return kernel;
}

/// Makes the positive weights sum to 1 and the negative ones to -1.
Kernel Normalized(Kernel kernel) {
    double positive = 0, negative = 0;
    for (const float w : kernel) (w > 0 ? positive : negative) += double(w);
    for (float& w : kernel)
        if (w != 0) w = float(double(w) / (w > 0 ? positive : -negative));
    return kernel;
}

/// Weighted mean of a pixel's neighbours in its row; the border pixel continues outward.
Plane FilterRows(const Plane& in, const Kernel& kernel) {
    Plane out(in.resolution);
    const int width = in.resolution.x, radius = int(kernel.size()) / 2;
    ParallelFor(in.resolution.y, [&](int64_t y) {
        const float* from = in.Row(int(y));
        float* to = out.Row(int(y));
        for (int x = 0; x < width; ++x) {
            float sum = 0;
            for (int k = -radius; k <= radius; ++k)
                sum += kernel[size_t(k + radius)] * from[std::clamp(x + k, 0, width - 1)];
            to[x] = sum;
        }
    });
    return out;
}

/// The same in its column.
Plane FilterColumns(const Plane& in, const Kernel& kernel) {
    Plane out(in.resolution);
    const int height = in.resolution.y, radius = int(kernel.size()) / 2;
    ParallelFor(height, [&](int64_t y) {
        float* to = out.Row(int(y));
        for (int k = -radius; k <= radius; ++k) {
            const float weight = kernel[size_t(k + radius)];
            const float* from = in.Row(std::clamp(int(y) + k, 0, height - 1));
            for (int x = 0; x < in.resolution.x; ++x) to[x] += weight * from[x];
        }
    });
    return out;
}

// ---- The colour pipeline ----

/// Contrast sensitivity of one opponent channel over frequency, as a sum of two Gaussians in space:
/// amplitude a sqrt(pi / b) exp(-pi^2 x^2 / b), x in degrees [Andersson et al. 2020, spatial filtering].
struct Sensitivity {
    double a1, b1, a2, b2;
};
constexpr std::array<Sensitivity, 3> kSensitivities{
    {{1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}}};
constexpr double kLargestB = 0.04;

/// Two-dimensional kernels are not separable, but each Gaussian of the sum is.
Plane FilterBySensitivity(const Plane& plane, const Sensitivity& s, float pixelsPerDegree) {
    const double pi = double(Pi), ppd = double(pixelsPerDegree);
    const int radius = int(std::ceil(3 * std::sqrt(kLargestB / (2 * pi * pi)) * ppd));
    const auto gaussian = [&](double b) {
        return MakeKernel(radius, [&](double x) { return std::exp(-Sqr(pi * x / ppd) / b); });
    };
    const auto mass = [&](double a, double b) {
        double sum = 0;
        for (const float w : gaussian(b)) sum += double(w);
        return a * std::sqrt(pi / b) * sum * sum;
    };
    const double mass1 = mass(s.a1, s.b1), mass2 = mass(s.a2, s.b2);
    const Kernel kernel1 = Normalized(gaussian(s.b1));
    Plane result = FilterColumns(FilterRows(plane, kernel1), kernel1);
    if (mass2 == 0) return result;
    const Kernel kernel2 = Normalized(gaussian(s.b2));
    const Plane second = FilterColumns(FilterRows(plane, kernel2), kernel2);
    const auto weight = float(mass2 / (mass1 + mass2));
    ForPixels(plane.resolution, [&](size_t i) {
        result.values[i] = (1 - weight) * result.values[i] + weight * second.values[i];
    });
    return result;
}

/// What the eye resolves of the image, in L*a*b* with the Hunt effect.
Colors Perceived(const Colors& opponent, float pixelsPerDegree) {
    Colors result(opponent.Resolution());
    for (size_t c = 0; c < 3; ++c)
        result.planes[c] = FilterBySensitivity(opponent.planes[c], kSensitivities[c], pixelsPerDegree);
    ForPixels(opponent.Resolution(), [&](size_t i) {
        const RGB rgb = glm::clamp(RgbFromOpponent(result.Get(i)), RGB(0), RGB(1));
        result.Set(i, HuntLabFromRgb(rgb));
    });
    return result;
}

/// Distance to the power 0.7 and onto [0,1]: 0.4 of the largest one, that between green and blue, becomes
/// 0.95, for beyond it differences hardly look larger.
float ColorDifference(Vec3 a, Vec3 b) {
    constexpr float kPower = 0.7f, kKneeIn = 0.4f, kKneeOut = 0.95f;
    static const float largest = std::pow(HyAB(HuntLabFromRgb({0, 1, 0}), HuntLabFromRgb({0, 0, 1})), kPower);
    const float difference = std::pow(HyAB(a, b), kPower), knee = kKneeIn * largest;
    if (difference < knee) return kKneeOut / knee * difference;
    return kKneeOut + (difference - knee) / (largest - knee) * (1 - kKneeOut);
}

// ---- The feature pipeline ----

/// How much of an edge and of a point is at each pixel, in the lightness of the image.
struct Features {
    Plane edges, points;
};

/// Lengths of the vectors (x, y).
Plane Lengths(const Plane& x, const Plane& y) {
    Plane result(x.resolution);
    ForPixels(x.resolution, [&](size_t i) {
        result.values[i] = std::sqrt(x.values[i] * x.values[i] + y.values[i] * y.values[i]);
    });
    return result;
}

/// First and second derivatives of a Gaussian as wide as the eye's detector of edges, 0.082 degrees from peak
/// to trough [Andersson et al. 2020, feature detection].
Features DetectFeatures(const Colors& opponent, float pixelsPerDegree) {
    const double deviation = 0.5 * 0.082 * double(pixelsPerDegree);
    const int radius = int(std::ceil(3 * deviation));
    const auto gaussian = [&](double x) { return std::exp(-x * x / (2 * deviation * deviation)); };
    const Kernel smooth = Normalized(MakeKernel(radius, gaussian));
    const Kernel edge = Normalized(MakeKernel(radius, [&](double x) { return -x * gaussian(x); }));
    const Kernel point =
        Normalized(MakeKernel(radius, [&](double x) { return (Sqr(x / deviation) - 1) * gaussian(x); }));

    Plane lightness = opponent.planes[0];
    // 116, not 100: the authors' correction of the paper.
    for (float& v : lightness.values) v = (v + 16) / 116;
    const Plane alongRows = FilterRows(lightness, smooth), alongColumns = FilterColumns(lightness, smooth);
    return {Lengths(FilterRows(alongColumns, edge), FilterColumns(alongRows, edge)),
            Lengths(FilterRows(alongColumns, point), FilterColumns(alongRows, point))};
}

float FeatureDifference(const Features& a, const Features& b, size_t i) {
    const float difference = std::max(std::abs(a.edges.values[i] - b.edges.values[i]),
                                      std::abs(a.points.values[i] - b.points.values[i]));
    return std::sqrt(difference * std::sqrt(0.5f));
}

// ---- Both ----

/// @param image, reference  linear sRGB in [0,1]
Plane Flip(Colors image, Colors reference, float pixelsPerDegree) {
    for (Colors* colors : {&image, &reference})
        ForPixels(colors->Resolution(), [&](size_t i) { colors->Set(i, OpponentFromRgb(colors->Get(i))); });
    const Features features = DetectFeatures(image, pixelsPerDegree);
    const Features referenceFeatures = DetectFeatures(reference, pixelsPerDegree);
    image = Perceived(image, pixelsPerDegree);
    reference = Perceived(reference, pixelsPerDegree);
    Plane result(image.Resolution());
    ForPixels(image.Resolution(), [&](size_t i) {
        const float color = ColorDifference(image.Get(i), reference.Get(i));
        // [Andersson et al. 2020, final difference]: features make differences of colour easier to see.
        result.values[i] = std::pow(color, 1 - FeatureDifference(features, referenceFeatures, i));
    });
    return result;
}

/// Linear sRGB of an image, any range.
Colors SrgbOf(const Image& image) {
    LACQUER_CHECK(image.HasRGB());
    const ColorSpace* space = image.ColorSpace();
    const bool convert = space && space != &ColorSpace::SRGB();
    const glm::mat3 matrix = convert ? ColorSpace::SRGB().RGBFromXYZ() * space->XYZFromRGB() : glm::mat3(1);
    Colors colors(image.Resolution());
    const auto stride = size_t(image.NumChannels());
    ForPixels(image.Resolution(), [&](size_t i) {
        const float* pixel = image.Pixels().data() + i * stride;
        colors.Set(i, matrix * RGB(pixel[0], pixel[1], pixel[2]));
    });
    return colors;
}

Image ToImage(const Plane& plane, const Image& like) {
    Image image(plane.resolution, {"FLIP"});
    image.Pixels() = plane.values;
    image.dataWindow = like.dataWindow;
    image.fullResolution = like.fullResolution;
    return image;
}

float LuminanceOf(RGB srgb) { return 0.2126f * srgb.x + 0.7152f * srgb.y + 0.0722f * srgb.z; }

/// What a screen shows of the scene at one exposure.
Colors Exposed(const Colors& scene, float stops) {
    Colors result(scene.Resolution());
    const float scale = std::exp2(stops);
    ForPixels(scene.Resolution(), [&](size_t i) {
        const RGB rgb = scene.Get(i) * scale;
        result.Set(i, {AcesCurve::Evaluate(rgb.x), AcesCurve::Evaluate(rgb.y), AcesCurve::Evaluate(rgb.z)});
    });
    return result;
}

}  // namespace

Image LdrFlip(const Image& image, const Image& reference, float pixelsPerDegree) {
    LACQUER_CHECK(image.Resolution() == reference.Resolution());
    std::array<Colors, 2> both{SrgbOf(image), SrgbOf(reference)};
    for (Colors& colors : both)
        for (Plane& plane : colors.planes)
            for (float& v : plane.values) v = std::clamp(v, 0.f, 1.f);
    return ToImage(Flip(std::move(both[0]), std::move(both[1]), pixelsPerDegree), image);
}

FlipExposures HdrFlipExposures(const Image& reference) {
    const Colors srgb = SrgbOf(reference);
    std::vector<float> luminances(srgb.planes[0].values.size());
    for (size_t i = 0; i < luminances.size(); ++i) luminances[i] = LuminanceOf(srgb.Get(i));
    const float largest = *std::max_element(luminances.begin(), luminances.end());
    if (!(largest > 0)) return {};
    const auto middle = luminances.begin() + std::ptrdiff_t((luminances.size() - 1) / 2);
    std::nth_element(luminances.begin(), middle, luminances.end());
    // Of an image that is black for the most part, the exposures must end somewhere.
    const float median = std::max(*middle, std::numeric_limits<float>::epsilon());
    const auto bright = float(AcesCurve::Inverse(0.85));
    FlipExposures exposures{std::log2(bright / largest), std::log2(bright / median), 2};
    exposures.count = std::max(2, int(std::ceil(exposures.stop - exposures.start)));
    return exposures;
}

Image HdrFlip(const Image& image, const Image& reference, const FlipExposures& exposures,
              float pixelsPerDegree) {
    LACQUER_CHECK(image.Resolution() == reference.Resolution() && exposures.count >= 1);
    const Colors a = SrgbOf(image), b = SrgbOf(reference);
    const float step = (exposures.stop - exposures.start) / float(std::max(1, exposures.count - 1));
    Plane result(a.Resolution());
    for (int i = 0; i < exposures.count; ++i) {
        const float stops = exposures.start + float(i) * step;
        const Plane flip = Flip(Exposed(a, stops), Exposed(b, stops), pixelsPerDegree);
        for (size_t p = 0; p < flip.values.size(); ++p)
            result.values[p] = std::max(result.values[p], flip.values[p]);
    }
    return ToImage(result, image);
}

}  // namespace lacquer::compare
