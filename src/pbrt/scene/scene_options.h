// Options of a whole scene, which its Option directives and the command line both can set, in one table.
//
// Who wins, where a value is given in several places: the first that says it, of
//
//   the options of OptionTable(), as in pbrt-v4
//       Option directive, command line, default
//   image name, resolution and crop of the film; samples per pixel (FilmOverrides, BuildOptions)
//       command line, parameter of Film or Sampler, default
//   estimator and pdf of layered materials (MaterialOverrides)
//       command line, parameter of Material, default
//   any parameter of a plugin (Params)
//       its directive, Attribute directives, default
#pragma once

#include <bitset>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "pbrt/scene/lexer.h"

namespace lacquer {

/// The options in force; initially the defaults.
struct SceneOptions {
    bool disablePixelJitter = false, disableTextureFiltering = false, disableWavelengthJitter = false;
    bool forceDiffuse = false, pixelStats = false, wavefront = false;
    int seed = 0;
    float displacementEdgeScale = 1;
    std::string mseReferenceImage, mseReferenceOut;
    std::string renderCoordSys = "cameraworld";  ///< one of RenderSpaces()
};

/// Spaces in which a scene can be computed: "camera", "cameraworld", "world".
const std::vector<std::string>& RenderSpaces();

/// One option.
struct SceneOption {
    using Field = std::variant<bool SceneOptions::*, int SceneOptions::*, float SceneOptions::*,
                               std::string SceneOptions::*>;
    const char* name;         ///< of the directive, in lower case and without '-' and '_'
    const char* commandLine;  ///< the same on the command line; null: only files have it
    Field field;
    const char* help;
    bool changesImage = false;                               ///< what renders converge to is another image
    bool isPositive = false;                                 ///< numbers of 0 and below make no sense
    const std::vector<std::string>& (*choices)() = nullptr;  ///< the texts that it can be; null: any
    bool isFile = false;                                     ///< the text is a path
};
/// In alphabetical order.
std::span<const SceneOption> OptionTable();

/// The options that one source says something about, with their values.
class GivenOptions {
  public:
    template <class Value>
    void Set(Value SceneOptions::*field, Value value) {
        values_.*field = std::move(value);
        given_.set(IndexOf(field));
    }
    /// Of the options that are not given: the default.
    const SceneOptions& Values() const { return values_; }
    bool IsGiven(const SceneOption::Field& field) const { return given_[IndexOf(field)]; }

  private:
    static size_t IndexOf(const SceneOption::Field& field);

    SceneOptions values_;
    std::bitset<32> given_;
};

/// The options in force, by the first row of the table above.
SceneOptions Resolve(const GivenOptions& ofScene, const GivenOptions& ofCommandLine);

/// Sets the option `name` of an Option directive; case, '-' and '_' in it do not count.
/// Errors: SceneError for unknown names (at `loc`) and for values of the wrong kind (at the value).
void SetOption(const std::string& name, const Token& value, const FileLoc& loc, GivenOptions* options);

}  // namespace lacquer
