#include "cmd/scenes/scene_survey.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <mutex>
#include <set>

#include "cmd/command_support.h"
#include "layered/estimator.h"
#include "pbrt/core/arena.h"
#include "pbrt/core/sampling.h"
#include "pbrt/core/spectrum.h"
#include "pbrt/image/image_cache.h"
#include "pbrt/image/mipmap.h"
#include "pbrt/scene/builder.h"
#include "pbrt/scene/texture_store.h"
#include "pbrt/textures/imagemap.h"

namespace lacquer::cmd {
namespace {

namespace fs = std::filesystem;

/// Keeps the warnings, which are a part of the answer.
class WarningList final : public Observer {
  public:
    void Warn(const std::string& message) override {
        const std::lock_guard lock(mutex_);
        if (std::find(list_.begin(), list_.end(), message) == list_.end()) list_.push_back(message);
    }
    std::vector<std::string> Take() { return std::move(list_); }

  private:
    std::mutex mutex_;
    std::vector<std::string> list_;
};

/// Calls `visit(parameter)` for the entity's own parameters and those that it inherits.
template <class Visit>
void VisitParameters(const PluginEntity& entity, const Visit& visit) {
    for (const Parameter& p : entity.parameters) visit(p);
    if (entity.attributes)
        for (const Parameter& p : *entity.attributes) visit(p);
}

/// The text of the parameter that counts: the last one of its own, else one that it inherits.
std::string TextOf(const PluginEntity& entity, const std::string& name, const std::string& fallback) {
    const auto last = [&](const std::vector<Parameter>& parameters) {
        std::optional<std::string> found;
        for (const Parameter& p : parameters)
            if (p.type == "string" && p.name == name && p.strings.size() == 1) found = p.strings[0];
        return found;
    };
    std::optional<std::string> value = last(entity.parameters);
    if (!value && entity.attributes) value = last(*entity.attributes);
    return value.value_or(fallback);
}

/// What the description alone tells.
class DescriptionSurvey {
  public:
    DescriptionSurvey(const SceneDescription& description, SceneSurvey* survey)
        : d_(description), s_(*survey) {}

    void Run() {
        s_.camera = d_.camera.type;
        s_.film = d_.film.type;
        s_.filter = d_.filter.type;
        s_.sampler = d_.sampler.type;
        s_.integrator = d_.integrator.type;
        s_.accelerator = d_.accelerator.type;
        CountDirectives();
        ListMaterials();
        for (const TextureEntity& t : d_.textures)
            s_.textures.push_back(
                {t.name, t.loc.ToString(), t.isSpectrum ? "spectrum" : "float", t.type, {}, {}, 0, false});
        WarnOfUnused();
    }

  private:
    template <class Visit>
    void VisitShapes(const Visit& visit) const {
        for (const ShapeEntity& shape : d_.shapes) visit(shape);
        for (const ObjectDefinition& object : d_.objects)
            for (const ShapeEntity& shape : object.shapes) visit(shape);
    }

    /// All entities that have parameters, with what they make.
    template <class Visit>
    void VisitEntities(const Visit& visit) const {
        visit(d_.camera, "camera");
        visit(d_.film, "film");
        for (const MediumEntity& e : d_.media) visit(e, "medium");
        for (const TextureEntity& e : d_.textures) visit(e, "texture");
        for (const MaterialEntity& e : d_.namedMaterials) visit(e, "material");
        for (const MaterialEntity& e : d_.materials) visit(e, "material");
        for (const LightEntity& e : d_.lights) visit(e, "light");
        for (const PluginEntity& e : d_.areaLights) visit(e, "light");
        VisitShapes([&](const ShapeEntity& e) { visit(e, "shape"); });
    }

    void CountDirectives() {
        VisitShapes([&](const ShapeEntity& shape) {
            ++s_.shapes[shape.type];
            if (shape.areaLight >= 0) ++s_.areaLights[d_.areaLights[size_t(shape.areaLight)].type];
        });
        for (const LightEntity& light : d_.lights) ++s_.lights[light.type];
        for (const MediumEntity& medium : d_.media) ++s_.media[medium.type];
        s_.objects = int64_t(d_.objects.size());
        s_.instances = int64_t(d_.instances.size());
    }

