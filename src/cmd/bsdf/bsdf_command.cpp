// Command "bsdf": what a material does to light.
#include "cmd/bsdf/bsdf_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "cmd/bsdf/color_table.h"
#include "cmd/bsdf/report.h"
#include "cmd/bsdf/sheet.h"
#include "cmd/choices.h"
#include "cmd/command.h"
#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/earlier_files.h"
#include "cmd/scenes/scene_arguments.h"
#include "cmd/version.h"
#include "layered/estimator.h"
#include "measure/anisotropic_merl.h"
#include "measure/bsdf_survey.h"
#include "measure/bsdf_tables.h"
#include "measure/scene_material.h"
#include "measure/tensor_table.h"
#include "pbrt/core/parallel.h"

namespace lacquer::cmd {

namespace {

namespace fs = std::filesystem;

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

/// One way to evaluate the material, with the objects behind it.
struct Variant {
    std::string name;
    measure::SceneMaterial material;
};

/// A kind of table for other programs.
struct ExportFormat {
    const char* name;
    const char* file;
    bool isOfRoughReflection;  ///< has no place for specular peaks and for transmission
    std::string (*make)(const measure::SceneMaterial&, Point2 uv, const measure::TableOptions&,
                        const std::string& description, Observer*);
};
using measure::SceneMaterial, measure::TableOptions;
constexpr ExportFormat kExportFormats[] = {
    {"merl", "merl.binary", false,
     [](const SceneMaterial& m, Point2, const TableOptions& options, const std::string&, Observer* observer) {
         if (measure::IsAnisotropic(*m.bsdf, options.seed))
             observer->Warn(
                 "--export merl: the material is anisotropic, and this table holds one azimuth of its half "
                 "vectors; merl-anisotropic holds all");
         return measure::TabulateMerl(*m.bsdf, options, observer).Bytes();
     }},
    {"merl-anisotropic", "merl-anisotropic.binary", true,
     [](const SceneMaterial& m, Point2, const TableOptions& options, const std::string&, Observer* observer) {
         return measure::TabulateAnisotropicMerl(*m.bsdf, {}, options, observer).Bytes();
     }},
    {"klems", "klems.xml", false,
     [](const SceneMaterial& m, Point2, const TableOptions& options, const std::string& name,
        Observer* observer) { return measure::TabulateKlems(*m.bsdf, options, observer).Xml(name); }},
    {"rgl", "rgl.bsdf", true,
     [](const SceneMaterial& m, Point2 uv, const TableOptions& options, const std::string& name,
        Observer* observer) { return measure::TabulateTensor(m, uv, options, observer).Bytes(name); }},
};
std::vector<std::string> ExportNames() {
    std::vector<std::string> names;
    for (const ExportFormat& format : kExportFormats) names.emplace_back(format.name);
    return names;
}
const ExportFormat& ExportOf(const std::string& name) {
    return *std::find_if(std::begin(kExportFormats), std::end(kExportFormats),
                         [&](const ExportFormat& format) { return format.name == name; });
}

class BsdfJob {
  public:
    explicit BsdfJob(const BsdfArguments& arguments)
        : a_(arguments), console_(ConsoleStyle::Detect(arguments.quiet)) {}

    ExitStatus Run() {
        CheckArguments();
        const ThreadLimit threads(a_.threads);
        BuildVariants();
        CheckExports();
        CheckOutputFolder(a_.out);
        Survey();
        SurveyColors();
        Write();
        return ExitStatus::Complete;
    }

  private:
    void CheckArguments() {
        const glm::dvec2 angles = ParsePair("wi", a_.wi, "THETA,PHI in degrees, THETA between 0 and 180");
        if (!(angles.x >= 0 && angles.x <= 180) || std::abs(angles.x - 90) < 0.01 || std::abs(angles.y) > 1e6)
            BadOption("wi", a_.wi,
                      "THETA between 0 and 180 degrees, but not 90, where light does not meet the surface");
        survey_ = {angles.x, angles.y, a_.resolution, a_.samples, a_.seed};
        const glm::dvec2 uv = ParsePair("uv", a_.uv, "U,V");
        uv_ = Point2(uv);
    }

    // ---- Materials ----

