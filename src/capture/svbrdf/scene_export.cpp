#include "capture/svbrdf/scene_export.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "capture/svbrdf/maps_file.h"
#include "capture/svbrdf/svbrdf_model.h"
#include "pbrt/core/output_file.h"
#include "pbrt/image/image.h"

namespace lacquer::capture {
namespace {

std::string Inside(const std::string& directory, const std::string& name) {
    return (std::filesystem::path(directory) / name).string();
}

void WriteText(const std::string& path, const std::string& text) {
    OutputFile file(path);
    file.Write(text);
    file.Finish();
}

std::string ImageTexture(const char* name, const char* type, const char* file) {
    return fmt::format("Texture \"captured {}\" \"{}\" \"imagemap\" \"string filename\" \"{}\"\n", name, type,
                       file);
}

/// The value below which this part of them lies. Reorders them.
double Quantile(std::vector<double>* values, double part) {
    const auto at = values->begin() + std::ptrdiff_t(part * double(values->size() - 1));
    std::nth_element(values->begin(), at, values->end());
    return *at;
}

/// All values of the diffuse lobe, a (1 - s), and of the specular albedo: of texel i in channel c at 3 i + c.
struct Lobes {
    std::vector<double> diffuse, specular;
    explicit Lobes(const Maps& maps) : diffuse(3 * maps.NumTexels()), specular(3 * maps.NumTexels()) {
        for (size_t i = 0; i < maps.NumTexels(); ++i)
            for (size_t c = 0; c < 3; ++c) {
                specular[3 * i + c] = LinearOf(maps.Channel(kSpecular + c)[i]);
                diffuse[3 * i + c] = LinearOf(maps.Channel(kAlbedo + c)[i]) * (1 - specular[3 * i + c]);
            }
    }
};

/// Values divided and cut off at 1; counts those.
void WriteDivided(const std::vector<double>& values, double divisor, int size, const std::string& path,
                  size_t* numClipped) {
    Image image({size, size}, {"R", "G", "B"});
    for (size_t i = 0; i < values.size(); ++i) {
        const double value = values[i] / divisor;
        *numClipped += value > 1;
        image.Pixels()[i] = float(std::min(value, 1.));
    }
    WriteImage(image, path);
}

std::string SvbrdfText() {
    return ImageTexture("albedo", "spectrum", "albedo.exr") +
           ImageTexture("specular", "spectrum", "specular.exr") +
           ImageTexture("alpha", "float", "alpha.exr") +
           "MakeNamedMaterial \"captured\" \"string type\" \"svbrdf\" \"texture albedo\" \"captured "
           "albedo\"\n"
           "    \"texture specular\" \"captured specular\" \"texture alpha\" \"captured alpha\"\n"
           "    \"bool conserve\" false \"string normalmap\" \"normal.exr\"\n";
}

std::string MixText(const Maps& maps, const std::string& directory, ExportReport* report) {
    const Lobes lobes(maps);
    constexpr double kPart = 0.999;
    std::vector<double> sorted = lobes.specular;
    const double specular = Quantile(&sorted, kPart);
    sorted = lobes.diffuse;
    const double diffuse = Quantile(&sorted, kPart);
    // Where nothing fits, both are cut off alike.
    constexpr double kLeast = 1e-6;  // both are divided by their parts
    report->mixAmount = ClampTo(specular + diffuse > 1 ? specular / (specular + diffuse)
                                                       : std::min(std::max(0.5, specular), 1 - diffuse),
                                kLeast, 1 - kLeast);
    size_t numClipped = 0;
    WriteDivided(lobes.diffuse, 1 - report->mixAmount, maps.size, Inside(directory, "diffuse2.exr"),
                 &numClipped);
    WriteDivided(lobes.specular, report->mixAmount, maps.size, Inside(directory, "specular2.exr"),
                 &numClipped);
    report->clippedShare = double(numClipped) / double(2 * lobes.diffuse.size());
    if (report->clippedShare > 0.001)
        report->warnings.push_back(
            fmt::format("{:.1f} % of the values of the mixture are cut off at 1: diffuse and specular albedo "
                        "are together more "
                        "than a mixture can have; svbrdf can",
                        100 * report->clippedShare));
    return ImageTexture("diffuse", "spectrum", "diffuse2.exr") +
           ImageTexture("specular", "spectrum", "specular2.exr") +
           ImageTexture("alpha", "float", "alpha.exr") +
           fmt::format(
               "MakeNamedMaterial \"captured base\" \"string type\" \"diffuse\"\n"
               "    \"texture reflectance\" \"captured diffuse\" \"string normalmap\" \"normal.exr\"\n"
               "MakeNamedMaterial \"captured gloss\" \"string type\" \"conductor\"\n"
               "    \"texture reflectance\" \"captured specular\" \"texture roughness\" \"captured alpha\"\n"
               "    \"bool remaproughness\" false \"string normalmap\" \"normal.exr\"\n"
               "MakeNamedMaterial \"captured\" \"string type\" \"mix\"\n"
               "    \"string materials\" [\"captured base\" \"captured gloss\"] \"float amount\" {}\n",
               report->mixAmount);
}

/// Mean Fresnel reflectance of a surface for even light from above.
double MeanReflectance(double eta) {
    constexpr int kSteps = 400;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double c = (i + 0.5) / kSteps, ct = std::sqrt(1 - (1 - c * c) / (eta * eta));
        const double parallel = (eta * c - ct) / (eta * c + ct), across = (c - eta * ct) / (c + eta * ct);
        sum += c * (parallel * parallel + across * across) / kSteps;
    }
    return sum;
}

/// The albedo of a base that shows a given albedo through a smooth coat, from straight above: light enters
/// and leaves by (1 - s)^2 / eta^2, and what the coat reflects back inside it meets the base again.
class BaseUnderCoat {
  public:
    BaseUnderCoat(double eta, double specular)
        : through_((1 - specular) * (1 - specular) / (eta * eta)),
          internal_(1 - (1 - MeanReflectance(eta)) / (eta * eta)) {}
    double AlbedoFor(double shown) const { return shown / (through_ + shown * internal_); }

