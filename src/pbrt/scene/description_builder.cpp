#include "pbrt/scene/description_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace lacquer {

DescriptionBuilder::DescriptionBuilder(DescriptionBuilder& importer, SceneDescription& out)
    : context_(importer.context_),
      out_(out),
      state_(importer.state_),
      object_(importer.object_),
      inWorld_(true) {
    // The default material that a fresh description has belongs to the scene only.
    out_.materials.clear();
}

PluginEntity DescriptionBuilder::MakeEntity(std::string type, const FileLoc& loc,
                                            std::vector<Parameter> parameters) const {
    PluginEntity entity;
    entity.type = std::move(type);
    entity.loc = loc;
    entity.parameters = std::move(parameters);
    entity.colorSpace = state_.colorSpace;
    entity.directory = context_.directory;
    return entity;
}

void DescriptionBuilder::Camera(PluginEntity entity) {
    RequireInvertible(entity.loc);
    CameraEntity camera{std::move(entity), state_.ctm, context_.scene.startTime, context_.scene.endTime,
                        state_.outsideMedium};
    if (camera.cameraFromWorld.start.HasScale())
        context_.log.Warn(camera.loc,
                          "the camera's transform scales lengths; lens radius and focus follow it");
    systems_["camera"] = {state_.ctm.start.Inverse(), state_.ctm.end.Inverse()};
    UseMedium(camera.medium);
    context_.scene.camera = std::move(camera);
}

void DescriptionBuilder::TransformTimes(float start, float end, const FileLoc& loc) {
    if (!(start < end))
        throw SceneError(loc,
                         fmt::format("TransformTimes: the start {} must come before the end {}", start, end));
    context_.scene.startTime = start;
    context_.scene.endTime = end;
}

void DescriptionBuilder::WorldBegin() {
    inWorld_ = true;
    state_.ctm = {};
    state_.singularSince.reset();
    ActiveTransform(true, true);
    systems_["world"] = state_.ctm;
}

// Real scenes have singular transforms with nothing under them, so the error waits for something that needs
// the inverse.
void DescriptionBuilder::SetCtm(const TransformPair& ctm, const FileLoc& loc) {
    state_.ctm = ctm;
    if (!ctm.start.IsSingular() && !ctm.end.IsSingular())
        state_.singularSince.reset();
    else if (!state_.singularSince)
        state_.singularSince = loc;
}

void DescriptionBuilder::RequireInvertible(const FileLoc& loc) const {
    if (state_.singularSince)
        throw SceneError(loc, fmt::format("the transform here is singular since {}: it has no inverse within "
                                          "the range of floats",
                                          state_.singularSince->ToString()));
}

void DescriptionBuilder::SetTransform(const Transform& m, const FileLoc& loc) {
    TransformPair next = state_.ctm;
    if (state_.startActive) next.start = m;
    if (state_.endActive) next.end = m;
    state_.singularSince.reset();
    SetCtm(next, loc);
}

void DescriptionBuilder::ConcatTransform(const Transform& m, const FileLoc& loc) {
    TransformPair next = state_.ctm;
    if (state_.startActive) next.start = next.start * m;
    if (state_.endActive) next.end = next.end * m;
    SetCtm(next, loc);
}

void DescriptionBuilder::CoordSysTransform(const std::string& name, const FileLoc& loc) {
    const auto found = systems_.find(name);
    if (found != systems_.end()) {
        SetCtm(found->second, loc);
        return;
    }
    std::vector<std::string> names;
    for (const auto& [known, pair] : systems_) names.push_back(known);
    context_.log.Warn(loc, fmt::format("there is no coordinate system \"{}\"; the transform stays as it is{}",
                                       Excerpt(name), DidYouMean(name, names)));
}

void DescriptionBuilder::ActiveTransform(bool start, bool end) {
    state_.startActive = start;
    state_.endActive = end;
}

void DescriptionBuilder::Push(Scope scope, const FileLoc& loc) {
    if (scopes_.size() >= kDeepestScope)
        context_.log.Fatal(loc, fmt::format("more than {} nested AttributeBegin", kDeepestScope));
    scopes_.push_back({scope, loc, state_});
}

void DescriptionBuilder::Pop(Scope scope, const FileLoc& loc) {
    const char* end = scope == Scope::Attribute ? "AttributeEnd" : "ObjectEnd";
    const char* begin = scope == Scope::Attribute ? "AttributeBegin" : "ObjectBegin";
    if (scopes_.empty()) throw SceneError(loc, fmt::format("{} without {}", end, begin));
    const Saved& saved = scopes_.back();
    if (saved.scope != scope)
        throw SceneError(loc, fmt::format("{} does not match the {} at {}", end,
                                          scope == Scope::Attribute ? "ObjectBegin" : "AttributeBegin",
                                          saved.loc.ToString()));
    state_ = saved.state;
    scopes_.pop_back();
}

