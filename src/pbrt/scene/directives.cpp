// What each directive does once its arguments have been read, and the table of all of them.
#include "pbrt/scene/directive.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "pbrt/scene/file_parser.h"
#include "pbrt/scene/parameter_list.h"
#include "pbrt/scene/v3.h"

namespace lacquer {

namespace {

/// Has names for itself that are those of other things in the scene.
namespace table {

using Arguments = DirectiveArguments;

Vec3 Triple(const Arguments& a, size_t first) {
    return {a.numbers[first], a.numbers[first + 1], a.numbers[first + 2]};
}

// Column by column, as GLM stores it.
Transform MatrixOf(const Arguments& a) {
    glm::mat4 m;
    for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = a.numbers[size_t(i)];
    return Transform(m);
}

// ---- Directives of which the builder has a function ----

template <void (DescriptionBuilder::*method)(PluginEntity)>
void Make(FileParser& p, Arguments& a) {
    (p.Builder().*method)(p.Entity(std::move(a.texts[0]), a));
}
template <void (DescriptionBuilder::*method)(const FileLoc&)>
void Plain(FileParser& p, Arguments&) {
    (p.Builder().*method)(p.Loc());
}
template <void (DescriptionBuilder::*method)(const std::string&, const FileLoc&)>
void Named(FileParser& p, Arguments& a) {
    (p.Builder().*method)(a.texts[0], p.Loc());
}

// ---- The others ----

void ActiveTransform(FileParser& p, Arguments& a) {
    p.Builder().ActiveTransform(a.texts[0] != "EndTime", a.texts[0] != "StartTime");
}

void Attribute(FileParser& p, Arguments& a) {
    const std::string& target = a.texts[0];
    const auto found = std::find(kAttributeTargets.begin(), kAttributeTargets.end(), target);
    if (found == kAttributeTargets.end()) {
        const std::vector<std::string> names(kAttributeTargets.begin(), kAttributeTargets.end());
        throw SceneError(
            p.Loc(), fmt::format("Attribute: unknown target \"{}\"; known are shape, light, material, medium "
                                 "and texture{}",
                                 Excerpt(target), DidYouMean(target, names)));
    }
    p.Builder().Attribute(AttributeTarget(found - kAttributeTargets.begin()), std::move(a.parameters));
}

void ConcatTransform(FileParser& p, Arguments& a) { p.Builder().ConcatTransform(MatrixOf(a), p.Loc()); }
void CoordinateSystem(FileParser& p, Arguments& a) { p.Builder().CoordinateSystem(a.texts[0]); }
void Identity(FileParser& p, Arguments&) { p.Builder().SetTransform({}, p.Loc()); }
void Import(FileParser& p, Arguments& a) { p.Import(a.texts[0]); }
void Include(FileParser& p, Arguments& a) { p.Include(a.texts[0]); }

void LookAt(FileParser& p, Arguments& a) {
    bool isValid = false;
    const Transform cameraFromWorld = Transform::LookAt(Triple(a, 0), Triple(a, 3), Triple(a, 6), &isValid);
    if (!isValid)
        throw SceneError(
            p.Loc(),
            "LookAt: the eye and the point looked at must differ, and up must not be parallel to "
            "the view direction");
    p.Builder().ConcatTransform(cameraFromWorld, p.Loc());
}

void MakeNamedMaterial(FileParser& p, Arguments& a) {
    p.Builder().MakeNamedMaterial(a.texts[0], p.Entity({}, a));
}

void MakeNamedMedium(FileParser& p, Arguments& a) {
    p.Builder().MakeNamedMedium(a.texts[0], p.Entity({}, a));
}

void MediumInterface(FileParser& p, Arguments& a) {
    p.Builder().MediumInterface(a.texts[0], a.texts[1], p.Loc());
}

void Option(FileParser& p, Arguments& a) {
    SetOption(a.texts[0], a.value, p.Loc(), &p.Context().scene.options);
}

void ReverseOrientation(FileParser& p, Arguments&) { p.Builder().ReverseOrientation(); }

void Rotate(FileParser& p, Arguments& a) {
    p.Builder().ConcatTransform(Transform::Rotate(a.numbers[0], Triple(a, 1)), p.Loc());
}

void Scale(FileParser& p, Arguments& a) {
    p.Builder().ConcatTransform(Transform::Scale(Triple(a, 0)), p.Loc());
}

void SetTransform(FileParser& p, Arguments& a) { p.Builder().SetTransform(MatrixOf(a), p.Loc()); }

void Texture(FileParser& p, Arguments& a) {
    const std::string &name = a.texts[0], &valueType = a.texts[1];
    const bool isSpectrum = valueType == "spectrum";
    if (isSpectrum || valueType == "float")
        return p.Builder().Texture(name, isSpectrum, p.Entity(std::move(a.texts[2]), a));
    const auto advice = V3TextureType(valueType);
    if (!advice)
        throw SceneError(
            p.Loc(),
            fmt::format("texture \"{}\": the value type must be \"float\" or \"spectrum\", not \"{}\"",
                        Excerpt(name), Excerpt(valueType)));
    p.Log().V3(p.Loc(), fmt::format("the texture type \"{}\"", valueType), *advice);
}

void TransformBegin(FileParser& p, Arguments&) {
    p.Log().Warn(p.Loc(),
                 "TransformBegin and TransformEnd are deprecated, and mean AttributeBegin and AttributeEnd");
    p.Builder().AttributeBegin(p.Loc());
}

void TransformTimes(FileParser& p, Arguments& a) {
    p.Builder().TransformTimes(a.numbers[0], a.numbers[1], p.Loc());
}

void Translate(FileParser& p, Arguments& a) {
    p.Builder().ConcatTransform(Transform::Translate(Triple(a, 0)), p.Loc());
}

void WorldBegin(FileParser& p, Arguments&) { p.Builder().WorldBegin(); }

// ---- The table ----

using enum Argument;
using W = Directive::Where;
using S = Directive::Scope;
constexpr const char* kItIsIntegrator = "it is Integrator";
constexpr const char* kItIsMedium = "it is MakeNamedMedium with MediumInterface";

/// A directive of pbrt-v3 only.
constexpr Directive OfV3(std::string_view name, std::array<Argument, 4> arguments, const char* advice) {
    return {name, W::Anywhere, arguments, nullptr, S::None, nullptr, advice};
}

/// Sorted by name.
constexpr Directive kDirectives[] = {
    // name, where it may stand, arguments, what it does, scope, plugin if not its name; pbrt-v3: advice,
    // successor
    {"Accelerator", W::Options, {Type, Parameters}, Make<&DescriptionBuilder::Accelerator>},
    {"ActiveTransform", W::Anywhere, {Times}, ActiveTransform},
    {"AreaLightSource", W::World, {Type, Parameters}, Make<&DescriptionBuilder::AreaLightSource>},
    {"Attribute", W::Anywhere, {Target, Parameters}, Attribute},
    {"AttributeBegin", W::World, {}, Plain<&DescriptionBuilder::AttributeBegin>, S::Opens},
    {"AttributeEnd", W::World, {}, Plain<&DescriptionBuilder::AttributeEnd>, S::Closes},
    {"Camera", W::Options, {Type, Parameters}, Make<&DescriptionBuilder::Camera>},
    {"ColorSpace", W::Anywhere, {Name}, Named<&DescriptionBuilder::SetColorSpace>},
    {"ConcatTransform", W::Anywhere, {Matrix}, ConcatTransform},
    {"CoordSysTransform", W::Anywhere, {Name}, Named<&DescriptionBuilder::CoordSysTransform>},
    {"CoordinateSystem", W::Anywhere, {Name}, CoordinateSystem},
    {"Film", W::Options, {Type, Parameters}, Make<&DescriptionBuilder::Film>},
    {"Identity", W::Anywhere, {}, Identity},
    {"Import", W::World, {File}, Import},
    {"Include", W::Anywhere, {File}, Include},
    {"Integrator", W::Options, {Type, Parameters}, Make<&DescriptionBuilder::Integrator>},
    {"LightSource", W::World, {Type, Parameters}, Make<&DescriptionBuilder::LightSource>},
    {"LookAt", W::Anywhere, {Vector, Vector, Vector}, LookAt},
    {"MakeNamedMaterial", W::World, {NewMaterial, Parameters}, MakeNamedMaterial, S::None, "Material"},
    {"MakeNamedMedium", W::Anywhere, {NewMedium, Parameters}, MakeNamedMedium, S::None, "Medium"},
    {"Material", W::World, {Type, Parameters}, Make<&DescriptionBuilder::Material>},
    {"MediumInterface", W::Anywhere, {Medium, OtherMedium}, MediumInterface},
    {"NamedMaterial", W::World, {Name}, Named<&DescriptionBuilder::NamedMaterial>},
    {"ObjectBegin", W::World, {Name}, Named<&DescriptionBuilder::ObjectBegin>, S::Opens},
    {"ObjectEnd", W::World, {}, Plain<&DescriptionBuilder::ObjectEnd>, S::Closes},
    {"ObjectInstance", W::World, {Name}, Named<&DescriptionBuilder::ObjectInstance>},
    {"Option", W::Anywhere, {Name, Value}, Option},
    {"PixelFilter", W::Options, {Type, Parameters}, Make<&DescriptionBuilder::PixelFilter>},
    OfV3("Renderer", {Type, Parameters}, kItIsIntegrator),
    {"ReverseOrientation", W::World, {}, ReverseOrientation},
    {"Rotate", W::Anywhere, {Number, Vector}, Rotate},
    {"Sampler", W::Options, {Type, Parameters}, Make<&DescriptionBuilder::Sampler>},
    {"Scale", W::Anywhere, {Vector}, Scale},
    {"Shape", W::World, {Type, Parameters}, Make<&DescriptionBuilder::Shape>},
    OfV3("SurfaceIntegrator", {Type, Parameters}, kItIsIntegrator),
    {"Texture", W::World, {Name, ValueType, Type, Parameters}, Texture},
    {"Transform", W::Anywhere, {Matrix}, SetTransform},
    {"TransformBegin", W::World, {}, TransformBegin, S::Opens, nullptr, nullptr, "AttributeBegin"},
    {"TransformEnd",
     W::World,
     {},
     Plain<&DescriptionBuilder::AttributeEnd>,
     S::Closes,
     nullptr,
     nullptr,
     "AttributeEnd"},
    {"TransformTimes", W::Options, {Number, Number}, TransformTimes},
    OfV3("TransformedMedium", {Type, Parameters}, kItIsMedium),
    {"Translate", W::Anywhere, {Vector}, Translate},
    OfV3("Volume", {Type, Parameters}, kItIsMedium),
    OfV3("VolumeIntegrator", {Type, Parameters}, "it is Integrator \"volpath\""),
    {"WorldBegin", W::Options, {}, WorldBegin},
    OfV3("WorldEnd", {}, "the world block ends with the file: remove the line"),
};
static_assert(std::is_sorted(std::begin(kDirectives), std::end(kDirectives),
                             [](const Directive& a, const Directive& b) { return a.name < b.name; }));

}  // namespace table
using table::kDirectives;

/// In the order of Argument.
constexpr ArgumentForm kForms[] = {
    {"nothing", 0},
    {"a name", 1, true},
    {"a name", 1, true},
    {"a name", 1, true},
    {"a type", 1, true},
    {"\"float\" or \"spectrum\"", 1, true},
    {"a target", 1, true},
    {"a medium", 1, true},
    {"a medium", 1, true, false, true},
    {"a file name", 1, true},
    {"All, StartTime or EndTime"},
    {"a value"},
    {"a number", 1, false, true},
    {"a number", 3, false, true},
    {"a number", 18, false, true, false, true},
    {"parameters", 0},
};
static_assert(std::size(kForms) == size_t(Argument::Parameters) + 1);

bool IsBracket(const ArgumentForm& form, size_t i) {
    return form.isBracketed && (i == 0 || i + 1 == form.numTokens);
}

}  // namespace

const ArgumentForm& FormOf(Argument argument) { return kForms[size_t(argument)]; }

float CheckToken(std::string_view directive, Argument argument, size_t i, const Token& token) {
    using Kind = Token::Kind;
    const ArgumentForm& form = FormOf(argument);
    const size_t numNumbers = form.numTokens - 2;  // of a list in brackets
    const auto fail = [&](const std::string& wanted) {
        throw SceneError(token.Loc(),
                         fmt::format("{}: expected {}, found {}", directive, wanted, token.Excerpt()));
    };
    const bool isString = token.kind == Kind::String, isWord = token.kind == Kind::Word;
    if (IsBracket(form, i)) {
        if (i == 0 && token.kind != Kind::Open) fail(fmt::format("[ and {} numbers", numNumbers));
        if (i > 0 && token.kind != Kind::Close) fail(fmt::format("] after {} numbers", numNumbers));
        return 0;
    }
    if (form.isString && !isString) fail(fmt::format("{} in quotes", form.wanted));
    if (argument == Argument::Value && !isString && !isWord) fail(form.wanted);
    const bool isTime = token.text == "All" || token.text == "StartTime" || token.text == "EndTime";
    if (argument == Argument::Times && !(isWord && isTime)) fail(form.wanted);
    if (!form.isNumber) return 0;
    if (form.isBracketed && token.kind == Kind::Close)
        throw SceneError(token.Loc(),
                         fmt::format("{}: a matrix has {} numbers, not {}", directive, numNumbers, i - 1));
    try {
        return ExpectFloat(token);
    } catch (const SceneError& e) {
        throw SceneError(e.Loc(), fmt::format("{}: {}", directive, e.Message()));
    }
}

void FailAtEnd(std::string_view directive, Argument argument, size_t i, const FileLoc& loc) {
    const ArgumentForm& form = FormOf(argument);
    const char* wanted = !IsBracket(form, i) ? form.wanted : i == 0 ? "[" : "]";
    throw SceneError(loc, fmt::format("{}: the file ends where {} is expected", directive, wanted));
}

bool Directive::Has(Argument argument) const {
    return std::find(arguments.begin(), arguments.end(), argument) != arguments.end();
}

std::string_view Directive::Plugin() const {
    if (plugin) return plugin;
    return Has(Argument::Type) ? name : std::string_view();
}

std::span<const Directive> Directives() { return kDirectives; }

const Directive* FindDirective(std::string_view name) {
    const auto* found = std::lower_bound(std::begin(kDirectives), std::end(kDirectives), name,
                                         [](const Directive& d, std::string_view n) { return d.name < n; });
    return found != std::end(kDirectives) && found->name == name ? found : nullptr;
}

std::vector<std::string> DirectiveNames() {
    std::vector<std::string> names;
    for (const Directive& d : kDirectives)
        if (d.run) names.emplace_back(d.name);
    return names;
}

}  // namespace lacquer
