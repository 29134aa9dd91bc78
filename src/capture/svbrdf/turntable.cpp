#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "capture/svbrdf/scene_export.h"
#include "pbrt/core/output_file.h"
#include "pbrt/core/vec.h"

namespace lacquer::capture {
namespace {

constexpr double kPlane = 30, kBall = 4, kWidth = 14, kHeight = 11;  ///< [cm]

/// A curtain that hangs in folds, wider ones further down. @param s, t  in [0,1], to the right and up
struct Curtain {
    static double Depth(double s, double t) {
        const double open = 1 - 0.6 * t;
        return 0.9 * open * std::sin(17 * s + 0.8 * std::sin(2.2 * t)) +
               0.35 * open * std::sin(7 * s + 3 * t);
    }
    static Point3 At(double s, double t) {
        return {float(kWidth * (s - 0.5)), float(Depth(s, t)), float(kHeight * t)};
    }
    /// Towards the camera, where y grows away from it.
    static Vec3 NormalAt(double s, double t) {
        constexpr double kStep = 1e-4;
        const Vec3 bySide = At(s + kStep, t) - At(s - kStep, t),
                   byHeight = At(s, t + kStep) - At(s, t - kStep);
        return Normalize(Cross(bySide, byHeight));
    }
};

/// @param size  edge of the sample: the cloth has as many of it as fit
std::string CurtainShape(double size) {
    constexpr int kColumns = 60, kRows = 24;
    std::string indices, points, normals, coordinates;
    for (int j = 0; j <= kRows; ++j)
        for (int i = 0; i <= kColumns; ++i) {
            const double s = double(i) / kColumns, t = double(j) / kRows;
            const Point3 p = Curtain::At(s, t);
            const Vec3 n = Curtain::NormalAt(s, t);
            const char* end = i == kColumns ? "\n" : "  ";
            points += fmt::format("{:.3f} {:.3f} {:.3f}{}", p.x, p.y, p.z, end);
            normals += fmt::format("{:.3f} {:.3f} {:.3f}{}", n.x, n.y, n.z, end);
            // Cloth is longer than the curtain is wide.
            coordinates += fmt::format("{:.4f} {:.4f}{}", 1.3 * kWidth * s / size, kHeight * t / size, end);
            if (i == kColumns || j == kRows) continue;
            const int a = j * (kColumns + 1) + i, b = a + kColumns + 1;
            indices += fmt::format("{} {} {}  {} {} {}\n", a, a + 1, b + 1, a, b + 1, b);
        }
    return fmt::format(
        "Shape \"trianglemesh\" \"integer indices\" [\n{}] \"point3 P\" [\n{}] \"normal N\" [\n{}]"
        " \"point2 uv\" [\n{}]\n",
        indices, points, normals, coordinates);
}

std::string Objects(double size) {
    const double h = kPlane / 2, repeats = kPlane / size;
    return fmt::format(
               "AttributeBegin\n"
               "    Shape \"bilinearmesh\" \"point3 P\" [-{0} -{0} 0  {0} -{0} 0  -{0} {0} 0  {0} {0} 0]\n"
               "        \"point2 uv\" [0 0  {1:.4f} 0  0 {1:.4f}  {1:.4f} {1:.4f}]\n"
               "    Translate -5 -4 {2}\n"
               "    Shape \"sphere\" \"float radius\" {2}\n"
               "AttributeEnd\n"
               "AttributeBegin\n"
               "    Translate 3 6 0\n",
               h, repeats, kBall) +
           CurtainShape(size) + "AttributeEnd\n";
}

std::string TurntableScene(const std::string& name, double turnDeg) {
    return fmt::format(
        "LookAt 0 -42 24  0 0 3.5  0 0 1\n"
        "Camera \"perspective\" \"float fov\" 30\n"
        "Film \"rgb\" \"integer xresolution\" 640 \"integer yresolution\" 480\n"
        "    \"string filename\" \"{}.exr\"\n"
        "Sampler \"zsobol\" \"integer pixelsamples\" 64\n"
        "Integrator \"path\" \"integer maxdepth\" 5\n"
        "WorldBegin\n"
        "LightSource \"infinite\" \"rgb L\" [0.08 0.08 0.08]\n"
        "AttributeBegin\n"
        "    Translate -11 -16 24\n"
        "    AreaLightSource \"diffuse\" \"rgb L\" [1000 1000 1000]\n"
        "    Shape \"sphere\" \"float radius\" 0.8\n"
        "AttributeEnd\n"
        "Include \"material.pbrt\"\n"
        "Rotate {:.4f} 0 0 1\n"
        "NamedMaterial \"captured\"\n"
        "Include \"turntable-objects.pbrt\"\n",
        name, turnDeg);
}

}  // namespace

void ExportTurntable(double size, const std::string& directory, int numFrames) {
    const auto write = [&](const std::string& name, const std::string& text) {
        OutputFile file((std::filesystem::path(directory) / (name + ".pbrt")).string());
        file.Write(text);
        file.Finish();
    };
    write("turntable-objects", Objects(size));
    write("turntable", TurntableScene("turntable", 0));
    for (int frame = 1; frame <= numFrames; ++frame) {
        const std::string name = fmt::format("turntable.{:04}", frame);
        write(name, TurntableScene(name, 360. * (frame - 1) / numFrames));
    }
}

}  // namespace lacquer::capture
