// Scenes: reading them, setting parameters of their materials, rendering.
#include <pybind11/numpy.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <variant>

#include "compare/variation.h"
#include "denoise/method.h"
#include "layered/estimator.h"
#include "pbrt/core/clock.h"
#include "pbrt/core/parallel.h"
#include "pbrt/integrators/rendered_image.h"
#include "pbrt/scene/parser.h"
#include "pbrt/scene/scene_options.h"
#include "python/errors.h"
#include "python/interruptible.h"
#include "python/module.h"

namespace lacquer::python {

namespace py = pybind11;

namespace {

/// What render() is asked for; the package has checked types and ranges.
struct RenderRequest {
    std::optional<int> spp;
    std::optional<std::array<int, 2>> resolution, sampleRange;
    std::optional<std::array<int, 4>> pixelBounds;  ///< x0, x1, y0, y1
    std::optional<std::array<float, 4>> cropWindow;
    std::optional<double> timeLimit;
    std::vector<std::string> aovs;
    int cryptomatteRanks = 6, threads = 0;
    std::string estimator, layeredPdf;
    bool quick = false, disableImageTextures = false, denoise = false;
    std::string denoiser;
    py::dict options;
    TextureFolders textures;
    /// What is kept beside colours: what was asked for, and what the denoiser needs.
    std::vector<std::string> Aovs() const {
        return denoise ? denoise::WithAovsOf(denoise::MethodOf(denoiser), aovs) : aovs;
    }
};

/// The name of an option as a parameter of Python; empty for those that write files, which render() does not.
std::string ParameterName(const SceneOption& option) {
    const bool writes = option.isFile || option.field == SceneOption::Field(&SceneOptions::pixelStats);
    if (!option.commandLine || writes) return {};
    std::string name = std::string(option.commandLine).substr(2);
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
}

std::vector<std::string> OptionNames() {
    std::vector<std::string> names;
    for (const SceneOption& option : OptionTable())
        if (const std::string name = ParameterName(option); !name.empty()) names.push_back(name);
    return names;
}

template <class Value>
const char* Expected(const SceneOption& option) {
    if constexpr (std::is_same_v<Value, bool>) return "True or False";
    if constexpr (std::is_same_v<Value, int>) return "an integer of 32 bits";
    if constexpr (std::is_same_v<Value, float>) return option.isPositive ? "a positive number" : "a number";
    return "a text";
}

template <class Value>
void SetValue(const SceneOption& option, Value SceneOptions::*field, const py::handle& value,
              GivenOptions* given) {
    const std::string name = ParameterName(option);
    Value cast{};
    try {
        // Otherwise None would be a truth value, too.
        if (std::is_same_v<Value, bool> && !py::isinstance<py::bool_>(value)) throw py::cast_error();
        cast = value.cast<Value>();
    } catch (const py::cast_error&) {
        throw UsageError(name + ": expected " + Expected<Value>(option));
    }
    if constexpr (std::is_same_v<Value, std::string>) {
        const std::vector<std::string> known = option.choices ? option.choices() : std::vector{cast};
        if (std::find(known.begin(), known.end(), cast) == known.end())
            throw UsageError(name + ": unknown \"" + Excerpt(cast) + "\"" + DidYouMean(cast, known));
    } else if (!std::is_same_v<Value, bool> && option.isPositive && !(cast > Value(0))) {
        throw UsageError(name + ": expected " + Expected<Value>(option));
    }
    given->Set(field, cast);
}

/// Sets an option of scenes by its name on the command line, with '_' for '-'. Errors: UsageError.
void SetOption(const std::string& name, const py::handle& value, GivenOptions* given) {
    for (const SceneOption& option : OptionTable())
        if (name == ParameterName(option)) {
            std::visit([&](auto field) { SetValue(option, field, value, given); }, option.field);
            return;
        }
    throw UsageError("there is no option \"" + Excerpt(name) + "\"" + DidYouMean(name, OptionNames()));
}

BuildOptions BuildOptionsOf(const RenderRequest& r) {
    BuildOptions options;
    options.samplesPerPixel = r.quick ? std::optional<int>(1) : r.spp;
    options.film.quick = r.quick;
    if (r.resolution) options.film.resolution = Int2((*r.resolution)[0], (*r.resolution)[1]);
    if (r.cropWindow) options.film.cropWindow = *r.cropWindow;
    if (r.pixelBounds) {
        const auto& b = *r.pixelBounds;
        options.film.pixelBounds = Bounds2i{{b[0], b[2]}, {b[1], b[3]}};
    }
    for (const auto& [name, value] : r.options) SetOption(name.cast<std::string>(), value, &options.given);
    options.keepNames = AovBuffer::NeedsSceneNames(r.aovs);
    options.film.keepsHalves = AovBuffer::NeedsHalves(r.Aovs());
    options.disableImageTextures = r.disableImageTextures;
    options.materials = {{"estimator", r.estimator}, {"pdf", r.layeredPdf}};
    options.textures = TextureMemoryOf(r.textures);
    return options;
}

/// One render, from the description to image and statistics.
class SceneRender {
  public:
    SceneRender(const ParsedScene& scene, const RenderRequest& request)
        : scene_(scene), request_(request), options_(BuildOptionsOf(request)) {}

