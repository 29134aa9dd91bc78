// The page of `lacquer bulk`: it says what was computed, what is in it can be read back, and nothing in it
// breaks out or loads. tests/report looks at the page in a browser.
#include "cmd/bulk/report.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "cmd/bulk/report_sentences.h"
#include "cmd/bulk/thumbnails.h"
#include "cmd/page_checks.h"
#include "cmd/page_parts.h"
#include "support/bulk_tables.h"

namespace lacquer::cmd::bulk_report_test {
namespace {

using namespace bulk;
using test::WriteFile;
using Json = nlohmann::ordered_json;

BulkSettings Droplets(BulkMethod method) {
    BulkSettings settings;
    settings.ensemble.species = {{"fat", RadiusDistribution::Constant(0.1), 0.03},
                                 {"casein", RadiusDistribution::Constant(0.06), 0.01}};
    settings.ensemble.count = 5;
    settings.indices = {OpticalIndex(1.46), OpticalIndex({1.52, 0.01})};
    settings.hostIndex = 1.33;
    settings.wavelengths = {450, 650};
    settings.method = method;
    return settings;
}

BulkComputation Solved(const BulkSettings& settings, int numRealizations) {
    BulkComputation computation(settings);
    if (numRealizations > 0) computation.AddRealizations(numRealizations, nullptr);
    return computation;
}

Json ResultsOf(const BulkComputation& computation, const BulkReportContext& context = {}) {
    return BulkReportResults(computation, computation.Table(), context);
}

/// All strings below a value.
std::string StringsOf(const Json& value) {
    if (value.is_string()) return value.get<std::string>() + "\n";
    std::string text;
    if (value.is_structured())
        for (const Json& each : value) text += StringsOf(each);
    return text;
}

TEST(BulkReport, NumbersAreThoseOfTheTable) {
    const BulkComputation computation = Solved(Droplets(BulkMethod::Clusters), 7);
    const BulkTable table = computation.Table();
    const Json results = BulkReportResults(computation, table, {});
    EXPECT_EQ(results["mode"], "medium");
    EXPECT_EQ(results["realisations"], 7);
    ASSERT_EQ(results["wavelengths"].size(), 2u);
    constexpr double kSixDigits = 1e-5;
    for (size_t w = 0; w < 2; ++w) {
        const Json& entry = results["wavelengths"][w];
        EXPECT_NEAR(entry["sigma_s"].get<double>() / table.sigmaS[w], 1, kSixDigits);
        EXPECT_NEAR(entry["sigma_s_error"].get<double>() / table.errorSigmaS[w], 1, kSixDigits);
        EXPECT_NEAR(entry["sigma_a"].get<double>() / table.sigmaA[w], 1, kSixDigits);
        ASSERT_EQ(entry["phase"].size(), table.angles.size());
        // Both coefficients are cross sections times the number of particles in a cubic millimetre.
        const double perCubicMicrometre = table.sigmaS[w] / 1000 / entry["c_sca"].get<double>();
        EXPECT_NEAR(perCubicMicrometre / computation.GetEnsemble().NumberDensity(), 1, 2 * kSixDigits);
        EXPECT_NEAR(entry["c_abs"].get<double>() * perCubicMicrometre * 1000 / table.sigmaA[w], 1,
                    4 * kSixDigits);
    }
    EXPECT_NE(results["wavelengths"][0]["sigma_s"], results["wavelengths"][1]["sigma_s"]);
}

// The parts of the light add up, and the one of the mode is that of the table.
TEST(BulkReport, PartsAddUpToTheWhole) {
    const BulkComputation computation = Solved(Droplets(BulkMethod::Clusters), 7);
    const BulkTable table = computation.Table();
    const Json results = BulkReportResults(computation, table, {});
    const Json& entry = results["wavelengths"][0];
    const Json& parts = entry["parts"];
    for (size_t i = 0; i < table.angles.size(); i += 10) {
        const double total = parts["total"][i], coherent = parts["coherent"][i],
                     incoherent = parts["incoherent"][i];
        EXPECT_NEAR(coherent + incoherent, total, 3e-5 * std::abs(total)) << i;
        EXPECT_NEAR(incoherent / (table.phase[0][i] * entry["c_sca"].get<double>()), 1, 0.02) << i;
    }
    // Control: the mean field has a part straight on that shows.
    EXPECT_GT(parts["coherent"][0].get<double>(), 0.05 * parts["total"][0].get<double>());
}

TEST(BulkReport, ConvergenceEndsAtTheResult) {
    const Json results = ResultsOf(Solved(Droplets(BulkMethod::Clusters), 9));
    for (const Json& entry : results["wavelengths"]) {
        const Json& history = entry["history"];
        ASSERT_EQ(history.size(), 8u);  // from two on
        EXPECT_EQ(history.back()["realisations"], 9);
        for (const char* key : {"c_ext", "c_sca", "g", "g_error"}) EXPECT_EQ(history.back()[key], entry[key]);
        EXPECT_NE(history[3]["c_ext"], entry["c_ext"]);
    }
}

// Independent spheres without an own computation: C of two sizes by their numbers.
TEST(BulkReport, IndependentParticlesStandBeside) {
    const Json results = ResultsOf(Solved(Droplets(BulkMethod::Clusters), 3));
    const BulkTable expected = BulkComputation(Droplets(BulkMethod::Independent)).Table();
    for (size_t w = 0; w < 2; ++w) {
        const Json& entry = results["wavelengths"][w]["independent"];
        EXPECT_NEAR(entry["sigma_s"].get<double>() / expected.sigmaS[w], 1, 1e-5);
        EXPECT_NEAR(entry["g"].get<double>() / expected.g[w], 1, 1e-5);
        EXPECT_NEAR(entry["phase"][7].get<double>() / expected.phase[w][7], 1, 1e-5);
    }
}

TEST(BulkReport, MethodsWithoutClustersHaveNoSectionsOfThem) {
    for (const BulkMethod method : {BulkMethod::Independent, BulkMethod::Structure}) {
        const Json results = ResultsOf(Solved(Droplets(method), 0));
        EXPECT_FALSE(results.contains("realisations"));
        EXPECT_TRUE(results["cluster"].is_null());
        EXPECT_TRUE(results["pairs"].is_null());
        EXPECT_FALSE(results["wavelengths"][0].contains("history"));
        EXPECT_FALSE(results["wavelengths"][0]["parts"].contains("total"));
        EXPECT_EQ(results["verdict"].get<std::string>().find("One standard error"), std::string::npos);
    }
    const Json control = ResultsOf(Solved(Droplets(BulkMethod::Clusters), 3));
    EXPECT_FALSE(control["cluster"].is_null());
    EXPECT_FALSE(control["pairs"].is_null());
}

TEST(BulkReport, VerdictAndWarningsSayWhatIsWeak) {
    EXPECT_NE(VerdictOn(Solved(Droplets(BulkMethod::Clusters), 2),
                        Solved(Droplets(BulkMethod::Clusters), 2).Table())
                  .find("2 realisations cannot tell"),
              std::string::npos);
    BulkSettings settings = Droplets(BulkMethod::Clusters);
    const auto warns = [&](const char* what) {
        const BulkComputation computation = Solved(settings, 3);
        std::string all;
        for (const std::string& caveat : CaveatsOf(computation, computation.Table())) all += caveat + "\n";
        return all.find(what) != std::string::npos;
    };
    EXPECT_FALSE(warns("optical depth"));
    EXPECT_FALSE(warns("same in each realisation"));
    settings.ensemble.arrangement = Arrangement::Uniform;
    EXPECT_TRUE(warns("same in each realisation"));
    settings.ensemble.arrangement = Arrangement::Cut;
    // Titania, crowded.
    settings.hostIndex = 1.5;
    settings.indices = {OpticalIndex(2.75), OpticalIndex(2.75)};
    settings.ensemble.species[0].volumeFraction = 0.2;
    EXPECT_TRUE(warns("optical depth"));
    // A ball of one sphere on the mean may have none; one sphere as such is exact.
    constexpr const char* kExact = "Exact: one sphere scatters as Lorenz–Mie theory says.";
    settings.ensemble.count = 1;
    const BulkComputation mean = Solved(settings, 12);
    EXPECT_NE(VerdictOn(mean, mean.Table()), kExact);
    settings.ensemble.species = {{"one", RadiusDistribution::Constant(0.1), 0.01}};
    settings.indices.resize(1, OpticalIndex(1));
    settings.ensemble.arrangement = Arrangement::Uniform;
    settings.mode = AverageMode::Aggregate;
    const BulkComputation one = Solved(settings, 2);
    EXPECT_EQ(VerdictOn(one, one.Table()), kExact);
}

// The page shows the coefficients that scenes read, and beside them those of each size.
TEST(BulkReport, ExtrapolatedTablesAreShownAsWritten) {
    std::vector<SizeResult> sizes;
    BulkSettings settings = Droplets(BulkMethod::Clusters);
    for (const int count : {3, 6}) {
        settings.ensemble.count = count;
        const BulkComputation computation = Solved(settings, 6);
        sizes.push_back(ResultOf(computation, computation.Rows()));
    }
    sizes.push_back(Extrapolate(sizes));
    const BulkComputation largest = Solved(settings, 6);
    BulkTable table = largest.Table();
    table.sigmaS[1] = sizes[2].sigmaS[1].mean;
    BulkReportContext context;
    context.sizes = sizes;
    const Json results = BulkReportResults(largest, table, context);
    ASSERT_EQ(results["sizes"].size(), 3u);
    EXPECT_EQ(results["sizes"][2]["wavelengths"][1]["sigma_s"], results["wavelengths"][1]["sigma_s"]);
    EXPECT_NE(results["sizes"][1]["wavelengths"][1]["sigma_s"], results["wavelengths"][1]["sigma_s"]);
    EXPECT_EQ(results["sizes"][1]["wavelengths"][0]["sigma_s"], results["wavelengths"][0]["sigma_s"]);
    context.sizes.resize(1);
    EXPECT_TRUE(BulkReportResults(largest, table, context)["sizes"].empty());
}

TEST(BulkReport, NamesAndInputsDoNotBecomeMarkup) {
    const auto page = [](const std::string& name) {
        BulkSettings settings = Droplets(BulkMethod::Clusters);
        settings.ensemble.species[0].name = name;
        BulkReportContext context;
        context.input = context.command = "{\"name\": \"" + name + "\"}";
        const Json results = ResultsOf(Solved(settings, 3), context);
        EXPECT_NE(StringsOf(results).find(name), std::string::npos);
        const std::string text = MakeBulkReport(results, {});
        EXPECT_EQ(
            Json::parse(Between(text, "<script type=\"application/json\" id=\"results\">", "</script>")),
            results);
        return text;
    };
    const std::string harmless = page("x"), hostile = page(kHostile);
    for (const char* mark : {"<script", "</script", "<!--", "<title"})
        EXPECT_EQ(Count(hostile, mark), Count(harmless, mark)) << mark;
    EXPECT_FALSE(Loads(hostile));
    EXPECT_NE(hostile.find("default-src 'none'"), std::string::npos);
    EXPECT_NE(hostile.find("Chart.js Contributors"), std::string::npos);
    EXPECT_NE(Between(hostile, "<title>", "</title>").find("&lt;/script&gt;"), std::string::npos);
}

// Light that leaves the wedge at its thin edge is the lamp's, and the image is the same each time.
TEST(BulkReport, ThumbnailsShowTheMedium) {
    const BulkTable table = test::HgTable({400, 550, 700}, {0.6, 0.6, 0.6}, {4, 1, 0.25}, {0, 0, 0});
    const std::string path = WriteFile("a \"quoted\" name.json", table);
    const std::vector<BulkThumbnail> first = RenderBulkThumbnails(path, table, 24);
    ASSERT_EQ(first.size(), 2u);
    const Image& wedge = first[0].image;
    const auto mean = [&](double from, double to, int channel) {
        double sum = 0;
        int count = 0;
        for (int y = 0; y < wedge.Resolution().y; ++y)
            for (int x = int(from * wedge.Resolution().x); x < int(to * wedge.Resolution().x); ++x, ++count)
                sum += double(wedge.Get({x, y}, channel));
        return sum / count;
    };
    EXPECT_NEAR(mean(0, 0.05, 1), 1, 0.1);
    // Red light comes through where blue light is sent back.
    EXPECT_GT(mean(0.9, 1, 0), 1.5 * mean(0.9, 1, 2));
    EXPECT_LT(mean(0.9, 1, 1), 0.7 * mean(0, 0.05, 1));
    EXPECT_EQ(PixelsForPage(RenderBulkThumbnails(path, table, 24)[0].image), PixelsForPage(wedge));
    BulkTable nothing = table;
    nothing.sigmaS.assign(3, 0.);
    EXPECT_TRUE(RenderBulkThumbnails(path, nothing, 24).empty());
}

// The file's numbers, not those of the balls, whose light is scattered more than once.
TEST(BulkReport, OfMediaFromThickBallsHasTheirNumbers) {
    BulkSettings settings = Droplets(BulkMethod::Clusters);
    settings.hostIndex = 1.5;
    settings.indices = {OpticalIndex(2.75), OpticalIndex(2.75)};
    settings.ensemble.species[0].volumeFraction = 0.1;
    settings.removesMultipleScattering = true;
    const BulkComputation computation = Solved(settings, 8);
    const std::vector<BulkRow> rows = computation.Rows();
    const Json results = BulkReportResults(computation, computation.TableOf(rows), {});
    for (size_t w = 0; w < 2; ++w) {
        const Json& entry = results["wavelengths"][w];
        EXPECT_NEAR(entry["sigma_s"].get<double>() / rows[w].sigmaS.mean, 1, 1e-5);
        EXPECT_NEAR(entry["g"].get<double>() / rows[w].g.mean, 1, 1e-5);
        EXPECT_NEAR(entry["g_error"].get<double>() / rows[w].g.error, 1, 0.05);
        const ScatteringAverage ofBall = computation.AverageAt(w);
        EXPECT_GT(std::abs(ofBall.g.mean - rows[w].g.mean), 0.01) << "a control";
        EXPECT_GT(entry["g_error"].get<double>(), 1.1 * ofBall.g.error) << "a control";
    }
    EXPECT_NE(results["summary"].get<std::string>().find("scattered several times"), std::string::npos);
}

/// A flat cloud of droplets with a common axis.
OrientedComputation SolvedOriented(int numRealizations, AverageMode mode = AverageMode::Aggregate) {
    BulkSettings settings = Droplets(BulkMethod::Clusters);
    settings.ensemble.arrangement = Arrangement::Gaussian;
    settings.ensemble.deviations = {0.3, 0.3, 0.1};
    settings.mode = mode;
    OrientedComputation computation(settings, {.numIncidences = 4, .numAzimuths = 7});
    computation.AddRealizations(numRealizations, nullptr);
    return computation;
}

TEST(BulkReport, OfOrientedEnsemblesHasTheNumbersOfTheTable) {
    const OrientedComputation computation = SolvedOriented(9);
    const OrientedBulkTable table = computation.Table();
    const Json results = OrientedReportResults(computation, table, {});
    EXPECT_EQ(results["oriented"]["incidences"], 4);
    EXPECT_FALSE(results["cluster"].is_null());
    constexpr double kSixDigits = 1e-5;
    for (size_t w = 0; w < 2; ++w) {
        const Json& entry = results["wavelengths"][w];
        ASSERT_EQ(entry["incidences"].size(), 4u);
        for (size_t i = 0; i < 4; ++i) {
            const Json& incidence = entry["incidences"][i];
            EXPECT_NEAR(incidence["angle"].get<double>(), table.angles[i], 1e-9);
            EXPECT_NEAR(incidence["sigma_s"].get<double>() / table.sigmaS[w][i], 1, kSixDigits);
            EXPECT_NEAR(incidence["sigma_t"].get<double>() / (table.sigmaS[w][i] + table.sigmaA[w][i]), 1,
                        kSixDigits);
            EXPECT_GT(incidence["sigma_t_error"].get<double>(), 0);
            EXPECT_GT(incidence["albedo_error"].get<double>(), 0);
        }
        EXPECT_NEAR(entry["sigma_s_error"].get<double>() / table.errorSigmaS[w], 1, kSixDigits);
        EXPECT_EQ(entry["history"].back()["c_ext"], entry["c_ext"]);
        // Incidences 0, 30, 60 and 90 degrees; p at the angle 60, this side and the other.
        ASSERT_EQ(entry["slices"].size(), 4u);
        for (size_t i = 0; i < 4; ++i) {
            const Json& slice = entry["slices"][i];
            ASSERT_EQ(slice["p"].size(), 12u);
            EXPECT_EQ(slice["angles"][2], 60);
            EXPECT_EQ(slice["angles"][10], 300);
            const size_t at = (i * 7 + 2) * 7;
            EXPECT_NEAR(slice["p"][2].get<double>() / double(table.phase[w][at]), 1, kSixDigits);
            EXPECT_NEAR(slice["p"][10].get<double>() / double(table.phase[w][at + 6]), 1, kSixDigits);
        }
        // Light across the axis goes on, not back.
        EXPECT_GT(entry["slices"][3]["p"][3].get<double>(), entry["slices"][3]["p"][9].get<double>());
    }
    EXPECT_NE(results["verdict"].get<std::string>().find("One standard error"), std::string::npos);
    const OrientedComputation few = SolvedOriented(3);
    EXPECT_NE(VerdictOn(few, few.Table()).find("3 realisations cannot tell"), std::string::npos);
    EXPECT_NE(results["summary"].get<std::string>().find("axis"), std::string::npos);
    EXPECT_FALSE(ResultsOf(Solved(Droplets(BulkMethod::Clusters), 3)).contains("oriented")) << "a control";
}

// In `medium` and `chapter` scattering is a part of what light loses: sigma_t is that of the file, with its
// own error, and not the extinction (the control).
TEST(BulkReport, OfOrientedEnsemblesHasTheExtinctionOfTheFileInAllModes) {
    for (const AverageMode mode : {AverageMode::Aggregate, AverageMode::Medium, AverageMode::Chapter}) {
        const OrientedComputation computation = SolvedOriented(9, mode);
        const OrientedBulkTable table = computation.Table();
        const Json results = OrientedReportResults(computation, table, {});
        for (size_t w = 0; w < 2; ++w)
            for (size_t i = 0; i < 4; ++i) {
                const Json& incidence = results["wavelengths"][w]["incidences"][i];
                const double sigmaT = incidence["sigma_t"], error = incidence["sigma_t_error"];
                EXPECT_NEAR(sigmaT / (table.sigmaS[w][i] + table.sigmaA[w][i]), 1, 1e-5) << ModeName(mode);
                const double s = incidence["sigma_s_error"], a = incidence["sigma_a_error"];
                EXPECT_GE(error, 0.9999 * std::abs(s - a));
                EXPECT_LE(error, 1.0001 * (s + a));
                EXPECT_GT(error, 0);
                const OrientedMeans means = computation.MeansOfIncidences(w)[i];
                const double difference = std::abs(means.extinction.mean / means.sum.mean - 1);
                if (mode == AverageMode::Aggregate) {
                    EXPECT_LT(difference, 1e-3);
                } else {
                    EXPECT_GT(difference, 0.01) << ModeName(mode);
                }
            }
    }
}

TEST(BulkReport, IsOneFileInItsFolder) {
    const BulkComputation computation = Solved(Droplets(BulkMethod::Clusters), 24);
    const std::string table = WriteFile("droplets.json", computation.Table());
    const std::filesystem::path folder = std::filesystem::path(table).parent_path();
    BulkReportContext context;
    context.thumbnailPixels = 16;
    WriteBulkReport(folder.string(), computation, computation.Table(), context, table);
    std::ifstream file(folder / "report.html");
    const std::string page((std::istreambuf_iterator<char>(file)), {});
    EXPECT_EQ(Count(page, "class=\"image\""), 2u);
    EXPECT_NE(page.find("data-file=\"wedge\" data-width=\"16\""), std::string::npos);
    EXPECT_LT(page.size(), 2u << 20);
}

}  // namespace
}  // namespace lacquer::cmd::bulk_report_test
