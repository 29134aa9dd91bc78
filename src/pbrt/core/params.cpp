#include "pbrt/core/params.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace lacquer {

namespace {

constexpr std::string_view kSpectrumTypes[] = {"rgb", "blackbody", "spectrum"};

// What every look-up demands of values: the kind that the declared type has, and finite numbers.
void RequireSound(const Parameter& p) {
    const ParameterType* type = FindParameterType(p.type);
    if (type && p.kind != type->values)
        throw SceneError(p.loc, fmt::format("{} needs {}", p.Quoted(), InWords(type->values).many));
    for (size_t i = 0; i < p.floats.size(); ++i)
        if (!std::isfinite(p.floats[i]))
            throw SceneError(p.loc, fmt::format("{} has a value that is not finite: {} (number {} of {})",
                                                p.Quoted(), p.floats[i], i + 1, p.floats.size()));
}

// Values that one element of a parameter's type has.
size_t ComponentsOf(const Parameter& p) {
    const ParameterType* type = FindParameterType(p.type);
    return type ? type->components : 1;
}

// "a", "b" or "c".
std::string Alternatives(const std::vector<std::string>& words) {
    std::string text;
    for (size_t i = 0; i < words.size(); ++i) {
        if (i > 0) text += i + 1 == words.size() ? " or " : ", ";
        text += fmt::format("\"{}\"", words[i]);
    }
    return text;
}

std::unique_ptr<Spectrum> SpectrumOfRgb(const Parameter& p, SpectrumKind kind, const ColorSpace& fallback) {
    RequireSound(p);
    if (p.floats.size() != 3)
        throw SceneError(p.loc, fmt::format("{} needs 3 values, has {}", p.Quoted(), p.floats.size()));
    for (const float c : p.floats) {
        if (c < 0) throw SceneError(p.loc, fmt::format("{}: {} is negative", p.Quoted(), c));
        if (kind == SpectrumKind::Albedo && c > 1)
            throw SceneError(
                p.loc, fmt::format("{}: {} is outside of [0, 1], the range of a reflectance or transmittance",
                                   p.Quoted(), c));
    }
    const ColorSpace& space = p.colorSpace ? *p.colorSpace : fallback;
    return space.MakeSpectrum({p.floats[0], p.floats[1], p.floats[2]}, kind);
}

// The range keeps Planck's law and its maximum inside of what a float holds.
std::unique_ptr<Spectrum> SpectrumOfBlackbody(const Parameter& p) {
    constexpr float kColdest = 1, kHottest = 1e8f;
    RequireSound(p);
    if (p.floats.size() != 1)
        throw SceneError(p.loc, fmt::format("{} needs 1 value, has {}", p.Quoted(), p.floats.size()));
    const float kelvin = p.floats[0];
    if (!(kelvin > 0))
        throw SceneError(p.loc, fmt::format("{}: the temperature must be positive", p.Quoted()));
    if (!(kelvin >= kColdest && kelvin <= kHottest))
        throw SceneError(p.loc,
                         fmt::format("{}: the temperature must lie between 1 K and 1e8 K", p.Quoted()));
    return std::make_unique<BlackbodySpectrum>(kelvin);
}

std::unique_ptr<Spectrum> SpectrumOfSamples(const Parameter& p) {
    RequireSound(p);
    if (p.floats.empty()) throw SceneError(p.loc, fmt::format("{} has no values", p.Quoted()));
    if (p.floats.size() % 2 != 0)
        throw SceneError(p.loc, fmt::format("{} needs pairs of wavelength and value, has {} numbers",
                                            p.Quoted(), p.floats.size()));
    std::vector<float> lambda, values;
    for (size_t i = 0; i < p.floats.size(); i += 2) {
        const float nm = p.floats[i], value = p.floats[i + 1];
        if (nm <= 0)
            throw SceneError(p.loc, fmt::format("{}: the wavelength {} is not positive", p.Quoted(), nm));
        if (!lambda.empty() && nm <= lambda.back())
            throw SceneError(p.loc, fmt::format("{}: wavelengths must increase, but {} follows {}",
                                                p.Quoted(), nm, lambda.back()));
        if (value < 0)
            throw SceneError(p.loc,
                             fmt::format("{}: the value {} at {} nm is negative", p.Quoted(), value, nm));
        lambda.push_back(nm);
        values.push_back(value);
    }
    return std::make_unique<PiecewiseLinearSpectrum>(std::move(lambda), std::move(values));
}

bool LooksLikePath(const std::string& name) { return name.find_first_of("./") != std::string::npos; }

std::unique_ptr<Spectrum> ReadSpectrum(const Parameter& p, const std::string& path) {
    const std::string& name = p.strings[0];
    std::error_code ignored;
    if (!LooksLikePath(name) && !std::filesystem::exists(path, ignored))
        throw SceneError(p.loc, fmt::format("\"{}\" is neither a named spectrum nor a readable file{}",
                                            Excerpt(name), DidYouMean(name, NamedSpectra())));
    try {
        return ReadSpectrumFile(path);
    } catch (const FileError& e) {
        throw FileError(name, fmt::format("{} (the spectrum file of {})", e.Problem(), p.Quoted()), p.loc);
    } catch (const SceneError& e) {
        throw SceneError(e.Loc(),
                         fmt::format("{} (read for {} at {})", e.Message(), p.Quoted(), p.loc.ToString()));
    }
}

}  // namespace

