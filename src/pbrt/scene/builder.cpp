#include "pbrt/scene/builder.h"

#include <algorithm>
#include <deque>
#include <set>
#include <tuple>

#include "pbrt/base/emitting_material.h"
#include "pbrt/base/warnings.h"
#include "pbrt/core/rng.h"
#include "pbrt/film/light_path_automaton.h"
#include "pbrt/film/passes.h"
#include "pbrt/materials/forced_diffuse.h"
#include "pbrt/scene/asset_cache.h"
#include "pbrt/scene/attribute_reads.h"
#include "pbrt/scene/creation.h"
#include "pbrt/scene/factory.h"
#include "pbrt/scene/naming.h"
#include "pbrt/scene/texture_store.h"

namespace lacquer {

namespace {

constexpr size_t kMaxErrors = 20;
/// Beyond what the scene asks for, no sampler is asked for more than all of them can give.
constexpr int64_t kMaxSamples = 65536;

/// Runs steps and keeps what goes wrong, so that several mistakes are reported together, up to kMaxErrors.
class ErrorCollector {
  public:
    template <class Step>
    bool Try(const Step& step) {
        try {
            step();
            return true;
        } catch (const SceneErrors& e) {
            for (const Diagnostic& d : e.Diagnostics()) Add(d);
        } catch (const SceneError& e) {
            Add({Diagnostic::Severity::Error, e.Loc(), e.Message(), Diagnostic::Cause::Scene});
        } catch (const FileError& e) {
            Add({Diagnostic::Severity::Error, e.Loc(), e.Message(), Diagnostic::Cause::File});
        }
        return false;
    }
    void ThrowIfAny() {
        if (errors_.empty()) return;
        // Objects are made kind by kind, but a reader goes through the files: each in its order, after one
        // another.
        std::map<FileName, size_t> rank;
        for (const Diagnostic& d : errors_) rank.emplace(d.loc.file, rank.size());
        std::stable_sort(errors_.begin(), errors_.end(), [&](const Diagnostic& a, const Diagnostic& b) {
            return std::tuple(rank[a.loc.file], a.loc.line, a.loc.column) <
                   std::tuple(rank[b.loc.file], b.loc.line, b.loc.column);
        });
        if (errors_.size() == kMaxErrors)
            errors_.push_back({Diagnostic::Severity::Error,
                               {},
                               fmt::format("stopped after {} errors", kMaxErrors),
                               errors_.back().cause});
        throw SceneErrors(std::move(errors_));
    }

  private:
    void Add(const Diagnostic& d) {
        // One mistake can surface at several users of a texture or a directive: it is said once.
        const auto same = [&](const Diagnostic& e) { return e.ToString() == d.ToString(); };
        if (std::any_of(errors_.begin(), errors_.end(), same)) return;
        errors_.push_back(d);
        // What follows would only take time: each message looks for a similar name among all that there are.
        if (errors_.size() == kMaxErrors) ThrowIfAny();
    }
    std::vector<Diagnostic> errors_;
};

/// Steps of BuildScene, in their order; state that they share.
class Builder {
  public:
    Builder(SceneDescription description, const BuildOptions& options, Observer* observer)
        : d_(std::move(description)), options_(options), observer_(observer) {
        for (FileResolver& resolver : d_.resolvers) resolver.RecordIn(&setup_.files);
        ReadOptions();
        ChooseRenderSpace();
        if (options.assets) options.assets->BeginScene();
        auto images = options.assets ? std::shared_ptr<ImageCache>(options.assets, &options.assets->images)
                                     : std::make_shared<ImageCache>(options.textures, observer);
        textures_ = std::make_shared<TextureStore>(d_, renderFromWorld_, std::move(images),
                                                   options.disableImageTextures);
    }

