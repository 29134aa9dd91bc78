// Photographs of a card around a sample, rendered: scenes with a point light at the camera.
#pragma once

#include <string>

#include "capture/card/camera_model.h"
#include "pbrt/image/image.h"

namespace lacquer::test {

/// What is photographed. Lengths in cm; the frame is that of the card.
struct PhotographScene {
    /// pbrt directives of the sample's material, textures first. Texture coordinates run from (0,0) at the
    /// lower left to (1,1) at the upper right of the square of the sample that a capture takes.
    std::string material = R"(Material "diffuse" "rgb reflectance" [.5 .4 .3])";
    double size = 17;    ///< of the card
    double depth = 0.1;  ///< of the sample below it
    Int2 resolution{400, 400};
    double fovDeg = 50;              ///< across the shorter side
    double lightPower = 1500;        ///< as ViewSet::lightPower
    Eigen::Vector3d flash{0, 0, 0};  ///< beside the camera, as CaptureOptions::flash
    /// Of a stratified sampler along an edge of a pixel: errors of neighbouring pixels are independent, as
    /// noise is, while few samples of a low-discrepancy sequence would shift edges.
    int samplesPerEdge = 3;
    int maxDepth = 2;  ///< of paths: 1 is light that is reflected once

    /// Of the camera, whose principal point is in the middle.
    capture::Intrinsics Intrinsics() const;
    /// The light in the frame of the card.
    Eigen::Vector3d Light(const capture::CameraPose& pose) const;
};

/// Writes the texture of the card that scenes name; its path.
std::string WriteCardTexture(const std::string& folder, double size);

/// The scene as a text. @param cardTexture  path of the card's texture
std::string PhotographSceneText(const PhotographScene& scene, const capture::CameraPose& pose,
                                const std::string& cardTexture);

/// The photograph as linear R, G, B.
Image RenderPhotograph(const PhotographScene& scene, const capture::CameraPose& pose,
                       const std::string& cardTexture);

}  // namespace lacquer::test