std::string FileResolver::Resolve(const std::string& path) const {
    if (directory_.IsEmpty() || path.empty() || path[0] == '/') return path;
    std::error_code ignored;
    const std::filesystem::path below = std::filesystem::path(directory_.Text()) / path;
    if (!std::filesystem::exists(below, ignored)) return path;
    // Without "./" and the like, unless a symbolic link gives ".." another meaning.
    const std::filesystem::path normal = below.lexically_normal();
    return (std::filesystem::equivalent(below, normal, ignored) ? normal : below).string();
}

Params::Params(std::string owner, FileLoc loc, std::vector<Parameter> parameters,
               const lacquer::ColorSpace* colorSpace, FileResolver files)
    : owner_(std::move(owner)),
      loc_(loc),
      parameters_(std::move(parameters)),
      colorSpace_(colorSpace),
      files_(std::move(files)) {}

// The parameter in force: the last own one, else the one that an Attribute directive set last.
const Parameter* Params::Find(std::string_view type, std::string_view name) const {
    const auto same = [&](const auto& pair) { return pair.first == type && pair.second == name; };
    if (std::none_of(asked_.begin(), asked_.end(), same)) asked_.emplace_back(type, name);
    const Parameter* inherited = nullptr;
    for (auto p = parameters_.rbegin(); p != parameters_.rend(); ++p) {
        if (p->name != name || p->type != type) continue;
        p->lookedUp = true;
        if (!p->fromAttribute) return &*p;
        if (!inherited) inherited = &*p;
    }
    return inherited;
}

const Parameter* Params::FindScalar(std::string_view type, std::string_view name) const {
    const Parameter* p = Find(type, name);
    if (!p) return nullptr;
    RequireSound(*p);
    if (const size_t n = ComponentsOf(*p); p->NumValues() != n)
        throw SceneError(p->loc, fmt::format("{} needs {} value{}, has {}", p->Quoted(), n, n == 1 ? "" : "s",
                                             p->NumValues()));
    return p;
}

const Parameter* Params::FindArray(std::string_view type, std::string_view name) const {
    const Parameter* p = Find(type, name);
    if (!p) return nullptr;
    RequireSound(*p);
    if (const size_t n = ComponentsOf(*p); p->NumValues() % n != 0)
        throw SceneError(
            p->loc, fmt::format("{} needs a multiple of {} values, has {}", p->Quoted(), n, p->NumValues()));
    return p;
}

std::optional<float> Params::GetOptionalFloat(std::string_view name) const {
    const Parameter* p = FindScalar("float", name);
    return p ? std::optional(p->floats[0]) : std::nullopt;
}

std::optional<std::string> Params::GetOptionalString(std::string_view name) const {
    const Parameter* p = FindScalar("string", name);
    return p ? std::optional(p->strings[0]) : std::nullopt;
}

std::optional<std::string> Params::GetTextureName(std::string_view name) const {
    const Parameter* p = FindScalar("texture", name);
    return p ? std::optional(p->strings[0]) : std::nullopt;
}

float Params::GetFloat(std::string_view name, float fallback) const {
    return GetOptionalFloat(name).value_or(fallback);
}

int Params::GetInt(std::string_view name, int fallback) const {
    const Parameter* p = FindScalar("integer", name);
    return p ? p->integers[0] : fallback;
}

bool Params::GetBool(std::string_view name, bool fallback) const {
    const Parameter* p = FindScalar("bool", name);
    return p ? p->bools[0] != 0 : fallback;
}