    void ListMaterials() {
        std::map<std::string, int64_t> shapesOfNamed;
        std::vector<int64_t> shapesOfUnnamed(d_.materials.size(), 0);
        VisitShapes([&](const ShapeEntity& shape) {
            if (shape.material.name.empty())
                ++shapesOfUnnamed[size_t(shape.material.index)];
            else
                ++shapesOfNamed[shape.material.name];
        });
        const auto add = [&](const MaterialEntity& m, const std::string& name, int64_t shapes) {
            MaterialUse use{name, m.type, m.loc.ToString(), shapes, shapes > 0, "", ""};
            if (Registry<MaterialKind>::TraitsOf(m.type).isLayered) {
                use.estimator = TextOf(m, "estimator", layered::LayeredEstimatorKind::kDefault);
                use.pdf = TextOf(m, "pdf", layered::LayeredPdfKind::kDefault);
            }
            s_.materials.push_back(use);
        };
        for (const MaterialEntity& m : d_.namedMaterials) add(m, m.name, shapesOfNamed[m.name]);
        for (size_t i = 0; i < d_.materials.size(); ++i)
            add(d_.materials[i], fmt::format("@{}", i), shapesOfUnnamed[i]);
        PropagateUse();
        for (const MaterialUse& use : s_.materials)
            if (use.shapes > 0 || use.name != "@0") ++s_.materialTypes[use.type];
    }

    /// What a used material names (a part of a mixture or of a stack) is used as well. Materials name
    /// earlier ones only, so unnamed ones first and the named ones backwards reach all.
    void PropagateUse() {
        std::set<std::string> named;
        const auto note = [&](const MaterialEntity& m) {
            VisitParameters(m, [&](const Parameter& p) {
                if (p.type == "string") named.insert(p.strings.begin(), p.strings.end());
            });
        };
        const size_t numNamed = d_.namedMaterials.size();
        for (size_t i = 0; i < d_.materials.size(); ++i)
            if (s_.materials[numNamed + i].isUsed) note(d_.materials[i]);
        for (size_t i = numNamed; i-- > 0;) {
            MaterialUse& use = s_.materials[i];
            use.isUsed = use.isUsed || named.contains(use.name);
            if (use.isUsed) note(d_.namedMaterials[i]);
        }
    }

    void WarnOfUnused() {
        for (const MaterialUse& use : s_.materials)
            if (!use.isUsed && use.name != "@0")
                s_.warnings.push_back(fmt::format(
                    "{}: warning: nothing uses the material {}", use.place,
                    use.name[0] == '@' ? fmt::format("\"{}\"", use.type) : fmt::format("\"{}\"", use.name)));
        std::set<std::string> textures, media, objects;
        VisitEntities([&](const PluginEntity& entity, const char*) {
            VisitParameters(entity, [&](const Parameter& p) {
                if (p.type == "texture") textures.insert(p.strings.begin(), p.strings.end());
            });
        });
        media.insert(d_.camera.medium);
        for (const LightEntity& light : d_.lights) media.insert(light.medium);
        VisitShapes([&](const ShapeEntity& s) { media.insert({s.insideMedium, s.outsideMedium}); });
        // A medium that is used may mix the phase functions of earlier ones.
        for (auto medium = d_.media.rbegin(); medium != d_.media.rend(); ++medium)
            if (media.contains(medium->name))
                VisitParameters(*medium, [&](const Parameter& p) {
                    if (p.type == "string") media.insert(p.strings.begin(), p.strings.end());
                });
        for (const InstanceEntity& i : d_.instances) objects.insert(i.name);
        WarnOfUnused("texture", d_.textures, textures);
        WarnOfUnused("medium", d_.media, media);
        WarnOfUnused("object", d_.objects, objects);
    }

    template <class Entities>
    void WarnOfUnused(const char* what, const Entities& entities, const std::set<std::string>& used) {
        for (const auto& entity : entities)
            if (!used.contains(entity.name))
                s_.warnings.push_back(fmt::format("{}: warning: nothing uses the {} \"{}\"",
                                                  entity.loc.ToString(), what, entity.name));
    }

