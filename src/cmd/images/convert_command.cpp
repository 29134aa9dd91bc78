// Command "convert": images to other formats, and scenes formatted or upgraded.
#include "cmd/images/convert_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "cmd/choices.h"
#include "cmd/command.h"
#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/images/image_arguments.h"
#include "cmd/scenes/convert_scene.h"
#include "cmd/scenes/scene_arguments.h"
#include "compare/tone_map.h"
#include "materialx/document.h"
#include "pbrt/image/operations.h"

namespace lacquer::cmd {
namespace {

/// Two to this power is still a float.
constexpr double kMaxStops = 100;

class ConvertJob {
  public:
    explicit ConvertJob(const ConvertArguments& arguments)
        : a_(arguments), console_(ConsoleStyle::Detect(arguments.quiet)) {}

    ExitStatus Run() {
        CheckArguments();
        CheckImageOutput(a_.output);
        image_ = ReadImageArgument(a_.input);
        if (!a_.layer.empty()) SelectLayer();
        if (!a_.crop.empty() || !a_.channels.empty()) SelectPart();
        if (a_.flipY) FlipY(&image_);
        if (!a_.resize.empty()) ResizeImage();
        if (a_.repeat > 1) Repeat();
        if (a_.clamp) Clamp(float(*a_.clamp));
        if (a_.blackAndWhite) MapImage("--bw", [](RGB rgb) { return RGB((rgb.x + rgb.y + rgb.z) / 3); });
        if (a_.despike) TellCount(Despike(&image_, float(*a_.despike)), "exceed --despike");
        ScaleColors();
        if (!a_.colorSpace.empty()) ConvertColors();
        if (toneMap_ != compare::ToneMap::None) MapTones();
        if (a_.gamma != 1) ApplyGamma(float(a_.gamma));
        if (a_.preserveColors) PreserveColors();
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
        if (a_.maxLuminance && toneMap_ != compare::ToneMap::Reinhard)
            throw CLI::ValidationError("--maxluminance belongs to --tonemap reinhard");
    }

    /// Replaces all colours. Errors: usage, if there are none.
    template <class Function>
    void MapImage(const char* option, const Function& function) {
        if (!MapColors(&image_, function))
            throw CLI::ValidationError(fmt::format("{}: the image has no colours, only {}", option,
                                                   fmt::join(image_.Channels(), ", ")));
    }

    /// The channels of one layer, without its name; errors: usage, with the nearest name there is.
    void SelectLayer() {
        std::vector<std::string> layers;
        for (const std::string& channel : image_.Channels())
            if (const std::string_view layer = LayerOfChannel(channel); !layer.empty())
                layers.emplace_back(layer);
        layers.erase(std::unique(layers.begin(), layers.end()), layers.end());
        CheckName("--layer", a_.layer, layers);
        image_ = image_.OnlyChannels(
            [&](const std::string& channel) { return LayerOfChannel(channel) == a_.layer; });
        std::vector<std::string> names;
        for (const std::string& channel : image_.Channels())
            names.push_back(channel.substr(a_.layer.size() + 1));
        image_.RenameChannels(std::move(names));
    }

    void SelectPart() {
        Bounds2i box{{0, 0}, image_.Resolution()};
        if (!a_.crop.empty()) box = BoxOfImage("--crop", a_.crop, image_).pixels;
        image_ = image_.Part(box, ChannelsOf(image_, a_.channels));
    }

    void Repeat() {
        const Int2 size = image_.Resolution();
        if (int64_t(std::max(size.x, size.y)) * a_.repeat > kMaxImageSide ||
            image_.Pixels().size() * sizeof(float) * size_t(a_.repeat) * size_t(a_.repeat) > kMaxImageBytes)
            throw CLI::ValidationError(
                fmt::format("--repeatpix {}: {} x {} pixels become too many", a_.repeat, size.x, size.y));
        image_ = RepeatPixels(image_, a_.repeat);
    }

    void TellCount(int64_t count, const char* what) {
        console_.Info(fmt::format("{}: {} pixel{} {}", a_.output, count, count == 1 ? "" : "s", what));
    }

    void ScaleColors() {
        const float scale = float(a_.scale) * float(std::exp2(a_.exposure));
        if (scale == 1) return;
        MapImage(a_.scale != 1 ? "--scale" : "--exposure", [&](RGB rgb) { return rgb * scale; });
    }

    /// Brighter colours keep their hue.
    void Clamp(float limit) {
        MapImage("--clamp", [&](RGB rgb) {
            const float largest = std::max({rgb.x, rgb.y, rgb.z});
            return largest > limit ? rgb * (limit / largest) : rgb;
        });
    }

    void ApplyGamma(float gamma) {
        MapImage("--gamma", [&](RGB rgb) { return glm::pow(glm::max(rgb, 0.f), RGB(gamma)); });
    }

