// What may be wrong with a calibration: before it begins, and with what it found.
#pragma once

#include <span>

#include "capture/card/calibration.h"

namespace lacquer::capture {

/// Errors: SceneError where there are no photographs, or the focal length of few ones is not known.
void CheckCalibrationInput(std::span<const CardPhotograph> photographs, const CalibrationOptions& options);

/// Errors: SceneError with the worst photograph as its place if the card is not flat, or mirrored. Warnings:
/// a focal length that is hardly known or is not that of the metadata, positions that are hardly known, or
/// equal.
void CheckCalibration(std::span<const CardPhotograph> photographs, const CalibrationOptions& options,
                      Calibration* calibration);

}  // namespace lacquer::capture