void DescriptionBuilder::ObjectBegin(const std::string& name, const FileLoc& loc) {
    if (Object())
        throw SceneError(
            loc, fmt::format("ObjectBegin inside of the definition of \"{}\" at {}; objects do not nest",
                             Excerpt(Object()->name), Object()->loc.ToString()));
    Push(Scope::Object, loc);
    ownObject_ = {name, loc, {}};
    object_ = &ownObject_;
    context_.declaredObjects.insert(name);
}

void DescriptionBuilder::ObjectEnd(const FileLoc& loc) {
    if (Object() != &ownObject_) throw SceneError(loc, "ObjectEnd without ObjectBegin");
    Pop(Scope::Object, loc);
    object_ = nullptr;
    Define(objects_, "object", ownObject_.name, ownObject_.loc);
    out_.objects.push_back(std::move(ownObject_));
}

void DescriptionBuilder::ObjectInstance(const std::string& name, const FileLoc& loc) {
    if (Object())
        throw SceneError(loc, fmt::format("ObjectInstance inside of the definition of \"{}\" at {}",
                                          Excerpt(Object()->name), Object()->loc.ToString()));
    RequireInvertible(loc);
    context_.usedObjects.emplace(name, loc);
    out_.instances.push_back({name, loc, state_.ctm});
}

// A newer parameter takes the place of an older one of the same type and name, so lists stay short.
void DescriptionBuilder::Attribute(AttributeTarget target, std::vector<Parameter> parameters) {
    AttributeList& list = state_.attributes[size_t(target)];
    std::vector<Parameter> all = list ? *list : std::vector<Parameter>();
    for (Parameter& p : parameters) {
        p.fromAttribute = true;
        std::erase_if(all, [&](const Parameter& old) { return old.type == p.type && old.name == p.name; });
        if (all.size() >= kMaxAttributes)
            throw SceneError(p.loc, fmt::format("more than {} parameters by Attribute", kMaxAttributes));
        all.push_back(std::move(p));
    }
    list = std::make_shared<const std::vector<Parameter>>(std::move(all));
}

void DescriptionBuilder::SetColorSpace(const std::string& name, const FileLoc& loc) {
    const lacquer::ColorSpace* space = lacquer::ColorSpace::Find(name);
    if (!space)
        throw SceneError(loc, fmt::format("unknown colour space \"{}\"{}", Excerpt(name),
                                          DidYouMean(name, lacquer::ColorSpace::Names())));
    state_.colorSpace = space;
}

void DescriptionBuilder::MediumInterface(const std::string& inside, const std::string& outside,
                                         const FileLoc& loc) {
    state_.insideMedium = inside;
    state_.outsideMedium = outside;
    state_.mediumLoc = loc;
}

void DescriptionBuilder::NamedMaterial(const std::string& name, const FileLoc& loc) {
    state_.material = {0, name};
    state_.materialLoc = loc;
}

void DescriptionBuilder::UseMedium(const std::string& name) {
    if (!name.empty()) context_.usedMedia.emplace(name, state_.mediumLoc);
}

void DescriptionBuilder::WarnIfAnimated(const char* what, const FileLoc& loc) const {
    if (state_.ctm.IsAnimated())
        context_.log.Warn(loc, fmt::format("{} cannot move; the transform at the start is used", what));
}

void DescriptionBuilder::TakeType(const char* what, PluginEntity& entity) const {
    const auto isType = [](const Parameter& p) {
        return p.type == "string" && p.name == "type" && p.strings.size() == 1;
    };
    const auto take = [&](const std::vector<Parameter>& parameters) {
        const auto found = std::find_if(parameters.rbegin(), parameters.rend(), isType);
        if (found == parameters.rend()) return false;
        entity.type = found->strings[0];
        return true;
    };
    if (!take(entity.parameters) && !(entity.attributes && take(*entity.attributes)))
        throw SceneError(entity.loc,
                         fmt::format("{} needs a parameter \"string type\" with one value", what));
    std::erase_if(entity.parameters, isType);
}

void DescriptionBuilder::ReplaceDeprecated(PluginEntity& material) const {
    if (!material.type.empty() && material.type != "none") return;
    context_.log.Warn(material.loc,
                      fmt::format("the material \"{}\" is deprecated; use \"interface\"", material.type));
    material.type = "interface";
}

void DescriptionBuilder::Define(Names& names, const char* what, const std::string& name, const FileLoc& loc) {
    const auto [first, isNew] = names.emplace(name, loc);
    if (!isNew)
        throw SceneError(loc, fmt::format("{} \"{}\" is already defined at {}", what, Excerpt(name),
                                          first->second.ToString()));
}

void DescriptionBuilder::Texture(const std::string& name, bool isSpectrum, PluginEntity entity) {
    entity.attributes = state_.AttributesOf(AttributeTarget::Texture);
    WarnIfAnimated("a texture", entity.loc);
    Define(isSpectrum ? spectrumTextures_ : floatTextures_, isSpectrum ? "spectrum texture" : "float texture",
           name, entity.loc);
    out_.textures.push_back({std::move(entity), name, isSpectrum, state_.ctm.start});
}

void DescriptionBuilder::Material(PluginEntity entity) {
    entity.attributes = state_.AttributesOf(AttributeTarget::Material);
    ReplaceDeprecated(entity);
    state_.material = {int(context_.scene.materials.size()), {}};
    context_.scene.materials.push_back({std::move(entity), {}});
}

