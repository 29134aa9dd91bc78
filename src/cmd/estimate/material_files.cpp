#include "cmd/estimate/material_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "cmd/command_support.h"
#include "layered/lambertian/coat_tables.h"
#include "pbrt/image/image.h"

namespace lacquer::cmd {
namespace {

using namespace estimate;

/// Roughness as files hold it: what the renderer's distributions take.
float Alpha(double roughness) { return float(roughness * roughness); }

/// Index of an interface by its reflectance at normal incidence.
double EtaOf(double f0) { return (1 + std::sqrt(f0)) / (1 - std::sqrt(f0)); }

// ---- Maps ----------------------------------------------------------------------------------------------

double At(const Field& field, size_t i) { return field.size() == 1 ? field[0] : field[i]; }

/// An image of the grid whose channel c has at point i the value of `value`.
template <class Value>
Image MapOf(const MapGrid& grid, const std::vector<std::string>& channels, Value value) {
    Image image({grid.size, grid.size}, channels);
    for (int y = 0; y < grid.size; ++y)
        for (int x = 0; x < grid.size; ++x) {
            const size_t i = size_t(y) * size_t(grid.size) + size_t(x);
            for (int c = 0; c < int(channels.size()); ++c) image.Set({x, y}, c, float(value(i, c)));
        }
    return image;
}

/// (n + 1) / 2 of the normals to slopes times `scale`.
Image NormalMap(const EstimatedMaterial& m, double scale) {
    return MapOf(m.grid, {"R", "G", "B"}, [&](size_t i, int c) {
        const double x = -scale * At(m.surface.slopeX, i), y = -scale * At(m.surface.slopeY, i);
        const double length = std::sqrt(x * x + y * y + 1);
        return 0.5 + 0.5 * (c == 0 ? x : c == 1 ? y : 1) / length;
    });
}

Image AlphaMap(const EstimatedMaterial& m, const Field& roughness) {
    return MapOf(m.grid, {"Y"}, [&](size_t i, int) { return Alpha(At(roughness, i)); });
}

/// Albedos after `change`(albedo, channel, point).
template <class Change>
Image ColorMap(const EstimatedMaterial& m, Change change) {
    return MapOf(m.grid, {"R", "G", "B"},
                 [&](size_t i, int c) { return change(At(m.surface.albedo[size_t(c)], i), c, i); });
}

/// Writes the maps and the material of one kind of surface.
class Writer {
  public:
    Writer(const std::string& folder, const EstimatedMaterial& material) : folder_(folder), m_(material) {}

    /// Text of material.pbrt.
    std::string Write() {
        MakeOutputFolder(folder_ + "/maps");
        switch (m_.surface.reflectance) {
            case Reflectance::Dielectric:
                return Dielectric();
            case Reflectance::Metal:
                return Metal();
            case Reflectance::Flakes:
                return Flakes();
        }
        return {};
    }

  private:
    void Map(const std::string& name, const Image& image) {
        WriteImage(image, fmt::format("{}/maps/{}.exr", folder_, name));
    }
    /// Writes a map and declares a texture of its name.
    std::string Texture(const std::string& name, const Image& image) {
        Map(name, image);
        return fmt::format("Texture \"{}\" \"{}\" \"imagemap\" \"string filename\" \"maps/{}.exr\"\n", name,
                           image.NumChannels() == 3 ? "spectrum" : "float", name);
    }
    void Relief() {
        Map("normal", NormalMap(m_, 1));
        Map("height", MapOf(m_.grid, {"Y"}, [&](size_t i, int) { return At(m_.surface.height, i); }));
    }

    std::string Dielectric() {
        const Image reflectance = ColorMap(m_, [&](double albedo, int, size_t i) {
            return ReflectanceUnderCoat(float(albedo), Alpha(At(m_.surface.roughness, i)));
        });
        std::string text =
            Texture("albedo", reflectance) + Texture("rough", AlphaMap(m_, m_.surface.roughness));
        Relief();
        return text + fmt::format(
                          "MakeNamedMaterial \"estimated\" \"string type\" \"coateddiffuse\" \"texture "
                          "reflectance\" \"albedo\"\n"
                          "    \"texture roughness\" \"rough\" \"bool remaproughness\" false \"float eta\" "
                          "{} \"float thickness\" 1e-5\n"
                          "    \"string normalmap\" \"maps/normal.exr\"\n",
                          kCoatEta);
    }

    std::string Metal() {
        std::string text = Texture("f0", ColorMap(m_, [](double f0, int, size_t) { return f0; })) +
                           Texture("roughx", AlphaMap(m_, {m_.surface.roughnessX})) +
                           Texture("roughy", AlphaMap(m_, {m_.surface.roughnessY}));
        Relief();
        return text +
               "MakeNamedMaterial \"estimated\" \"string type\" \"conductor\" \"texture reflectance\" "
               "\"f0\"\n"
               "    \"texture uroughness\" \"roughx\" \"texture vroughness\" \"roughy\" \"bool "
               "remaproughness\" false\n"
               "    \"string normalmap\" \"maps/normal.exr\"\n";
    }