    /// Colours beyond 1 as a whole, and not each component for itself.
    void PreserveColors() {
        MapImage("--preservecolors", [](RGB rgb) {
            const float largest = std::max({rgb.x, rgb.y, rgb.z});
            return largest > 1 ? rgb / largest : rgb;
        });
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
        if (to != image_.ColorSpace()) MapImage("--colorspace", [&](RGB rgb) { return matrix * rgb; });
        image_.SetColorSpace(to);
        // The file's own would contradict the new space.
        image_.metadata.erase("chromaticities");
    }

    void MapTones() {
        const ColorSpace* space = image_.HasRGB() ? image_.ColorSpace() : nullptr;
        MapImage("--tonemap", [&](RGB rgb) {
            const float Y = space ? space->Luminance(rgb) : rgb.x;
            return compare::Apply(toneMap_, rgb, Y, float(a_.maxLuminance.value_or(0)));
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
    app.add_option("output,--outfile", a.output,
                   "The image to write; the extension chooses the format.\n"
                   "The scene file to write; none: standard output")
        ->type_name(kFile);
    app.add_option("--crop", a.crop, "x0,x1,y0,y1: only this part, in fractions or in pixels");
    app.add_option("--layer", a.layer, "NAME: only its channels, R instead of NAME.R");
    AddChannels(app, a.channels);
    app.add_flag("--flipy", a.flipY, "Upside down");
    app.add_option("--resize", a.resize, "WxH: the size of the result in pixels");
    app.add_option("--repeatpix", a.repeat, "Each pixel as often in both directions")
        ->check(CLI::Range(1, kMaxImageSide));
    app.add_option("--clamp", a.clamp, "The largest component: brighter colours are scaled down to it")
        ->check(CLI::NonNegativeNumber);
    app.add_flag("--bw", a.blackAndWhite, "Grey: the mean of R, G and B");
    app.add_option("--despike", a.despike, "Pixels of a higher luminance become the median around them")
        ->check(CLI::NonNegativeNumber);
    app.add_option("--scale", a.scale, "Multiplies the colours")->check(CLI::Range(-1e30, 1e30));
    app.add_option("--exposure", a.exposure, "Stops: doubles the light for each");
    app.add_option("--colorspace", a.colorSpace, "Primaries of the result")
        ->check(OneOf(ColorSpace::Names(), [](const std::string& name) {
            return ColorSpace::Find(name) ? std::string() : WhyUnknown(name, ColorSpace::Names());
        }));
    app.add_option("--tonemap", a.toneMap, "Brings values into the screen's range")
        ->check(OneOf(compare::ToneMapNames()));
    app.add_option("--maxluminance", a.maxLuminance,
                   "Of --tonemap reinhard: the luminance that becomes white")
        ->check(Positive());
    app.add_option("--gamma", a.gamma, "An exponent of the colours")->check(Positive());
    app.add_flag("--preservecolors", a.preserveColors,
                 "Colours beyond 1 are scaled as a whole instead of cut off");
    app.add_flag("--half,--fp16", a.half, "16-bit floats where the format has them");
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

/// A document of MaterialX as a file of materials, for Include. To standard output without a name.
ExitStatus ConvertDocument(const ConvertArguments& a) {
    Console console(ConsoleStyle::Detect(a.quiet));
    if (a.IsForScene())
        throw CLI::ValidationError(
            fmt::format("{} is no scene: --format, --toply and --upgrade are for those", Excerpt(a.input)));
    if (!a.output.empty() && !IsSceneName(a.output))
        throw CLI::ValidationError(
            fmt::format("{}: the materials of {} are written to a scene file; expected a "
                        "name that ends with .pbrt",
                        Excerpt(a.output), Excerpt(a.input)));
    if (!a.output.empty()) CheckOutputFile(a.output);
    const materialx::MaterialText document = materialx::ReadDocument(a.input);
    for (const Diagnostic& warning : document.warnings) console.Warn(warning.ToString());
    if (a.output.empty())
        fmt::print("{}", document.text);
    else
        WriteText(a.output, document.text);
    return ExitStatus::Complete;
}

ExitStatus RunConvert(const ConvertArguments& arguments) {
    if (materialx::IsDocumentName(arguments.input)) return ConvertDocument(arguments);
    return arguments.IsForScene() ? RunConvertScene(arguments) : ConvertJob(arguments).Run();
}

namespace {

constexpr const char* kConvertSynopsis =
    "Writes an image in another format, size, exposure or colour space. What the options say\n"
    "is done in the order in which they are listed here.\n"
    "Writes a document of MaterialX as a scene file with its materials.\n"
    "Writes a scene formatted (--format), with its meshes in PLY files (--toply), or upgraded from pbrt-v3.";
constexpr const char* kConvertFooter = R"(
Exit status: 0 all is done; 1 wrong usage; 2 the scene is wrong, or parts of it cannot be upgraded (the
result is written all the same); 3 a file cannot be read or written, or does not fit.)";

}  // namespace

LACQUER_REGISTER(CommandKind, "convert", (CommandOf<ConvertArguments, AddConvertOptions, RunConvert>::Make),
                 {.synopsis = kConvertSynopsis, .footer = kConvertFooter});

}  // namespace lacquer::cmd