std::string Params::GetString(std::string_view name, std::string_view fallback) const {
    return GetOptionalString(name).value_or(std::string(fallback));
}

Vec2 Params::GetPoint2(std::string_view name, Vec2 fallback) const {
    const Parameter* p = FindScalar("point2", name);
    return p ? Vec2(p->floats[0], p->floats[1]) : fallback;
}

Vec3 Params::GetPoint3(std::string_view name, Vec3 fallback) const {
    const Parameter* p = FindScalar("point3", name);
    return p ? Vec3(p->floats[0], p->floats[1], p->floats[2]) : fallback;
}

Vec3 Params::GetVector3(std::string_view name, Vec3 fallback) const {
    const Parameter* p = FindScalar("vector3", name);
    return p ? Vec3(p->floats[0], p->floats[1], p->floats[2]) : fallback;
}

int Params::GetIntInRange(std::string_view name, int fallback, int low, int high) const {
    const int value = GetInt(name, fallback);
    if (value < low || value > high)
        Fail(name, fmt::format("\"integer {}\" must lie in [{}, {}], is {}", name, low, high, value));
    return value;
}

float Params::GetFloatInRange(std::string_view name, float fallback, float low, float high) const {
    const float value = GetFloat(name, fallback);
    if (!(value >= low && value <= high))
        Fail(name, fmt::format("\"float {}\" must lie in [{}, {}], is {}", name, low, high, value));
    return value;
}

std::string Params::GetChoice(std::string_view name, std::string_view fallback,
                              const std::vector<std::string>& choices) const {
    const std::optional<std::string> given = GetOptionalString(name);
    if (!given) return std::string(fallback);
    if (std::find(choices.begin(), choices.end(), *given) == choices.end())
        Fail(name, fmt::format("\"string {}\" of {} is {}, not \"{}\"{}", name, owner_, Alternatives(choices),
                               Excerpt(*given), DidYouMean(*given, choices)));
    return *given;
}

std::vector<float> Params::GetFloats(std::string_view name) const {
    const Parameter* p = FindArray("float", name);
    return p ? p->floats : std::vector<float>();
}

std::vector<int> Params::GetInts(std::string_view name) const {
    const Parameter* p = FindArray("integer", name);
    return p ? p->integers : std::vector<int>();
}

std::vector<std::string> Params::GetStrings(std::string_view name) const {
    const Parameter* p = FindArray("string", name);
    return p ? p->strings : std::vector<std::string>();
}

std::vector<Vec2> Params::GetPoint2s(std::string_view name) const {
    std::vector<Vec2> points;
    if (const Parameter* p = FindArray("point2", name)) {
        points.reserve(p->floats.size() / 2);
        for (size_t i = 0; i < p->floats.size(); i += 2) points.emplace_back(p->floats[i], p->floats[i + 1]);
    }
    return points;
}

std::vector<Vec3> Params::Triples(std::string_view type, std::string_view name) const {
    std::vector<Vec3> triples;
    if (const Parameter* p = FindArray(type, name)) {
        triples.reserve(p->floats.size() / 3);
        for (size_t i = 0; i < p->floats.size(); i += 3)
            triples.emplace_back(p->floats[i], p->floats[i + 1], p->floats[i + 2]);
    }
    return triples;
}

std::vector<Vec3> Params::GetPoint3s(std::string_view name) const { return Triples("point3", name); }
std::vector<Vec3> Params::GetVector3s(std::string_view name) const { return Triples("vector3", name); }
std::vector<Vec3> Params::GetNormals(std::string_view name) const { return Triples("normal", name); }
std::vector<RGB> Params::GetRgbs(std::string_view name) const { return Triples("rgb", name); }

// Of the three forms the one in force is the last own one, else the last inherited one.
std::unique_ptr<Spectrum> Params::GetSpectrum(std::string_view name, SpectrumKind kind) const {
    const Parameter* chosen = nullptr;
    for (const std::string_view type : kSpectrumTypes) {
        const Parameter* p = Find(type, name);
        if (!p) continue;
        const bool replaces =
            !chosen || (chosen->fromAttribute == p->fromAttribute ? p > chosen : chosen->fromAttribute);
        if (chosen) (replaces ? chosen : p)->lookedUp = false;
        if (replaces) chosen = p;
    }
    if (!chosen) return nullptr;
    if (chosen->type == "rgb") return SpectrumOfRgb(*chosen, kind, ColorSpace());
    if (chosen->type == "blackbody") return SpectrumOfBlackbody(*chosen);
    if (chosen->kind != Parameter::Values::Strings) return SpectrumOfSamples(*chosen);
    if (chosen->strings.size() != 1)
        throw SceneError(chosen->loc,
                         fmt::format("{} needs 1 name, has {}", chosen->Quoted(), chosen->strings.size()));
    const std::string& text = chosen->strings[0];
    if (std::unique_ptr<Spectrum> named = NamedSpectrum(text)) return named;
    const FileUse use = UseOf(name, text);
    std::unique_ptr<Spectrum> spectrum = ReadSpectrum(*chosen, use.path);
    files_.Record(use);
    return spectrum;
}