    RenderSetup Build() {
        if (options_.keepNames) ReserveNames();
        PhaseClock clock;
        MakeFilmAndCamera();
        clock.End("materials");
        textures_->ReadImagesAhead();
        clock.End("textures");
        MakeMaterials();
        MakeMedia();
        clock.End("materials");
        MakeShapes();
        clock.End("shapes");
        MakeLights();
        clock.End("lights");
        textures_->MakeUnused([&](const auto& step) { errors_.Try(step); });
        CheckAccelerator();
        MakeSampler();
        // The integrator needs the finished scene, but whether there is one of that name is known now.
        errors_.Try([&] { FactoryOf<IntegratorKind>(d_.integrator); });
        errors_.ThrowIfAny();
        clock.End("materials");

        parts_.textures = textures_;
        setup_.scene = std::make_unique<Scene>(std::move(parts_));
        clock.End("acceleration structure");
        errors_.Try([&] { MakeIntegrator(); });
        errors_.ThrowIfAny();
        clock.End("integrator");
        setup_.phases = clock.Times();
        for (const Diagnostic& unread : attributeReads_.Unread()) Warn(unread.loc, unread.message);
        setup_.renderFromWorld = renderFromWorld_;
        if (options_.assets) options_.assets->DropUnused();
        return std::move(setup_);
    }

    MaterialSetup BuildOneMaterial(const std::string& name) {
        const MaterialEntity& entity = FindMaterial(name);
        MaterialSetup made;
        errors_.Try([&] {
            MakeNeededBy(entity);
            made.material = MakeMaterial(entity);
            RequireSurface(*made.material, fmt::format("\"{}\"", Excerpt(name)), entity.loc);
        });
        errors_.ThrowIfAny();
        made.textures = textures_;
        made.owned = std::move(parts_.materials);
        made.entity.name = name;
        made.entity.type = entity.type;
        made.entity.loc = entity.loc;
        return made;
    }

  private:
    const MaterialEntity& FindMaterial(const std::string& name) const {
        std::vector<std::string> names;
        for (const MaterialEntity& entity : d_.namedMaterials) {
            if (entity.name == name) return entity;
            names.push_back(entity.name);
        }
        for (size_t i = 0; i < d_.materials.size(); ++i)
            if (name == fmt::format("@{}", i)) return d_.materials[i];
        constexpr size_t kMaxNames = 12;
        std::string known = DidYouMean(name, names);
        if (names.empty())
            known += fmt::format("; it has no named materials, but unnamed ones from @0 to @{}",
                                 d_.materials.size() - 1);
        else if (names.size() <= kMaxNames)
            known += fmt::format(" (the scene has {})", fmt::join(names, ", "));
        throw SceneError({}, fmt::format("there is no material \"{}\" in the scene{}", Excerpt(name), known));
    }

    /// The materials before this one that its strings name, and those that they name, in the order of the
    /// file.
    void MakeNeededBy(const MaterialEntity& entity) {
        std::set<std::string> needed;
        const auto note = [&](const std::vector<Parameter>& parameters) {
            for (const Parameter& p : parameters) needed.insert(p.strings.begin(), p.strings.end());
        };
        const auto noteAll = [&](const MaterialEntity& e) {
            note(e.parameters);
            if (e.attributes) note(*e.attributes);
        };
        noteAll(entity);
        // A named material can only refer to earlier ones, so one pass backwards finds all. All of those may
        // be named by an unnamed material: the factory only looks at what exists.
        std::vector<const MaterialEntity*> earlier;
        auto last = d_.namedMaterials.rbegin();
        if (!entity.name.empty())
            last = std::find_if(last, d_.namedMaterials.rend(),
                                [&](const MaterialEntity& e) { return e.name == entity.name; });
        for (auto it = last; it != d_.namedMaterials.rend(); ++it) {
            if (&*it == &entity || !needed.contains(it->name)) continue;
            noteAll(*it);
            earlier.push_back(&*it);
        }
        std::reverse(earlier.begin(), earlier.end());
        for (const MaterialEntity* part : earlier) named_[part->name] = MakeMaterial(*part);
    }

    void Warn(const FileLoc& loc, const std::string& message) {
        if (observer_)
            observer_->Warn(Diagnostic{Diagnostic::Severity::Warning, loc, message, {}}.ToString());
    }

    template <class Made>
    void PassOnWarnings(const Made& made) {
        if (const auto* role = dynamic_cast<const HasWarnings*>(&made))
            for (const Diagnostic& warning : role->Warnings()) Warn(warning.loc, warning.message);
    }

    void ReadOptions() {
        setup_.options = Resolve(d_.options, options_.given);
        if (setup_.options.wavefront) Warn({}, "the option \"wavefront\" has no effect in this version");
    }

