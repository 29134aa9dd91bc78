#include "pbrt/film/sensor.h"

#include <fmt/format.h>

namespace lacquer {

Sensor::Sensor(const Params& params, float shutterTime, const ColorSpace& output)
    : imagingRatio_(shutterTime * params.GetFloatInRange("iso", 100, 0, 1e9f) / 100) {
    const std::string sensor = params.GetString("sensor", "cie1931");
    if (sensor != "cie1931") {
        const auto isMeasured = [&](const char* maker) { return sensor.starts_with(maker); };
        const bool planned =
            isMeasured("canon_") || isMeasured("nikon_") || isMeasured("sony_") || isMeasured("hasselblad_");
        const std::string reason =
            planned ? "is part of the pbrt-v4 format, but not in this version of Lacquer yet" : "is unknown";
        params.Fail("sensor", fmt::format("sensor \"{}\" {}; \"cie1931\" is here", sensor, reason));
    }
    const float whiteBalance = params.GetFloat("whitebalance", 0);
    rgbFromSensor_ = output.RGBFromXYZ();
    if (whiteBalance != 0) {
        if (!(whiteBalance >= 500 && whiteBalance <= 25000))
            params.Fail(
                "whitebalance",
                fmt::format("whitebalance is {} K; it must be 0 or lie between 500 and 25000", whiteBalance));
        const Point2 seen = Chromaticity(SpectrumToXYZ(*DaylightSpectrum(whiteBalance)));
        rgbFromSensor_ = rgbFromSensor_ * WhiteBalance(seen, output.White());
    }
    for (int i = 0; i < DenselySampledSpectrum::kCount; ++i)
        observer_.emplace_back(CieX().Values()[size_t(i)], CieY().Values()[size_t(i)],
                               CieZ().Values()[size_t(i)]);
}

}  // namespace lacquer
