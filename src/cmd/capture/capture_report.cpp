#include "cmd/capture/capture_report.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <deque>
#include <numbers>

#include "capture/svbrdf/pixel_fit.h"
#include "capture/svbrdf/svbrdf_model.h"
#include "cmd/console.h"
#include "cmd/page_parts.h"
#include "cmd/report_page.h"
#include "cmd/version.h"

namespace lacquer::cmd {
namespace {

using namespace capture;
using Json = nlohmann::ordered_json;

/// Pixels of the page's images along an edge, at most; of many photographs they are half as large.
constexpr int kPagePixels = 256;
constexpr size_t kManyViews = 5;
constexpr size_t kNumRelit = 16;
/// From here on held-out photographs say that the maps are wrong where nobody looked.
constexpr double kMuchWorse = 2;

/// An image of encoded values.
Image ImageOf(RectifiedImage values, int pixels) {
    while (values.size > pixels && values.size % 2 == 0) values = Halved(values);
    Image image(Int2(values.size), {"R", "G", "B"});
    for (size_t c = 0; c < 3; ++c)
        for (size_t i = 0; i < values.NumPixels(); ++i)
            image.Pixels()[3 * i + c] = float(values.Channel(c)[i]);
    return image;
}

Image DifferenceOf(const RectifiedImage& a, const RectifiedImage& b, int pixels) {
    RectifiedImage left = a, right = b;
    while (left.size > pixels && left.size % 2 == 0) {
        left = Halved(left);
        right = Halved(right);
    }
    Image image(Int2(left.size), {"Y"});
    for (size_t i = 0; i < left.NumPixels(); ++i) {
        double largest = 0;
        for (size_t c = 0; c < 3; ++c)
            largest = std::max(largest, std::abs(left.Channel(c)[i] - right.Channel(c)[i]));
        image.Pixels()[i] = float(largest);
    }
    return image;
}

/// A map as people look at it. @param value  of a texel: three numbers
template <class Value>
Image MapImage(const Maps& maps, const Value& value) {
    Image image(Int2(maps.size), {"R", "G", "B"});
    for (size_t i = 0; i < maps.NumTexels(); ++i) {
        StoredTexel<double> stored;
        for (size_t c = 0; c < kNumChannels; ++c) stored[c] = maps.Channel(c)[i];
        const std::array<double, 3> v = value(Decode(stored));
        for (size_t c = 0; c < 3; ++c) image.Pixels()[3 * i + c] = float(v[c]);
    }
    return image;
}

/// Images of the page, which must outlive it.
struct PageImages {
    std::deque<Image> images;
    std::vector<ReportImage> list;
    std::string Add(std::string name, Image image) {
        images.push_back(std::move(image));
        list.push_back({name, &images.back()});
        return name;
    }
};

void AddMaps(const CaptureResults& results, Json* page, PageImages* images) {
    Maps maps = results.maps;
    if (maps.size > 2 * kPagePixels) maps = ResizeMaps(maps, 2 * kPagePixels);
    const auto add = [&](const char* name, const char* caption, bool isColor, const auto& value) {
        (*page)["maps"].push_back(
            {{"file", images->Add(name, MapImage(maps, value))}, {"caption", caption}, {"color", isColor}});
    };
    using T = Texel<double>;
    add("map albedo", "Albedo", true, [](const T& t) { return t.albedo; });
    add("map specular", "Specular albedo", true, [](const T& t) { return t.specular; });
    add("map roughness", "Roughness: the root of GGX's alpha, black 0, white 1", false, [](const T& t) {
        const double r = std::sqrt(t.alpha);
        return std::array{r, r, r};
    });
    add("map normal", "Normal: right is redder, up is greener", false, [](const T& t) {
        return std::array{(t.normal[0] + 1) / 2, (t.normal[1] + 1) / 2, (t.normal[2] + 1) / 2};
    });
}

/// The sample under a light that goes around, seen from straight above.
void AddRelit(const CaptureResults& results, Json* page, PageImages* images) {
    double height = 0;
    for (const View& view : results.views.views)
        height += view.camera[2] / double(results.views.views.size());
    Maps maps = results.maps;
    if (maps.size > kPagePixels) maps = ResizeMaps(maps, kPagePixels);
    const double radius = 0.6 * height;
    (*page)["relit"]["caption"] = fmt::format(
        "By the maps: a light {:.3g} cm above the sample goes around it at {:.3g} cm; the camera is straight "
        "above.",
        0.7 * height, radius);
    ViewSet set = results.views;
    set.lightPower = results.lightPower;
    for (size_t k = 0; k < kNumRelit; ++k) {
        const double turn = double(k) / kNumRelit, angle = 2 * std::numbers::pi * turn;
        View view;
        view.camera = {0, 0, height};
        view.light = {radius * std::cos(angle), radius * std::sin(angle), 0.7 * height};
        const std::string file =
            images->Add(fmt::format("relit {}", k), ImageOf(RenderView(maps, set, view), kPagePixels));
        (*page)["relit"]["frames"].push_back(
            {{"file", file},
             {"caption", fmt::format("The light stands at {:.0f}° from the right", 360 * turn)}});
    }
}

void AddViewImages(const CaptureResults& results, Json* page, PageImages* images) {
    const int pixels = results.views.views.size() > kManyViews ? kPagePixels / 2 : kPagePixels;
    for (size_t i = 0; i < results.views.views.size(); ++i) {
        Json& view = (*page)["views"][i];
        view["photo"] = images->Add(fmt::format("photo {}", i), ImageOf(results.photographs[i], pixels));
        view["model"] = images->Add(fmt::format("model {}", i), ImageOf(results.models[i], pixels));
        view["difference"] = images->Add(fmt::format("difference {}", i),
                                         DifferenceOf(results.photographs[i], results.models[i], pixels));
    }
}

std::string PowerText(const std::array<double, 3>& power) {
    if (power[0] == power[1] && power[1] == power[2]) return fmt::format("{:.4g} cm²", power[0]);
    return fmt::format("{:.4g}, {:.4g}, {:.4g} cm²", power[0], power[1], power[2]);
}

Json SettingsOf(const CaptureResults& r) {
    Json settings = Json::array();
    const auto add = [&](const char* name, const std::string& value) {
        settings.push_back({{"name", name}, {"value", value}});
    };
    size_t tests = 0;
    for (const View& view : r.views.views) tests += view.isTest;
    add("Photographs", fmt::format("{} fitted, {} held out", r.views.views.size() - tests, tests));
    add("Sample", fmt::format("{:.4g} x {:.4g} cm, {} x {} texels", r.views.size, r.views.size, r.maps.size,
                              r.maps.size));
    add("Light", PowerText(r.lightPower) + (r.fittedLight ? ", found with the maps" : ", given"));
    if (r.focal > 0)
        add("Focal length", r.focalError > 0 ? fmt::format("{:.5g} ± {:.2g} pixels", r.focal, r.focalError)
                                             : fmt::format("{:.5g} pixels", r.focal));
    for (const auto& [name, value] : r.fitSettings) add(name.c_str(), value);
    add("Material", r.materialType);
    add("Time", FormatSeconds(r.seconds));
    return settings;
}

Json FindingsOf(const CaptureResults& r) {
    Json findings = Json::array();
    if (const auto error = RmseOf(r, true))
        findings.push_back({{"label", "Held out"},
                            {"text", fmt::format("RMSE {:.2g} of encoded values, where fitted photographs "
                                                 "have {:.2g}.",
                                                 *error, RmseOf(r, false).value_or(0))}});
    double worst = 0;
    for (const CardFinding& f : r.card) worst = std::max(worst, f.reprojectionRms);
    if (!r.card.empty())
        findings.push_back(
            {{"label", "Card"},
             {"text", fmt::format("Its tags are where a flat card has them within {:.2f} pixels in each "
                                  "photograph.",
                                  worst)}});
    for (const auto& [label, text] : r.fitFindings) findings.push_back({{"label", label}, {"text", text}});
    if (r.materialType == "mix")
        findings.push_back(
            {{"label", "Mixture"},
             {"text",
              fmt::format("The metal has a share of {:.3g}; {:.2g} % of the values were cut off at 1.",
                          r.material.mixAmount, 100 * r.material.clippedShare)}});
    return findings;
}

}  // namespace

std::optional<double> RmseOf(const CaptureResults& results, bool ofTests) {
    double sum = 0;
    int count = 0;
    for (size_t i = 0; i < results.views.views.size(); ++i)
        if (results.views.views[i].isTest == ofTests) {
            sum += results.rmse[i] * results.rmse[i];
            ++count;
        }
    return count > 0 ? std::optional(std::sqrt(sum / count)) : std::nullopt;
}

std::string VerdictOf(const CaptureResults& results) {
    const double fit = RmseOf(results, false).value_or(0);
    const std::optional<double> test = RmseOf(results, true);
    std::string verdict;
    if (!results.isComplete) verdict = "The fit was stopped before its end. ";
    if (!test)
        return verdict + fmt::format(
                             "The maps match the photographs to {:.2g} of encoded values (root mean "
                             "square). None was held out, so nothing tells how well they hold under "
                             "other light.",
                             fit);
    verdict += fmt::format(
        "The maps predict the held-out photographs to {:.2g} of encoded values (root mean "
        "square) and match the fitted ones to {:.2g}.",
        *test, fit);
    if (*test > kMuchWorse * fit)
        verdict += " More photographs, from other directions, would make them better.";
    return verdict;
}

nlohmann::ordered_json CaptureReportResults(const CaptureResults& r) {
    Json page;
    page["schema"] = "lacquer-capture-report 1";
    page["title"] = r.title;
    page["version"] = kVersion;
    page["command"] = r.command;
    page["verdict"] = VerdictOf(r);
    const std::optional<double> test = RmseOf(r, true);
    page["complete"] = r.isComplete;
    page["good"] = test && *test <= kMuchWorse * RmseOf(r, false).value_or(0);
    page["warnings"] = Json::array();
    for (const std::string& warning : r.warnings) page["warnings"].push_back(Sentence(warning));
    for (const std::string& warning : r.material.warnings) page["warnings"].push_back(Sentence(warning));
    page["findings"] = FindingsOf(r);
    page["settings"] = SettingsOf(r);
    page["size"] = r.views.size;
    page["card"] = r.cardSize;
    page["focal"] = r.focal;
    page["light_power"] = r.lightPower;
    page["fit_rmse"] = RmseOf(r, false).value_or(0);
    if (test) page["test_rmse"] = *test;
    page["seconds"] = r.seconds;
    page["views"] = Json::array();
    for (size_t i = 0; i < r.views.views.size(); ++i) {
        const View& view = r.views.views[i];
        Json entry = {{"name", r.names[i]},
                      {"use", view.isTest ? "test" : "fit"},
                      {"camera", view.camera},
                      {"light", view.light},
                      {"rmse", r.rmse[i]}};
        if (i < r.card.size()) {
            entry["reprojection"] = r.card[i].reprojectionRms;
            entry["tags"] = r.card[i].numTags;
            entry["camera_error"] = r.card[i].positionError;
        }
        page["views"].push_back(entry);
    }
    page["history"] = Json::array();
    for (const CaptureStep& step : r.history) {
        Json entry = {{"iteration", step.iteration}, {"fit_rmse", step.fitRmse}};
        if (step.testRmse) entry["test_rmse"] = *step.testRmse;
        page["history"].push_back(entry);
    }
    page["maps"] = Json::array();
    page["relit"] = {{"caption", ""}, {"frames", Json::array()}};
    return page;
}

std::string MakeCaptureReport(const CaptureResults& results, nlohmann::ordered_json page) {
    static constexpr std::array kStyles = {"report.css", "bulk.css", "estimate.css", "capture.css"};
    static constexpr std::array kScripts = {"format.js",        "blocks.js",      "axes.js",   "images.js",
                                            "image_figures.js", "error_scale.js", "curves.js", "start.js",
                                            "capture_views.js", "capture.js"};
    PageImages images;
    AddViewImages(results, &page, &images);
    AddMaps(results, &page, &images);
    AddRelit(results, &page, &images);
    return MakeReportPage({.page = "capture.html",
                           .title = results.title,
                           .styles = kStyles,
                           .scripts = kScripts,
                           .results = &page,
                           .images = &images.list});
}

}  // namespace lacquer::cmd