FileUse Params::UseOf(std::string_view name, const std::string& written) const {
    return {written, files_.Resolve(written), owner_, std::string(name), loc_};
}

std::string Params::PathOf(std::string_view name) const {
    FileUse use = UseOf(name, GetString(name, ""));
    files_.Record(use);
    return use.path;
}

void Params::RecordImage(std::string_view name, Int2 resolution, size_t bytes) const {
    FileUse use = UseOf(name, GetString(name, ""));
    use.resolution = resolution;
    use.bytes = bytes;
    files_.Record(std::move(use));
}

std::optional<RGB> Params::GetRgb(std::string_view name) const {
    const Parameter* p = FindScalar("rgb", name);
    return p ? std::optional(RGB(p->floats[0], p->floats[1], p->floats[2])) : std::nullopt;
}

bool Params::Has(std::string_view name) const {
    return std::any_of(parameters_.begin(), parameters_.end(),
                       [&](const Parameter& p) { return p.name == name; });
}

FileLoc Params::LocOf(std::string_view name) const {
    const Parameter* inherited = nullptr;
    for (auto p = parameters_.rbegin(); p != parameters_.rend(); ++p) {
        if (p->name != name) continue;
        if (!p->fromAttribute) return p->loc;
        if (!inherited) inherited = &*p;
    }
    return inherited ? inherited->loc : loc_;
}

void Params::Fail(std::string_view name, const std::string& message) const {
    throw SceneError(LocOf(name), message);
}

void Params::Ignore(std::string_view type, std::string_view name) const { Find(type, name); }

std::string Params::WhyUnused(const Parameter& p) const {
    std::vector<std::string> names, types;
    bool rightType = false;
    for (const auto& [type, name] : asked_) {
        names.push_back(name);
        if (name != p.name) continue;
        types.push_back(fmt::format("{} {}", type, name));
        rightType |= type == p.type;
    }
    if (rightType)
        return fmt::format("{} of {} is given in another form as well; remove one of them", p.Quoted(),
                           owner_);
    if (!types.empty())
        return fmt::format("{} has the type \"{}\", but {} expects {}", p.Quoted(), Excerpt(p.type), owner_,
                           Alternatives(types));
    return fmt::format("{} has no parameter {}{}", owner_.empty() ? "this directive" : owner_, p.Quoted(),
                       DidYouMean(p.name, names));
}

std::vector<Diagnostic> Params::UnusedParameters() const {
    std::vector<Diagnostic> unused;
    for (auto p = parameters_.begin(); p != parameters_.end(); ++p) {
        if (p->lookedUp || p->fromAttribute) continue;
        const bool shadowed = std::any_of(p + 1, parameters_.end(), [&](const Parameter& later) {
            return !later.fromAttribute && later.type == p->type && later.name == p->name;
        });
        if (!shadowed) unused.push_back({Diagnostic::Severity::Error, p->loc, WhyUnused(*p)});
    }
    return unused;
}

std::vector<Diagnostic> Params::UnusedAttributes() const {
    std::vector<Diagnostic> unused;
    for (const Parameter& p : parameters_) {
        // An own parameter of that name comes before it, and no mistake is to be told.
        const bool overridden =
            std::any_of(parameters_.begin(), parameters_.end(),
                        [&](const Parameter& own) { return !own.fromAttribute && own.name == p.name; });
        if (p.fromAttribute && !p.lookedUp && !overridden)
            unused.push_back({Diagnostic::Severity::Warning, p.loc, WhyUnused(p)});
    }
    return unused;
}

bool Params::HasAttributes() const {
    return std::any_of(parameters_.begin(), parameters_.end(),
                       [](const Parameter& p) { return p.fromAttribute; });
}

void Params::CheckAllUsed() const {
    std::vector<Diagnostic> unused = UnusedParameters();
    if (!unused.empty()) throw SceneErrors(std::move(unused));
}

}  // namespace lacquer