    // Floats keep most digits near the origin: by default that is where the camera is.
    void ChooseRenderSpace() {
        const Transform cameraFromWorld = d_.camera.cameraFromWorld.start;
        const std::string& space = setup_.options.renderCoordSys;
        if (space == "world") return;
        // Rendering space may turn and move the world, no more: lengths and handedness are the scene's.
        if (space == "camera" && !cameraFromWorld.HasScale() && !cameraFromWorld.SwapsHandedness())
            renderFromWorld_ = cameraFromWorld;
        else
            renderFromWorld_ = Transform::Translate(-cameraFromWorld.InversePoint(Point3(0)));
    }

    Transform ToRender(const Transform& worldFromObject) const { return renderFromWorld_ * worldFromObject; }
    AnimatedTransform ToRender(const TransformPair& pair) const {
        return {ToRender(pair.start), d_.startTime, ToRender(pair.end), d_.endTime};
    }

    /// Makes one plugin from its entity: factory(params), then the check for parameters that nobody wanted.
    template <class Kind, class Make>
    void Create(PluginEntity entity, const Make& make) {
        const auto factory = FactoryOf<Kind>(entity);
        const FileResolver& files = d_.FilesOf(entity);
        const Params params = MakeParams(std::move(entity), Kind::kKind, files);
        make(factory, params);
        params.CheckAllUsed();
        attributeReads_.Note(params);
    }

    /// The same for many entities: factories run at the same time, by all threads, and what they have made is
    /// taken in the order of the entities. Of one with several faults the factory's is told.
    /// @param entity  (index) -> PluginEntity&, whose parameters go
    /// @param make  (index, factory, parameters, observer) -> product
    /// @param take  (index, parameters, product); checks that all parameters were used
    template <class Kind, class EntityAt, class Make, class Take>
    void CreateMany(size_t count, const EntityAt& entity, const Make& make, const Take& take) {
        using Factory = typename Kind::Factory;
        using Product = std::invoke_result_t<Make, size_t, Factory, const Params&, Observer*>;
        for (size_t begin = 0; begin < count;) {
            const size_t size = BatchSize(begin, count, entity);
            std::deque<Creation<Kind, Product>> batch;
            for (size_t i = 0; i < size; ++i) {
                PluginEntity& e = entity(begin + i);
                batch.emplace_back(e, d_.FilesOf(e), observer_);
            }
            ParallelFor(int64_t(size), [&](int64_t i) {
                batch[size_t(i)].Run([&](Factory factory, const Params& params, Observer* observer) {
                    return make(begin + size_t(i), factory, params, observer);
                });
            });
            for (size_t i = 0; i < size; ++i)
                errors_.Try([&] {
                    Product product = batch[i].Finish(&setup_.files);
                    take(begin + i, batch[i].Parameters(), std::move(product));
                });
            begin += size;
        }
    }

    void MakeFilmAndCamera() {
        std::unique_ptr<Filter> filter;
        errors_.Try([&] {
            Create<FilterKind>(d_.filter,
                               [&](auto factory, const Params& params) { filter = factory(params); });
        });
        // The shutter's length belongs to the camera, but the film's exposure needs it.
        float shutterTime = 1;
        errors_.Try([&] {
            shutterTime = Camera::ShutterTime(MakeParams(d_.camera, "camera", d_.FilesOf(d_.camera)));
        });
        errors_.Try([&] {
            if (!filter) filter = Registry<FilterKind>::Find("box")(Params());
            Create<FilmKind>(d_.film, [&](auto factory, const Params& params) {
                setup_.film = factory({params, options_.film, std::move(filter), shutterTime,
                                       renderFromWorld_, RenderFromCamera()});
            });
        });
        parts_.resolution = setup_.film ? setup_.film->Resolution() : Int2(1);
        errors_.Try([&] { MakeCamera(); });
    }

    AnimatedTransform RenderFromCamera() const {
        const TransformPair& pair = d_.camera.cameraFromWorld;
        return {renderFromWorld_ * pair.start.Inverse(), d_.camera.startTime,
                renderFromWorld_ * pair.end.Inverse(), d_.camera.endTime};
    }