    void Run(Observer& observer) {
        const ThreadLimit threads(request_.threads);
        const Clock::time_point start = Clock::now();
        setup_ = BuildScene(*scene_.description, options_, &observer);
        costs_.buildSeconds = SecondsSince(start);
        if (request_.spp && !request_.quick && setup_.sampler->SamplesPerPixel() != *request_.spp)
            observer.Warn("the scene's sampler takes " + std::to_string(setup_.sampler->SamplesPerPixel()) +
                          " samples per pixel instead of " + std::to_string(*request_.spp));
        if (!setup_.scene->HasEmission()) observer.Warn("the scene has no light: the image will be black");
        CheckAovs(request_.aovs, setup_);
        try {
            passes_ = MakePasses(request_.Aovs(), setup_);
        } catch (const LightPathError& e) {
            throw UsageError(std::string("aov: ") + e.what());
        }
        aovs_ = MakeAovBuffer(request_.Aovs(), request_.cryptomatteRanks, setup_);
        RenderOptions options = RenderOptionsOf(setup_);
        if (request_.sampleRange) SetRange(*request_.sampleRange, &options);
        if (request_.denoise) CheckDenoiser(options.endSample - options.firstSample);
        if (request_.timeLimit) options.timeLimit = *request_.timeLimit;
        options.aovs = aovs_.get();
        options.passes = passes_.get();
        stats_ = Render(*setup_.scene, *setup_.integrator, *setup_.sampler, *setup_.film, options, observer);
        if (stats_.badSamples > 0)
            observer.Warn(std::to_string(stats_.badSamples) + " of " + std::to_string(stats_.cameraRays) +
                          " samples were NaN, infinite or negative and count as black");
        ImageOrigin origin;
        origin.samplesPerPixel = stats_.samplesPerPixel;
        origin.firstSample = options.firstSample;
        origin.seconds = stats_.seconds;
        origin.showsSampleCounts = PixelsDiffer(stats_);
        origin.software = std::string("Lacquer ") + LACQUER_VERSION;
        origin.scene = std::filesystem::path(scene_.name).filename().string();
        image_ = DevelopRender(setup_, aovs_.get(), passes_.get(), origin);
        if (request_.denoise) Denoise(observer);
    }

    std::shared_ptr<Image> TakeImage() { return std::move(image_); }
    std::string Statistics() {
        rusage usage{};
        getrusage(RUSAGE_SELF, &usage);
        costs_.parseSeconds = scene_.parseSeconds;
        costs_.peakBytes = int64_t(usage.ru_maxrss) * 1024;
        return StatisticsText(setup_, stats_, costs_, LACQUER_VERSION, setup_.film->Filename());
    }
    bool SavesHalf() const { return setup_.film->SavesHalf(); }

  private:
    void CheckDenoiser(int samples) const {
        const std::string why =
            denoise::WhyNot(denoise::MethodOf(request_.denoiser), samples, setup_.integrator->MakesSplats());
        if (!why.empty()) throw UsageError("denoise: the image " + why);
    }

    /// What a stop has left can be denoised later: its channels stay.
    void Denoise(Observer& observer) {
        if (stats_.interrupted) {
            observer.Warn("not denoised, since the render was stopped: denoise() of the result does it");
            return;
        }
        const denoise::Method method = denoise::MethodOf(request_.denoiser);
        try {
            denoise::DenoiseImage(method, image_.get(), &observer);
        } catch (const std::invalid_argument& e) {
            observer.Warn(std::string("not denoised: the image ") + e.what());
        } catch (const std::runtime_error& e) {
            observer.Warn(std::string("not denoised: ") + e.what());
        }
        *image_ = WithoutAovs(*image_, denoise::AovsOf(method), request_.aovs);
    }

    void SetRange(const std::array<int, 2>& range, RenderOptions* options) const {
        if (setup_.integrator->UsesChains())
            throw UsageError(
                "sample_range: the integrator of this scene follows Markov chains, whose samples depend on "
                "those before them");
        if (range[1] > options->endSample)
            throw UsageError("sample_range: expected an end of at most " +
                             std::to_string(options->endSample) + ", the samples per pixel");
        options->firstSample = range[0];
        options->endSample = range[1];
    }