    /// The model adds lobes; in a stack light goes through the top to the flakes, is bent by it, and the
    /// flakes' colour is that of an absorbing slab above them. So flakes reflect more by what the top takes
    /// away twice, their normals and roughness are those that look as tilted from outside, and the base is as
    /// bright as it has to be for what leaves the stack after any number of reflections from below.
    std::string Flakes() {
        const Surface& s = m_.surface;
        const double throughTop = (1 - s.topF0) * (1 - s.topF0);
        const double largest =
            std::clamp(*std::max_element(s.flakeF0.begin(), s.flakeF0.end()) / throughTop, 1e-4, 0.95);
        const double top = EtaOf(s.topF0), eta = top * EtaOf(largest);
        std::array<double, 3> tau{};
        for (size_t c = 0; c < 3; ++c)
            tau[c] = -0.5 * std::log(std::max(s.flakeF0[c] / throughTop, 1e-4) / largest);
        const Image reflectance = ColorMap(m_, [&](double albedo, int c, size_t) {
            const double through = (1 - s.topF0) * (1 - largest) * std::exp(-tau[size_t(c)]);
            // t^2 rho' / (eta^2 (1 - rho' R)) = rho, with 1 - R = t / eta^2 of light without direction.
            const double out = through * through / (eta * eta), back = 1 - through / (eta * eta);
            return std::clamp(albedo / (out + albedo * back), 0., 1.);
        });
        Map("flake_normal", NormalMap(m_, 1 / top));
        return Texture("albedo", reflectance) +
               fmt::format(
                   "MakeNamedMaterial \"top\" \"string type\" \"dielectric\" \"float eta\" {:.6g} \"float "
                   "roughness\" {:.6g}\n"
                   "    \"bool remaproughness\" false\n"
                   "MakeNamedMaterial \"colour\" \"string type\" \"slab\" \"float eta\" {:.6g} \"rgb "
                   "sigma_t\" [{:.6g} {:.6g} {:.6g}] \"rgb albedo\" [0 0 0]\n"
                   "MakeNamedMaterial \"flakes\" \"string type\" \"dielectric\" \"float eta\" {:.6g} \"float "
                   "roughness\" {:.6g}\n"
                   "    \"bool remaproughness\" false \"string normalmap\" \"maps/flake_normal.exr\"\n"
                   "MakeNamedMaterial \"base\" \"string type\" \"diffuse\" \"texture reflectance\" "
                   "\"albedo\"\n"
                   "MakeNamedMaterial \"estimated\" \"string type\" \"layered\" \"string stack\" [\"top\" "
                   "\"colour\" \"flakes\" \"base\"]\n",
                   top, Alpha(s.topRoughness), top, tau[0], tau[1], tau[2], EtaOf(largest),
                   double(Alpha(s.flakeRoughness)) / top);
    }