  private:
    double through_, internal_;
};

std::string CoatedText(const Maps& maps, const std::string& directory, ExportReport* report) {
    // What dielectrics have, of indices from 1.33 to 1.79.
    constexpr double kLow = 0.02, kHigh = 0.08, kGrey = 0.2;
    const Lobes lobes(maps);
    std::vector<double> values = lobes.specular;
    const double median = Quantile(&values, 0.5), specular = ClampTo(median, kLow, kHigh);
    const double low = Quantile(&values, 0.1), high = Quantile(&values, 0.9);
    if (median < kLow || median > kHigh)
        report->warnings.push_back(fmt::format(
            "the specular albedo has the median {:.3f}, and that of a coat lies between {} and {}: "
            "the material is no coat over a diffuse base",
            median, kLow, kHigh));
    else if (high - low > kGrey * median)
        report->warnings.push_back(
            fmt::format("the specular albedo goes from {:.3f} to {:.3f}: a coat has one index, and no colour",
                        low, high));
    const double eta = (1 + std::sqrt(specular)) / (1 - std::sqrt(specular));
    report->coatIndex = eta;

    const BaseUnderCoat coat(eta, specular);
    Image base({maps.size, maps.size}, {"R", "G", "B"});
    for (size_t i = 0; i < lobes.diffuse.size(); ++i)
        base.Pixels()[i] = float(std::min(coat.AlbedoFor(lobes.diffuse[i]), 1.));
    WriteImage(base, Inside(directory, "base.exr"));
    return ImageTexture("base", "spectrum", "base.exr") + ImageTexture("alpha", "float", "alpha.exr") +
           fmt::format(
               "MakeNamedMaterial \"captured coat\" \"string type\" \"dielectric\" \"float eta\" {:.4f}\n"
               "    \"texture roughness\" \"captured alpha\" \"bool remaproughness\" false\n"
               "MakeNamedMaterial \"captured base\" \"string type\" \"diffuse\"\n"
               "    \"texture reflectance\" \"captured base\"\n"
               "MakeNamedMaterial \"captured\" \"string type\" \"layered\"\n"
               "    \"string stack\" [\"captured coat\" \"captured base\"] \"string normalmap\" "
               "\"normal.exr\"\n",
               eta);
}

}  // namespace

ExportReport ExportMaterial(const Maps& maps, const std::string& directory, ExportAs as) {
    WriteLinearMaps(maps, directory);
    ExportReport report;
    std::string text = "# Maps of a sample, from photographs.\n";
    if (as == ExportAs::Svbrdf) text += SvbrdfText();
    if (as == ExportAs::Mix) text += MixText(maps, directory, &report);
    if (as == ExportAs::Coated) text += CoatedText(maps, directory, &report);
    WriteText(Inside(directory, "material.pbrt"), text);
    return report;
}

std::string ViewScene(const ViewSet& views, const View& view, int resolution, const std::string& outfile,
                      int samples) {
    const double h = views.size / 2;
    const auto& [x, y, z] = view.camera;
    // In a plane one unit below the camera, with 90 degrees, the frame goes from -1 to 1.
    return fmt::format(
        "Film \"rgb\" \"integer xresolution\" {0} \"integer yresolution\" {0} \"string filename\" \"{1}\"\n"
        "Sampler \"paddedsobol\" \"integer pixelsamples\" {2}\n"
        "Integrator \"path\" \"integer maxdepth\" 1\n"
        "PixelFilter \"box\" \"float xradius\" 0.001 \"float yradius\" 0.001\n"
        "Scale -1 1 1\n"
        "LookAt {3} {4} {5}  {3} {4} 0  0 1 0\n"
        "Camera \"perspective\" \"float fov\" 90 \"float screenwindow\" [{6} {7} {8} {9}]\n"
        "WorldBegin\n"
        "LightSource \"point\" \"rgb I\" [{10} {11} {12}] \"point3 from\" [{13} {14} {15}]\n"
        "Include \"material.pbrt\"\n"
        "NamedMaterial \"captured\"\n"
        "Shape \"bilinearmesh\" \"point3 P\" [-{16} -{16} 0  {16} -{16} 0  -{16} {16} 0  {16} {16} 0]\n"
        "    \"point2 uv\" [0 0  1 0  0 1  1 1]\n",
        resolution, outfile, samples, x, y, z, (-h - x) / z, (h - x) / z, (-h - y) / z, (h - y) / z,
        views.lightPower[0], views.lightPower[1], views.lightPower[2], view.light[0], view.light[1],
        view.light[2], h);
}

}  // namespace lacquer::capture
