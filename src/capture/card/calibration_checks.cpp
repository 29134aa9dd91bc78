#include "capture/card/calibration_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "pbrt/core/error.h"

namespace lacquer::capture {

namespace {

/// Shares of a camera's distance: of the standard error of a position from which on there is a warning, and
/// of the distance between two positions up to which there is one.
constexpr double kVaguePosition = 0.03, kEqualPositions = 0.02;
/// Share of the photograph's longer side: what remains of the tags from which on there is a warning. A flat
/// card leaves a tenth of it in sharp photographs; it moves rectified points by about as much of the sample.
constexpr double kNotQuiteFlat = 5e-4;

void CheckFlatness(std::span<const CardPhotograph> photographs, double maxRms, const Calibration& found) {
    const auto worst =
        std::max_element(found.photographs.begin(), found.photographs.end(),
                         [](const PhotographPose& a, const PhotographPose& b) { return a.rms < b.rms; });
    if (worst->rms <= maxRms) return;
    const std::string lens =
        found.photographs.size() < 3
            ? "; or the lens bends straight lines, which three photographs would tell, or the "
              "focal length is another"
            : "";
    throw SceneError(
        {photographs[size_t(worst - found.photographs.begin())].name},
        fmt::format("the card is not flat, or not a print of ours: its tags are {:.1f} pixels (RMS) from "
                    "where a flat one has them; expected at most {:.3g}{}",
                    worst->rms, maxRms, lens));
}

void WarnOfBending(Int2 resolution, Calibration* found) {
    double worst = 0;
    for (const PhotographPose& p : found->photographs) worst = std::max(worst, p.rms);
    if (worst > kNotQuiteFlat * std::max(resolution.x, resolution.y))
        found->warnings.push_back(
            fmt::format("the card is not quite flat, or the lens not simple: tags are up to {:.2f} pixels "
                        "(RMS) from where they "
                        "should be, and so are points of the sample",
                        worst));
}

void WarnOfPositions(std::span<const CardPhotograph> photographs, Calibration* found) {
    const std::vector<PhotographPose>& poses = found->photographs;
    for (size_t i = 0; i < poses.size(); ++i) {
        const double distance = poses[i].pose.position.norm(), error = std::sqrt(poses[i].covariance.trace());
        if (error > kVaguePosition * distance)
            found->warnings.push_back(fmt::format(
                "{}: the position of the camera is known to {:.1f} cm only; photographs from more "
                "slanted directions, or the focal length, would help",
                photographs[i].name, error));
        for (size_t j = 0; j < i; ++j)
            if ((poses[i].pose.position - poses[j].pose.position).norm() < kEqualPositions * distance)
                found->warnings.push_back(
                    fmt::format("{} and {} were taken from the same position: the second one tells little",
                                photographs[j].name, photographs[i].name));
    }
}

void WarnOfFocalLength(const CalibrationOptions& options, Calibration* found) {
    const double f = found->intrinsics.f;
    if (found->photographs.size() >= 3 && found->focalError > 0.05 * f)
        found->warnings.push_back(
            fmt::format("the photographs tell the focal length to {:.0f} % only; more slanted "
                        "directions would help",
                        100 * found->focalError / f));
    // The metadata's own error, or a zoom that they do not know of.
    if (options.focalOfMetadata && std::abs(f / *options.focalOfMetadata - 1) > 0.15)
        found->warnings.push_back(
            fmt::format("the focal length is {:.0f} pixels by the card, and {:.0f} by the "
                        "photographs' metadata",
                        f, *options.focalOfMetadata));
}

}  // namespace

void CheckCalibrationInput(std::span<const CardPhotograph> photographs, const CalibrationOptions& options) {
    if (photographs.empty()) throw SceneError({}, "there are no photographs");
    if (photographs.size() < 3 && !options.focal && !options.focalOfMetadata)
        throw SceneError(
            {photographs[0].name},
            "the focal length is unknown: the file does not tell FocalLengthIn35mmFilm; give it in "
            "pixels, or three photographs");
}

void CheckCalibration(std::span<const CardPhotograph> photographs, const CalibrationOptions& options,
                      Calibration* calibration) {
    CheckFlatness(photographs, options.maxRms, *calibration);
    for (size_t i = 0; i < photographs.size(); ++i)
        if (!(calibration->photographs[i].pose.position.z() > 0))
            throw SceneError({photographs[i].name}, "the card is mirrored");
    WarnOfBending(options.resolution, calibration);
    WarnOfPositions(photographs, calibration);
    WarnOfFocalLength(options, calibration);
}

}  // namespace lacquer::capture