    const ParsedScene& scene_;
    const RenderRequest& request_;
    BuildOptions options_;
    RenderSetup setup_;
    std::unique_ptr<AovBuffer> aovs_;
    std::unique_ptr<PassSet> passes_;
    RenderStats stats_;
    RenderCosts costs_;
    std::unique_ptr<Image> image_;
};

/// Image, statistics as JSON, warnings, whether the scene asks for half floats.
py::tuple RenderScene(const ParsedScene& scene, const RenderRequest& request, const py::object& progress) {
    const ParsedScene kept = scene;  // what another thread sets meanwhile is for later renders
    const RenderTurn mine;
    Notices notices;
    SceneRender render(kept, request);
    RunInterruptibly(notices, progress, [&] { render.Run(notices); });
    const std::string statistics = render.Statistics();
    const bool half = render.SavesHalf();
    return py::make_tuple(render.TakeImage(), statistics, notices.Warnings(), half);
}

template <class Parse>
ParsedScene ParseScene(const std::string& name, const Parse& parse) {
    const py::gil_scoped_release released;
    const Clock::time_point start = Clock::now();
    Notices notices;
    ParsedScene scene;
    scene.description = std::make_shared<const SceneDescription>(parse(&notices));
    scene.name = name;
    scene.parseSeconds = SecondsSince(start);
    scene.warnings = notices.Warnings();
    return scene;
}

ParsedScene Load(const std::vector<std::string>& paths) {
    return ParseScene(paths.at(0), [&](Observer* observer) { return ParseFiles(paths, observer); });
}

ParsedScene Parse(const std::string& text, const std::string& name, const std::string& folder) {
    return ParseScene(name, [&](Observer* observer) { return ParseText(text, name, folder, observer); });
}

void SetParameter(ParsedScene& scene, const std::string& target, const std::string& value,
                  const std::string& defaultType) {
    auto changed = std::make_shared<SceneDescription>(*scene.description);
    compare::Apply({target, {value}, defaultType}, value, changed.get());
    scene.description = std::move(changed);
}

/// Names as BuildMaterial() takes them, with the types.
std::vector<std::pair<std::string, std::string>> Materials(const ParsedScene& scene) {
    std::vector<std::pair<std::string, std::string>> materials;
    for (const MaterialEntity& m : scene.description->namedMaterials) materials.emplace_back(m.name, m.type);
    for (size_t i = 1; i < scene.description->materials.size(); ++i)
        materials.emplace_back("@" + std::to_string(i), scene.description->materials[i].type);
    return materials;
}

}  // namespace

TextureMemory TextureMemoryOf(const TextureFolders& folders) {
    TextureMemory memory;
    memory.bytes = size_t(std::get<0>(folders)) << 20;
    memory.cacheFolder = std::get<1>(folders);
    memory.temporaryFolder = std::get<2>(folders);
    return memory;
}

void DefineScenes(py::module_& m) {
    py::class_<RenderRequest>(m, "RenderRequest")
        .def(py::init<>())
        .def_readwrite("spp", &RenderRequest::spp)
        .def_readwrite("resolution", &RenderRequest::resolution)
        .def_readwrite("sample_range", &RenderRequest::sampleRange)
        .def_readwrite("pixel_bounds", &RenderRequest::pixelBounds)
        .def_readwrite("crop_window", &RenderRequest::cropWindow)
        .def_readwrite("time_limit", &RenderRequest::timeLimit)
        .def_readwrite("aovs", &RenderRequest::aovs)
        .def_readwrite("cryptomatte_ranks", &RenderRequest::cryptomatteRanks)
        .def_readwrite("threads", &RenderRequest::threads)
        .def_readwrite("estimator", &RenderRequest::estimator)
        .def_readwrite("layered_pdf", &RenderRequest::layeredPdf)
        .def_readwrite("quick", &RenderRequest::quick)
        .def_readwrite("disable_image_textures", &RenderRequest::disableImageTextures)
        .def_readwrite("denoise", &RenderRequest::denoise)
        .def_readwrite("denoiser", &RenderRequest::denoiser)
        .def_readwrite("options", &RenderRequest::options)
        .def_readwrite("textures", &RenderRequest::textures);
    py::class_<ParsedScene>(m, "ParsedScene")
        .def("render", &RenderScene, py::arg("request"), py::arg("progress"))
        .def("set", &SetParameter, py::arg("target"), py::arg("value"), py::arg("default_type"))
        .def("copy", [](const ParsedScene& scene) { return scene; })
        .def("materials", &Materials)
        .def("parts", [](const ParsedScene& scene) { return compare::PartsOf(*scene.description); })
        .def_readonly("warnings", &ParsedScene::warnings)
        .def_readonly("name", &ParsedScene::name);
    m.def("load", &Load, py::arg("paths"));
    m.def("parse", &Parse, py::arg("text"), py::arg("name"), py::arg("folder"));
    m.def("aovs", &AovNames);
    m.def("estimators", [] { return Registry<layered::LayeredEstimatorKind>::Names(); });
    m.def("layered_pdfs", [] { return Registry<layered::LayeredPdfKind>::Names(); });
    m.def("material_types", [] { return Registry<MaterialKind>::Names(); });
    m.def("options", &OptionNames);
}

}  // namespace lacquer::python
