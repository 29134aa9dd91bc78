#include "cmd/bsdf/bsdf_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "cmd/bsdf/report.h"
#include "cmd/bsdf/result.h"
#include "cmd/bsdf/sheet.h"
#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/scenes/scene_arguments.h"
#include "cmd/version.h"
#include "layered/layered_bxdf.h"
#include "pbrt/core/parallel.h"
#include "pbrt/scene/builder.h"

namespace lacquer::cmd {

namespace {

namespace fs = std::filesystem;

constexpr int kSets = BsdfSubject::kNumSets;
/// Batches (one sample at each set of wavelengths) for each sample per pixel that was asked for.
constexpr int64_t kSamplesAtWi = 4096, kBatchesAtWi = 1024, kBatchesByAngle = 128;
constexpr int kReciprocityPairs = 256, kReciprocityBatches = 64;

/// Two finite numbers with a comma between them.
glm::dvec2 ParsePair(const std::string& name, const std::string& text, const std::string& expected) {
    std::istringstream in(text);
    glm::dvec2 pair(0);
    char comma = 0, rest = 0;
    if (!(in >> pair.x >> comma >> pair.y) || comma != ',' || in >> rest || !std::isfinite(pair.x) ||
        !std::isfinite(pair.y))
        BadOption(name, text, expected);
    return pair;
}

/// The direction at these angles [degrees]; its z is 0 nowhere near 90 degrees that a user may ask for.
Vec3 DirectionOf(double thetaDeg, double phiDeg) {
    const double theta = thetaDeg * double(Pi) / 180, phi = phiDeg * double(Pi) / 180;
    const glm::dvec3 w(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
    return Normalize(Vec3(w));
}

/// One way to evaluate the material, with the objects behind it.
struct Variant {
    std::string name;
    MaterialSetup setup;
    std::unique_ptr<BsdfSubject> subject;
};

class BsdfJob {
  public:
    explicit BsdfJob(const BsdfArguments& arguments)
        : a_(arguments), console_(ConsoleStyle::Detect(arguments.quiet)) {}

    ExitStatus Run() {
        CheckArguments();
        const ThreadLimit threads(a_.threads);
        BuildVariants();
        CheckOutputFolder(a_.out);
        Describe();
        SurveySamples();
        for (size_t i = 0; i < variants_.size(); ++i) SurveyEstimator(i);
        SurveyInterfaces();
        Write();
        return ExitStatus::Complete;
    }

  private:
    void CheckArguments() {
        const glm::dvec2 angles = ParsePair("wi", a_.wi, "THETA,PHI in degrees, THETA between 0 and 180");
        r_.thetaDeg = angles.x;
        r_.phiDeg = angles.y;
        if (!(angles.x >= 0 && angles.x <= 180) || std::abs(angles.x - 90) < 0.01 || std::abs(angles.y) > 1e6)
            BadOption("wi", a_.wi,
                      "THETA between 0 and 180 degrees, but not 90, where light does not meet the surface");
        r_.w = DirectionOf(angles.x, angles.y);
        const glm::dvec2 uv = ParsePair("uv", a_.uv, "U,V");
        r_.uv = Point2(uv);
        for (const std::string& name : a_.estimators)
            CheckName("--estimator", name, Registry<layered::LayeredEstimatorKind>::Names());
        if (!a_.layeredPdf.empty())
            CheckName("--layered-pdf", a_.layeredPdf, Registry<layered::LayeredPdfKind>::Names());
        r_.resolution = a_.resolution;
        r_.seed = a_.seed;
        // Each pixel takes all wavelengths equally often, and at least twice, for an error.
        r_.samplesPerPixel = std::max(2, (a_.samples + kSets - 1) / kSets) * kSets;
        r_.histogramSamples = int64_t(r_.samplesPerPixel) * a_.resolution * a_.resolution;
        for (double angle = 0; angle < 86; angle += 5) r_.anglesDeg.push_back(angle);
        r_.lossAnglesDeg = {0, 30, 60, 80};
    }

    // ---- Materials ----

    void BuildVariants() {
        SceneDescription description = ParseInputs(ReadSceneArguments(a_.scenes), &console_);
        // Nothing of this is needed, and the description is copied for each estimator.
        description.shapes.clear();
        description.objects.clear();
        description.instances.clear();
        description.lights.clear();
        description.areaLights.clear();
        variants_.push_back(Build(description, "exact", ""));
        if (!IsLayered(*variants_[0].subject)) {
            if (!a_.estimators.empty() || !a_.layeredPdf.empty())
                throw CLI::ValidationError(
                    fmt::format("--{} is for layered materials; \"{}\" is a {}, whose value is exact",
                                a_.estimators.empty() ? "layered-pdf" : "estimator", a_.material,
                                variants_[0].setup.entity.type));
            return;
        }
        variants_.clear();
        for (const std::string& name :
             a_.estimators.empty() ? Registry<layered::LayeredEstimatorKind>::Names() : a_.estimators)
            variants_.push_back(Build(description, name, name));
    }

    Variant Build(const SceneDescription& description, const std::string& name,
                  const std::string& estimator) {
        BuildOptions options;
        options.seed = a_.seed;
        options.layered.estimator = estimator;
        options.layered.pdf = a_.layeredPdf;
        options.textures = DefaultTextureMemory();
        Variant variant;
        variant.name = name;
        variant.setup = BuildMaterial(description, a_.material, options, &console_);
        variant.subject =
            std::make_unique<BsdfSubject>(*variant.setup.material, r_.uv, variant.setup.entity.loc);
        return variant;
    }

    static bool IsLayered(const BsdfSubject& subject) {
        for (int i = 0; i < subject.NumVariants(); ++i)
            if (dynamic_cast<const layered::LayeredBxDF*>(&subject.At(int64_t(i) * kSets))) return true;
        return false;
    }

    void Describe() {
        const Variant& first = variants_[0];
        r_.material = a_.material;
        r_.type = first.setup.entity.type;
        r_.scene = fs::path(FirstSceneName(a_.scenes)).filename().string();
        r_.transmits = Any(first.subject->Flags(), Lobes::Transmission);
        r_.isStochastic = first.subject->IsStochastic();
        if (IsLayered(*first.subject)) r_.pdfName = a_.layeredPdf.empty() ? "of the material" : a_.layeredPdf;
    }

    // ---- Numbers ----

    /// A query with a seed of its own.
    LobeQuery Query(const Variant& v, Vec3 w, TransportMode mode, uint64_t purpose) {
        return {*v.subject, w, mode, Hash(uint64_t(a_.seed), purpose, int(mode)), &console_};
    }
    Vec3 AtAngle(size_t i) const {
        // Light from below stays below.
        const double thetaDeg = std::max(0.01, r_.anglesDeg[i]);
        return DirectionOf(r_.w.z > 0 ? thetaDeg : 180 - thetaDeg, r_.phiDeg);
    }
    int64_t SamplesAtWi() const { return kSamplesAtWi * a_.samples; }
    int64_t BatchesAtWi() const { return kBatchesAtWi * a_.samples; }
    int64_t BatchesByAngle() const { return kBatchesByAngle * a_.samples; }

    void SurveySamples() {
        const Variant& v = variants_[0];
        const int64_t angles = int64_t(r_.anglesDeg.size());
        console_.Begin("samples",
                       r_.histogramSamples + 2 * kSets * (SamplesAtWi() + angles * BatchesByAngle()),
                       "samples");
        r_.sampled = SampleLobe(Query(v, r_.w, TransportMode::Importance, 1), SamplesAtWi());
        r_.sampledFurnace = SampleLobe(Query(v, r_.w, TransportMode::Radiance, 2), SamplesAtWi());
        r_.histogram = SampleImages(Query(v, r_.w, TransportMode::Importance, 3), r_.resolution,
                                    r_.histogramSamples, &r_.density);
        for (size_t i = 0; i < r_.anglesDeg.size(); ++i) {
            r_.sampledByAngle.push_back(
                SampleLobe(Query(v, AtAngle(i), TransportMode::Importance, 100 + i), BatchesByAngle()));
            r_.sampledFurnaceByAngle.push_back(
                SampleLobe(Query(v, AtAngle(i), TransportMode::Radiance, 200 + i), BatchesByAngle()));
        }
        console_.End();
    }

    void SurveyEstimator(size_t index) {
        const Variant& v = variants_[index];
        const uint64_t purpose = 1000 * (index + 1);
        const int64_t pixels = int64_t(r_.resolution) * r_.resolution * (r_.transmits ? 2 : 1);
        const int64_t angles = int64_t(r_.anglesDeg.size());
        console_.Begin(v.name,
                       pixels * r_.samplesPerPixel + 2 * kSets * (BatchesAtWi() + angles * BatchesByAngle()),
                       "samples");
        EstimatorResult e;
        e.name = v.name;
        const LobeQuery query = Query(v, r_.w, TransportMode::Importance, purpose);
        e.lobe = EvaluateImages(query, r_.resolution, r_.samplesPerPixel, index == 0 ? &r_.pdf : nullptr);
        e.reflection = Compare(e.lobe.reflection, r_.histogram.reflection);
        if (r_.transmits) e.transmission = Compare(e.lobe.transmission, r_.histogram.transmission);
        const auto integrate = [&](Vec3 w, TransportMode mode, uint64_t number, const SampledLobe& lobe,
                                   int64_t batches) {
            const LobeQuery q = Query(v, w, mode, purpose + number);
            return IntegrateLobe(q, GuideTo(q, lobe), lobe.eta, batches);
        };
        e.energy = integrate(r_.w, TransportMode::Importance, 1, r_.sampled, BatchesAtWi());
        e.furnace = integrate(r_.w, TransportMode::Radiance, 2, r_.sampledFurnace, BatchesAtWi());
        for (size_t i = 0; i < r_.anglesDeg.size(); ++i) {
            e.energyByAngle.push_back(integrate(AtAngle(i), TransportMode::Importance, 100 + i,
                                                r_.sampledByAngle[i], BatchesByAngle()));
            e.furnaceByAngle.push_back(integrate(AtAngle(i), TransportMode::Radiance, 200 + i,
                                                 r_.sampledFurnaceByAngle[i], BatchesByAngle()));
        }
        e.reciprocity = MeasureReciprocity(
            *v.subject, r_.w, r_.sampled.eta, kReciprocityPairs,
            v.subject->IsStochastic() ? std::clamp(2 * a_.samples, 8, kReciprocityBatches) : 1, query.seed);
        e.cost = MeasureCost(query, r_.sampled);
        console_.End();
        r_.estimators.push_back(std::move(e));
    }

    void SurveyInterfaces() {
        const auto* layered = dynamic_cast<const layered::LayeredBxDF*>(&variants_[0].subject->At(0));
        if (!layered) return;
        for (int i = 0; i <= layered->GetStack().Last(); ++i) {
            InterfaceLoss loss;
            loss.index = i;
            const bool transmits = layered->GetStack().interfaces[size_t(i)].transmits;
            for (const double angle : r_.lossAnglesDeg) {
                loss.fromAbove.push_back(LossOf(i, angle));
                if (transmits) loss.fromBelow.push_back(LossOf(i, 180 - angle));
            }
            r_.interfaces.push_back(std::move(loss));
        }
    }

    /// 1 - what an interface sends on of light from this angle, mean of the wavelengths.
    double LossOf(int index, double thetaDeg) const {
        constexpr int kSamples = 1 << 14;
        Rng rng(Hash(uint64_t(a_.seed), 7, index, thetaDeg));
        const Vec3 w = DirectionOf(thetaDeg, r_.phiDeg);
        double sum = 0;
        for (int i = 0; i < kSamples; ++i) {
            const auto* layered = dynamic_cast<const layered::LayeredBxDF*>(&variants_[0].subject->At(i));
            if (!layered) continue;
            const BxDFContext context{.mode = TransportMode::Importance, .rng = &rng};
            const auto sample = layered->GetStack().interfaces[size_t(index)].Sample(w, context);
            if (sample && IsUsable(sample->weight)) sum += double(sample->weight.Average());
        }
        return 1 - sum / kSamples;
    }

    // ---- Files ----

    void Save(Image image, const std::string& name, const std::string& what,
              const std::string& source) const {
        image.metadata["Software"] = fmt::format("Lacquer {}", kVersion);
        image.metadata["material"] = r_.material;
        image.metadata["content"] = what;
        image.metadata["source"] = source;
        image.metadata["wiDegrees"] = std::vector<float>{float(r_.thetaDeg), float(r_.phiDeg)};
        WriteImage(image, (fs::path(a_.out) / name).string());
    }

    void SavePair(const LobePair& pair, const std::string& source) const {
        const std::string what = "f |cos theta| [1/sr] over the projected hemisphere, linear sRGB";
        Save(ToImage(pair.reflection), source + "-reflection.exr", what, source);
        if (r_.transmits) Save(ToImage(pair.transmission), source + "-transmission.exr", what, source);
    }

    void SavePair(const DensityPair& pair, const std::string& source) const {
        const std::string what = "density over solid angle [1/sr] over the projected hemisphere";
        Save(ToImage(pair.reflection), source + "-reflection.exr", what, source);
        if (r_.transmits) Save(ToImage(pair.transmission), source + "-transmission.exr", what, source);
    }

    void Write() {
        MakeOutputFolder(a_.out);  // late, so that an interrupted survey leaves nothing behind
        for (size_t i = 0; i < r_.estimators.size(); ++i) {
            const std::string& name = r_.estimators[i].name;
            SavePair(r_.estimators[i].lobe, name);
            Save(MakeLobePicture(r_, i), name + ".png", "lobes and their differences from the histogram",
                 name);
        }
        SavePair(r_.histogram, "samples");
        SavePair(r_.density, "density");
        SavePair(r_.pdf, "pdf");
        WriteText(fs::path(a_.out) / "table.json", JsonText(ToJson(r_), 1) + "\n");
        WriteText(fs::path(a_.out) / "table.txt", ToText(r_));
        Save(MakeSheet(r_), "sheet.png", "contact sheet", "all");
        console_.Say(fmt::format(
            "{}: sheet.png, table.txt, table.json, and PNG and EXR files of each estimator", a_.out));
    }

    const BsdfArguments& a_;
    Console console_;
    std::vector<Variant> variants_;
    BsdfResult r_;
};

}  // namespace

void AddBsdfOptions(CLI::App& app, BsdfArguments& a) {
    app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    app.add_option("scene", a.scenes, "Scene files, read one after another as one scene (-: standard input)")
        ->required()
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    app.add_option("--material", a.material, "Name of a named material; @1, @2, ...: the unnamed ones")
        ->required();
    app.add_option("--wi", a.wi, "THETA,PHI: where the light comes from [degrees]")->required();
    app.add_option("--out", a.out, "Folder for the files; made if it is not there")->required();
    app.add_option("--uv", a.uv, "U,V: where textures are looked up");
    app.add_option("--estimator", a.estimators,
                   "Estimators of a layered material, with commas between; default: all")
        ->type_name("A,B,...")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    app.add_option("--layered-pdf", a.layeredPdf, "pdf of a layered material, instead of its own");
    app.add_option("--resolution", a.resolution, "Pixels on a side of the pictures")
        ->check(CLI::Range(16, 2048));
    app.add_option("--samples", a.samples, "Evaluations of a pixel; other counts grow with it")
        ->check(CLI::Range(1, 1 << 16));
    app.add_option("--seed", a.seed, "Seed of all random numbers");
    app.add_option("--nthreads", a.threads, "Threads; 0: all processors")->check(CLI::Range(0, 1024));
    app.add_flag("--quiet", a.quiet, "No progress and no warnings");
}

ExitStatus RunBsdf(const BsdfArguments& arguments) { return BsdfJob(arguments).Run(); }

}  // namespace lacquer::cmd
