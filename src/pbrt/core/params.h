// Typed parameters of one directive of a scene file.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pbrt/core/parameter.h"
#include "pbrt/core/vec.h"

namespace lacquer {

/// A file that a parameter names and that the scene has read.
struct FileUse {
    std::string name;       ///< as it is written
    std::string path;       ///< where it was found
    std::string owner;      ///< Params::Owner(): `material "diffuse"`
    std::string parameter;  ///< its name: "filename"
    FileLoc loc;            ///< of the directive
    Int2 resolution{0};     ///< of an image that stays in memory; 0 for all else
    size_t bytes = 0;       ///< likewise
};

/// Finds files that a scene names.
class FileResolver {
  public:
    FileResolver() = default;
    /// @param directory  of the top-level scene file; empty for standard input
    explicit FileResolver(const std::string& directory) : directory_(directory) {}
    /// `path` below the scene's directory if a file is there, in its shortest form; else as it is written.
    std::string Resolve(const std::string& path) const;
    /// From now on this resolver and its copies add the files that are read to `uses`, which outlives them.
    void RecordIn(std::vector<FileUse>* uses) { uses_ = uses; }
    void Record(FileUse use) const {
        if (uses_) uses_->push_back(std::move(use));
    }

  private:
    FileName directory_;
    std::vector<FileUse>* uses_ = nullptr;
};

/// The parameters of one directive. Look-ups need the exact name and type and remember what was asked for, so
/// that CheckAllUsed() can say what is left over and what was meant. Errors: SceneError at the parameter's
/// place for wrong counts, kinds or values, among them every number that is not finite. Not thread-safe.
class Params {
  public:
    Params() = default;
    /// @param owner  what the directive makes, for messages: `material "diffuse"`
    Params(std::string owner, FileLoc loc, std::vector<Parameter> parameters, const ColorSpace* colorSpace,
           FileResolver files = {});

    const std::string& Owner() const { return owner_; }
    const FileLoc& Loc() const { return loc_; }
    const lacquer::ColorSpace& ColorSpace() const { return *colorSpace_; }
    const std::vector<Parameter>& All() const { return parameters_; }

    // Scalars: the value or the default; more or fewer values than one are an error.
    float GetFloat(std::string_view name, float fallback) const;
    int GetInt(std::string_view name, int fallback) const;
    bool GetBool(std::string_view name, bool fallback) const;
    std::string GetString(std::string_view name, std::string_view fallback) const;
    Vec2 GetPoint2(std::string_view name, Vec2 fallback) const;
    Vec3 GetPoint3(std::string_view name, Vec3 fallback) const;
    Vec3 GetVector3(std::string_view name, Vec3 fallback) const;
    std::optional<float> GetOptionalFloat(std::string_view name) const;
    std::optional<std::string> GetOptionalString(std::string_view name) const;
    /// An integer that must lie in [low, high].
    int GetIntInRange(std::string_view name, int fallback, int low, int high) const;
    /// A float in [low, high].
    float GetFloatInRange(std::string_view name, float fallback, float low, float high) const;
    /// One of `choices`; an error that names the nearest one otherwise.
    std::string GetChoice(std::string_view name, std::string_view fallback,
                          const std::vector<std::string>& choices) const;

    // Arrays: empty if absent; the count must be a multiple of the components.
    std::vector<float> GetFloats(std::string_view name) const;
    std::vector<int> GetInts(std::string_view name) const;
    std::vector<std::string> GetStrings(std::string_view name) const;
    std::vector<Vec2> GetPoint2s(std::string_view name) const;
    std::vector<Vec3> GetPoint3s(std::string_view name) const;
    std::vector<Vec3> GetVector3s(std::string_view name) const;
    std::vector<Vec3> GetNormals(std::string_view name) const;
    std::vector<RGB> GetRgbs(std::string_view name) const;

    /// Where the file is that `"string name"` names, which must be given. The only way in which plugins find
    /// files: what a scene reads is recorded (FileUse), and nobody else needs to know which parameters are
    /// files. Cost  recorded anew at each call.
    std::string PathOf(std::string_view name) const;
    /// Records the size of the image in that file, for those that stay in memory.
    void RecordImage(std::string_view name, Int2 resolution, size_t bytes) const;

    /// Name of the texture in `"texture name" "..."`, if given.
    std::optional<std::string> GetTextureName(std::string_view name) const;
    /// The spectrum given as rgb, blackbody or spectrum under `name`, or null if there is none.
    /// Errors: rgb outside its domain, odd or unordered inline samples, unknown names, unreadable files.
    std::unique_ptr<Spectrum> GetSpectrum(std::string_view name, SpectrumKind kind) const;
    /// The rgb triple of `"rgb name"` if the parameter is given in that form.
    std::optional<RGB> GetRgb(std::string_view name) const;
    /// True if any parameter called `name` is there, whatever its type; marks nothing.
    bool Has(std::string_view name) const;
    /// Place of the parameter `name`, or of the directive if it is not there.
    FileLoc LocOf(std::string_view name) const;
    /// SceneError at LocOf(name).
    [[noreturn]] void Fail(std::string_view name, const std::string& message) const;

    /// Says that `type name` is understood though it was not asked for (a parameter without effect here).
    void Ignore(std::string_view type, std::string_view name) const;
    /// Every parameter of the directive itself that was never looked up: what it might have meant.
    /// Parameters inherited by Attribute, and earlier duplicates, are left out.
    std::vector<Diagnostic> UnusedParameters() const;
    /// The same, as warnings, of the parameters inherited by Attribute.
    std::vector<Diagnostic> UnusedAttributes() const;
    /// True if any parameter is inherited by Attribute.
    bool HasAttributes() const;
    /// Throws the diagnostics above if there are any.
    void CheckAllUsed() const;

  private:
    const Parameter* Find(std::string_view type, std::string_view name) const;
    /// One element, or any number of them.
    const Parameter* FindScalar(std::string_view type, std::string_view name) const;
    const Parameter* FindArray(std::string_view type, std::string_view name) const;
    FileUse UseOf(std::string_view name, const std::string& written) const;
    std::string WhyUnused(const Parameter& p) const;
    std::vector<Vec3> Triples(std::string_view type, std::string_view name) const;

    std::string owner_;
    FileLoc loc_;
    std::vector<Parameter> parameters_;
    const lacquer::ColorSpace* colorSpace_ = nullptr;
    FileResolver files_;
    mutable std::vector<std::pair<std::string, std::string>> asked_;  // (type, name)
};

}  // namespace lacquer
