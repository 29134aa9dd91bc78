// Command "convert": images to other formats, and scenes formatted or upgraded.
#include "cmd/images/convert_command.h"

#include <fmt/format.h>

#include <cmath>
#include <numeric>
#include <stdexcept>

#include "cmd/choices.h"
#include "cmd/command.h"
#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/images/image_arguments.h"
#include "cmd/scenes/convert_scene.h"
#include "cmd/scenes/scene_arguments.h"
#include "compare/tone_map.h"

namespace lacquer::cmd {
namespace {

/// Two to this power is still a float.
constexpr double kMaxStops = 100;

/// Replaces the colour of every pixel: R, G, B, or Y as a grey. Other channels stay.
template <class Function>
void MapColors(Image* image, const char* option, const Function& function) {
    const int grey = image->FindChannel("Y");
    if (!image->HasRGB() && grey < 0)
        throw CLI::ValidationError(
            fmt::format("{}: the image has no colours, only {}", option, fmt::join(image->Channels(), ", ")));
    const Int2 resolution = image->Resolution();
    for (int y = 0; y < resolution.y; ++y)
        for (int x = 0; x < resolution.x; ++x) {
            const Int2 p(x, y);
            if (!image->HasRGB()) {
                image->Set(p, grey, function(RGB(image->Get(p, grey))).x);
                continue;
            }
            const RGB rgb = function(RGB(image->Get(p, 0), image->Get(p, 1), image->Get(p, 2)));
            for (int c = 0; c < 3; ++c) image->Set(p, c, rgb[c]);
        }
}

std::vector<int> AllChannels(const Image& image) {
    std::vector<int> channels(size_t(image.NumChannels()));
    std::iota(channels.begin(), channels.end(), 0);
    return channels;
}

class ConvertJob {
  public:
    explicit ConvertJob(const ConvertArguments& arguments)
        : a_(arguments), console_(ConsoleStyle::Detect(arguments.quiet)) {}

    ExitStatus Run() {
        CheckArguments();
        image_ = ReadImageArgument(a_.input);
        if (!a_.crop.empty())
            image_ = image_.Part(BoxOfImage("--crop", a_.crop, image_).pixels, AllChannels(image_));
        if (!a_.resize.empty()) ResizeImage();
        if (a_.exposure != 0) {
            const auto scale = float(std::exp2(a_.exposure));
            MapColors(&image_, "--exposure", [&](RGB rgb) { return rgb * scale; });
        }
        if (!a_.colorSpace.empty()) ConvertColors();
        if (toneMap_ != compare::ToneMap::None) MapTones();
        WarnOfNonFinite(image_, a_.output, &console_);
        WriteImage(image_, a_.output, a_.half || image_.format == PixelFormat::Half);
        return ExitStatus::Complete;
    }

  private:
    void CheckArguments() {
        if (IsSceneName(a_.input))
            throw CLI::ValidationError(
                fmt::format("{} is a scene: --format, --toply or --upgrade is expected", Excerpt(a_.input)));
        if (a_.output.empty())
            throw CLI::ValidationError(
                "output is required, the image to write (lacquer convert --help lists the options)");
        toneMap_ = *compare::ParseToneMap(a_.toneMap);
        if (!(std::abs(a_.exposure) <= kMaxStops))
            throw CLI::ValidationError(fmt::format("--exposure {}: expected stops between {} and {}",
                                                   a_.exposure, -kMaxStops, kMaxStops));
        if (!a_.resize.empty()) ParseResolution("resize", a_.resize);
    }

    void ResizeImage() {
        try {
            image_ = Resize(image_, ParseResolution("resize", a_.resize));
        } catch (const std::invalid_argument& e) {
            throw CLI::ValidationError(fmt::format("--resize \"{}\": {}", a_.resize, e.what()));
        }
    }