    void MakeCamera() {
        const AnimatedTransform renderFromCamera = RenderFromCamera();
        Create<CameraKind>(d_.camera, [&](auto factory, const Params& params) {
            const float filmDiagonal = setup_.film ? setup_.film->Diagonal() : 35;
            parts_.camera = factory({params, renderFromCamera, parts_.resolution, filmDiagonal, observer_});
        });
    }

    void MakeMaterials() {
        for (const MaterialEntity& entity : d_.namedMaterials) {
            const Material* made = nullptr;
            errors_.Try([&] { made = MakeMaterial(entity); });
            // A failed material still has its name: its users are not to blame.
            named_[entity.name] = made ? made : Placeholder();
            NameMaterial(entity, made);
        }
        for (const MaterialEntity& entity : d_.materials) {
            unnamed_.push_back(nullptr);
            errors_.Try([&] {
                unnamed_.back() = MakeMaterial(entity);
                RequireSurface(*unnamed_.back(), fmt::format("\"{}\"", entity.type), entity.loc);
            });
            NameMaterial(entity, unnamed_.back());
        }
        if (!setup_.options.forceDiffuse) return;
        matte_ = AddMatteCounterparts(&parts_.materials);
        for (auto& [material, name] : parts_.names.materials) material = Rendered(material);
    }

    /// What stands for a material in the rendered scene.
    const Material* Rendered(const Material* material) const {
        if (!matte_) return material;
        const auto found = matte_->find(material);
        return found == matte_->end() ? material : found->second;
    }

    /// What the scene calls "tree#2" keeps that name, though a second "tree" may come before it.
    void ReserveNames() {
        for (const ShapeEntity& entity : d_.shapes) objectNames_.Reserve(NameOf(entity));
        for (const InstanceEntity& instance : d_.instances) objectNames_.Reserve(instance.name);
        for (const MaterialEntity& entity : d_.namedMaterials) materialNames_.Reserve(NameOf(entity));
        for (const MaterialEntity& entity : d_.materials) materialNames_.Reserve(NameOf(entity));
    }

    void NameMaterial(const MaterialEntity& entity, const Material* made) {
        if (!options_.keepNames) return;
        parts_.names.materials.emplace_back(made, materialNames_.Make(NameOf(entity)));
    }

    /// Index of one object more. @param name  a function that gives its name: only called if names are kept
    template <class Name>
    int AddObject(const Name& name) {
        if (options_.keepNames) parts_.names.objects.push_back(objectNames_.Make(name()));
        return numObjects_++;
    }

    /// For a material that could not be made, until the errors are reported.
    const Material* Placeholder() {
        parts_.materials.push_back(std::make_unique<PlaceholderMaterial>());
        return parts_.materials.back().get();
    }

    const Material* MakeMaterial(const MaterialEntity& entity) {
        Create<MaterialKind>(entity, [&](auto factory, const Params& params) {
            parts_.materials.push_back(
                factory({params, *textures_, named_, entity.name, &options_.materials}));
            parts_.materials.back()->SetHoldout(params.GetBool("holdout", false));
            PassOnWarnings(*parts_.materials.back());
        });
        return parts_.materials.back().get();
    }

    static void RequireSurface(const Material& material, const std::string& name, const FileLoc& loc) {
        if (const std::string why = material.WhyNotASurface(); !why.empty())
            throw SceneError(loc, fmt::format("material {} {}", name, why));
    }

    const Material* MaterialOf(const MaterialRef& ref) const {
        if (ref.name.empty()) return unnamed_[size_t(ref.index)];
        const auto it = named_.find(ref.name);
        return it == named_.end() ? nullptr : it->second;
    }

    void MakeMedia() {
        for (const MediumEntity& entity : d_.media) {
            const Medium* made = nullptr;
            errors_.Try([&] {
                Create<MediumKind>(entity, [&](auto factory, const Params& params) {
                    parts_.media.push_back(factory({params, ToRender(entity.worldFromMedium), &media_}));
                    parts_.media.back()->SetGroup(LightGroupOf(params));
                    PassOnWarnings(parts_.media.back()->GetPhaseModel());
                });
                made = parts_.media.back().get();
            });
            // A medium that failed still has its name: its users are not to blame.
            media_[entity.name] = made;
        }
        parts_.cameraMedium = MediumOf(d_.camera.medium);
    }

