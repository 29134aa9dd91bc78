#include "pbrt/scene/v3_upgrade.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <span>

#include "pbrt/core/parameter.h"
#include "pbrt/scene/directive.h"
#include "pbrt/scene/v3.h"

namespace lacquer {

namespace {

using Names = std::vector<std::string_view>;

/// How a material of pbrt-v3 becomes one of pbrt-v4.
struct MaterialRule {
    const char* type;
    std::map<std::string_view, const char*> renamed;
    Names dropped;  ///< without an equal: a warning
    /// Added where it is not given (written as in a file): pbrt-v4 has another default.
    std::vector<std::pair<const char*, const char*>> defaults;
    /// Where the model itself is another one: what changes even if no parameter is lost.
    const char* warning = "";
};

constexpr const char* kRoughness = "float roughness";
constexpr const char* kCoatInstead = "its highlight is that of a coat, by the index of refraction alone";
const std::map<std::string_view, MaterialRule> kMaterials = {
    {"matte", {"diffuse", {{"Kd", "reflectance"}}, {"sigma"}, {}}},
    {"plastic",
     {"coateddiffuse",
      {{"Kd", "reflectance"}},
      {"Ks"},
      {{"rgb reflectance", "0.25"}, {kRoughness, "0.1"}},
      kCoatInstead}},
    {"uber",
     {"coateddiffuse",
      {{"Kd", "reflectance"}, {"index", "eta"}},
      {"Ks", "Kr", "Kt", "opacity"},
      {{"rgb reflectance", "0.25"}, {kRoughness, "0.1"}},
      kCoatInstead}},
    {"substrate", {"coateddiffuse", {{"Kd", "reflectance"}}, {"Ks"}, {{kRoughness, "0.1"}}, kCoatInstead}},
    {"glass", {"dielectric", {{"index", "eta"}}, {"Kr", "Kt"}, {}}},
    {"metal", {"conductor", {}, {}, {{kRoughness, "0.01"}}}},
    {"mirror", {"conductor", {{"Kr", "reflectance"}}, {}, {{"rgb reflectance", "0.9"}}}},
    {"translucent", {"diffusetransmission", {}, {"Ks", "roughness"}, {}}},
    {"kdsubsurface", {"subsurface", {{"Kd", "reflectance"}, {"index", "eta"}}, {"Kr", "Kt"}, {}}},
    {"disney",
     {"diffuse",
      {{"color", "reflectance"}},
      {"anisotropic", "clearcoat", "clearcoatgloss", "eta", "metallic", "roughness", "scatterdistance",
       "sheen", "sheentint", "spectrans", "speculartint", "thin", "difftrans", "flatness"},
      {}}},
};

const std::map<std::string_view, const char*> kSamplers = {{"lowdiscrepancy", "paddedsobol"},
                                                           {"02sequence", "paddedsobol"},
                                                           {"maxmindist", "pmj02bn"},
                                                           {"random", "independent"}};

std::string Quoted(const WrittenParameter& p) { return fmt::format("\"{} {}\"", p.type, p.name); }

class Upgrade {
  public:
    explicit Upgrade(SceneText* scene) : s_(*scene) {}

    std::vector<Diagnostic> Run() {
        std::vector<WrittenDirective> directives;
        std::vector<std::string> comments;  // of directives that are left out
        for (WrittenDirective& d : s_.directives) {
            d.commentsBefore.insert(d.commentsBefore.begin(), comments.begin(), comments.end());
            comments.clear();
            // The end of the world block ends nothing any more.
            if (const Directive* known = FindDirective(d.name); known->advice && d.arguments.empty()) {
                comments = std::move(d.commentsBefore);
                if (!d.commentBehind.empty()) comments.push_back(std::move(d.commentBehind));
                continue;
            }
            UpgradeDirective(&d);
            directives.push_back(std::move(d));
        }
        s_.directives = std::move(directives);
        s_.commentsAtEnd.insert(s_.commentsAtEnd.begin(), comments.begin(), comments.end());
        return std::move(diagnostics_);
    }

  private:
    // ---- Tools ----

    void Warn(const FileLoc& loc, std::string message) {
        diagnostics_.push_back({Diagnostic::Severity::Warning, loc, std::move(message)});
    }
    void Fail(const FileLoc& loc, const std::string& message) {
        ++numErrors_;
        diagnostics_.push_back({Diagnostic::Severity::Error, loc, "this cannot be upgraded: " + message});
    }
    WrittenValue StringValue(std::string text) { return {s_.Own(std::move(text)), true}; }
    WrittenValue NumberValue(double value) { return {s_.Own(fmt::format("{}", float(value))), false}; }
    WrittenValue WordValue(const char* text) { return {s_.Own(text), false}; }

