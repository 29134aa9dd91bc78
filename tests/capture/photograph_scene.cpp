#include "capture/photograph_scene.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "capture/card/card.h"
#include "integrators/render_fixtures.h"

namespace lacquer::test {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// A rectangle at a height, with texture coordinates from 0 to 1 over a square about the origin.
std::string Rectangle(Vector2d a, Vector2d b, double z, double square) {
    const auto uv = [&](double x) { return x / square + 0.5; };
    return fmt::format(
        "Shape \"bilinearmesh\" \"point3 P\" [{0} {1} {4}  {2} {1} {4}  {0} {3} {4}  {2} {3} {4}]\n"
        "    \"point2 uv\" [{5} {6}  {7} {6}  {5} {8}  {7} {8}]\n",
        a.x(), a.y(), b.x(), b.y(), z, uv(a.x()), uv(a.y()), uv(b.x()), uv(b.y()));
}

/// The card around its window.
std::string CardText(double size, const std::string& texture) {
    const double unit = size / capture::kUnitsPerSize, page = capture::kPageUnits * unit, h = page / 2,
                 w = capture::kWindowUnits * unit / 2;
    return fmt::format(
               "Texture \"card\" \"spectrum\" \"imagemap\" \"string filename\" \"{}\"\n"
               "Material \"diffuse\" \"texture reflectance\" \"card\"\n",
               texture) +
           Rectangle({-h, w}, {h, h}, 0, page) + Rectangle({-h, -h}, {h, -w}, 0, page) +
           Rectangle({-h, -w}, {-w, w}, 0, page) + Rectangle({w, -w}, {h, w}, 0, page);
}

}  // namespace

capture::Intrinsics PhotographScene::Intrinsics() const {
    const double f = 0.5 * std::min(resolution.x, resolution.y) / std::tan(fovDeg * std::numbers::pi / 360);
    return {f, 0.5 * resolution.x, 0.5 * resolution.y, 0, 0};
}

Vector3d PhotographScene::Light(const capture::CameraPose& pose) const {
    return pose.position + pose.rotation.transpose() * Vector3d(flash.x(), -flash.y(), flash.z());
}

std::string WriteCardTexture(const std::string& folder, double size) {
    Image card = capture::CardImage(size, 32);
    for (float& v : card.Pixels()) v = 0.04F + 0.8F * v;  // toner, and paper
    const std::string path = (std::filesystem::path(folder) / "card-texture.png").string();
    WriteImage(card, path);
    return path;
}

std::string PhotographSceneText(const PhotographScene& scene, const capture::CameraPose& pose,
                                const std::string& cardTexture) {
    const Vector3d p = pose.position, target = p + pose.rotation.row(2).transpose(),
                   up = -pose.rotation.row(1).transpose(), light = scene.Light(pose);
    const double square = capture::kSampleShare * scene.size, edge = 0.36 * scene.size,
                 table = 5 * scene.size;
    // Frames of pbrt are left-handed: without the mirror x would run to the left.
    std::string text = fmt::format("Scale -1 1 1\nLookAt {} {} {}  {} {} {}  {} {} {}\n", p.x(), p.y(), p.z(),
                                   target.x(), target.y(), target.z(), up.x(), up.y(), up.z());
    text += fmt::format("Camera \"perspective\" \"float fov\" {}\nPixelFilter \"box\"\n", scene.fovDeg);
    text += fmt::format("Sampler \"stratified\" \"integer xsamples\" {0} \"integer ysamples\" {0}\n",
                        scene.samplesPerEdge);
    text += fmt::format("Integrator \"path\" \"integer maxdepth\" {}\n", scene.maxDepth);
    text += fmt::format("Film \"rgb\" \"integer xresolution\" {} \"integer yresolution\" {}\nWorldBegin\n",
                        scene.resolution.x, scene.resolution.y);
    text += fmt::format("LightSource \"point\" \"rgb I\" [{0} {0} {0}] \"point3 from\" [{1} {2} {3}]\n",
                        scene.lightPower, light.x(), light.y(), light.z());
    text += CardText(scene.size, cardTexture) + scene.material + "\n";
    text += Rectangle({-edge, -edge}, {edge, edge}, -scene.depth, square);
    return text + "Material \"diffuse\" \"rgb reflectance\" [.15 .13 .1]\n" +
           Rectangle({-table, -table}, {table, table}, -scene.depth - 0.02, square);
}

Image RenderPhotograph(const PhotographScene& scene, const capture::CameraPose& pose,
                       const std::string& cardTexture) {
    return *RenderText(PhotographSceneText(scene, pose, cardTexture));
}

}  // namespace lacquer::test
