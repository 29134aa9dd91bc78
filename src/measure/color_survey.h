// The colours of a material as instruments of paint laboratories read them.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "measure/spectral_subject.h"
#include "pbrt/core/color_difference.h"
#include "pbrt/core/progress.h"

namespace lacquer::measure {

/// Where light comes from and where it is measured. All are reflectances relative to a white diffuser.
struct ColorGeometry {
    std::string name;
    enum class Kind {
        Directional,  ///< one direction of light, one of the detector, in one plane
        Annular,      ///< light at one angle from all around
        Diffuse       ///< light from the whole hemisphere
    } kind = Kind::Directional;
    double lightDeg = 45;    ///< from the normal
    double detectorDeg = 0;  ///< from the normal, on the side of the light; negative: on the other one
    bool hasGlossTrap =
        false;  ///< of a sphere: light from within kTrapDeg of the mirror direction is left out
};
/// Half the opening of a gloss trap.
inline constexpr double kTrapDeg = 5;

/// 45°:0° by a ring of light; d:8° with and without the specular part; and what multi-angle instruments for
/// effect paint have: light at 45°, and a detector 15°, 25°, 45°, 75° and 110° from the mirror direction
/// toward the normal [ASTM E2194]. Detectors and lights have no size: specular peaks are seen by the sphere
/// alone.
const std::vector<ColorGeometry>& ColorGeometries();

/// D50, D65 and A, of the CIE.
inline constexpr std::array kIlluminants = {"D50", "D65", "A"};

/// A number with its standard error.
struct Uncertain {
    double value = 0, error = 0;
};
/// A colour under one illuminant, for the observer of 1931 (2 degrees).
struct ColorReading {
    std::array<Uncertain, 3> xyz;  ///< of white: Y = 100
    Uncertain L, a, b, chroma, hueDeg;
};

/// The readings of one material.
class ColorSurvey {
  public:
    /// Independent parts of the samples, from which errors follow. Deterministic models have the same in all.
    static constexpr int kParts = 16;
    /// @param xyz  [geometry][illuminant][part], of white: Y = 100
    using Parts = std::array<glm::dvec3, kParts>;
    explicit ColorSurvey(std::vector<std::array<Parts, kIlluminants.size()>> xyz) : xyz_(std::move(xyz)) {}

    /// @param geometry  of ColorGeometries()
    ColorReading At(size_t geometry, size_t illuminant) const;
    /// CIEDE2000 between two materials, with the error that both give it. Where the colours are the same, the
    /// value is of the size of its error, and never negative.
    static Uncertain Difference(const ColorSurvey& a, const ColorSurvey& b, size_t geometry,
                                size_t illuminant);

  private:
    std::vector<std::array<Parts, kIlluminants.size()>> xyz_;
};

/// Wavelengths that a survey wants of its subject [nm]: the whole range, at steps of 5 nm, or of 1 nm, which
/// fringes of films want, where evaluations have no noise.
std::vector<float> ColorWavelengths(bool isStochastic);

struct ColorSurveyOptions {
    double azimuthDeg = 0;  ///< of the light
    int samples = 4096;     ///< of each geometry
    uint64_t seed = 0;
};
/// @param subject     at ColorWavelengths()
/// @param wavelengths  those
/// The same for the same seed whatever the threads. Cost: some seconds on two cores for a stack.
ColorSurvey SurveyColors(const SpectralSubject& subject, const std::vector<float>& wavelengths,
                         const ColorSurveyOptions& options, Observer* observer);

}  // namespace lacquer::measure
