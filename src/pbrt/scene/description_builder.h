// The meaning of directives: graphics state in, entities of a scene description out.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "pbrt/scene/description.h"
#include "pbrt/scene/graphics_state.h"
#include "pbrt/scene/parse_log.h"

namespace lacquer {

/// What a scene's files and the files that they import have in common.
struct ParseContext {
    SceneDescription& scene;
    ParseLog& log;
    /// Names that shapes, lights and instances use, with the place of the first use.
    std::map<std::string, FileLoc> usedMaterials, usedMedia, usedObjects;
    /// Names that a directive has tried to define, also where that failed.
    std::set<std::string> declaredMaterials, declaredMedia, declaredObjects;
    int directory = 0;  ///< of the top-level file
};

/// Carries out directives whose arguments have been read. One builder for all top-level files, and one for
/// each imported file, which fills a description of its own until the importing file ends. Errors: SceneError
/// at the directive, after which the state is as before it; ParsingStops for scopes without end.
class DescriptionBuilder {
  public:
    explicit DescriptionBuilder(ParseContext& context) : context_(context), out_(context.scene) {}
    /// For a file imported by `importer`: a copy of its state; its coordinate systems are not visible.
    DescriptionBuilder(DescriptionBuilder& importer, SceneDescription& out);

    bool InWorld() const { return inWorld_; }
    bool InObject() const { return Object() != nullptr; }
    const ColorSpace* CurrentColorSpace() const { return state_.colorSpace; }

    // Options block.
    void Camera(PluginEntity entity);
    void Film(PluginEntity entity) { context_.scene.film = std::move(entity); }
    void Sampler(PluginEntity entity) { context_.scene.sampler = std::move(entity); }
    void PixelFilter(PluginEntity entity) { context_.scene.filter = std::move(entity); }
    void Integrator(PluginEntity entity) { context_.scene.integrator = std::move(entity); }
    void Accelerator(PluginEntity entity) { context_.scene.accelerator = std::move(entity); }
    void TransformTimes(float start, float end, const FileLoc& loc);
    void WorldBegin();

    // Transforms.
    void SetTransform(const Transform& m, const FileLoc& loc);
    void ConcatTransform(const Transform& m, const FileLoc& loc);
    void CoordinateSystem(const std::string& name) { systems_[name] = state_.ctm; }
    void CoordSysTransform(const std::string& name, const FileLoc& loc);
    void ActiveTransform(bool start, bool end);

    // Scopes and state.
    void AttributeBegin(const FileLoc& loc) { Push(Scope::Attribute, loc); }
    void AttributeEnd(const FileLoc& loc) { Pop(Scope::Attribute, loc); }
    void ObjectBegin(const std::string& name, const FileLoc& loc);
    void ObjectEnd(const FileLoc& loc);
    void ObjectInstance(const std::string& name, const FileLoc& loc);
    void ReverseOrientation() { state_.reverseOrientation = !state_.reverseOrientation; }
    void Attribute(AttributeTarget target, std::vector<Parameter> parameters);
    void SetColorSpace(const std::string& name, const FileLoc& loc);
    void MediumInterface(const std::string& inside, const std::string& outside, const FileLoc& loc);
    void NamedMaterial(const std::string& name, const FileLoc& loc);

    // Entities.
    void Texture(const std::string& name, bool isSpectrum, PluginEntity entity);
    void Material(PluginEntity entity);
    void MakeNamedMaterial(const std::string& name, PluginEntity entity);
    void MakeNamedMedium(const std::string& name, PluginEntity entity);
    void LightSource(PluginEntity entity);
    void AreaLightSource(PluginEntity entity);
    void Shape(PluginEntity entity);

    /// A plugin's directive with the state that it inherits.
    PluginEntity MakeEntity(std::string type, const FileLoc& loc, std::vector<Parameter> parameters) const;
    /// A description that FinishFile() merges.
    SceneDescription& AddImport() { return imports_.emplace_back(); }
    /// Ends a file that is no part of another one: merges what it imported.
    void FinishFile();
    /// Ends the last file: reports scopes that are still open.
    void FinishScopes();
    /// Ends the scene: reports names that nothing defines.
    void CheckReferences() const;

  private:
    enum class Scope { Attribute, Object };
    struct Saved {
        Scope scope;
        FileLoc loc;
        GraphicsState state;
    };
    using Names = std::map<std::string, FileLoc>;

    static constexpr size_t kDeepestScope = 10000, kMaxAttributes = 1000;

    /// @param loc  of the directive that changes it
    void SetCtm(const TransformPair& ctm, const FileLoc& loc);
    /// For what uses the CTM. Errors: SceneError at `loc` if it has no inverse.
    void RequireInvertible(const FileLoc& loc) const;
    void Push(Scope scope, const FileLoc& loc);
    void Pop(Scope scope, const FileLoc& loc);
    /// Takes the parameter `string type` out of the entity, or its value from the attributes.
    void TakeType(const char* what, PluginEntity& entity) const;
    void ReplaceDeprecated(PluginEntity& material) const;
    void WarnIfAnimated(const char* what, const FileLoc& loc) const;
    void UseMedium(const std::string& name);
    void Merge(SceneDescription& import);
    ObjectDefinition* Object() const { return object_; }
    static void Define(Names& names, const char* what, const std::string& name, const FileLoc& loc);

    ParseContext& context_;
    SceneDescription& out_;
    GraphicsState state_;
    std::vector<Saved> scopes_;
    std::map<std::string, TransformPair> systems_;
    std::deque<SceneDescription> imports_;
    Names floatTextures_, spectrumTextures_, materials_, media_, objects_;
    ObjectDefinition ownObject_;
    ObjectDefinition* object_ = nullptr;  // the definition in progress; may be the importer's
    bool inWorld_ = false;
};

}  // namespace lacquer