    void Add(WrittenDirective* d, const char* type, const char* name, std::vector<WrittenValue> values) {
        d->parameters.push_back({type, name, std::move(values), d->loc, {}, {}});
    }
    /// Comments of a parameter that goes move before its directive.
    void Remove(WrittenDirective* d, std::string_view name) {
        for (const WrittenParameter& p : d->parameters) {
            if (p.name != name) continue;
            d->commentsBefore.insert(d->commentsBefore.end(), p.commentsBefore.begin(),
                                     p.commentsBefore.end());
            if (!p.commentBehind.empty()) d->commentsBefore.push_back(p.commentBehind);
        }
        std::erase_if(d->parameters, [&](const WrittenParameter& p) { return p.name == name; });
    }
    static void Rename(WrittenDirective* d, std::string_view from, const char* to) {
        for (WrittenParameter& p : d->parameters)
            if (p.name == from) p.name = to;
    }
    void SetText(WrittenParameter* p, const char* type, const char* name, const std::string& text) {
        p->type = type;
        p->name = name;
        p->values = {StringValue(text)};
    }
    static std::optional<std::vector<double>> NumbersOf(const WrittenParameter& p) {
        std::vector<double> numbers;
        for (const WrittenValue& v : p.values) {
            float number = 0;
            if (v.isString || ParseFloat(v.text, &number) != NumberProblem::None) return std::nullopt;
            numbers.push_back(double(number));
        }
        return numbers.empty() ? std::nullopt : std::optional(numbers);
    }
    /// The value of a float, or of an rgb whose components are equal.
    static std::optional<double> ScalarOf(const WrittenParameter& p) {
        const auto numbers = p.type == "float" || p.type == "rgb" ? NumbersOf(p) : std::nullopt;
        if (!numbers) return std::nullopt;
        const bool isGrey =
            std::all_of(numbers->begin(), numbers->end(), [&](double x) { return x == numbers->front(); });
        return isGrey ? std::optional(numbers->front()) : std::nullopt;
    }
    static bool IsTrue(const WrittenParameter& p) {
        return p.values.size() == 1 && p.values[0].text == "true";
    }

    /// The plugin's name: an argument, or for named materials and media the parameter "type".
    static WrittenValue* TypeOf(WrittenDirective* d) {
        const auto& arguments = FindDirective(d->name)->arguments;
        const auto type = std::find(arguments.begin(), arguments.end(), Argument::Type);
        if (type != arguments.end()) return &d->arguments[size_t(type - arguments.begin())];
        WrittenParameter* p = d->Find("type");
        return p && p->values.size() == 1 ? &p->values[0] : nullptr;
    }

    // ---- Directives ----

    void UpgradeDirective(WrittenDirective* d) {
        const Directive& known = *FindDirective(d->name);
        if (known.successor) d->name = known.successor;
        if (known.Has(Argument::ValueType) && d->arguments[1].text == "color")
            d->arguments[1].text = "spectrum";
        if (known.advice) return Fail(d->loc, fmt::format("the directive {}: {}", d->name, known.advice));
        const size_t numErrors = numErrors_;
        for (WrittenParameter& p : d->parameters) UpgradeType(&p);
        WrittenValue* type = known.Plugin().empty() ? nullptr : TypeOf(d);
        if (!type) return;
        for (const auto& [plugin, upgrade] : Upgrades())
            if (plugin == known.Plugin()) (this->*upgrade)(d, type);
        if (numErrors_ == numErrors) ReportUnknownNames(d, known.Plugin(), *TypeOf(d));
    }

    void UpgradeType(WrittenParameter* p) {
        if (const ParameterType* type = FindV3ParameterType(p->type)) p->type = type->name;
        if (p->type == "bool")
            for (WrittenValue& v : p->values)
                if (v.isString && (v.text == "true" || v.text == "false")) v.isString = false;
        if (p->type == "blackbody" && p->values.size() == 2) {
            const auto numbers = NumbersOf(*p);
            if (numbers && (*numbers)[1] == 1)
                p->values.pop_back();
            else
                Fail(p->loc, fmt::format("{} has a temperature and a scale; pbrt-v4 takes one temperature",
                                         Quoted(*p)));
        }
    }

