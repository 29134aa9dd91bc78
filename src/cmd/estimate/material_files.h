// Estimated materials as files: maps, a material for scenes, and scenes to look at.
#pragma once

#include <string>

#include "cmd/estimate/estimate_arguments.h"
#include "estimate/photo/flash_photo.h"
#include "estimate/photo_simulator.h"

namespace lacquer::cmd {

/// What is written: a surface and how it was photographed.
struct EstimatedMaterial {
    std::string model;
    estimate::MapGrid grid;
    estimate::Surface surface;
    estimate::FlashSettings flash;
    double distance = 25;  ///< of the camera from the sample [cm]
};

/// The surface of a seed at a simulator's parameters, as large and as fine as --map-extent and --map-size ask
/// for, or as the photograph is.
/// @param parameters  free ones, natural units
EstimatedMaterial MaterialOf(const EstimateArguments& arguments, const estimate::PhotoSimulator& simulator,
                             const estimate::Vector& parameters, uint64_t seed);

/// Index of refraction of interfaces with F0 = 0.04.
inline constexpr double kCoatEta = 1.5;

/// The reflectance of a Lambertian base that under a rough interface (alpha, index 1.5) looks as albedo / pi
/// does, seen and lit straight on: rho' with t^2 rho' / (eta^2 (1 - rho' R)) = rho, t and R those of the
/// interface; in [0,1]. Rough interfaces at slanted angles let in a little less: within 2 % up to 45 degrees
/// for alpha <= 0.16.
float ReflectanceUnderCoat(float albedo, float alpha);

/// Writes into `folder`, which exists:
///     maps/*.exr        32-bit floats, rows from the top: albedo (metals: f0; dielectrics: of the base under
///     the
///                       coat), normal ((n + 1) / 2, y up), rough (metals: roughx, roughy; alpha), height
///                       [cm]; flakes: flake_normal in place of normal and height
///     material.pbrt     the named material "estimated", to be included
///     preview.pbrt      a ball of it and a plane
///     photograph.pbrt   the photograph again, without vignette: what the camera sees of the square
/// Errors: FileError.
void WriteMaterialFiles(const std::string& folder, const EstimatedMaterial& material);

}  // namespace lacquer::cmd