    /// Null for the vacuum, and for a medium that could not be made.
    const Medium* MediumOf(const std::string& name) const {
        const auto it = media_.find(name);
        return it == media_.end() ? nullptr : it->second;
    }

    void MakeShapes() {
        SharedTextures textures(*textures_);
        for (const ShapeEntity& entity : d_.shapes) MakeDisplacementOf(entity);
        for (const ObjectDefinition& object : d_.objects)
            for (const ShapeEntity& entity : object.shapes) MakeDisplacementOf(entity);
        parts_.groups.emplace_back();
        std::vector<ShapeEntity*> entities;
        for (ShapeEntity& entity : d_.shapes) entities.push_back(&entity);
        // A moving shape is placed by an instance of it.
        const auto place = [&](const ShapeEntity& entity) {
            return entity.worldFromObject.IsAnimated() ? Transform() : ToRender(entity.worldFromObject.start);
        };
        CreateShapes(entities, place, textures, [&](size_t, const ShapeSource& source, Shapes shapes) {
            const int object = AddObject([&] { return NameOf(source.entity); });
            if (source.entity.worldFromObject.IsAnimated())
                AddMovingShape(source, std::move(shapes), object);
            else
                AddShape(source, std::move(shapes), 0, object);
        });
        MakeObjects(textures);
        CheckUnusedEmitters();
    }

    /// Textures that shapes ask for while they are made are there before, so that the files that they read
    /// are listed in the same order each time. What is wrong with one is told to the shape.
    void MakeDisplacementOf(const ShapeEntity& entity) {
        for (const Parameter& p : entity.parameters) {
            if (p.type != "texture" || p.name != "displacement" || p.strings.size() != 1) continue;
            try {
                textures_->Float(p.strings[0], p.loc);
            } catch (const std::runtime_error&) {  // NOLINT(bugprone-empty-catch): as said
            }
        }
    }

    /// Area lights that no shape took (in objects, on interfaces, at the end of a file) are tried on a
    /// placeholder, so that their mistakes are found as well.
    void CheckUnusedEmitters() {
        for (size_t i = 0; i < d_.areaLights.size(); ++i) {
            if (usedEmitters_.contains(int(i))) continue;
            errors_.Try([&] {
                const auto sphere = Registry<ShapeKind>::Find("sphere")(
                    {Params("shape \"sphere\"", {}, {}, &ColorSpace::SRGB()), Transform(), false, *textures_,
                     nullptr});
                Create<AreaLightKind>(d_.areaLights[i], [&](auto factory, const Params& params) {
                    LightGroupOf(params);
                    factory({params, Transform(), *sphere[0], nullptr, *textures_});
                });
            });
        }
    }

    void MakeObjects(SharedTextures& textures) {
        std::map<std::string, int> groupOf;
        std::vector<ShapeEntity*> entities;
        std::vector<size_t> groups;  // of the entities
        for (ObjectDefinition& object : d_.objects) {
            const size_t group = parts_.groups.size();
            parts_.groups.emplace_back();
            groupOf[object.name] = int(group);
            for (ShapeEntity& entity : object.shapes) entities.push_back(&entity);
            groups.resize(entities.size(), group);
        }
        const auto place = [](const ShapeEntity& entity) { return entity.worldFromObject.start; };
        CreateShapes(entities, place, textures, [&](size_t i, const ShapeSource& source, Shapes shapes) {
            if (source.entity.worldFromObject.IsAnimated())
                Warn(source.entity.loc,
                     "a moving shape inside an object stands still at its start; move the instance "
                     "instead");
            AddShape(source, std::move(shapes), groups[i], -1);
        });
        for (const InstanceEntity& instance : d_.instances) {
            const auto group = groupOf.find(instance.name);
            if (group == groupOf.end() || parts_.groups[size_t(group->second)].empty()) continue;
            parts_.instances.push_back({group->second, ToRender(instance.worldFromInstance)});
            parts_.instanceObjects.push_back(AddObject([&] { return instance.name; }));
        }
    }

    using Shapes = std::vector<std::unique_ptr<Shape>>;
    /// What shapes are made from.
    struct ShapeSource {
        const ShapeEntity& entity;
        const Params& params;  ///< the entity's own are gone
        Transform renderFromObject;
    };