    /// Keeps what is seen: the CIE XYZ of each pixel.
    void ConvertColors() {
        if (!image_.HasRGB())
            throw CLI::ValidationError(
                fmt::format("--colorspace: the image has no channels R, G and B, only {}",
                            fmt::join(image_.Channels(), ", ")));
        const ColorSpace* to = ColorSpace::Find(a_.colorSpace);
        const glm::mat3 matrix = to->RGBFromXYZ() * image_.ColorSpace()->XYZFromRGB();
        if (to != image_.ColorSpace())
            MapColors(&image_, "--colorspace", [&](RGB rgb) { return matrix * rgb; });
        image_.SetColorSpace(to);
        // The file's own would contradict the new space.
        image_.metadata.erase("chromaticities");
    }

    void MapTones() {
        const ColorSpace* space = image_.HasRGB() ? image_.ColorSpace() : nullptr;
        MapColors(&image_, "--tonemap", [&](RGB rgb) {
            return compare::Apply(toneMap_, rgb, space ? space->Luminance(rgb) : rgb.x);
        });
    }

    const ConvertArguments& a_;
    Console console_;
    compare::ToneMap toneMap_ = compare::ToneMap::None;
    Image image_;
};

}  // namespace

void AddConvertOptions(CLI::App& app, ConvertArguments& a) {
    app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    app.add_option("input", a.input, "The image or the scene file (-: standard input) to read")
        ->type_name(kFile)
        ->required();
    app.add_option("output", a.output,
                   "The image to write; the extension chooses the format.\n"
                   "The scene file to write; none: standard output")
        ->type_name(kFile);
    app.add_option("--crop", a.crop, "x0,x1,y0,y1: only this part, in fractions or in pixels");
    app.add_option("--resize", a.resize, "WxH: the size of the result in pixels");
    app.add_option("--exposure", a.exposure, "Stops: doubles the light for each");
    app.add_option("--colorspace", a.colorSpace, "Primaries of the result")
        ->check(OneOf(ColorSpace::Names(), [](const std::string& name) {
            return ColorSpace::Find(name) ? std::string() : WhyUnknown(name, ColorSpace::Names());
        }));
    app.add_option("--tonemap", a.toneMap, "Brings values into the screen's range")
        ->check(OneOf(compare::ToneMapNames()));
    app.add_flag("--half", a.half, "16-bit floats where the format has them");
    app.add_flag("--quiet", a.quiet, "No warnings");
    app.add_flag("--format", a.format, "A scene: with even spacing; comments stay");
    app.add_flag("--toply", a.toPly, "A scene: with its triangle meshes in PLY files; formatted");
    app.add_flag("--upgrade", a.upgrade, "A scene of pbrt-v3: as one of pbrt-v4; formatted");
    app.add_option("--outdir", a.outDir,
                   "Folder for PLY files, instead of the scene's; made if it is not there")
        ->type_name(kFolder);
    app.add_option("--min-triangles", a.minTriangles, "Meshes of fewer triangles stay in the scene")
        ->capture_default_str();
}

ExitStatus RunConvert(const ConvertArguments& arguments) {
    return arguments.IsForScene() ? RunConvertScene(arguments) : ConvertJob(arguments).Run();
}

namespace {

constexpr const char* kSynopsis =
    "Writes an image in another format, size, exposure or colour space. Crops, resizes, exposes, changes "
    "the\n"
    "colour space and maps the tones, in this order.\n"
    "Writes a scene formatted (--format), with its meshes in PLY files (--toply), or upgraded from pbrt-v3.";
constexpr const char* kFooter = R"(
Exit status: 0 all is done; 1 wrong usage; 2 the scene is wrong, or parts of it cannot be upgraded (the
result is written all the same); 3 a file cannot be read or written, or does not fit.)";

}  // namespace

LACQUER_REGISTER(CommandKind, "convert", (CommandOf<ConvertArguments, AddConvertOptions, RunConvert>::Make),
                 {.synopsis = kSynopsis, .footer = kFooter});

}  // namespace lacquer::cmd