    /// Names of pbrt-v3 that no rule has taken.
    void ReportUnknownNames(WrittenDirective* d, std::string_view plugin, const WrittenValue& type) {
        if (const auto advice = V3Plugin(plugin, type.text))
            Fail(d->loc, fmt::format("{} \"{}\": {}", d->name, type.text, *advice));
        for (const WrittenParameter& p : d->parameters) {
            if (const auto advice = V3ParameterType(p.type))
                Fail(p.loc, fmt::format("{}: {}", Quoted(p), *advice));
            if (const auto advice = V3Parameter(plugin, type.text, p.type, p.name))
                Fail(p.loc, fmt::format("{}: {}", Quoted(p), *advice));
        }
    }

    void UpgradeFilter(WrittenDirective* d, WrittenValue* type) {
        Rename(d, "xwidth", "xradius");
        Rename(d, "ywidth", "yradius");
        if (type->text != "gaussian") return;
        if (WrittenParameter* p = d->Find("alpha")) {
            const auto alpha = ScalarOf(*p);
            if (!alpha || *alpha <= 0) return Fail(p->loc, fmt::format("{} must be positive", Quoted(*p)));
            p->name = "sigma";
            p->values = {NumberValue(1 / std::sqrt(2 * *alpha))};
        }
        // 2 in pbrt-v3, 1.5 in pbrt-v4.
        for (const char* name : {"xradius", "yradius"})
            if (!d->Find(name)) Add(d, "float", name, {NumberValue(2)});
    }

    void UpgradeFilm(WrittenDirective* d, WrittenValue* type) {
        if (type->text == "image") type->text = "rgb";
        Rename(d, "maxsampleluminance", "maxcomponentvalue");
        WrittenParameter* p = d->Find("scale");
        if (!p) return;
        const auto scale = ScalarOf(*p);
        if (!scale) return;
        p->name = "iso";
        p->values = {NumberValue(100 * *scale)};
    }

    void UpgradeSampler(WrittenDirective* d, WrittenValue* type) {
        if (const auto found = kSamplers.find(type->text); found != kSamplers.end()) {
            type->text = found->second;
            Remove(d, "dimensions");
        }
    }

    void UpgradeIntegrator(WrittenDirective* d, WrittenValue* type) {
        Remove(d, "rrthreshold");
        if (type->text == "sppm") {
            Remove(d, "imagewritefrequency");
            Remove(d, "numiterations");
        }
        if (type->text == "directlighting") {
            type->text = "path";
            Warn(d->loc,
                 "Integrator \"directlighting\" becomes \"path\" with \"maxdepth\" 1, which sees nothing in "
                 "mirrors and through glass; each of those needs one more");
            Remove(d, "strategy");
            Remove(d, "maxdepth");
            Add(d, "integer", "maxdepth", {NumberValue(1)});
        } else if (type->text == "whitted") {
            type->text = "path";
            Warn(d->loc, "Integrator \"whitted\" becomes \"path\", which follows light between all surfaces");
        }
        if (WrittenParameter* p = d->Find("lightsamplestrategy")) {
            const bool isSpatial = p->values.size() == 1 && p->values[0].text == "spatial";
            SetText(p, "string", "lightsampler",
                    isSpatial ? "bvh" : std::string(p->values.empty() ? "" : p->values[0].text));
        }
        if (const WrittenParameter* p = d->Find("pixelbounds"))
            Fail(p->loc, fmt::format("{} is a parameter of Film in pbrt-v4", Quoted(*p)));
    }

    void UpgradeCamera(WrittenDirective* d, WrittenValue* type) {
        if (type->text == "realistic") Remove(d, "simpleweighting");
        if (type->text != "environment") return;
        type->text = "spherical";
        Add(d, "string", "mapping", {StringValue("equirectangular")});
    }

    // ---- Materials ----

    void UpgradeMaterial(WrittenDirective* d, WrittenValue* value) {
        Rename(d, "bumpmap", "displacement");
        const std::string_view type = value->text;
        if (type.empty() || type == "none") {
            TypeOf(d)->text = "interface";
            return;
        }
        if (type == "mix") return UpgradeMix(d);
        if (type == "translucent") UpgradeTranslucent(d);
        if (type == "hair") Rename(d, "color", "reflectance");
        const auto rule = kMaterials.find(type);
        if (rule == kMaterials.end()) return;
        if (*rule->second.warning && warned_.insert(std::string(type)).second)
            Warn(d->loc,
                 fmt::format("\"{}\" becomes \"{}\": {}", type, rule->second.type, rule->second.warning));
        Apply(rule->second, d, std::string(type));
        TypeOf(d)->text = rule->second.type;
    }