    const std::string& folder_;
    const EstimatedMaterial& m_;
};

// ---- Scenes --------------------------------------------------------------------------------------------

/// A square of the maps' extent in the plane z = 0, u to the right and v upward.
std::string Square(double extent) {
    const double h = extent / 2;
    return fmt::format(
        "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point2 uv\" [0 0 1 0 1 1 0 1]\n"
        "    \"point3 P\" [-{0} -{0} 0 {0} -{0} 0 {0} {0} 0 -{0} {0} 0]\n",
        h);
}

/// Camera and light as the model has them: straight above the axis, which need not meet the sample's centre.
std::string PhotographScene(const EstimatedMaterial& m) {
    const double extent = m.grid.extent, x = m.flash.axisX, y = m.flash.axisY;
    const double fov = 2 * std::atan(extent / 2 / m.distance) * 180 / std::numbers::pi;
    const auto window = [&](double side, double axis) { return side - 2 * axis / extent; };
    return fmt::format(
               "# The photograph that {0} was estimated from, again: camera and light above the sample, no "
               "vignette.\n"
               "Film \"rgb\" \"integer xresolution\" {1} \"integer yresolution\" {1} \"string filename\" "
               "\"photograph.exr\"\n"
               "PixelFilter \"box\"\n"
               "Sampler \"zsobol\" \"integer pixelsamples\" 64\n"
               "Integrator \"path\" \"integer maxdepth\" 1\n"
               // A pixel looks at the middle of its texel, as the model does; cameras mirror without this.
               "Option \"disablepixeljitter\" true\n"
               "Scale -1 1 1\n",
               m.model, m.grid.size) +
           fmt::format(
               "LookAt {0:.9g} {1:.9g} {2:.9g}  {0:.9g} {1:.9g} 0  0 1 0\n"
               "Camera \"perspective\" \"float fov\" {3:.9g} \"float screenwindow\" [{4:.9g} {5:.9g} {6:.9g} "
               "{7:.9g}]\n"
               "WorldBegin\n"
               "LightSource \"point\" \"rgb I\" [{8:.9g} {8:.9g} {8:.9g}] \"point3 from\" [{0:.9g} {1:.9g} "
               "{2:.9g}]\n"
               "Include \"material.pbrt\"\n"
               "NamedMaterial \"estimated\"\n{9}",
               x, y, m.distance, fov, window(-1, x), window(1, x), window(-1, y), window(1, y), m.flash.light,
               Square(extent));
}

constexpr const char* kPreview = R"(# The estimated material on a ball and on a tile that lies in front of it.
Scale -1 1 1
LookAt 0 -8 3.1   0 -0.35 0.72   0 0 1
Camera "perspective" "float fov" 25
Film "rgb" "integer xresolution" 600 "integer yresolution" 450 "string filename" "preview.exr"
Sampler "zsobol" "integer pixelsamples" 64
Integrator "path" "integer maxdepth" 5
WorldBegin
LightSource "infinite" "rgb L" [0.2 0.21 0.23]
AttributeBegin
    AreaLightSource "diffuse" "blackbody L" [6000] "float scale" [11]
    Shape "bilinearmesh" "point3 P" [ -3.0 -6.5 2.5   -5.5 -4.0 2.5   -3.0 -6.5 5.5   -5.5 -4.0 5.5 ]
AttributeEnd
AttributeBegin
    AreaLightSource "diffuse" "blackbody L" [6500] "float scale" [4]
    Shape "bilinearmesh" "point3 P" [ 5.5 -4.0 1.5   4.2 -5.4 1.5   5.5 -4.0 4.5   4.2 -5.4 4.5 ]
AttributeEnd
AttributeBegin
    Material "diffuse" "rgb reflectance" [0.3 0.3 0.31]
    Shape "bilinearmesh" "point3 P" [ -20 -20 0   20 -20 0   -20 20 0   20 20 0 ]
AttributeEnd
Include "material.pbrt"
NamedMaterial "estimated"
AttributeBegin
    Translate 0 0.3 1
    Shape "sphere"
AttributeEnd
AttributeBegin
    Translate 0 -1.9 0.01
    Shape "bilinearmesh" "point3 P" [ -1.4 -0.7 0   1.4 -0.7 0   -1.4 0.7 0   1.4 0.7 0 ] "point2 uv" [ 0 0   1 0   0 0.5   1 0.5 ]
AttributeEnd
)";

}  // namespace

EstimatedMaterial MaterialOf(const EstimateArguments& a, const PhotoSimulator& simulator,
                             const Vector& parameters, uint64_t seed) {
    const MaterialModel& model = simulator.Model();
    EstimatedMaterial material;
    material.model = std::string(model.Name());
    material.grid = simulator.Settings().FineGrid();
    if (a.mapSize > 0) material.grid.size = a.mapSize;
    if (a.mapExtent > 0) {
        material.grid.extent = a.mapExtent;
        material.grid.isPeriodic = model.CanTile();
    }
    const std::vector<double> all = simulator.AllParameters(parameters);
    material.surface = MakeSurface(model, material.grid, simulator.Settings().kinds, all, seed);
    const auto value = [&](const char* wanted) { return all[size_t(model.Find(wanted))]; };
    material.flash = {value("light"), value("vig"), value("axis_x"), value("axis_y")};
    material.distance = simulator.Settings().distance;
    return material;
}

float ReflectanceUnderCoat(float albedo, float alpha) {
    const float smallest = layered::Coat::IsKnown(alpha, float(kCoatEta)) ? alpha : 0;
    const layered::Coat coat(MicrofacetModel::TrowbridgeReitz, smallest, float(kCoatEta), SampledSpectrum(0));
    const float t = coat.Transmittance(1).clear, back = coat.Reflectance()[0];
    const float out = t * t / float(kCoatEta * kCoatEta);
    return std::clamp(albedo / (out + albedo * back), 0.F, 1.F);
}

void WriteMaterialFiles(const std::string& folder, const EstimatedMaterial& material) {
    const std::string text = Writer(folder, material).Write();
    WriteText(folder + "/material.pbrt",
              fmt::format("# Estimated by the model \"{}\". The maps show {:.6g} cm.\n{}", material.model,
                          material.grid.extent, text));
    WriteText(folder + "/preview.pbrt", kPreview);
    WriteText(folder + "/photograph.pbrt", PhotographScene(material));
}

}  // namespace lacquer::cmd
