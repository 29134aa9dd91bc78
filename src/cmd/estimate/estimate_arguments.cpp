#include "cmd/estimate/estimate_arguments.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "cmd/choices.h"
#include "cmd/command_support.h"

namespace lacquer::cmd {

using namespace estimate;

namespace {

/// A name among several, as options have them, and what it stands for.
template <class T>
struct Named {
    const char* name;
    T value;
};
constexpr Named<ToneCurve> kTones[] = {
    {"srgb", ToneCurve::SRGB}, {"gamma2.2", ToneCurve::Gamma22}, {"linear", ToneCurve::Linear}};
constexpr Named<Brdf> kBrdfs[] = {{"smith", Brdf::Smith}, {"chapter", Brdf::Chapter}};
constexpr Named<PriorSet> kPriorSets[] = {{"test", PriorSet::Test}, {"demo", PriorSet::Demo}};

template <class T, size_t N>
std::vector<std::string> NamesOf(const Named<T> (&table)[N]) {
    std::vector<std::string> names;
    for (const Named<T>& entry : table) names.emplace_back(entry.name);
    return names;
}
/// Of a name that an option has checked.
template <class T, size_t N>
T ValueOf(const Named<T> (&table)[N], const std::string& name) {
    for (const Named<T>& entry : table)
        if (name == entry.name) return entry.value;
    return table[0].value;
}

std::vector<std::string> Strings(std::span<const std::string_view> names) {
    return {names.begin(), names.end()};
}
constexpr const char* kAnyKind = "any";
std::vector<std::string> OrAny(std::span<const std::string_view> kinds) {
    std::vector<std::string> names = Strings(kinds);
    names.emplace_back(kAnyKind);
    return names;
}
/// The kind of a name that an option has checked, or all.
template <class Kind>
std::vector<Kind> KindsNamed(std::span<const std::string_view> names, const std::string& name, bool hasThem) {
    std::vector<Kind> kinds;
    for (size_t i = 0; i < names.size(); ++i)
        if (names[i] == name || (name == kAnyKind && hasThem)) kinds.push_back(Kind(i));
    if (kinds.empty()) kinds.push_back(Kind(0));
    return kinds;
}

std::vector<std::string> ModelNames() {
    std::vector<std::string> names;
    for (const MaterialModel* model : AllModels()) names.emplace_back(model->Name());
    return names;
}

std::vector<std::string> ParameterNames(const MaterialModel& model) {
    std::vector<std::string> names;
    for (const ModelParameter& parameter : model.Parameters()) names.emplace_back(parameter.name);
    return names;
}

std::vector<std::string> SummaryNames() {
    std::vector<std::string> names = Strings(SummaryFamilies());
    names.emplace_back("vgg");
    return names;
}

/// "NAME=rest": the name is one of the model's.
std::pair<std::string, std::string> SplitAtName(const char* option, const std::string& text,
                                                const MaterialModel& model, const std::string& expected) {
    const size_t equals = text.find('=');
    if (equals == std::string::npos) BadOption(std::string(option).substr(2), text, expected);
    CheckName(option, text.substr(0, equals), ParameterNames(model));
    return {text.substr(0, equals), text.substr(equals + 1)};
}

void CheckIsFirst(const char* option, const std::string& name, bool isThere) {
    if (isThere) throw CLI::ValidationError(fmt::format("{}: {} is there twice", option, name));
}
void CheckIsNotFixed(const char* option, const std::string& name, const FreeParameters& free) {
    if (free.fixed.contains(name))
        throw CLI::ValidationError(
            fmt::format("{}: {} is fixed by --fix as well; expected one of the two", option, name));
}

Prior ParsePrior(const std::string& option, const std::string& text) {
    constexpr const char* kExpected = "NAME=normal(MEAN,SD,LOW,HIGH) with SD > 0 and LOW < HIGH";
    if (!text.starts_with("normal(") || !text.ends_with(")")) BadOption("prior", option, kExpected);
    const std::vector<double> n = NumbersBetweenCommas(text.substr(7, text.size() - 8));
    if (n.size() != 4 || !(n[1] > 0) || !(n[2] < n[3])) BadOption("prior", option, kExpected);
    return {n[0], n[1], n[2], n[3]};
}

/// Of a number that an earlier check has found to be one.
CLI::Validator MultipleOf16() {
    return {[](const std::string& text) {
                int value = 0;
                if (!CLI::detail::lexical_cast(text, value) || value % 16 == 0) return std::string();
                const int below = value / 16 * 16;
                return fmt::format("{}; expected a multiple of 16, such as {} or {}", text, below,
                                   below + 16);
            },
            ""};
}

void AddLayeredOptions(CLI::App& app, EstimateArguments& a) {
    app.add_option(
           "--scene", a.scene,
           "A scene with the material that was measured: the data are then a goniometer's (CSV or RGL), "
           "or a photograph of what the scene shows, and --free names numbers of its materials "
           "(docs/estimation-layers.md)")
        ->type_name(kFile);
    app.add_option("--material", a.material,
                   "The scene's material that was measured; default: its only layered one");
    app.add_flag("--robust", a.robust,
                 "Errors of a measurement have long tails: outliers count little (Student, 4 degrees)");
    app.add_option("--candidates", a.candidates,
                   "Directions (CSV) among which the next best measurement is sought; default: 75 of them")
        ->type_name(kFile);
}

void AddPhotographOptions(CLI::App& app, EstimateArguments& a) {
    app.add_option("--size", a.size,
                   "Side of what the photograph shows, after the crop [cm]; 25 if nothing tells it")
        ->check(Positive());
    app.add_option("--distance", a.distance,
                   "Of camera and flash from the sample [cm]; 25 if nothing tells it")
        ->check(Positive());
    app.add_option("--fov", a.fieldOfView,
                   "Field of view across the photograph, after the crop [degrees]; default: by the focal "
                   "length that the file tells")
        ->check([](const std::string& text) {
            double value = 0;
            return CLI::detail::lexical_cast(text, value) && value > 0 && value < 180
                       ? std::string()
                       : fmt::format("{}: expected an angle between 0 and 180 degrees", text);
        });
    app.add_option("--crop", a.crop,
                   "x0,x1,y0,y1: the part to use, a square, in pixels; default: the largest at the centre");
    app.add_option("--tone", a.tone, "How the camera's values follow from light; files of floats are linear")
        ->check(OneOf(NamesOf(kTones)))
        ->capture_default_str();
    app.add_option("--resolution", a.resolution, "Pixels along a side that are looked at, a multiple of 16")
        ->check(CLI::Range(kMinPhotographSide, 1024))
        ->check(MultipleOf16())
        ->capture_default_str();
    app.add_option("--simulated-resolution", a.simulatedResolution,
                   "Pixels along a side that are simulated, at most, before they are averaged to those of "
                   "--resolution: a photograph with more pixels than these is averaged as well")
        ->check(CLI::Range(kMinPhotographSide, 4096))
        ->capture_default_str();
}

void AddModelOptions(CLI::App& app, EstimateArguments& a) {
    app.add_option("--model", a.model, "The kind of material")->check(OneOf(ModelNames()));
    app.add_option("--fix", a.fixed, "NAME=VALUE: a parameter that is known")->type_name("NAME=VALUE");
    app.add_option("--free", a.free,
                   "Optional parameters that are estimated too, such as axis_x and axis_y; with --scene, all "
                   "that are "
                   "estimated: MATERIAL.PARAMETER,... and, of a photograph, exposure")
        ->delimiter(',');
    app.add_option("--prior", a.priors,
                   "NAME=normal(MEAN,SD,LOW,HIGH): what is believed of a parameter beforehand")
        ->type_name("NAME=PRIOR");
    app.add_option("--prior-set", a.priorSet, "Priors of the parameters that --prior does not name")
        ->check(OneOf(NamesOf(kPriorSets)))
        ->capture_default_str();
    app.add_option("--summaries", a.summaries,
                   "Families of summaries; default: those that tell most of this model")
        ->delimiter(',')
        ->check(OneOf(SummaryNames()));
    app.add_option("--vgg", a.vgg,
                   "Weights of VGG-19 (safetensors), for the summaries \"vgg\", which are then used")
        ->type_name(kFile);
    app.add_option("--brdf", a.brdf, "Microfacets with masking, as they render, or without, as published")
        ->check(OneOf(NamesOf(kBrdfs)))
        ->capture_default_str();
    app.add_option("--cells", a.cells, "Kind of cells of leather and flakes; any: the photograph tells")
        ->check(OneOf(OrAny(CellKindNames())))
        ->capture_default_str();
    app.add_option("--noise", a.noise, "Kind of noise of plaster and leather; any: the photograph tells")
        ->check(OneOf(OrAny(NoiseKindNames())))
        ->capture_default_str();
}

void AddMethodOptions(CLI::App& app, EstimateArguments& a) {
    app.add_option(
           "--method", a.method,
           "emulated: a regression of simulations; fixed-seed: a few fixed realisations for each point, "
           "with derivatives")
        ->check(OneOf({"emulated", "fixed-seed"}))
        ->capture_default_str();
    app.add_option("--seeds", a.seeds, "Realisations of --method fixed-seed")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    app.add_option(
           "--sampler", a.sampler,
           "How chains move: Hamiltonian (the default), Langevin, or Langevin with the published rule as "
           "warm-up; with fixed seeds, parameters without derivatives and kinds move by steps of their own")
        ->check(OneOf({"hmc", "mala", "mala-published"}));
    app.add_option("--error", a.error,
                   "Error of summaries: calibrated, by simulations; or hand:S, the same for all, with "
                   "--method fixed-seed")
        ->capture_default_str();
    app.add_flag("--map-only", a.mapOnly, "The most probable parameters alone, without their uncertainty");
    app.add_flag("--explain", a.explain, "Tell what each family of summaries alone would tell (explain.txt)");
    app.add_option("--samples", a.samples, "Draws of the posterior, of each chain")
        ->check(CLI::Range(100, 1000000))
        ->capture_default_str();
    app.add_option("--chains", a.chains, "Markov chains")->check(CLI::Range(2, 64))->capture_default_str();
    app.add_option("--warmup", a.warmup, "Steps of each chain in which it adapts, before its draws")
        ->check(CLI::Range(100, 1000000))
        ->capture_default_str();
    app.add_option("--seed", a.seed, "Seed of all random numbers")->capture_default_str();
    app.add_option("--time-limit", a.timeLimit, "Stop after so many seconds; --resume goes on")
        ->check(Positive());
    app.add_option("--checkpoint-every", a.checkpointEvery,
                   "Seconds between checkpoints of the chains; simulations are kept as they are made")
        ->check(Positive())
        ->capture_default_str();
    app.add_flag("--resume", a.resume,
                 "Go on with what a stopped run left in --out; the results have the same bits");
}

}  // namespace

void AddEstimateOptions(CLI::App& app, EstimateArguments& a) {
    app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    app.add_option(
           "photo", a.photo,
           "The photograph, taken straight on with a flash beside the lens (docs/estimation.md); with "
           "--scene, what was measured")
        ->type_name(kFile);
    app.add_option("--out", a.out, "Folder for the results; made if it is not there")->type_name(kFolder);
    app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    AddModelOptions(app, a);
    app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    AddPhotographOptions(app, a);
    AddMethodOptions(app, a);
    AddLayeredOptions(app, a);
    app.add_option("--map-size", a.mapSize, "Texels along a side of the maps; default: as the photograph")
        ->check(CLI::Range(16, 8192));
    app.add_option("--map-extent", a.mapExtent,
                   "What the maps show [cm], a tile that repeats; default: as the photograph, which does not")
        ->check(Positive());
    app.add_option("--simulate", a.simulate,
                   "Make a synthetic photograph, with the parameters drawn from their priors or fixed, and "
                   "FILE.json with the truth; with --out its material too")
        ->type_name(kFile);
    app.add_option("--truth", a.truth, "Truth of a synthetic photograph, for the report")->type_name(kFile);
    app.add_option("--sbc", a.calibration,
                   "Test the method on so many synthetic photographs: are its intervals right?")
        ->check(CLI::Range(20, 100000));
    app.add_flag("--models", a.listModels, "List the models with their parameters and priors");
    app.add_flag("--json", a.json, "The list as JSON");
    app.add_option("--nthreads", a.threads, "Threads; 0: all processors")->check(CLI::Range(0, 1024));
    app.add_flag("--quiet", a.quiet, "No progress and no warnings");
}

std::pair<std::string, Prior> NamedPriorOf(const std::string& option) {
    const size_t equals = option.find('=');
    if (equals == std::string::npos) BadOption("prior", option, "NAME=normal(MEAN,SD,LOW,HIGH)");
    return {option.substr(0, equals), ParsePrior(option, option.substr(equals + 1))};
}

const MaterialModel& ModelOf(const EstimateArguments& a) {
    if (a.model.empty()) {
        std::string names;
        for (const std::string& name : ModelNames()) names += (names.empty() ? "" : ", ") + name;
        throw CLI::ValidationError(fmt::format("--model is required: one of {}", names));
    }
    return *FindModel(a.model);
}

FreeParameters FreeParametersOf(const EstimateArguments& a, const MaterialModel& model) {
    FreeParameters free;
    free.priors = ValueOf(kPriorSets, a.priorSet);
    for (const std::string& text : a.fixed) {
        const auto [name, value] = SplitAtName("--fix", text, model, "NAME=VALUE");
        const std::vector<double> numbers = NumbersBetweenCommas(value);
        if (numbers.size() != 1) BadOption("fix", text, "NAME=VALUE with a number");
        CheckIsFirst("--fix", name, free.fixed.contains(name));
        free.fixed[name] = numbers[0];
    }
    for (const std::string& text : a.priors) {
        const auto [name, prior] = SplitAtName("--prior", text, model, "NAME=normal(MEAN,SD,LOW,HIGH)");
        CheckIsFirst("--prior", name, free.replacedPriors.contains(name));
        CheckIsNotFixed("--prior", name, free);
        free.replacedPriors[name] = ParsePrior(text, prior);
    }
    for (const std::string& name : a.free) {
        CheckName("--free", name, ParameterNames(model));
        CheckIsNotFixed("--free", name, free);
        free.alsoFree.push_back(name);
    }
    return free;
}

std::optional<double> HandError(const EstimateArguments& a) {
    if (a.error == "calibrated") return std::nullopt;
    const std::vector<double> numbers =
        a.error.starts_with("hand:") ? NumbersBetweenCommas(a.error.substr(5)) : std::vector<double>();
    if (numbers.size() != 1 || !(numbers[0] > 0))
        BadOption("error", a.error, "calibrated, or hand:S with S > 0");
    return numbers[0];
}

void RefuseIneffective(bool isGiven, const std::string& option, const std::string& why) {
    if (isGiven) throw CLI::ValidationError(fmt::format("{} has no effect {}", option, why));
}

void CheckModelArguments(const EstimateArguments& a) {
    const char* const ofScenes = "with --model: it is for --scene, and measurements of layers";
    RefuseIneffective(a.robust, "--robust", ofScenes);
    RefuseIneffective(!a.candidates.empty(), "--candidates", ofScenes);
    RefuseIneffective(!a.material.empty(), "--material", ofScenes);
    RefuseIneffective(a.fieldOfView && a.size && a.distance, "--fov",
                      "beside --size and --distance, which tell it; expected two of the three");
    if (a.model.empty()) return;
    const MaterialModel& model = ModelOf(a);
    const EstimateArguments defaults;
    RefuseIneffective(!model.HasCells() && a.cells != defaults.cells, "--cells",
                      fmt::format("on {}: it has none", model.Name()));
    RefuseIneffective(!model.HasNoise() && a.noise != defaults.noise, "--noise",
                      fmt::format("on {}: it has no kinds of noise", model.Name()));
}

void CheckMethod(const EstimateArguments& a) {
    if (HandError(a) && a.method == "emulated")
        throw CLI::ValidationError(
            "--error hand:S needs --method fixed-seed: the emulated method has its error from "
            "its simulations");
    if (a.vgg.empty() && std::find(a.summaries.begin(), a.summaries.end(), "vgg") != a.summaries.end())
        throw CLI::ValidationError("--summaries vgg needs --vgg FILE, the weights of the network");
}

std::vector<ModelKinds> KindsOf(const EstimateArguments& a, const MaterialModel& model) {
    std::vector<ModelKinds> kinds;
    for (const CellKind cells : KindsNamed<CellKind>(CellKindNames(), a.cells, model.HasCells()))
        for (const NoiseKind noise : KindsNamed<NoiseKind>(NoiseKindNames(), a.noise, model.HasNoise()))
            kinds.push_back({cells, noise});
    return kinds;
}

std::string NameOf(const ModelKinds& kinds, const MaterialModel& model) {
    std::string name;
    if (model.HasCells()) name += fmt::format("cells {}", CellKindNames()[size_t(kinds.cells)]);
    if (model.HasNoise())
        name += fmt::format("{}noise {}", name.empty() ? "" : ", ", NoiseKindNames()[size_t(kinds.noise)]);
    return name;
}

PhotoSettings PhotoSettingsOf(const EstimateArguments& a, const PhotographFile* file) {
    PhotoSettings settings;
    settings.resolution = file ? file->linear.size : a.resolution;
    if (file) settings.averaging = file->averaging;
    settings.tone = ValueOf(kTones, a.tone);
    settings.isRounded = settings.tone != ToneCurve::Linear;
    settings.brdf = ValueOf(kBrdfs, a.brdf);
    settings.kinds = KindsOf(a, ModelOf(a)).front();
    const double fov = a.fieldOfView.value_or(file ? file->fieldOfView : 0);
    const double sizeOverDistance = fov > 0 ? 2 * std::tan(fov * std::numbers::pi / 360) : 1;
    if (a.size)
        settings.extent = *a.size;
    else if (a.distance)
        settings.extent = *a.distance * sizeOverDistance;
    settings.distance = a.distance.value_or(settings.extent / sizeOverDistance);
    if (!a.size && !a.distance) settings.extent = settings.distance * sizeOverDistance;
    return settings;
}

PhotographReading ReadingOf(const EstimateArguments& a) {
    PhotographReading reading;
    reading.resolution = a.resolution;
    reading.simulatedResolution = a.simulatedResolution;
    if (a.tone == "gamma2.2") reading.tone = {ColorEncoding::Kind::Gamma, 2.2F};
    if (a.tone == "linear") reading.tone = {ColorEncoding::Kind::Linear, 1};
    if (!a.crop.empty()) {
        const std::vector<double> n = NumbersBetweenCommas(a.crop);
        bool isFine = n.size() == 4;
        for (const double edge : n)
            isFine = isFine && edge >= 0 && edge <= kMaxImageSide && edge == std::floor(edge);
        if (!isFine || !(n[0] < n[1] && n[2] < n[3]))
            BadOption("crop", a.crop, "x0,x1,y0,y1 in pixels, with x0 < x1 and y0 < y1");
        reading.crop = Bounds2i{{int(n[0]), int(n[2])}, {int(n[1]), int(n[3])}};
    }
    return reading;
}

std::unique_ptr<PhotoSimulator> SimulatorOf(const EstimateArguments& a, const PhotoSettings& settings,
                                            const std::vector<std::string>& families) {
    const MaterialModel& model = ModelOf(a);
    try {
        return std::make_unique<PhotoSimulator>(model, settings, FreeParametersOf(a, model), families);
    } catch (const std::invalid_argument& e) {
        throw CLI::ValidationError(e.what());
    }
}

void CheckSomethingIsFree(const PhotoSimulator& simulator) {
    if (simulator.Parameters().Size() == 0)
        throw CLI::ValidationError("--fix has all parameters: none is left to be estimated");
}

}  // namespace lacquer::cmd