    void Apply(const MaterialRule& rule, WrittenDirective* d, const std::string& type) {
        for (const auto& [from, to] : rule.renamed) Rename(d, from, to);
        for (const std::string_view name : rule.dropped) {
            const WrittenParameter* p = d->Find(name);
            if (!p) continue;
            Warn(p->loc, fmt::format("{} of \"{}\" is left out: \"{}\" has nothing like it", Quoted(*p), type,
                                     rule.type));
            Remove(d, name);
        }
        for (const auto& [declaration, value] : rule.defaults) {
            const std::string_view words = declaration;
            const std::string name(words.substr(words.find(' ') + 1));
            const bool isRough = name == "roughness" && (d->Find("uroughness") || d->Find("vroughness"));
            if (d->Find(name) || isRough) continue;
            const bool isRgb = words.starts_with("rgb");
            Add(d, isRgb ? "rgb" : "float", name.c_str(),
                std::vector<WrittenValue>(isRgb ? 3 : 1, WordValue(value)));
        }
    }

    /// pbrt-v3 gives the amount of the first material, pbrt-v4 that of the second one.
    void UpgradeMix(WrittenDirective* d) {
        WrittenParameter *first = d->Find("namedmaterial1"), *second = d->Find("namedmaterial2");
        if (!first || !second || first->values.size() != 1 || second->values.size() != 1) return;
        const std::vector<WrittenValue> both = {second->values[0], first->values[0]};
        first->name = "materials";
        first->values = both;
        Remove(d, "namedmaterial2");
        WrittenParameter* amount = d->Find("amount");
        if (!amount || amount->type == "texture") return;
        if (const auto value = ScalarOf(*amount)) {
            amount->type = "float";
            amount->values = {NumberValue(*value)};
        } else {
            Fail(amount->loc,
                 fmt::format("{} is a colour; the amount of pbrt-v4 is one number", Quoted(*amount)));
        }
    }

    /// Kd times "reflect" goes back, Kd times "transmit" through.
    void UpgradeTranslucent(WrittenDirective* d) {
        const auto numbersOf = [&](const char* name, double fallback) -> std::optional<std::vector<double>> {
            const WrittenParameter* p = d->Find(name);
            if (!p) return std::vector<double>(3, fallback);
            auto numbers = p->type == "rgb" ? NumbersOf(*p) : std::nullopt;
            return numbers && numbers->size() == 3 ? numbers : std::nullopt;
        };
        const auto kd = numbersOf("Kd", 0.25), reflect = numbersOf("reflect", 0.5),
                   transmit = numbersOf("transmit", 0.5);
        if (kd && reflect && transmit) {
            std::vector<WrittenValue> back, through;
            for (size_t c = 0; c < 3; ++c) {
                back.push_back(NumberValue((*kd)[c] * (*reflect)[c]));
                through.push_back(NumberValue((*kd)[c] * (*transmit)[c]));
            }
            Remove(d, "Kd");
            Add(d, "rgb", "reflectance", back);
            Add(d, "rgb", "transmittance", through);
        } else if (reflect && transmit && *reflect == *transmit && (*reflect)[0] == (*reflect)[1] &&
                   (*reflect)[1] == (*reflect)[2]) {
            WrittenParameter through = *d->Find("Kd");
            through.commentsBefore.clear();
            through.commentBehind.clear();
            through.name = "transmittance";
            Rename(d, "Kd", "reflectance");
            d->parameters.push_back(through);
            Add(d, "float", "scale", {NumberValue((*reflect)[0])});
        } else {
            return Fail(d->loc, "\"reflect\" and \"transmit\" of a translucent material with textures");
        }
        Remove(d, "reflect");
        Remove(d, "transmit");
    }

    // ---- Textures, lights, shapes ----

    void UpgradeTexture(WrittenDirective* d, WrittenValue* type) {
        if (type->text == "uv") return Fail(d->loc, "pbrt-v4 has no texture \"uv\"");
        if (type->text == "scale") UpgradeScale(d);
        if (type->text != "imagemap") return;
        if (WrittenParameter* p = d->Find("trilinear"))
            SetText(p, "string", "filter", IsTrue(*p) ? "trilinear" : "EWA");
        else if (!d->Find("filter"))
            Add(d, "string", "filter", {StringValue("EWA")});
        WrittenParameter* gamma = d->Find("gamma");
        if (!gamma) return;
        if (gamma->type == "bool")
            return SetText(gamma, "string", "encoding", IsTrue(*gamma) ? "sRGB" : "linear");
        if (const auto value = ScalarOf(*gamma))
            SetText(gamma, "string", "encoding", fmt::format("gamma {}", float(*value)));
    }