    /// @param place  (entity) -> its transform to rendering space
    /// @param add  (index, source, shapes)
    template <class Place, class Add>
    void CreateShapes(const std::vector<ShapeEntity*>& entities, const Place& place, TextureLibrary& textures,
                      const Add& add) {
        CreateMany<ShapeKind>(
            entities.size(), [&](size_t i) -> ShapeEntity& { return *entities[i]; },
            [&](size_t i, auto factory, const Params& params, Observer* observer) {
                return factory({params, place(*entities[i]), entities[i]->reverseOrientation, textures,
                                observer, setup_.options.displacementEdgeScale,
                                options_.assets ? &options_.assets->meshes : nullptr});
            },
            [&](size_t i, const Params& params, Shapes shapes) {
                add(i, ShapeSource{*entities[i], params, place(*entities[i])}, std::move(shapes));
            });
    }

    /// A moving shape is the only member of an object that a moving instance places.
    void AddMovingShape(const ShapeSource& source, Shapes shapes, int object) {
        const ShapeEntity& entity = source.entity;
        if (entity.areaLight >= 0) throw SceneError(entity.loc, "a moving shape cannot be an area light");
        const AnimatedTransform moving = ToRender(entity.worldFromObject);
        const size_t group = parts_.groups.size();
        parts_.groups.emplace_back();
        AddShape(source, std::move(shapes), group, object);
        parts_.instances.push_back({int(group), moving});
        parts_.instanceObjects.push_back(object);
    }

    /// @param object  index of the object that the shape is, -1 within object definitions
    void AddShape(const ShapeSource& source, Shapes shapes, size_t group, int object) {
        const auto& [entity, params, renderFromObject] = source;
        const FileLoc& loc = entity.loc;
        const FloatTexture* alpha = OptionalFloatTextureParam(params, "alpha", *textures_);
        if (alpha && alpha->Constant().value_or(0) >= 1) alpha = nullptr;
        const Material* material = MaterialOf(entity.material);
        if (material && !entity.material.name.empty())
            RequireSurface(*material, fmt::format("\"{}\"", Excerpt(entity.material.name)), loc);
        params.CheckAllUsed();
        attributeReads_.Note(params);
        const Params* emission = EmissionOf(material, entity.areaLight >= 0, group > 0, loc);
        for (auto& shape : shapes) {
            if (shape->NumPrimitives() == 0) continue;
            Primitive primitive;
            primitive.material = Rendered(material);
            primitive.alpha = alpha;
            primitive.media = {MediumOf(entity.insideMedium), MediumOf(entity.outsideMedium)};
            primitive.object = object;
            if (entity.areaLight >= 0)
                primitive.firstLight = AddAreaLights(entity, loc, renderFromObject, *shape, alpha, material);
            else if (emission && CanEmit(*shape, *material, loc))
                primitive.firstLight =
                    AddAreaLights(*emission, loc, renderFromObject, *shape, alpha, material);
            primitive.shape = std::move(shape);
            parts_.groups[group].push_back(std::move(primitive));
        }
    }

    /// Parameters of the light that its material makes of a shape; null if that emits nothing or must not.
    const Params* EmissionOf(const Material* material, bool hasAreaLight, bool isInGroup,
                             const FileLoc& loc) {
        const auto* emitting = dynamic_cast<const EmittingMaterial*>(material);
        const Params* emission = emitting ? emitting->EmissionParams() : nullptr;
        if (!emission) return nullptr;
        if (hasAreaLight) {
            WarnOfEmission(
                *material, loc,
                "the shape has an AreaLightSource, which takes the place of its material's emission");
            return nullptr;
        }
        if (isInGroup) {
            WarnOfEmission(
                *material, loc,
                "a shape that moves or is part of an object cannot be an area light; its material's "
                "emission is left out");
            return nullptr;
        }
        return emission;
    }
    /// Whether a shape can have the emission of its material; warns if not.
    bool CanEmit(const Shape& shape, const Material& material, const FileLoc& loc) {
        const std::string why = shape.WhyNoEmitter();
        if (!why.empty())
            WarnOfEmission(material, loc, fmt::format("{}; its material's emission is left out", why));
        return why.empty();
    }
    /// Once for a material: what is made of it are often thousands of shapes.
    void WarnOfEmission(const Material& material, const FileLoc& loc, const std::string& message) {
        if (warnedOfEmission_.insert({&material, message}).second) Warn(loc, message);
    }