    void BuildVariants() {
        description_ = ParseInputs(ReadMaterialArguments(a_.scenes, &console_), &console_);
        // Nothing of this is needed, and the description is copied for each estimator.
        description_.shapes.clear();
        description_.objects.clear();
        description_.instances.clear();
        description_.lights.clear();
        description_.areaLights.clear();
        variants_.push_back(Build("exact", ""));
        if (!measure::IsLayered(*variants_[0].material.bsdf)) {
            if (!a_.estimators.empty() || !a_.layeredPdf.empty())
                throw CLI::ValidationError(
                    fmt::format("--{} is for layered materials; \"{}\" is a {}, whose value is exact",
                                a_.estimators.empty() ? "layered-pdf" : "estimator", a_.material,
                                variants_[0].material.setup.entity.type));
            return;
        }
        variants_.clear();
        std::vector<std::string> names = a_.estimators;
        if (names.empty()) {  // all that should agree
            names = Registry<layered::LayeredEstimatorKind>::Names();
            std::erase_if(names, [](const std::string& name) {
                return Registry<layered::LayeredEstimatorKind>::TraitsOf(name).isApproximate;
            });
        }
        for (const std::string& name : names) variants_.push_back(Build(name, name));
    }

    BuildOptions OptionsOf(const std::string& estimator) const {
        BuildOptions options;
        options.given.Set(&SceneOptions::seed, a_.seed);
        options.materials = {{"estimator", estimator}, {"pdf", a_.layeredPdf}};
        options.textures = DefaultTextureMemory();
        return options;
    }
    Variant Build(const std::string& name, const std::string& estimator) {
        return {name, measure::LoadMaterial(description_, a_.material, uv_, OptionsOf(estimator), &console_)};
    }

    void Survey() {
        std::vector<measure::NamedBsdf> estimators;
        for (const Variant& v : variants_) estimators.push_back({v.name, v.material.bsdf.get()});
        measure::BsdfResult result = measure::SurveyBsdf(survey_, estimators, &console_);
        const MaterialEntity& entity = variants_[0].material.setup.entity;
        result.material = a_.material;
        result.type = entity.type;
        result.scene = fs::path(FirstSceneName(a_.scenes)).filename().string();
        result.uv = uv_;
        if (measure::IsLayered(*variants_[0].material.bsdf))
            result.pdfName = a_.layeredPdf.empty() ? "of the material" : a_.layeredPdf;
        r_ = std::move(result);
    }

    void SurveyColors() {
        // As many samples as the images have in some rows.
        const int samples = std::max(256, 128 * a_.samples);
        colors_ = MakeColorTable(description_,
                                 {a_.material,
                                  a_.reference,
                                  uv_,
                                  {survey_.phiDeg, samples, uint64_t(a_.seed)},
                                  OptionsOf(a_.estimators.empty() ? "" : a_.estimators[0])},
                                 &console_);
    }

    // ---- Files ----

    void Save(Image image, const std::string& name, const std::string& what, const std::string& source) {
        image.metadata["Software"] = fmt::format("Lacquer {}", kVersion);
        image.metadata["material"] = r_.material;
        image.metadata["content"] = what;
        image.metadata["source"] = source;
        image.metadata["wiDegrees"] = std::vector<float>{float(r_.thetaDeg), float(r_.phiDeg)};
        WriteImage(image, (fs::path(a_.out) / name).string());
        files_.push_back(name);
    }

    void SavePair(const measure::LobePair& pair, const std::string& source) {
        const std::string what = "f |cos theta| [1/sr] over the projected hemisphere, linear sRGB";
        Save(measure::ToImage(pair.reflection), source + "-reflection.exr", what, source);
        if (r_.transmits)
            Save(measure::ToImage(pair.transmission), source + "-transmission.exr", what, source);
    }

    void SavePair(const measure::DensityPair& pair, const std::string& source) {
        const std::string what = "density over solid angle [1/sr] over the projected hemisphere";
        Save(measure::ToImage(pair.reflection), source + "-reflection.exr", what, source);
        if (r_.transmits)
            Save(measure::ToImage(pair.transmission), source + "-transmission.exr", what, source);
    }

    /// Early, for a survey takes its time.
    void CheckExports() {
        if (a_.exports.empty()) return;
        const Lobes lobes = measure::LobesFromAbove(*variants_[0].material.bsdf, uint64_t(a_.seed));
        const char* what = Any(lobes, Lobes::Transmission) ? "transmits light"
                           : IsSpecular(lobes)             ? "has specular reflections"
                                                           : nullptr;
        for (const std::string& name : a_.exports)
            if (what && ExportOf(name).isOfRoughReflection)
                throw CLI::ValidationError(fmt::format(
                    "--export {} is for opaque materials without specular reflections, but \"{}\" "
                    "{}: --export klems has a place for both",
                    name, a_.material, what));
    }

    /// Tables for other programs, of the first estimator.
    void WriteTables() {
        const TableOptions options{a_.samples, uint64_t(a_.seed)};
        for (const std::string& name : a_.exports) {
            const ExportFormat& format = ExportOf(name);
            WriteText((fs::path(a_.out) / format.file).string(),
                      format.make(variants_[0].material, uv_, options, r_.material, &console_));
            files_.push_back(format.file);
        }
    }

