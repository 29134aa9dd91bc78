#include "cmd/bulk/thumbnails.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "pbrt/integrators/render.h"
#include "pbrt/scene/builder.h"
#include "pbrt/scene/parser.h"
#include "pbrt/scene/statements.h"

namespace lacquer::cmd {
namespace {

// The thin edge is on the left; light of radiance 1 behind all of it.
constexpr const char* kWedge = R"(
LookAt 0 0 -4  0 0 0  0 1 0
Camera "orthographic" "float screenwindow" [-1 1 -1 1]
{film}
WorldBegin
{medium}
AttributeBegin
    Translate 0 0 1.2
    AreaLightSource "diffuse" "rgb L" [1 1 1] "bool twosided" true
    Shape "bilinearmesh" "point3 P" [-3 -3 0  3 -3 0  -3 3 0  3 3 0]
AttributeEnd
AttributeBegin
    MediumInterface "m" ""
    Material "interface"
    Shape "trianglemesh"
        "point3 P" [-1 -2 0  1 -2 0  1 -2 1  -1 2 0  1 2 0  1 2 1]
        "integer indices" [0 1 2  3 5 4  0 4 1  0 3 4  1 5 2  1 4 5  0 5 3  0 2 5]
AttributeEnd
)";

// The lamp is large: light that peaked phase functions send there by chance finds it.
constexpr const char* kBall = R"(
LookAt 0 1.3 -5  0 -0.05 0  0 1 0
Camera "perspective" "float fov" 30
{film}
WorldBegin
{medium}
AttributeBegin
    AreaLightSource "diffuse" "rgb L" [2.4 2.4 2.4] "bool twosided" true
    Translate -4 4 -2
    Rotate 45 0 0 1
    Rotate 20 0 1 0
    Shape "bilinearmesh" "point3 P" [-4 0 -4  4 0 -4  -4 0 4  4 0 4]
AttributeEnd
LightSource "infinite" "rgb L" [0.35 0.35 0.35]
AttributeBegin
    Material "diffuse" "rgb reflectance" [0.3 0.3 0.3]
    Translate 0 -1 0
    Shape "bilinearmesh" "point3 P" [-20 0 -20  20 0 -20  -20 0 20  20 0 20]
AttributeEnd
AttributeBegin
    MediumInterface "m" ""
    Material "interface"
    Shape "sphere"
AttributeEnd
)";

std::string Replaced(std::string text, const std::string& what, const std::string& by) {
    const size_t at = text.find(what);
    return text.replace(at, what.size(), by);
}

Image RenderText(const std::string& text) {
    Observer nobody;
    const RenderSetup setup = BuildScene(ParseText(text, "thumbnail", "", &nobody), {}, &nobody);
    RenderOptions options;
    options.endSample = setup.sampler->SamplesPerPixel();
    Render(*setup.scene, *setup.integrator, *setup.sampler, *setup.film, options, nobody);
    return *setup.film->Develop();
}

/// Millimetres with two digits.
std::string Millimetres(double length) {
    return length < 0.1 ? fmt::format("{:.2g} µm", 1000 * length) : fmt::format("{:.2g} mm", length);
}

/// Of the medium [mm]: light comes through at the wavelength in the middle, and at none is scattered so often
/// that rendering takes long. 0: nothing scatters or absorbs.
double LengthFor(const BulkTable& table) {
    constexpr double kTransportLengths = 2.5, kMaxTransportLengths = 10, kMaxOpticalDepth = 10;
    const auto sigmaT = [&](size_t w) { return table.sigmaS[w] + table.sigmaA[w]; };
    const auto transport = [&](size_t w) { return sigmaT(w) - table.g[w] * table.sigmaS[w]; };
    const size_t middle = table.wavelengths.size() / 2;
    if (!(transport(middle) > 0)) return 0;
    double length = std::min(kTransportLengths / transport(middle), kMaxOpticalDepth / sigmaT(middle));
    for (size_t w = 0; w < table.wavelengths.size(); ++w)
        if (transport(w) > 0) length = std::min(length, kMaxTransportLengths / transport(w));
    return length;
}

}  // namespace

std::vector<BulkThumbnail> RenderBulkThumbnails(const std::string& tablePath, const BulkTable& table,
                                                int resolution) {
    const double length = LengthFor(table);
    if (!(length > 0)) return {};
    const std::string film = fmt::format(
        R"(Film "rgb" "integer xresolution" {0} "integer yresolution" {0}
Sampler "zsobol" "integer pixelsamples" 64
Integrator "volpath" "integer maxdepth" 150)",
        resolution);
    const std::string path = std::filesystem::absolute(tablePath).string();
    std::vector<BulkThumbnail> thumbnails;
    const auto add = [&](const char* name, const char* scene, double scale, const std::string& caption) {
        const std::string medium = fmt::format(
            R"(MakeNamedMedium "m" "string type" "homogeneous" "string bulk" {} "float scale" {})",
            QuotedText(path), scale);
        thumbnails.push_back(
            {name, caption, RenderText(Replaced(Replaced(scene, "{film}", film), "{medium}", medium))});
    };
    add("wedge", kWedge, length,
        fmt::format("A wedge, 0 to {} thick from left to right, in front of a white lamp",
                    Millimetres(length)));
    add("ball", kBall, 0.6 * length,
        fmt::format("A ball, {} wide, under a large lamp and a grey sky", Millimetres(1.2 * length)));
    return thumbnails;
}

}  // namespace lacquer::cmd