void DescriptionBuilder::MakeNamedMaterial(const std::string& name, PluginEntity entity) {
    entity.attributes = state_.AttributesOf(AttributeTarget::Material);
    TakeType("MakeNamedMaterial", entity);
    ReplaceDeprecated(entity);
    Define(materials_, "material", name, entity.loc);
    out_.namedMaterials.push_back({std::move(entity), name});
}

void DescriptionBuilder::MakeNamedMedium(const std::string& name, PluginEntity entity) {
    entity.attributes = state_.AttributesOf(AttributeTarget::Medium);
    TakeType("MakeNamedMedium", entity);
    WarnIfAnimated("a medium", entity.loc);
    Define(media_, "medium", name, entity.loc);
    out_.media.push_back({std::move(entity), name, state_.ctm.start});
}

void DescriptionBuilder::LightSource(PluginEntity entity) {
    entity.attributes = state_.AttributesOf(AttributeTarget::Light);
    WarnIfAnimated("a light", entity.loc);
    UseMedium(state_.outsideMedium);
    out_.lights.push_back({std::move(entity), state_.ctm.start, state_.outsideMedium});
}

void DescriptionBuilder::AreaLightSource(PluginEntity entity) {
    entity.attributes = state_.AttributesOf(AttributeTarget::Light);
    state_.areaLight = int(context_.scene.areaLights.size());
    context_.scene.areaLights.push_back(std::move(entity));
}

void DescriptionBuilder::Shape(PluginEntity entity) {
    RequireInvertible(entity.loc);
    entity.attributes = state_.AttributesOf(AttributeTarget::Shape);
    int areaLight = state_.areaLight;
    if (areaLight >= 0 && InObject()) {
        context_.log.Warn(entity.loc, "shapes in object definitions cannot be area lights; they do not emit");
        areaLight = -1;
    }
    if (areaLight >= 0 && state_.ctm.IsAnimated())
        throw SceneError(entity.loc, "a moving shape cannot be an area light");
    if (!state_.material.name.empty())
        context_.usedMaterials.emplace(state_.material.name, state_.materialLoc);
    UseMedium(state_.insideMedium);
    UseMedium(state_.outsideMedium);
    std::vector<ShapeEntity>& shapes = InObject() ? Object()->shapes : out_.shapes;
    shapes.push_back({std::move(entity), state_.ctm, state_.reverseOrientation, state_.material, areaLight,
                      state_.insideMedium, state_.outsideMedium});
}

void DescriptionBuilder::Merge(SceneDescription& import) {
    const auto tryDefine = [&](Names& names, const char* what, const std::string& name, const FileLoc& loc) {
        try {
            Define(names, what, name, loc);
        } catch (const SceneError& e) {
            context_.log.Error(e.Loc(), e.Message());
        }
    };
    for (const TextureEntity& t : import.textures)
        tryDefine(t.isSpectrum ? spectrumTextures_ : floatTextures_,
                  t.isSpectrum ? "spectrum texture" : "float texture", t.name, t.loc);
    for (const MaterialEntity& m : import.namedMaterials) tryDefine(materials_, "material", m.name, m.loc);
    for (const MediumEntity& m : import.media) tryDefine(media_, "medium", m.name, m.loc);
    for (const ObjectDefinition& o : import.objects) tryDefine(objects_, "object", o.name, o.loc);
    const auto append = [](auto& to, auto& from) {
        to.insert(to.end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
    };
    append(out_.textures, import.textures);
    append(out_.namedMaterials, import.namedMaterials);
    append(out_.media, import.media);
    append(out_.lights, import.lights);
    append(out_.shapes, import.shapes);
    append(out_.objects, import.objects);
    append(out_.instances, import.instances);
}

void DescriptionBuilder::FinishFile() {
    for (SceneDescription& import : imports_) Merge(import);
    imports_.clear();
    if (&out_ == &context_.scene) out_.coordinateSystems = systems_;
}

void DescriptionBuilder::FinishScopes() {
    for (const Saved& saved : scopes_)
        context_.log.Error(saved.loc, saved.scope == Scope::Attribute ? "AttributeBegin is never closed"
                                                                      : "ObjectBegin is never closed");
}

void DescriptionBuilder::CheckReferences() const {
    const auto check = [&](const char* what, const Names& used, const Names& defined,
                           const std::set<std::string>& declared) {
        std::vector<std::string> names;
        for (const auto& [name, loc] : defined) names.push_back(name);
        for (const auto& [name, loc] : used)
            if (!defined.contains(name) && !declared.contains(name))
                context_.log.Error(loc, fmt::format("{} \"{}\" is not defined{}", what, Excerpt(name),
                                                    DidYouMean(name, names)));
    };
    check("material", context_.usedMaterials, materials_, context_.declaredMaterials);
    check("medium", context_.usedMedia, media_, context_.declaredMedia);
    check("object", context_.usedObjects, objects_, context_.declaredObjects);
}

}  // namespace lacquer
