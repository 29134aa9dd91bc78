#include "cmd/bsdf/color_table.h"

#include <fmt/format.h>

#include "measure/scene_material.h"

namespace lacquer::cmd {

using namespace measure;

namespace {

using Json = nlohmann::ordered_json;

Json ToJson(const Uncertain& u) { return {{"value", u.value}, {"standard_error", u.error}}; }

Json ToJson(const ColorReading& r) {
    return {{"X", ToJson(r.xyz[0])},      {"Y", ToJson(r.xyz[1])},
            {"Z", ToJson(r.xyz[2])},      {"L", ToJson(r.L)},
            {"a", ToJson(r.a)},           {"b", ToJson(r.b)},
            {"chroma", ToJson(r.chroma)}, {"hue_degrees", ToJson(r.hueDeg)}};
}

Json ToJson(const ColorGeometry& g) {
    const char* kinds[] = {"directional", "ring", "hemisphere"};
    Json json{{"name", g.name}, {"light", kinds[int(g.kind)]}};
    if (g.kind != ColorGeometry::Kind::Diffuse) json["light_degrees"] = g.lightDeg;
    json["detector_degrees"] = g.detectorDeg;
    if (g.hasGlossTrap) json["gloss_trap_degrees"] = kTrapDeg;
    return json;
}

/// Errors that round to nothing are those of models without noise.
std::string Digits(const Uncertain& u) {
    return u.error < 5e-4 ? fmt::format("{:8.2f}       ", u.value)
                          : fmt::format("{:8.2f} \u00b1{:5.2f}", u.value, u.error);
}

std::string ReadingRow(const ColorTable& t, size_t geometry, size_t illuminant) {
    const ColorReading r = t.colors->At(geometry, illuminant);
    std::string text = fmt::format("  {:<8} {:<4}", illuminant == 0 ? ColorGeometries()[geometry].name : "",
                                   kIlluminants[illuminant]);
    for (const Uncertain& v : r.xyz) text += fmt::format("{:8.2f}", v.value);
    for (const Uncertain* v : {&r.L, &r.a, &r.b, &r.chroma}) text += Digits(*v);
    text += r.chroma.value < 0.05 ? fmt::format("{:>8}       ", "-") : Digits(r.hueDeg);
    if (t.referenceColors)
        text += Digits(ColorSurvey::Difference(*t.colors, *t.referenceColors, geometry, illuminant));
    return text.substr(0, text.find_last_not_of(' ') + 1) + "\n";
}

ColorSurvey ColorsOf(const SceneDescription& scene, const std::string& name, const ColorQuery& query,
                     Observer* observer) {
    const SceneMaterial material = LoadMaterial(scene, name, query.uv, query.build, observer);
    const std::vector<float> wavelengths = ColorWavelengths(material.bsdf->IsStochastic());
    const SpectralSubject subject(*material.setup.material, query.uv, wavelengths, material.setup.entity.loc);
    return SurveyColors(subject, wavelengths, query.survey, observer);
}

}  // namespace

ColorTable MakeColorTable(const SceneDescription& scene, const ColorQuery& query, Observer* observer) {
    ColorTable table{query.material, query.reference, query.survey.azimuthDeg, {}, {}};
    table.colors = ColorsOf(scene, query.material, query, observer);
    if (!query.reference.empty()) table.referenceColors = ColorsOf(scene, query.reference, query, observer);
    return table;
}

Json ToJson(const ColorTable& t) {
    Json json{{"observer", "CIE 1931, 2 degrees"},
              {"detector_half_angle_degrees", 0},
              {"azimuth_degrees", t.azimuthDeg},
              {"reference", t.reference.empty() ? Json() : Json(t.reference)}};
    json["geometries"] = Json::array();
    for (size_t g = 0; g < ColorGeometries().size(); ++g) {
        Json entry = ToJson(ColorGeometries()[g]);
        for (size_t i = 0; i < kIlluminants.size(); ++i) {
            Json reading = ToJson(t.colors->At(g, i));
            if (t.referenceColors)
                reading["delta_E2000"] = ToJson(ColorSurvey::Difference(*t.colors, *t.referenceColors, g, i));
            entry[kIlluminants[i]] = std::move(reading);
        }
        json["geometries"].push_back(std::move(entry));
    }
    return json;
}

std::string ToText(const ColorTable& t) {
    std::string text = fmt::format(
        "\nColour of \"{}\", CIE 1931 observer (2\u00b0), white Y = 100; light in the plane of azimuth "
        "{:g}\u00b0;\n"
        "45:0 by a ring, di:8 and de:8 by a sphere without and with a gloss trap of {:g}\u00b0, 45asN with "
        "the "
        "detector\nN\u00b0 from the mirror direction; detectors have no size, and see no specular peaks but "
        "by the "
        "sphere\n",
        t.material, t.azimuthDeg, kTrapDeg);
    if (t.referenceColors) text += fmt::format("\u0394E00 is CIEDE2000 from \"{}\"\n", t.reference);
    text += fmt::format("  {:<13}{:>8}{:>8}{:>8}{:>8}{:>15}{:>15}{:>15}{:>15}", "", "X", "Y", "Z", "L*", "a*",
                        "b*", "C*ab", "hab");
    if (t.referenceColors) text += fmt::format("{:>15}", "\u0394E00");
    text += "\n";
    for (size_t g = 0; g < ColorGeometries().size(); ++g)
        for (size_t i = 0; i < kIlluminants.size(); ++i) text += ReadingRow(t, g, i);
    return text;
}

}  // namespace lacquer::cmd