    const SceneDescription& d_;
    SceneSurvey& s_;
};

/// True if the material scatters, but into single directions only.
bool IsSmooth(const Material& material) {
    constexpr int kSamples = 32;
    Arena arena;
    TextureContext context;
    context.n = {0, 0, 1};
    context.uv = {0.5f, 0.5f};
    for (int i = 0; i < kSamples; ++i) {
        // A mix draws by a hash of the direction.
        const float u = (float(i) + 0.5f) / kSamples;
        const Material& chosen = *material.Choose(context, SampleUniformSphere({u, std::fmod(7 * u, 1.f)}));
        SampledWavelengths lambda = SampledWavelengths::SampleVisible(0.5f);
        const BxDF* bxdf = chosen.MakeBxDF(context, lambda, arena);
        if (!bxdf) return false;
        const auto flags = unsigned(bxdf->Flags());
        if (!(flags & unsigned(Lobes::Specular)) || flags & unsigned(Lobes::Diffuse | Lobes::Glossy))
            return false;
    }
    return true;
}

/// What the built scene tells.
class BuiltSurvey {
  public:
    BuiltSurvey(const SceneDescription& description, const RenderSetup& setup, SceneSurvey* survey)
        : d_(description), setup_(setup), parts_(setup.scene->Parts()), s_(*survey) {}

    void Run() {
        s_.image = setup_.film->Filename();
        s_.resolution = setup_.film->Resolution();
        s_.pixels = setup_.film->PixelBounds();
        s_.colorSpace = setup_.film->ColorSpace().Name();
        s_.samplesPerPixel = setup_.sampler->SamplesPerPixel();
        s_.emitters = int64_t(parts_.areaLights.size());
        CountPrimitives();
        DescribeTextures();
        DescribeImages();
        ListFiles();
        ForecastMemory();
        WarnOfLight();
    }

  private:
    void CountPrimitives() {
        std::vector<int64_t> ofGroup;
        for (const auto& group : parts_.groups) {
            int64_t sum = 0;
            for (const Primitive& p : group) {
                const int64_t count = p.shape->NumPrimitives();
                (p.shape->Triangles() ? s_.triangles : s_.otherPrimitives) += count;
                sum += count;
            }
            ofGroup.push_back(sum);
        }
        s_.placedPrimitives = ofGroup.empty() ? 0 : ofGroup[0];
        for (const AccelInstance& instance : parts_.instances)
            s_.placedPrimitives += ofGroup[size_t(instance.group)];
    }

    void DescribeTextures() {
        const auto& store = dynamic_cast<const TextureStore&>(*parts_.textures);
        std::set<const MipMap*> seen;
        for (size_t i = 0; i < d_.textures.size(); ++i) {
            const TextureEntity& t = d_.textures[i];
            const MipMap* map = nullptr;
            if (const SpectrumTexture* made = t.isSpectrum ? store.MadeSpectrum(t.name) : nullptr)
                map = ImageOf(*made);
            if (const FloatTexture* made = t.isSpectrum ? nullptr : store.MadeFloat(t.name))
                map = ImageOf(*made);
            if (!map) continue;
            TextureUse& use = s_.textures[i];
            use.file = FileNamedAt(use.place);
            use.resolution = map->Resolution(0);
            use.bytes = map->Bytes();
            use.isShared = !seen.insert(map).second;
            if (!use.isShared) s_.memory.textures += use.bytes;
        }
    }

    /// The file that the directive at this place has read; empty if there is none.
    std::string FileNamedAt(const std::string& place) const {
        const auto found = std::find_if(setup_.files.begin(), setup_.files.end(),
                                        [&](const FileUse& use) { return use.loc.ToString() == place; });
        return found == setup_.files.end() ? std::string() : found->name;
    }

    /// Images that are no textures: of lights, maps of materials.
    void DescribeImages() {
        for (const FileUse& use : setup_.files) {
            if (use.bytes == 0) continue;
            const auto isSame = [&](const ImageUse& i) { return i.file == use.name; };
            if (std::any_of(s_.images.begin(), s_.images.end(), isSame)) continue;
            s_.images.push_back(
                {use.name, fmt::format("{}, {}", use.owner, use.parameter), use.resolution, use.bytes});
            s_.memory.images += use.bytes;
        }
    }

