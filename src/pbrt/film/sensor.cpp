#include "pbrt/film/sensor.h"

#include <fmt/format.h>

#include "pbrt/core/embedded.h"

namespace lacquer {

namespace {

constexpr const char* kIdeal = "cie1931";

/// Reflectances of the 24 patches of a ColorChecker, row by row.
std::vector<PiecewiseLinearSpectrum> ColorCheckerPatches() {
    std::vector<float> lambda;
    std::vector<std::vector<float>> values(24);
    for (const std::vector<double>& row : EmbeddedTable("reflectances/colorchecker.txt")) {
        lambda.push_back(float(row.at(0)));
        for (size_t i = 0; i < values.size(); ++i) values[i].push_back(float(row.at(i + 1)));
    }
    std::vector<PiecewiseLinearSpectrum> patches;
    for (std::vector<float>& v : values)
        patches.push_back(PiecewiseLinearSpectrum::Extended(lambda, std::move(v)));
    return patches;
}

/// Kelvin; `fallback` where the scene says 0 or nothing.
float ReadWhiteBalance(const Params& params, float fallback) {
    const float kelvin = params.GetFloat("whitebalance", 0);
    if (kelvin == 0) return fallback;
    if (!(kelvin >= 500 && kelvin <= 25000))
        params.Fail("whitebalance",
                    fmt::format("whitebalance is {} K; it must be 0 or lie between 500 and 25000", kelvin));
    return kelvin;
}

/// Sum over all nanometres of light times reflectance times each of three curves.
glm::dvec3 Responses(const SensorCurves& curves, const Spectrum& light, const Spectrum& reflectance) {
    glm::dvec3 sum(0.0);
    for (int i = 0; i < DenselySampledSpectrum::kCount; ++i) {
        const auto lambda = float(DenselySampledSpectrum::kFirst + i);
        const double seen = double(light.Evaluate(lambda)) * double(reflectance.Evaluate(lambda));
        for (int c = 0; c < 3; ++c) sum[c] += seen * double(curves[size_t(c)].Values()[size_t(i)]);
    }
    return sum;
}

}  // namespace

std::vector<std::string> SensorNames() {
    constexpr std::string_view kSuffix = ".txt";
    std::vector<std::string> names = {kIdeal};
    for (const std::string& file : EmbeddedNames("sensors/"))
        names.push_back(file.substr(0, file.size() - kSuffix.size()));
    return names;
}

glm::dmat3 FitXYZFromSensor(const SensorCurves& curves, const Spectrum& light, const Spectrum& white) {
    const SensorCurves observer = {CieX(), CieY(), CieZ()};
    const ConstantSpectrum one(1);
    const double green = Responses(curves, light, one)[1];
    const double luminance = Responses(observer, light, one)[1], whiteY = Responses(observer, white, one)[1];
    // Normal equations: the sums over the patches of xyz rgb^T and rgb rgb^T.
    glm::dmat3 mixed(0.0), squares(0.0);
    for (const PiecewiseLinearSpectrum& patch : ColorCheckerPatches()) {
        const glm::dvec3 rgb = Responses(curves, light, patch) / green;
        const glm::dvec3 xyz = Responses(observer, white, patch) / whiteY * (luminance / green);
        mixed += glm::outerProduct(xyz, rgb);
        squares += glm::outerProduct(rgb, rgb);
    }
    return mixed * glm::inverse(squares);
}

Sensor::Sensor(const Params& params, float shutterTime, const ColorSpace& output)
    : imagingRatio_(shutterTime * params.GetFloatInRange("iso", 100, 0, 1e9f) / 100) {
    const std::string name = params.GetChoice("sensor", kIdeal, SensorNames());
    const bool isIdeal = name == kIdeal;
    const auto curve = [&](const char* color) {
        return DenselySampledSpectrum(*NamedSpectrum(name + color));
    };
    const SensorCurves curves =
        isIdeal ? SensorCurves{CieX(), CieY(), CieZ()} : SensorCurves{curve("_r"), curve("_g"), curve("_b")};
    for (size_t i = 0; i < DenselySampledSpectrum::kCount; ++i)
        curves_.emplace_back(curves[0].Values()[i], curves[1].Values()[i], curves[2].Values()[i]);

    rgbFromSensor_ = output.RGBFromXYZ();
    const float kelvin = ReadWhiteBalance(params, isIdeal ? 0 : 6500);
    if (!isIdeal) {
        const glm::dmat3 fit = FitXYZFromSensor(curves, *DaylightSpectrum(kelvin), output.Illuminant());
        rgbFromSensor_ = rgbFromSensor_ * glm::mat3(fit);
    } else if (kelvin != 0) {
        const Point2 seen = Chromaticity(SpectrumToXYZ(*DaylightSpectrum(kelvin)));
        rgbFromSensor_ = rgbFromSensor_ * WhiteBalance(seen, output.White());
    }
}

}  // namespace lacquer
