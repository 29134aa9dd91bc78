// Typed parameters of one directive of a scene file.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pbrt/core/color_space.h"
#include "pbrt/core/error.h"
#include "pbrt/core/vec.h"

namespace lacquer {

/// "type name" [values] as it stands in the file.
struct Parameter {
    enum class Values { Floats, Integers, Strings, Bools };

    std::string type, name;
    FileLoc loc;
    Values kind = Values::Floats;
    std::vector<float> floats;
    std::vector<int> integers;
    std::vector<std::string> strings;
    std::vector<unsigned char> bools;
    const ColorSpace* colorSpace = nullptr;  ///< the one in force where the parameter stands
    bool fromAttribute = false;              ///< inherited by an Attribute directive: may stay unused
    mutable bool lookedUp = false;
};

/// Finds files that a scene names.
class FileResolver {
  public:
    FileResolver() = default;
    /// @param directory  of the top-level scene file; empty for standard input
    explicit FileResolver(std::string directory) : directory_(std::move(directory)) {}
    /// `path` below the scene's directory if a file is there, in its shortest form; else as it is written.
    std::string Resolve(const std::string& path) const;

  private:
    std::string directory_;
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
    const FileResolver& Files() const { return files_; }
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
    /// Throws the diagnostics above if there are any.
    void CheckAllUsed() const;

  private:
    const Parameter* Find(std::string_view type, std::string_view name) const;
    const Parameter* FindScalar(std::string_view type, std::string_view name, size_t components) const;
    const Parameter* FindArray(std::string_view type, std::string_view name, size_t components) const;
    std::vector<Vec3> Triples(std::string_view type, std::string_view name) const;

    std::string owner_;
    FileLoc loc_;
    std::vector<Parameter> parameters_;
    const lacquer::ColorSpace* colorSpace_ = nullptr;
    FileResolver files_;
    mutable std::vector<std::pair<std::string, std::string>> asked_;  // (type, name)
};

}  // namespace lacquer