    void Write() {
        MakeOutputFolder(a_.out);  // late, so that an interrupted survey leaves nothing behind
        for (size_t i = 0; i < r_.estimators.size(); ++i) {
            const std::string& name = r_.estimators[i].name;
            SavePair(r_.estimators[i].lobe, name);
            Save(MakeLobeImage(r_, i), name + ".png", "lobes and their differences from the histogram", name);
        }
        SavePair(r_.histogram, "samples");
        SavePair(r_.density, "density");
        SavePair(r_.pdf, "pdf");
        Save(MakeSheet(r_), "sheet.png", "contact sheet", "all");
        WriteTables();
        WriteText(fs::path(a_.out) / "table.txt", ToText(r_) + ToText(colors_));
        nlohmann::ordered_json table = ToJson(r_);
        table["colors"] = ToJson(colors_);
        table["files"] = files_;
        const std::set<std::string> earlier = FilesOfEarlierSurvey(a_.out);
        WriteText(fs::path(a_.out) / "table.json", JsonText(table, 1) + "\n");
        RemoveEarlierFiles(a_.out, earlier, table);
        console_.Info(fmt::format(
            "{}: sheet.png, table.txt, table.json, and PNG and EXR files of each estimator", a_.out));
        fmt::print("{}", ToText(colors_));
    }

    const BsdfArguments& a_;
    Console console_;
    Point2 uv_{0};
    std::vector<std::string> files_;  ///< images that were written
    measure::BsdfSurveyOptions survey_;
    SceneDescription description_;
    std::vector<Variant> variants_;
    measure::BsdfResult r_;
    ColorTable colors_;
};

}  // namespace

void AddBsdfOptions(CLI::App& app, BsdfArguments& a) {
    app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    app.add_option(
           "scene", a.scenes,
           "Scene files, read one after another as one scene (-: standard input); or documents of MaterialX")
        ->type_name(kFile)
        ->required()
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    app.add_option("--material", a.material, "Name of a named material; @1, @2, ...: the unnamed ones")
        ->required();
    app.add_option("--wi", a.wi, "THETA,PHI: where the light comes from [degrees]")->required();
    app.add_option("--out", a.out, "Folder for the files; made if it is not there")
        ->type_name(kFolder)
        ->required();
    app.add_option("--reference", a.reference, "Another material of the scene: color differences from it");
    app.add_option(
           "--export", a.exports,
           "Tables for other programs, with commas between: merl (isotropic reflection), merl-anisotropic, "
           "klems (BSDF XML), rgl (for the material \"measured\")")
        ->type_name("A,B")
        ->check(OneOf(ExportNames()))
        ->delimiter(',')
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    app.add_option("--uv", a.uv, "U,V: where textures are looked up");
    app.add_option("--estimator", a.estimators,
                   "Estimators of a layered material, with commas between; default: all but approximations")
        ->type_name("A,B,...")
        ->check(OneOf(Registry<layered::LayeredEstimatorKind>::Names()))
        ->delimiter(',')
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    app.add_option("--layered-pdf", a.layeredPdf, "pdf of a layered material, instead of its own")
        ->check(OneOf(Registry<layered::LayeredPdfKind>::Names()));
    app.add_option("--resolution", a.resolution, "Pixels on a side of the images")
        ->check(CLI::Range(16, 2048));
    app.add_option("--samples", a.samples, "Evaluations of a pixel; other counts grow with it")
        ->check(CLI::Range(1, 1 << 16));
    app.add_option("--seed", a.seed, "Seed of all random numbers");
    app.add_option("--nthreads", a.threads, "Threads; 0: all processors")->check(CLI::Range(0, 1024));
    app.add_flag("--quiet", a.quiet, "No progress and no warnings");
}

ExitStatus RunBsdf(const BsdfArguments& arguments) { return BsdfJob(arguments).Run(); }

namespace {

constexpr const char* kBsdfSynopsis =
    "Shows what a material does to light: lobes, albedo, agreement of the estimators.\n"
    "Usage: lacquer bsdf [OPTIONS] scene.pbrt ... --material NAME --wi THETA,PHI --out DIR";
constexpr const char* kBsdfFooter = R"(
Exit status: 0 the files are written; 1 wrong usage; 2 the scene is wrong, or has no such material; 3 a
file cannot be read or written.)";

}  // namespace

LACQUER_REGISTER(CommandKind, "bsdf", (CommandOf<BsdfArguments, AddBsdfOptions, RunBsdf>::Make),
                 {.synopsis = kBsdfSynopsis, .footer = kBsdfFooter});

}  // namespace lacquer::cmd
