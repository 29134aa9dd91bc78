// The page of `lacquer estimate`: its sentences say what the numbers do and no more, and nothing in it breaks
// out or loads. tests/report looks at the pages in a browser.
#include "cmd/estimate/report.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "cmd/estimate/report_sentences.h"
#include "cmd/estimate_report_cases.h"

namespace lacquer::cmd::estimate_report_test {
namespace {

using Json = nlohmann::ordered_json;

bool Has(const std::string& text, const std::string& what) { return text.find(what) != std::string::npos; }

std::string FindingOn(const EstimateReport& report, const std::string& label) {
    for (const EstimateFinding& finding : FindingsOf(report))
        if (finding.label == label) return finding.text;
    return "";
}

EstimateParameter Interval(double q5, double q95, const std::string& unit = "") {
    EstimateParameter p;
    p.name = "p", p.unit = unit, p.q5 = q5, p.q95 = q95;
    return p;
}

TEST(EstimateReport, IntervalsAreWrittenInTheirOwnDigits) {
    EXPECT_EQ(IntervalText(Interval(0.2401, 0.3299)), "between 0.240 and 0.330");
    EXPECT_EQ(IntervalText(Interval(0.2, 0.4, "cm")), "between 0.20 and 0.40\u00a0cm");
    EXPECT_EQ(IntervalText(Interval(1012, 1533)), "between 1010 and 1540");
    EXPECT_EQ(IntervalText(Interval(-0.5, 0.4)), "between −0.50 and 0.40");
    EXPECT_EQ(IntervalText(Interval(-0.001, 0.002)), "between −0.0010 and 0.0020");
    EXPECT_EQ(IntervalText(Interval(2, 2)), "at 2");
    EXPECT_EQ(IntervalText(Interval(kUnknown, 2)), "");
}

// What is written must hold what was found. Rounding to the nearest would not do, and that shows.
TEST(EstimateReport, IntervalsAreNeverNarrowerThanFound) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform;
    int numNarrower = 0;
    for (int i = 0; i < 2000; ++i) {
        const double middle = 10 * uniform(random) - 5, width = std::pow(10., 5 * uniform(random) - 4);
        const EstimateParameter p = Interval(middle, middle + width);
        std::string text = IntervalText(p);
        for (size_t at = text.find("−"); at != std::string::npos; at = text.find("−"))
            text.replace(at, std::string("−").size(), "-");
        double from = 0, to = 0;
        ASSERT_EQ(std::sscanf(text.c_str(), "between %lf and %lf", &from, &to), 2) << text;
        const double tiny = 1e-8 * width;
        EXPECT_LE(from, p.q5 + tiny) << text;
        EXPECT_GE(to, p.q95 - tiny) << text;
        EXPECT_LE(to - from, 1.21 * width) << text;
        const double step = std::pow(10., std::floor(std::log10(width / 10)));
        numNarrower += std::round(p.q95 / step) * step < p.q95 - tiny;
    }
    EXPECT_GT(numNarrower, 500);
}

TEST(EstimateReport, WhoTellsAParameterIsByItsDeviations) {
    EstimateParameter p;
    p.priorSd = 2;
    const auto at = [&](double sd) { return p.sd = sd, WhatTells(p); };
    EXPECT_EQ(at(0.99), ToldBy::Data);
    EXPECT_EQ(at(1.01), ToldBy::Little);
    EXPECT_EQ(at(1.79), ToldBy::Little);
    EXPECT_EQ(at(1.81), ToldBy::Prior);
    EXPECT_EQ(ShareTold(p), 1 - 1.81 / 2);
    p.sd = 3;
    EXPECT_EQ(ShareTold(p), 0);
    EXPECT_EQ(at(kUnknown), ToldBy::Unknown);
    EXPECT_TRUE(std::isnan(ShareTold(p)));
    p.sd = 1, p.priorSd = 0;
    EXPECT_EQ(WhatTells(p), ToldBy::Unknown);
}

TEST(EstimateReport, GoodResultsHaveAPlainVerdictAndNoWarning) {
    const EstimateReport report = GoodReport();
    EXPECT_TRUE(HasConverged(report));
    EXPECT_EQ(
        VerdictOn(report),
        "The model looks as much like the photograph as two samples of one material look like each "
        "other, and "
        "the photograph tells red albedo, roughness, height of the relief and size of cells, but says little "
        "about strength of the light and power, and hardly anything about roughness in creases.");
    EXPECT_EQ(WarningsOf(report), std::vector<std::string>());
    const std::string told = FindingOn(report, "The photograph tells");
    EXPECT_TRUE(Has(told, "With 90\u00a0% probability, if the model is right: ")) << told;
    for (const EstimateParameter& p : report.parameters)
        if (p.factors.empty()) {
            EXPECT_EQ(Has(told, LabelOf(p) + " " + IntervalText(p)), WhatTells(p) == ToldBy::Data) << p.name;
        }
    EXPECT_TRUE(Has(FindingOn(report, "Chains"), "4 chains of 500 draws"));
    EXPECT_TRUE(Has(FindingOn(report, "Chains"), "R-hat is 1.004 (power")) << FindingOn(report, "Chains");
}

// One thing after the other goes wrong, and each is said.
TEST(EstimateReport, EachWeaknessIsSaid) {
    const auto with = [](const std::function<void(EstimateReport*)>& change) {
        EstimateReport report = GoodReport();
        change(&report);
        return report;
    };
    const struct {
        std::function<void(EstimateReport*)> change;
        const char *warning, *verdict;
        bool hasConverged;
    } cases[] = {
        {[](auto* r) { r->parameters[2].rhat = 1.31; }, "disagree, most about roughness (R-hat 1.31)",
         "Do not rely", false},
        {[](auto* r) { r->parameters[2].rhat = kUnknown; }, "agree about roughness is not known",
         "Do not rely", false},
        {[](auto* r) { r->parameters[5].essTail = 99; }, "only 99 independent draws of power", "Do not rely",
         false},
        {[](auto* r) { r->parameters[5].essBulk = kUnknown; }, "draws there are of power is not known",
         "Do not rely", false},
        {[](auto* r) { r->wasStopped = true; }, "time ended", "Do not rely", false},
        {[](auto* r) { r->hasMeanSettled = false; }, "last wave", "Do not rely", false},
        {[](auto* r) { r->parameters[2].rhat = 1.03; }, "R-hat reaches 1.030 (roughness)", "photograph tells",
         true},
        {[](auto* r) { r->parameters[5].essTail = 250; }, "draws of power are worth 250", "photograph tells",
         true},
        {[](auto* r) { r->tau = 2.34, r->misfit = 5.4; }, "by 2.3 standard deviations",
         "misses it by 2.3 times", true},
        {[](auto* r) { r->misfit = 5.4; }, "too narrow", "misses it by 2.3 times", true},
        {[](auto* r) { r->tau = 4, r->misfit = 16; }, "by 4 standard deviations", "does not look like", true},
        {[](auto* r) { r->isCalibrated = false, r->handError = 0.02; }, "set to 0.02 by hand", "by hand",
         true},
        {[](auto* r) { r->numDivergent = 2; }, "2 steps of the sampler diverged", "tells", true},
        {[](auto* r) { r->lowestEbfmi = 0.2; }, "E-BFMI is 0.2", "tells", true},
        {[](auto* r) { r->paretoK = 0.8; }, "Pareto k is 0.8", "tells", true},
        {[](auto* r) { std::fill_n(r->checks[3].shares.begin(), 10, 0.); },
         "of 48 summaries that were not used", "tells", true},
        {[](auto* r) { r->warnings = {"Own."}; }, "Own.", "tells", true}};
    for (const auto& each : cases) {
        const EstimateReport report = with(each.change);
        const std::vector<std::string> warnings = WarningsOf(report);
        ASSERT_EQ(warnings.size(), 1u) << each.warning << fmt::format("{}", fmt::join(warnings, "|"));
        EXPECT_TRUE(Has(warnings[0], each.warning)) << warnings[0];
        EXPECT_TRUE(Has(VerdictOn(report), each.verdict)) << VerdictOn(report);
        EXPECT_EQ(HasConverged(report), each.hasConverged) << each.warning;
        // Without convergence no interval has a probability.
        for (const EstimateFinding& finding : FindingsOf(report))
            EXPECT_TRUE(each.hasConverged || !Has(finding.text, "90\u00a0% probability")) << finding.text;
        EXPECT_EQ(Has(FindingOn(report, "The photograph tells"), "90\u00a0% probability"), each.hasConverged);
        EXPECT_EQ(Has(VerdictOn(report), "tells"), each.hasConverged) << VerdictOn(report);
    }
    EXPECT_GT(WarningsOf(BadReport()).size(), 8u);
    // What is known to be bad is said before what is not known.
    EXPECT_TRUE(Has(VerdictOn(BadReport()), "a_long_name_of_a_parameter_22 (R-hat 1.53)"))
        << VerdictOn(BadReport());
}

TEST(EstimateReport, BoundsThatEndAnIntervalAreNamed) {
    EstimateReport report = GoodReport();
    EXPECT_EQ(FindingOn(report, "At a limit"), "");
    EXPECT_FALSE(Has(VerdictOn(report), "limit"));
    report.parameters[0].shareAtHigh = 0.12;
    EXPECT_TRUE(Has(FindingOn(report, "At a limit"),
                    "12\u00a0% of strength of the light is at the upper limit 2500."));
    EXPECT_TRUE(Has(VerdictOn(report), "strength of the light into its upper limit."));
    report.parameters[0].shareAtHigh = 0.04;
    EXPECT_FALSE(Has(VerdictOn(report), "limit"));
}

TEST(EstimateReport, ProductsAreSaidOnlyWhereTheyAreKnownBetter) {
    EstimateReport report = GoodReport();
    const std::string text = FindingOn(report, "Known as a product");
    EXPECT_TRUE(
        Has(text, "if the model is right: light × red " + IntervalText(report.parameters.back()) + ", " +
                      fmt::format("{:.0f}", 100 * ShareTold(report.parameters.back())) +
                      "\u00a0% narrower than assumed; strength of the light and red albedo alone at most"))
        << text;
    // The factors alone are known as well.
    report.parameters[0].sd = 0.2 * report.parameters[0].priorSd;
    report.parameters[1].sd = 0.2 * report.parameters[1].priorSd;
    report.parameters.back().sd = 0.19 * report.parameters.back().priorSd;
    EXPECT_EQ(FindingOn(report, "Known as a product"), "");
}

TEST(EstimateReport, TrueValuesAreCounted) {
    EstimateReport report = GoodReport();
    size_t inside = 0;
    for (size_t i = 0; i < 7; ++i) {
        const EstimateParameter& p = report.parameters[i];
        inside += p.q5 <= *p.truth && *p.truth <= p.q95;
    }
    EXPECT_TRUE(Has(FindingOn(report, "True values"), fmt::format("{} of 7 lie inside", inside)));
    report.parameters[6].truth = 100;
    EXPECT_TRUE(Has(FindingOn(report, "True values"), fmt::format("{} of 7 lie inside", inside - 1)));
    EXPECT_TRUE(Has(FindingOn(report, "True values"), "size of cells."));
    for (EstimateParameter& p : report.parameters) p.truth.reset();
    EXPECT_EQ(FindingOn(report, "True values"), "");
}

// Where photograph and predictions are alike, the number outside is what the page calls chance.
TEST(EstimateReport, ChanceOutsideOfPredictionsIsRight) {
    constexpr int kPredicted = 50, kSummaries = 40000;
    std::mt19937 random(2);
    EstimateReport report;
    report.numPredicted = kPredicted;
    report.checks = {{"alike", true, {}, {}}};
    for (int i = 0; i < kSummaries; ++i) {
        const auto own = random();
        int above = 0;
        for (int k = 0; k < kPredicted; ++k) above += random() > own;
        report.checks[0].shares.push_back(double(above) / kPredicted);
    }
    const OutsideCount outside = CountOutside(report, true);
    EXPECT_EQ(outside.of, size_t(kSummaries));
    EXPECT_NEAR(double(outside.count), outside.expected, 4 * std::sqrt(outside.expected));
    // Control: another rule of thumb, 2 / n, is told apart.
    EXPECT_GT(std::abs(2. * kSummaries / (kPredicted - 5) - outside.expected),
              4 * std::sqrt(outside.expected));
    EXPECT_EQ(CountOutside(report, false).of, 0u);
}

TEST(EstimateReport, NumbersFollowFromTheDraws) {
    const EstimateReport report = GoodReport();
    const Json results = EstimateReportResults(report);
    EXPECT_EQ(results["schema"], "lacquer-estimate-report-1");
    for (size_t i = 0; i < report.parameters.size(); ++i) {
        const Json& entry = results["parameters"][i];
        EXPECT_NEAR(entry["mean"].get<double>() / report.parameters[i].mean, 1, 1e-5);
        double mass = 0, mean = 0;
        const double step = entry["histogram"]["step"], from = entry["histogram"]["from"];
        for (size_t k = 0; k < entry["histogram"]["densities"].size(); ++k) {
            const double share = entry["histogram"]["densities"][k].get<double>() * step;
            mass += share, mean += share * (from + (double(k) + 0.5) * step);
        }
        EXPECT_GT(mass, 0.99);
        EXPECT_LE(mass, 1 + 1e-4);
        EXPECT_NEAR(mean / mass, report.parameters[i].mean, 0.15 * report.parameters[i].sd);
        const Json& traces = entry["traces"];
        const size_t every = traces["every"];
        EXPECT_EQ(traces["chains"].size(), 4u);
        EXPECT_LE(traces["chains"][0].size(), 240u);
        EXPECT_NEAR(traces["chains"][2][7].get<double>() / report.parameters[i].chains[2][7 * every], 1,
                    1e-5);
        const Json& curve = entry["prior_curve"];
        double area = 0;
        for (size_t k = 1; k < curve["x"].size(); ++k)
            area += (curve["x"][k].get<double>() - curve["x"][k - 1].get<double>()) *
                    (curve["y"][k].get<double>() + curve["y"][k - 1].get<double>()) / 2;
        EXPECT_NEAR(area, 1, entry["factors"].empty() ? 0.003 : 0.05) << entry["name"];
    }
    // By construction light and red share .95 of a common part, with opposite signs.
    const Json& correlations = results["correlations"];
    EXPECT_EQ(correlations["names"].size(), 7u);
    EXPECT_NEAR(correlations["values"][0][1].get<double>(), -0.95 * 0.95, 0.02);
    EXPECT_NEAR(correlations["values"][0][6].get<double>(), 0, 0.07);
    EXPECT_EQ(correlations["values"][3][3], 1);
    ASSERT_EQ(results["pairs"].size(), 6u);
    EXPECT_EQ(results["pairs"][0]["a"], "light");
    EXPECT_EQ(results["pairs"][0]["b"], "red");
    EXPECT_EQ(results["residuals"].size(), 5u);
    EXPECT_EQ(results["residuals"][0]["text"],
              "energy at 8 cycles/cm: the photograph has less than the model, by 2.1 standard deviations");
    EXPECT_NEAR(results["maps"][2]["most"].get<double>(), 0.2, 0.04);
}

TEST(EstimateReport, WhatIsNotKnownIsLeftOut) {
    const Json results = EstimateReportResults(MapOnlyReport());
    EXPECT_TRUE(results["correlations"].is_null());
    EXPECT_TRUE(results["parameters"][0]["histogram"].is_null());
    EXPECT_TRUE(results["parameters"][0]["sd"].is_null());
    EXPECT_TRUE(Has(results["verdict"], "how uncertain they are was not computed"));
    EXPECT_TRUE(results["warnings"].empty());
    const Json empty = EstimateReportResults({});
    EXPECT_TRUE(empty["photo"].is_null());
    EXPECT_TRUE(Has(empty["verdict"], "there are no chains"));
}

TEST(EstimateReport, TextsDoNotBecomeMarkup) {
    EstimateReport harmless = BadReport();
    harmless.title = "x";
    const std::string plain = MakeEstimateReport(GoodReport()), hostile = MakeEstimateReport(BadReport());
    EXPECT_EQ(Json::parse(Between(hostile, "<script type=\"application/json\" id=\"results\">", "</script>")),
              EstimateReportResults(BadReport()));
    const size_t more = GoodReport().draws.size() + GoodReport().maps.size() + 1 - BadReport().maps.size();
    EXPECT_EQ(Count(hostile, "<script") + more, Count(plain, "<script"));
    for (const char* mark : {"<!--", "<title"}) EXPECT_EQ(Count(hostile, mark), Count(plain, mark)) << mark;
    EXPECT_FALSE(Loads(hostile));
    EXPECT_FALSE(Loads(plain));
    EXPECT_TRUE(Has(hostile, "default-src 'none'"));
    EXPECT_TRUE(Has(Between(hostile, "<title>", "</title>"), "&lt;/script&gt;"));
}

// The folder of LACQUER_REPORT_PAGES gets the pages that tests/report opens in a browser.
TEST(EstimateReport, IsOneFileInItsFolder) {
    const char* wanted = std::getenv("LACQUER_REPORT_PAGES");
    const std::filesystem::path folder = wanted ? wanted : testing::TempDir() + "lacquer_estimate_report";
    const std::pair<const char*, EstimateReport> cases[] = {
        {"estimate-good", GoodReport()}, {"estimate-bad", BadReport()}, {"estimate-map", MapOnlyReport()}};
    for (const auto& [name, report] : cases) {
        std::filesystem::create_directories(folder / name);
        WriteEstimateReport((folder / name).string(), report);
        EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder / name), {}), 1);
        std::ifstream file(folder / name / "report.html");
        const std::string page((std::istreambuf_iterator<char>(file)), {});
        EXPECT_EQ(page, MakeEstimateReport(report));
        EXPECT_LT(page.size(), 2u << 20);
    }
    if (!wanted) std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace lacquer::cmd::estimate_report_test