    /// Index of the first of the lights that a shape's primitives become, -1 if they emit nothing.
    int AddAreaLights(const ShapeEntity& entity, const FileLoc& loc, const Transform& renderFromObject,
                      const Shape& shape, const FloatTexture* alpha, const Material* material) {
        if (material && material->IsInvisible()) {
            Warn(loc, "a shape of the interface material cannot be an area light; its light is left out");
            return -1;
        }
        RequireEmitter(shape, renderFromObject, loc);
        const PluginEntity& emitter = d_.areaLights[size_t(entity.areaLight)];
        usedEmitters_.insert(entity.areaLight);
        const int first = int(parts_.areaLights.size());
        Create<AreaLightKind>(emitter, [&](auto factory, const Params& params) {
            const int group = LightGroupOf(params);
            KeepAreaLights(factory({params, renderFromObject, shape, alpha, *textures_}), group, material);
        });
        return first;
    }
    /// The same of a material's emission.
    int AddAreaLights(const Params& emission, const FileLoc& loc, const Transform& renderFromObject,
                      const Shape& shape, const FloatTexture* alpha, const Material* material) {
        RequireEmitter(shape, renderFromObject, loc);
        const int first = int(parts_.areaLights.size());
        const auto factory = Registry<AreaLightKind>::Find("diffuse");
        KeepAreaLights(factory({emission, renderFromObject, shape, alpha, *textures_}), 0, material);
        return first;
    }
    void RequireEmitter(const Shape& shape, const Transform& renderFromObject, const FileLoc& loc) {
        if (const std::string why = shape.WhyNoEmitter(); !why.empty()) throw SceneError(loc, why);
        if (shape.AreaIgnoresScale() && renderFromObject.HasScale())
            Warn(loc, "the transform of this area light scales; its emission is sampled as if it did not");
    }
    void KeepAreaLights(std::vector<std::unique_ptr<Light>> lights, int group, const Material* material) {
        for (auto& light : lights) {
            light->SetGroup(group);
            light->SetHoldout(material && material->IsHoldout());
            parts_.areaLights.push_back(std::move(light));
        }
    }

    /// Number of the light group of a light or a medium; a new one for a new name.
    int LightGroupOf(const Params& params) {
        const std::optional<std::string> name = params.GetOptionalString("group");
        if (!name) return 0;
        if (const std::string why = WhyNoLayerName(*name); !why.empty())
            params.Fail("group", fmt::format("the name of the light group {}", why));
        std::vector<std::string>& groups = parts_.lightGroups;
        const auto found = std::find(groups.begin() + 1, groups.end(), *name);
        if (found != groups.end()) return int(found - groups.begin());
        if (groups.size() > kMaxLightGroups)
            params.Fail("group", fmt::format("\"{}\" is one light group too many; a scene can have {}",
                                             Excerpt(*name), kMaxLightGroups));
        groups.push_back(*name);
        return int(groups.size()) - 1;
    }

    void MakeLights() {
        SharedTextures textures(*textures_);
        CreateMany<LightKind>(
            d_.lights.size(), [&](size_t i) -> LightEntity& { return d_.lights[i]; },
            [&](size_t i, auto factory, const Params& params, Observer* observer) {
                const Transform renderFromLight = ToRender(d_.lights[i].worldFromLight);
                return factory({params, renderFromLight, renderFromWorld_, textures, observer});
            },
            [&](size_t, const Params& params, std::unique_ptr<Light> light) {
                light->SetGroup(LightGroupOf(params));
                params.CheckAllUsed();
                attributeReads_.Note(params);
                parts_.lights.push_back(std::move(light));
            });
        d_.lights = {};
    }

    // Both of pbrt's accelerators mean ours; their parameters tune nothing here.
    void CheckAccelerator() {
        errors_.Try([&] {
            const PluginEntity& entity = d_.accelerator;
            const std::vector<std::string>& known = AcceleratorNames();
            if (std::find(known.begin(), known.end(), entity.type) == known.end())
                UnknownPlugin("accelerator", entity.type, entity.loc, known);
            const Params params = MakeParams(entity, "accelerator", d_.FilesOf(entity));
            params.Ignore("string", "splitmethod");
            for (const char* name :
                 {"maxnodeprims", "intersectcost", "traversalcost", "maxprims", "maxdepth"})
                params.Ignore("integer", name);
            params.Ignore("float", "emptybonus");
            params.CheckAllUsed();
        });
    }

