// Parameters that the media of the scene format share.
#pragma once

#include <optional>

#include "pbrt/base/medium.h"
#include "pbrt/core/spectrum.h"
#include "pbrt/scattering/presets.h"

namespace lacquer {

/// Absorption and scattering of a medium, or of one unit of density [1 / unit of length].
struct Coefficients {
    DenselySampledSpectrum sigma_a, sigma_s;
};

/// `"sigma_a"` and `"sigma_s"`, 1 where absent, times `"float scale"`; with a preset its numbers instead,
/// which are [1/mm]; with the phase function "bulk" those of its file, in 1/mm as well. Errors: SceneError
/// for negative values, and at the parameter `cause` if the extinction at the largest density is beyond
/// floats.
/// @param phase  of the medium
Coefficients ReadCoefficients(const Params& params, float largestDensity, std::string_view cause,
                              const PhaseModel& phase, const ScatteringPreset* preset = nullptr);

/// The same without preset, for densities up to 1, and with `"scale"` for a file's coefficients only.
Coefficients ReadUnscaledCoefficients(const Params& params, const PhaseModel& phase);

/// That named by `"string preset"`, if any. Errors: SceneError for an unknown name.
std::optional<ScatteringPreset> ReadPreset(const Params& params);

/// A float parameter. Errors: SceneError if it is negative.
float ReadNonNegative(const Params& params, std::string_view name, float fallback);

/// `"string phase"`, by default "hg" or that of `"string bulk"`, with the parameters that belong to it; a
/// mixture is of the phase functions of earlier media. Errors: those of ReadPhaseModel(), SceneError for the
/// name of no such medium.
MediumPhase ReadMediumPhase(const MediumArgs& args);

/// `"Le"` times `"float Lescale"`, of unit luminance as lights have it (see EmissionScale()). Empty where
/// absent or 0.
std::optional<DenselySampledSpectrum> ReadMediumEmission(const Params& params);

}  // namespace lacquer