    /// The factor of pbrt-v4 is one number or a float texture.
    void UpgradeScale(WrittenDirective* d) {
        WrittenParameter *tex1 = d->Find("tex1"), *tex2 = d->Find("tex2");
        const auto isFactor = [](const WrittenParameter* p) {
            return p && (p->type == "float" || (p->type == "rgb" && ScalarOf(*p)));
        };
        if (!isFactor(tex2) && isFactor(tex1)) std::swap(tex1, tex2);
        const bool isFloat = d->arguments[1].text == "float";
        if (tex2 && !isFactor(tex2) && !(isFloat && tex2->type == "texture"))
            return Fail(
                tex2->loc,
                fmt::format("{} multiplies by a colour; the factor of pbrt-v4 is one number", Quoted(*tex2)));
        if (tex1) tex1->name = "tex";
        if (!tex2) return;
        tex2->name = "scale";
        if (tex2->type == "rgb") tex2->values.resize(1);
        if (tex2->type == "rgb") tex2->type = "float";
    }

    void UpgradeLight(WrittenDirective* d, WrittenValue* type) {
        if (type->text == "area") type->text = "diffuse";
        Remove(d, "samples");
        Remove(d, "nsamples");
        if (d->Find("mapname")) {
            Rename(d, "mapname", "filename");
            if (type->text == "infinite")
                Warn(d->Find("filename")->loc,
                     "the image of an infinite light is square and octahedral in pbrt-v4: one with latitudes "
                     "and longitudes must be resampled");
        }
        WrittenParameter* scale = d->Find("scale");
        if (!scale || scale->type != "rgb") return;
        if (const auto value = ScalarOf(*scale)) {
            scale->type = "float";
            scale->values = {NumberValue(*value)};
            return;
        }
        const auto factors = NumbersOf(*scale);
        for (const char* name : {"L", "I"}) {
            WrittenParameter* p = d->Find(name);
            const auto values = p && p->type == "rgb" ? NumbersOf(*p) : std::nullopt;
            if (!values || !factors || values->size() != 3 || factors->size() != 3) continue;
            for (size_t c = 0; c < 3; ++c) p->values[c] = NumberValue((*values)[c] * (*factors)[c]);
            return Remove(d, "scale");
        }
    }

    void UpgradeMedium(WrittenDirective*, WrittenValue* type) {
        if (type->text == "heterogeneous") type->text = "uniformgrid";
    }

    void UpgradeShape(WrittenDirective* d, WrittenValue*) {
        for (WrittenParameter& p : d->parameters) {
            if (p.name == "st" || (p.name == "uv" && p.type == "float")) {
                p.type = "point2";
                p.name = "uv";
            }
        }
        Rename(d, "nlevels", "levels");
        Remove(d, "shadowalpha");
        Remove(d, "discarddegenerateUVs");
    }

    struct PluginUpgrade {
        std::string_view plugin;  ///< Directive::Plugin()
        void (Upgrade::*run)(WrittenDirective* d, WrittenValue* type);
    };
    static std::span<const PluginUpgrade> Upgrades() {
        static constexpr PluginUpgrade kUpgrades[] = {
            {"PixelFilter", &Upgrade::UpgradeFilter}, {"Film", &Upgrade::UpgradeFilm},
            {"Sampler", &Upgrade::UpgradeSampler},    {"Integrator", &Upgrade::UpgradeIntegrator},
            {"Camera", &Upgrade::UpgradeCamera},      {"Medium", &Upgrade::UpgradeMedium},
            {"Material", &Upgrade::UpgradeMaterial},  {"Texture", &Upgrade::UpgradeTexture},
            {"LightSource", &Upgrade::UpgradeLight},  {"AreaLightSource", &Upgrade::UpgradeLight},
            {"Shape", &Upgrade::UpgradeShape},
        };
        return kUpgrades;
    }

    SceneText& s_;
    std::vector<Diagnostic> diagnostics_;
    std::set<std::string> warned_;  ///< materials whose models differ: said once for each
    size_t numErrors_ = 0;
};

}  // namespace

std::vector<Diagnostic> UpgradeFromV3(SceneText* scene) { return Upgrade(scene).Run(); }

}  // namespace lacquer