    void MakeSampler() {
        errors_.Try([&] {
            const std::optional<int> mutations = MutationsPerPixel();
            PluginEntity entity = d_.sampler;
            if (mutations) MakeIndependent(&entity);
            std::optional<int> samples = options_.samplesPerPixel;
            if (!samples) samples = mutations;
            Create<SamplerKind>(entity, [&](auto factory, const Params& params) {
                SamplerArgs args{params, parts_.resolution, samples, setup_.options.seed, observer_};
                setup_.sampler = factory(args);
                setup_.samplesPerPixel = setup_.sampler->SamplesPerPixel();
                if (options_.maxTimes > 1) {
                    args.observer = nullptr;
                    const int64_t most = int64_t(setup_.samplesPerPixel) * options_.maxTimes;
                    args.samplesPerPixel = std::max(setup_.samplesPerPixel, int(std::min(most, kMaxSamples)));
                    setup_.longSampler = factory(args);
                }
                const int seed = setup_.options.seed;
                setup_.generatorSeed =
                    params.Has("seed") ? int(Hash(seed, params.GetInt("seed", seed)) >> 33) : seed;
            });
        });
    }

    /// Samples per pixel that the integrator asks for; empty: those of the sampler.
    std::optional<int> MutationsPerPixel() const {
        const auto read = Registry<IntegratorKind>::TraitsOf(d_.integrator.type).mutationsPerPixel;
        if (!read) return std::nullopt;
        return read(MakeParams(d_.integrator, IntegratorKind::kKind, d_.FilesOf(d_.integrator)));
    }
    /// Of a sampler whose points no path gets, the seed is left. Its name must be one all the same.
    static void MakeIndependent(PluginEntity* sampler) {
        FactoryOf<SamplerKind>(*sampler);
        sampler->type = "independent";
        std::erase_if(sampler->parameters, [](const Parameter& p) { return p.name != "seed"; });
    }

    void MakeIntegrator() {
        const bool filtering = !setup_.options.disableTextureFiltering;
        setup_.plannedSamples = options_.filterSamples.value_or(setup_.samplesPerPixel);
        const float scale = filtering ? std::max(0.125f, 1 / std::sqrt(float(setup_.plannedSamples))) : 0.f;
        Create<IntegratorKind>(d_.integrator, [&](auto factory, const Params& params) {
            setup_.integrator = factory({params, *setup_.scene, scale, observer_});
        });
        if (setup_.scene->HasMedia() && !setup_.integrator->RendersMedia())
            Warn(d_.integrator.loc,
                 fmt::format("integrator \"{}\" renders the media of this scene as vacuum; "
                             "\"volpath\" renders them",
                             d_.integrator.type));
    }

    SceneDescription d_;
    const BuildOptions& options_;
    Observer* observer_;
    ErrorCollector errors_;
    AttributeReads attributeReads_;
    Transform renderFromWorld_;
    std::shared_ptr<TextureStore> textures_;
    std::map<std::string, const Material*> named_;
    std::vector<const Material*> unnamed_;
    std::shared_ptr<const MatteCounterparts> matte_;  ///< null unless all is forced to be diffuse
    NamedMedia media_;
    std::set<std::pair<const Material*, std::string>> warnedOfEmission_;
    std::set<int> usedEmitters_;  ///< indices of d_.areaLights that some shape has taken
    UniqueNames objectNames_, materialNames_;
    int numObjects_ = 0;
    SceneParts parts_;
    RenderSetup setup_;
};

}  // namespace

const std::vector<std::string>& AcceleratorNames() {
    static const std::vector<std::string> names = {"bvh", "kdtree"};
    return names;
}

RenderSetup BuildScene(SceneDescription description, const BuildOptions& options, Observer* observer) {
    return Builder(std::move(description), options, observer).Build();
}

MaterialSetup BuildMaterial(SceneDescription description, const std::string& name,
                            const BuildOptions& options, Observer* observer) {
    return Builder(std::move(description), options, observer).BuildOneMaterial(name);
}

}  // namespace lacquer