    /// First the scene's own, then what its directives have read. Roles are the kinds of the plugins that
    /// read them: the owner without its type.
    void ListFiles() {
        for (const std::string& path : d_.files) AddFile(path, "scene");
        for (const FileUse& use : setup_.files) AddFile(use.path, use.owner.substr(0, use.owner.find(" \"")));
    }

    void AddFile(const std::string& path, const std::string& role) {
        std::error_code error;
        const auto isSame = [&](const ListedFile& f) { return f.path == path; };
        if (std::any_of(s_.files.begin(), s_.files.end(), isSame)) return;
        const bool isRegular = fs::is_regular_file(path, error);
        s_.files.push_back({path, role, isRegular ? uint64_t(fs::file_size(path, error)) : 0});
    }

    void ForecastMemory() {
        for (const auto& medium : parts_.media) s_.memory.media += medium->MemoryBytes();
        s_.memory.geometry = setup_.scene->GeometryBytes();
        s_.memory.accelerationStructure = setup_.scene->Accelerator().MemoryBytes();
        // The sums of all samples, and at the end the developed image beside them.
        s_.memory.film = setup_.film->MemoryBytes() + setup_.film->Develop()->Pixels().size() * sizeof(float);
    }

    void WarnOfLight() {
        const auto& lights = setup_.scene->Lights();
        if (s_.placedPrimitives == 0) s_.warnings.emplace_back("warning: the scene has no shape");
        if (!setup_.scene->HasEmission()) {
            s_.warnings.emplace_back("warning: the scene has no light: the image will be black");
            return;
        }
        if (lights.empty()) return;
        if (!std::all_of(lights.begin(), lights.end(), [](const Light* l) { return l->IsDelta(); })) return;
        if (s_.integrator == "randomwalk")
            s_.warnings.emplace_back(
                "warning: the integrator \"randomwalk\" finds lights by chance, and all lights are points or "
                "single directions: the image will be black");
        WarnOfSmoothMaterials();
    }

    /// Light from a point never meets a perfect mirror in just the direction of the camera.
    void WarnOfSmoothMaterials() {
        bool isAllSmooth = true, isAny = false;
        std::vector<std::string> found;
        for (size_t i = 0; i < s_.materials.size(); ++i) {
            const MaterialUse& use = s_.materials[i];
            if (use.shapes == 0) continue;
            const bool isSmooth = IsSmooth(*parts_.materials[i]);
            isAny = isAny || isSmooth;
            isAllSmooth = isAllSmooth && isSmooth;
            if (isSmooth)
                found.push_back(fmt::format(
                    "{}: warning: the {} \"{}\" is perfectly smooth, and all lights are points or single "
                    "directions: no light is seen in it, only other surfaces",
                    use.place, use.type, use.name));
        }
        if (isAny && isAllSmooth)
            s_.warnings.emplace_back(
                "warning: all surfaces are perfectly smooth, and all lights are points or single directions: "
                "the image will be black");
        s_.warnings.insert(s_.warnings.end(), found.begin(), found.end());
    }

    const SceneDescription& d_;
    const RenderSetup& setup_;
    const SceneParts& parts_;
    SceneSurvey& s_;
};

}  // namespace

SceneSurvey SurveyScene(std::vector<SceneInput> inputs) {
    SceneSurvey survey;
    survey.name = inputs[0].name;
    for (size_t i = 1; i < inputs.size(); ++i) survey.name += " " + inputs[i].name;
    WarningList warnings;
    SceneDescription description = ParseInputs(std::move(inputs), &warnings);
    DescriptionSurvey(description, &survey).Run();
    // The builder empties the description of the shapes, which are large and have been looked at.
    auto shapes = std::move(description.shapes);
    auto objects = std::move(description.objects);
    const SceneDescription rest = description;
    description.shapes = std::move(shapes);
    description.objects = std::move(objects);
    BuildOptions options;
    options.textures = DefaultTextureMemory();
    const RenderSetup setup = BuildScene(std::move(description), options, &warnings);
    BuiltSurvey(rest, setup, &survey).Run();
    std::vector<std::string> all = warnings.Take();
    all.insert(all.end(), survey.warnings.begin(), survey.warnings.end());
    survey.warnings = std::move(all);
    return survey;
}

}  // namespace lacquer::cmd
