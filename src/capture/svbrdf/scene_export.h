// Maps as a material of scenes, and scenes that show it.
#pragma once

#include <string>
#include <vector>

#include "capture/maps.h"
#include "capture/views.h"

namespace lacquer::capture {

/// What stands for the maps in a scene. All are called "captured".
enum class ExportAs {
    Svbrdf,  ///< the model itself, material "svbrdf"
    Mix,     ///< "mix" of "diffuse" and "conductor": materials of pbrt, nearly the model
    Coated   ///< "layered": a dielectric coat of one index over a diffuse base; nicer than the model, and not
             ///< it
};

struct ExportReport {
    /// Of Mix: the probability of the metal, by which its reflectance is divided. A half where that
    /// keeps 99.9 % of the values below 1, else as near to it as that allows.
    double mixAmount = 0.5;
    double clippedShare = 0;  ///< of Mix: part of the values that were cut off at 1 all the same
    double coatIndex = 1.5;   ///< of Coated: index of refraction, of the median of the specular albedo
    /// Each a sentence without its full stop, of what the material does not show as the maps have it.
    std::vector<std::string> warnings;
};

/// Writes material.pbrt, and what it reads: the files of WriteLinearMaps(); of Mix diffuse2.exr and
/// specular2.exr, which are divided by their probabilities; of Coated base.exr, the albedo that shows as the
/// sample's through the coat from straight above. `Include` of it, in the same folder, defines "captured".
/// Errors: FileError.
ExportReport ExportMaterial(const Maps& maps, const std::string& directory, ExportAs as);

/// Writes turntable.pbrt, which includes material.pbrt: a plane, a ball and a curtain under a small light,
/// with the sample in its size. With frames, also turntable.0001.pbrt and so on, where all that turns by 360
/// degrees over them; `lacquer turntable.####.pbrt --frames 1-N --outfile turntable.####.png` renders these.
/// @param size  edge of the sample [cm]
/// Errors: FileError.
void ExportTurntable(double size, const std::string& directory, int numFrames = 0);

/// A scene that shows the material, which it includes from material.pbrt, as a rectified photograph does: a
/// camera that looks straight down and has the sample as its frame, a point light, and a pixel for each
/// texel, with its samples in the middle.
/// @param outfile  of the render    @param samples  of a pixel
std::string ViewScene(const ViewSet& views, const View& view, int resolution, const std::string& outfile,
                      int samples);

}  // namespace lacquer::capture
