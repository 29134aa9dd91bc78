// From spectral radiance to the film's RGB.
#pragma once

#include <array>

#include "pbrt/core/params.h"
#include "pbrt/core/sampled_spectrum.h"

namespace lacquer {

/// What the three kinds of a sensor's pixels see.
using SensorCurves = std::array<DenselySampledSpectrum, 3>;

/// Matrix from a camera's responses to XYZ: that which fits the 24 patches of a ColorChecker best (least
/// squares), seen by the camera under `light` and by the observer under `white`, at equal luminance of the
/// two.
glm::dmat3 FitXYZFromSensor(const SensorCurves& curves, const Spectrum& light, const Spectrum& white);

/// What `"string sensor"` can say: the ideal observer, and the cameras whose curves are built in.
std::vector<std::string> SensorNames();

/// The ideal CIE 1931 observer or a measured camera, exposed for shutter time x ISO / 100, white-balanced.
class Sensor {
  public:
    /// Reads `sensor`, `iso`, `whitebalance`. @param shutterTime  shutterclose - shutteropen
    Sensor(const Params& params, float shutterTime, const ColorSpace& output);

    /// Sensor response (X, Y, Z, or the camera's red, green, blue) of one camera sample; a Monte Carlo
    /// estimate over its wavelengths.
    Vec3 Response(SampledSpectrum L, const SampledWavelengths& lambda) const {
        const SampledSpectrum weighted = SafeDivide(L, lambda.Pdf());
        SampledSpectrum::Lanes x, y, z;
        for (int i = 0; i < kNumWavelengths; ++i) {
            const Vec3 xyz = CurvesAt(lambda[i]);
            x[i] = xyz.x;
            y[i] = xyz.y;
            z[i] = xyz.z;
        }
        return imagingRatio_ * Vec3((weighted * SampledSpectrum(x)).Average(),
                                    (weighted * SampledSpectrum(y)).Average(),
                                    (weighted * SampledSpectrum(z)).Average());
    }
    /// Linear RGB of the film's colour space from accumulated responses.
    const glm::mat3& RGBFromSensor() const { return rgbFromSensor_; }

  private:
    /// Curves at the nearest integer nanometre, interleaved for one cache line a look-up.
    Vec3 CurvesAt(float lambda) const {
        return curves_[size_t(std::clamp(int(lambda + 0.5f) - 360, 0, 470))];
    }

    float imagingRatio_;
    glm::mat3 rgbFromSensor_;
    std::vector<Vec3> curves_;
};

}  // namespace lacquer
