// Densities of a path at each of its wavelengths.
//
// What a path draws in a medium (flight distances, kinds of collisions) follows its first wavelength. The
// same path might have been drawn for each of the others, with other densities: combining them by the
// balance heuristic divides by the mean density instead of by that of the first [Wilkie et al. 2014, eq. 4;
// Miller et al. 2019, sec. 4].
#pragma once

#include "pbrt/core/sampled_spectrum.h"

namespace lacquer {

/// Density over density at the first wavelength, for each wavelength: of drawing the path by scattering
/// alone, and of drawing all but its last edge so and the last edge by a light sample. Surfaces draw alike at
/// all wavelengths, and so do phase functions that do not depend on them.
struct SpectralPdfs {
    SampledSpectrum scattering{1.f};
    SampledSpectrum light{1.f};  ///< since the last vertex where a light was sampled

    /// The path got a vertex where lights are sampled.
    void StartEdge() { light = scattering; }
};

/// Mean over the wavelengths that the path still carries.
inline float MeanPdf(SampledSpectrum pdfs, const SampledWavelengths& lambda) {
    return lambda.SecondaryTerminated() ? pdfs[0] : pdfs.Average();
}
/// The same of products with the density of one draw more, alike at all wavelengths or not.
inline float MeanPdf(SampledSpectrum pdfs, float drawn, const SampledWavelengths& lambda) {
    return MeanPdf(pdfs, lambda) * drawn;
}
inline float MeanPdf(SampledSpectrum pdfs, SampledSpectrum drawn, const SampledWavelengths& lambda) {
    return MeanPdf(pdfs * drawn, lambda);
}

/// Values with the first one standing for all, after a dispersive event ended the others for a caller who
/// keeps all wavelengths: their sum is the same in the mean over which wavelength is first.
inline SampledSpectrum OnlyFirst(SampledSpectrum s) { return SampledSpectrum::Lanes{kNumWavelengths * s[0]}; }
/// Light as a caller who keeps all wavelengths counts it.
/// @param isAlone  a dispersive event has ended all wavelengths but the first
inline SampledSpectrum OverMeanPdf(SampledSpectrum light, SampledSpectrum pdfs, bool isAlone) {
    return isAlone ? OnlyFirst(light / pdfs[0]) : light / pdfs.Average();
}

}  // namespace lacquer
