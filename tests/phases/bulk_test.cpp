// Files of bulk scattering in media and slabs: what is rendered is what they say.
#include "pbrt/phases/bulk.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "media/medium_fixtures.h"
#include "pbrt/phases/hg.h"
#include "phases/phase_checks.h"
#include "phases/phase_scenes.h"
#include "support/bulk_tables.h"
#include "support/nanovdb_fog.h"

namespace lacquer::test::bulk_test {
namespace {

constexpr double kAlpha = 1e-5;  // some forty runs in this file

/// Rows that differ at each of the four wavelengths of the tests: 750 nm is beyond the last one.
BulkTable FourColours(bool absorbs = true) {
    return HgTable({400, 500, 600, 700}, {0.85, 0.4, -0.3, 0.1}, {4, 2.5, 1, 0.5},
                   absorbs ? std::vector<double>{0, 0.1, 0.5, 0.2} : std::vector<double>(4));
}
const std::vector<double> kFour = {450, 550, 650, 750};

/// Linear between the wavelengths of a table, constant beyond.
double At(const BulkTable& table, double lambda, const std::function<double(size_t)>& value) {
    const std::vector<double>& w = table.wavelengths;
    if (lambda <= w.front()) return value(0);
    for (size_t i = 1; i < w.size(); ++i)
        if (lambda <= w[i]) {
            const double x = (lambda - w[i - 1]) / (w[i] - w[i - 1]);
            return (1 - x) * value(i - 1) + x * value(i);
        }
    return value(w.size() - 1);
}

/// A parameter that names a file with the table.
std::string Bulk(const BulkTable& table, const std::string& name = "t.json") {
    return "\"string bulk\" \"" + WriteFile(name, table) + "\" ";
}

/// The phase function of a table, at the four wavelengths.
struct Made {
    explicit Made(const BulkTable& table) : model(table, "t.json", {}) {}
    const PhaseFunction& operator*() {
        const Frame frame;
        return *model.Make({frame, Four()}, arena);
    }
    IsotropicBulkModel model;
    Arena arena;
};

// ---- The phase function ----

// 200,000 draws over some 400 cells at each wavelength; the control draws at another one.
TEST(BulkPhase, SamplesFollowP) {
    Made made(FourColours());
    const PhaseFunction& phase = *made;
    const Vec3 wo = Normalize({0.3f, -0.5f, 0.7f});
    SphereGrid grid = SphereGrid::Geometric(-wo);
    grid.subT = 64;  // kinks at the nodes
    for (int l = 0; l < kNumTested; ++l) {
        const AtWavelength at(phase, l);
        EXPECT_TRUE(Passes(fmt::format("{} {}", FullTestName(), l), SidakAlpha(1e-3, 4),
                           [&](uint64_t seed) { return SamplesFollow(at, at, wo, grid, seed); }));
    }
    EXPECT_LT(SamplesFollow(AtWavelength(phase, 2), AtWavelength(phase, 3), wo, grid, 1).pValue, 1e-6);
}

// Power: 10^6 draws find a difference of 0.003; rows are 0.2 or more apart.
TEST(BulkPhase, MeanCosineOfSamplesIsTheFilesG) {
    const BulkTable table = FourColours();
    Made made(table);
    const PhaseFunction& phase = *made;
    for (int l = 0; l < kNumTested; ++l) {
        const double expected = At(table, kFour[size_t(l)], [&](size_t i) { return table.g[i]; });
        EXPECT_TRUE(Passes(fmt::format("{} {}", FullTestName(), l), SidakAlpha(1e-3, 4), [&](uint64_t seed) {
            Rng rng(seed);
            RunningMean mean;
            const Vec3 wo(0.6f, 0, -0.8f);
            for (int i = 0; i < 1000000; ++i) mean.Add(double(Dot(-wo, phase.SampleAt(l, wo, rng))));
            EXPECT_LT(mean.StandardError(), 7e-4);
            return ZTest(mean, expected, 1e-6, "mean cosine");
        }));
    }
}

TEST(BulkPhase, OfHenyeyAndGreensteinIsTheirs) {
    for (const double g : {0.5, -0.5, 0.2}) {
        Made made(HgTable({550}, {g}, {1}, {0}));
        const PhaseFunction& phase = *made;
        EXPECT_FALSE(phase.IsChromatic());
        const HenyeyGreensteinPhase hg{float(g)};
        for (float a = 0; a < Pi; a += 0.013f) {
            const Vec3 wi(std::sin(a), 0, std::cos(a));
            const float p = hg.Evaluate({0, 0, -1}, wi).p;
            EXPECT_NEAR(phase.Evaluate({0, 0, -1}, wi).p / p, 1, 1e-3f) << g << ' ' << a;
        }
    }
}

/// Half of the light in a lobe of 0.2 degrees, linear in the cosine, and half everywhere; angles at the nodes
/// of an instrument, and more where the lobe is.
BulkTable Peak() {
    BulkTable table = HgTable({550}, {0}, {1}, {0});
    for (const double angle : {0.02, 0.05, 0.1, 0.15, 0.2}) table.angles.push_back(angle);
    std::sort(table.angles.begin(), table.angles.end());
    const auto t = [](double deg) { return 1 - std::cos(deg * M_PI / 180); };
    table.phase[0].clear();
    for (const double angle : table.angles)
        table.phase[0].push_back(1 / (8 * M_PI) + std::max(0., 1 - t(angle) / t(0.2)) / (2 * M_PI * t(0.2)));
    return table;
}

TEST(BulkPhase, AForwardPeakOfAFifthOfADegreeSurvives) {
    const BulkTable table = Peak();
    EXPECT_NEAR(NormOfPhase(table.angles, table.phase[0]), 1, 1e-9);
    Made made(table);
    const PhaseFunction& phase = *made;
    const auto at = [&](double deg) {
        const double a = deg * M_PI / 180;
        return double(phase.Evaluate({0, 0, -1}, {float(std::sin(a)), 0, float(std::cos(a))}).p);
    };
    const double peak = 1 / (2 * M_PI * (1 - std::cos(0.2 * M_PI / 180)));
    EXPECT_NEAR(at(0) / peak, 1, 1e-3);
    EXPECT_NEAR(at(0.1) / (0.75 * peak), 1, 1e-3);
    EXPECT_NEAR(at(0.15) / (0.4375 * peak), 1, 1e-3);
    EXPECT_NEAR(at(0.25), 1 / (8 * M_PI), 1e-6);
    // Half of the draws are in it, a quarter of those within a radius that has a quarter of its light.
    Rng rng(SeedOf(FullTestName()));
    const double half = 0.2 * std::sqrt(1 - std::sqrt(0.5));
    double inside = 0, core = 0;
    constexpr int kDraws = 400000;
    for (int i = 0; i < kDraws; ++i) {
        const Vec3 wi = phase.Sample({0, 0, -1}, rng).wi;
        const double deg = std::atan2(std::hypot(double(wi.x), double(wi.y)), double(wi.z)) * 180 / M_PI;
        inside += deg < 0.2;
        core += deg < half;
    }
    EXPECT_NEAR(inside / kDraws, 0.5, 4e-3);  // 5 standard errors
    EXPECT_NEAR(core / kDraws, 0.25, 4e-3);
    // The control: nodes at whole degrees would make it a lobe with more than five times the light.
    BulkTable coarse = HgTable({550}, {0}, {1}, {0});
    coarse.phase[0][0] += peak / 2;
    EXPECT_GT(NormOfPhase(coarse.angles, coarse.phase[0]), 5);
}

// ---- Coefficients ----

TEST(BulkMedia, HaveTheFilesCoefficientsTimesTheScale) {
    const BulkTable table = FourColours();
    const auto medium = MakeMedium("homogeneous", Bulk(table) + "\"float scale\" 10");
    const MediumProperties there = medium->At({0, 0, 0}, Four());
    for (int l = 0; l < kNumTested; ++l) {
        const double nm = kFour[size_t(l)];
        EXPECT_NEAR(there.sigma_s[l], 10 * At(table, nm, [&](size_t i) { return table.sigmaS[i]; }), 1e-5);
        EXPECT_NEAR(there.sigma_a[l], 10 * At(table, nm, [&](size_t i) { return table.sigmaA[i]; }), 1e-6);
    }
    const auto plain = MakeMedium("homogeneous", Bulk(table) + "\"string phase\" \"bulk\"");
    EXPECT_NEAR(plain->At({0, 0, 0}, Four()).sigma_s[0], 3.25, 1e-6);
}

// Density times the file's coefficients, and the file's phase function, in all that have a density.
TEST(BulkMedia, OnGridsAreTheHomogeneousOnesTimesTheDensity) {
    const std::string bulk = Bulk(FourColours()) + "\"float scale\" 2 ";
    const auto homogeneous = MakeMedium("homogeneous", bulk);
    const MediumProperties unit = homogeneous->At({0, 0, 0}, Four());
    Rng rng(SeedOf(FullTestName()));
    const std::pair<const char*, std::string> rows[] = {
        {"uniformgrid",
         "\"float density\" [1 2 3 4 0.5 1 2 7] \"integer nx\" 2 \"integer ny\" 2 \"integer nz\" 2"},
        {"cloud", ""},
        {"nanovdb", "\"string filename\" \"" + FogFile() + "\""}};
    for (const auto& [type, parameters] : rows) {
        const auto medium = MakeMedium(type, bulk + parameters);
        int numInside = 0;
        float least = Infinity, most = 0;
        for (int i = 0; i < 1000; ++i) {
            const MediumProperties there = medium->At(RandomPoint(rng), Four());
            const float density = there.sigma_s[0] / unit.sigma_s[0];
            if (!(density > 0)) continue;
            ++numInside;
            least = std::min(least, density), most = std::max(most, density);
            for (int l = 0; l < kNumWavelengths; ++l) {
                EXPECT_NEAR(there.sigma_s[l], density * unit.sigma_s[l], 1e-5f * there.sigma_s[l]) << type;
                EXPECT_NEAR(there.sigma_a[l], density * unit.sigma_a[l], 1e-5f * there.sigma_a[l]) << type;
            }
        }
        EXPECT_GT(numInside, 100) << type;
        EXPECT_GT(most, 1.05f * least) << type;
        EXPECT_TRUE(BoundsHold(*medium, {Point3(0), Point3(1)}, rng)) << type;
        EXPECT_FALSE(BoundsHold(*medium, {Point3(0), Point3(1)}, rng, 300, 40, 1e-5, 0.5))
            << type << ": control";
        Arena arena;
        const Vec3 wo = RandomDirection(rng), wi = RandomDirection(rng);
        EXPECT_EQ(medium->Phase(Four(), arena).EvaluateSpectral(wo, wi).p,
                  homogeneous->Phase(Four(), arena).EvaluateSpectral(wo, wi).p)
            << type;
    }
    const auto constant = MakeMedium("uniformgrid", bulk + "\"float density\" [3 3] \"integer nx\" 2");
    // Voxels count from their middles: the middle of the box is between the two.
    const MediumProperties middle = constant->At({0.5f, 0.5f, 0.5f}, Four());
    for (int l = 0; l < kNumWavelengths; ++l)
        EXPECT_NEAR(middle.sigma_s[l], 3 * unit.sigma_s[l], 1e-5f * middle.sigma_s[l]);
}

// ---- Rendered ----

std::string MediumText(const std::string& parameters) {
    return "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" " + parameters;
}
std::string SlabScene(const std::string& parameters, const std::string& light) {
    return View("volpath", 500, {1.5f, 1, 2}) + light +
           "MakeNamedMaterial \"s\" \"string type\" \"slab\" \"float eta\" 1 " + parameters +
           "Material \"layered\" \"string stack\" [\"interface\" \"s\" \"interface\"] Shape \"trianglemesh\" "
           "\"point3 P\" [-2 -2 0 2 -2 0 -2 2 0 2 2 0] \"integer indices\" [0 1 2 1 3 2] ";
}
const Vec3 kFront(-1, 0.5f, 1.2f), kBehind(0.4f, -1, -1.5f);

/// A medium or slab without absorption, or with an albedo of 0.98, in white surroundings.
std::vector<std::pair<std::string, std::string>> Furnaces(bool isLossy) {
    BulkTable table = FourColours(false);
    for (size_t i = 0; isLossy && i < 4; ++i) table.sigmaA[i] = table.sigmaS[i] / 49;
    const std::string bulk = Bulk(table), start = View("volpath", 4000, {3, 1, -2}) + kWhite;
    return {{"homogeneous", start + MediumText(bulk) + kBall},
            {"grid", start +
                         "MakeNamedMedium \"m\" \"string type\" \"uniformgrid\" \"point3 p0\" [-1 -1 -1] "
                         "\"float density\" [2 0.5 1 3] \"integer nx\" 2 \"integer ny\" 2 " +
                         bulk + kBall},
            {"slab", SlabScene(bulk + "\"float thickness\" 2 ", kWhite)}};
}

// In media the mean over the wavelengths of a path is 1 without any noise, for the balance heuristic divides
// by it. Slabs have a standard error of 0.06 %.
TEST(BulkFurnace, IsOne) {
    for (const auto& furnace : Furnaces(false)) {
        const std::string &name = furnace.first, &scene = furnace.second;  // lambdas capture no bindings
        if (name == "slab") {
            EXPECT_TRUE(Passes(FullTestName() + name, kAlpha, [&](uint64_t seed) {
                const RunningMean mean = CenterRadiance(BuildText(scene), Scaled(400000), seed);
                EXPECT_LT(mean.StandardError(), 0.42 / std::sqrt(Scaled(400000)));
                return ZTest(mean, 1, 1e-4, name);
            }));
        } else {
            const RunningMean mean = CenterRadiance(BuildText(scene), Scaled(20000), SeedOf(name));
            EXPECT_NEAR(mean.Mean(), 1, 2e-4) << name;
        }
    }
}

TEST(BulkFurnace, ALossOfOneInFiftyIsFound) {
    for (const auto& [name, scene] : Furnaces(true)) {
        const RunningMean mean = CenterRadiance(BuildText(scene), 20000, SeedOf(name));
        EXPECT_LT(ZTest(mean, 1, 1e-4, name).pValue, kAlpha) << name;
    }
}

// Each table of scenes/bulk, none of which absorbs, in a ball two mean free paths in radius at the table's
// first wavelength. As above the mean has no noise.
TEST(BulkFurnace, IsOneForEveryTableOfTheScenes) {
    int numTables = 0;
    for (const auto& entry : std::filesystem::directory_iterator(LACQUER_SOURCE_DIR "/scenes/bulk/tables")) {
        if (entry.path().extension() != ".json") continue;
        ++numTables;
        const std::string file = entry.path().string();
        const auto table = nlohmann::json::parse(std::ifstream(file));
        const auto& first = table.at("sigma_s").at(0);
        const double sigmaS = first.is_array() ? double(first.at(0)) : double(first);
        const std::string scene =
            View("volpath", 4000, {3, 1, -2}) + kWhite +
            MediumText(fmt::format("\"string bulk\" \"{}\" \"float scale\" {} ", file, 2 / sigmaS)) + kBall;
        const RunningMean mean = CenterRadiance(BuildText(scene), Scaled(20000), SeedOf(entry.path().stem()));
        EXPECT_NEAR(mean.Mean(), 1, 2e-4) << file;
    }
    EXPECT_GE(numTables, 40);
}

TEST(BulkFurnace, IsOneAtEachWavelength) {
    const std::string medium = MediumText(Bulk(FourColours(false)));
    EXPECT_TRUE(
        Passes(FullTestName(), kAlpha, [&](uint64_t seed) { return FurnaceAtEachWavelength(medium, seed); }));
}

/// Radiance of light that is scattered once, over the light's irradiance, through the middle of the unit
/// ball.
/// @param cosine  of the scattering angle: the light comes from there, the camera looks along z
double SingleScattering(double sigmaA, double sigmaS, double p, double cosine) {
    constexpr int kSteps = 20000;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double z = -1 + 2 * (i + 0.5) / kSteps, along = z * cosine;
        const double toLight = -along + std::sqrt(along * along + 1 - z * z);
        sum += std::exp(-(sigmaA + sigmaS) * (z + 1 + toLight));
    }
    return sum * 2 / kSteps * sigmaS * p;
}

/// The worst of four wavelengths and three angles, for a ball with the table rendered, and one computed.
Outcome ScattersOnce(const BulkTable& rendered, const BulkTable& computed, uint64_t seed) {
    std::vector<Outcome> outcomes;
    const auto empty = SpectralRadiance(View("volpath", 5, {0, 0, -4}) + kWhite, 4, 1);
    for (const size_t node : {size_t(30), size_t(90), size_t(150)}) {
        const double cosine = std::cos(double(node) * M_PI / 180), sine = std::sqrt(1 - cosine * cosine);
        const std::string scene = View("volpath", 1, {0, 0, -4}) + Distant({float(sine), 0, float(cosine)}) +
                                  MediumText(Bulk(rendered)) + kBall;
        const auto all = SpectralRadiance(scene, Scaled(40000), Hash(seed, node));
        for (size_t l = 0; l < all.size(); ++l) {
            const auto at = [&](const std::function<double(size_t)>& f) { return At(computed, kFour[l], f); };
            const double expected =
                3 * empty[l].Mean() *
                SingleScattering(at([&](size_t i) { return computed.sigmaA[i]; }),
                                 at([&](size_t i) { return computed.sigmaS[i]; }),
                                 at([&](size_t i) { return computed.phase[i][node]; }), cosine);
            const double power = 0.02 * std::sqrt(40000. / Scaled(40000));
            EXPECT_LT(all[l].StandardError(), power * expected) << node << ' ' << l;
            outcomes.push_back(
                ZTest(all[l], expected, 2e-4 * expected, fmt::format("{} degrees {}", node, l)));
        }
    }
    return WorstOf(outcomes);
}

// Power: standard errors are below 2 %. The controls: a table 25 nm off, and absorption that is left out.
TEST(BulkMedia, ScatterOnceByTheirIntegral) {
    const BulkTable table = FourColours();
    EXPECT_TRUE(
        Passes(FullTestName(), kAlpha, [&](uint64_t seed) { return ScattersOnce(table, table, seed); }));
    BulkTable shifted = table;
    for (double& nm : shifted.wavelengths) nm += 25;
    EXPECT_LT(ScattersOnce(shifted, table, 1).pValue, kAlpha);
    EXPECT_LT(ScattersOnce(FourColours(false), table, 1).pValue, kAlpha);
}

// Of a radius of 500 nm and an index of 1.33, at 700 nm: a million in a cubic millimetre of air.
TEST(BulkMedia, OfLoneSpheresScatterOnceByLorenzAndMie) {
    const BulkTable table = ReadBulkTable(LACQUER_SOURCE_DIR "/tests/phases/sphere_water_700nm.json");
    // k^2 C = 202.601575259; p by the same theory at 30, 90 and 150 degrees.
    const double k = 2 * M_PI / 700e-6;
    EXPECT_NEAR(table.sigmaS[0] / (1e6 * 202.601575259 / (k * k)), 1, 1e-8);
    EXPECT_NEAR(MeanCosine(table.angles, table.phase[0]), table.g[0], 5e-4);
    EXPECT_TRUE(
        Passes(FullTestName(), kAlpha, [&](uint64_t seed) { return ScattersOnce(table, table, seed); }));
}

// By the same seed, a table that is spelt out in the scene makes the same image, but for roundings. The
// control has its rows in another order.
TEST(BulkMedia, AreWhatTheSceneCouldSpellOut) {
    const BulkTable table = FourColours();
    std::string angles, values, nm, sigmaA, sigmaS;
    for (const double angle : table.angles) angles += fmt::format("{} ", angle);
    for (size_t i = 0; i < 4; ++i) {
        const double w = table.wavelengths[i], a = table.sigmaA[i], s = table.sigmaS[i];
        for (const double p : table.phase[i]) values += fmt::format("{:.9g} ", p);
        nm += fmt::format("{} ", w);
        sigmaA += fmt::format("{} {} ", w, a);
        sigmaS += fmt::format("{} {} ", w, s);
    }
    // Samples are 0 beyond their ends.
    const auto extended = [&](const std::string& list) {
        return "[360 " + list.substr(4, list.find(' ', 4) - 4) + ' ' + list + "830 " +
               list.substr(list.rfind(' ', list.size() - 2) + 1) + "] ";
    };
    const std::string spelt = "\"string phase\" \"table\" \"float angles\" [" + angles +
                              "] \"float wavelengths\" [" + nm + "] \"float table\" [" + values +
                              "] \"spectrum sigma_a\" " + extended(sigmaA) + "\"spectrum sigma_s\" " +
                              extended(sigmaS);
    BulkTable swapped = table;
    std::swap(swapped.phase[1], swapped.phase[2]);
    const auto render = [](const std::string& parameters) {
        return SpectralRadiance(
            View("volpath", 100, {3, 1, -2}) + Distant(kFront) + MediumText(parameters) + kBall, Scaled(8000),
            5);
    };
    const auto file = render(Bulk(table)), here = render(spelt), wrong = render(Bulk(swapped));
    double difference = 0;
    for (size_t l = 0; l < 4; ++l) {
        EXPECT_NEAR(file[l].Mean() / here[l].Mean(), 1, 2e-3) << l;
        difference = std::max(difference, std::abs(wrong[l].Mean() / here[l].Mean() - 1));
    }
    EXPECT_GT(difference, 0.1);
}

// Power: standard errors of 0.5 to 1 %, in reflection and in transmission; the control has a g of 0.4 for
// 0.5.
TEST(BulkSlabs, OfHenyeyAndGreensteinAreTheirs) {
    const std::string hg =
        "\"string phase\" \"hg\" \"float g\" 0.5 \"rgb sigma_t\" [1.5 1.5 1.5] \"rgb albedo\" [0.9 0.9 0.9] ";
    const auto bulk = [](double g) {
        return "\"string phase\" \"bulk\" " + Bulk(HgTable({400, 700}, {g, g}, {1.35, 1.35}, {0.15, 0.15}));
    };
    double control = 1;
    for (const Vec3 light : {kFront, kBehind}) {
        EXPECT_TRUE(Passes(fmt::format("{} {}", FullTestName(), light.z), kAlpha, [&](uint64_t seed) {
            return Compare(SlabScene(hg, Distant(light)), SlabScene(bulk(0.5), Distant(light)), 100000, seed);
        }));
        control = std::min(
            control,
            Compare(SlabScene(hg, Distant(light)), SlabScene(bulk(0.4), Distant(light)), 100000, 1).pValue);
    }
    EXPECT_LT(control, kAlpha);
}

// ---- What is wrong ----

TEST(BulkParameters, ThatSayTheSameAreErrors) {
    const std::string bulk = Bulk(FourColours());
    for (const std::string other :
         {"rgb sigma_a\" [1 1 1]", "rgb sigma_s\" [1 1 1]", "float g\" 0.3", "string preset\" \"Skin1\""}) {
        const std::string name = other.substr(other.find(' ') + 1, other.find('"') - other.find(' ') - 1);
        const std::string error = MediumErrorOf("homogeneous", bulk + "\"" + other);
        EXPECT_NE(error.find("\"" + name + "\" is given beside \"bulk\""), std::string::npos) << error;
    }
    for (const std::string other : {"sigma_t", "albedo"}) {
        const std::string error = BuildErrorsOf(
            "WorldBegin MakeNamedMaterial \"s\" \"string type\" \"slab\" \"string phase\" \"bulk\" " + bulk +
            "\"rgb " + other + "\" [1 1 1]");
        EXPECT_NE(error.find("\"" + other + "\" is given beside \"bulk\""), std::string::npos) << error;
    }
    const auto expect = [](const std::string& type, const std::string& parameters, const std::string& says) {
        const std::string error = MediumErrorOf(type, parameters);
        EXPECT_NE(error.find(says), std::string::npos) << error;
    };
    expect("homogeneous", bulk + "\"string phase\" \"hg\"", "belongs to \"string phase\" \"bulk\"");
    expect("homogeneous", "\"string phase\" \"bulk\"", "needs \"string bulk\"");
    expect("homogeneous", bulk + "\"float scale\" -1", "scale");
    expect("homogeneous", bulk + "\"float scale\" 3e38", "too large for floats");
    expect("rgbgrid", bulk, "has its coefficients in its voxels");
    BulkTable narrow = HgTable({550}, {0}, {1}, {0}, 3);
    narrow.angles.insert(narrow.angles.begin() + 1, 3e-5);
    narrow.phase[0] = {4.1e12, 0, 0.04, 0.04};
    const double norm = NormOfPhase(narrow.angles, narrow.phase[0]);
    for (double& p : narrow.phase[0]) p /= norm;
    expect("homogeneous", Bulk(narrow), "narrower than directions can tell");
}

TEST(BulkParameters, OfDoubtfulUseAreWarnings) {
    const auto warnings = [](const std::string& directive) {
        WarningList list;
        BuildText("WorldBegin " + directive, &list);
        return list.text;
    };
    const auto slab = [&](double host, float eta) {
        BulkTable table = FourColours();
        table.hostIndex = host;
        return warnings(fmt::format("MakeNamedMaterial \"s\" \"string type\" \"slab\" \"float eta\" {} {}",
                                    eta, Bulk(table)));
    };
    EXPECT_EQ(slab(1.5, 1.5f), "");
    EXPECT_EQ(slab(1.5, 1.509f), "");
    EXPECT_NE(slab(1.5, 1.33f)
                  .find("scene.pbrt:1:55: warning: the index of this slab is 1.33, but \"bulk\" is of "
                        "particles in matter of "
                        "index 1.5"),
              std::string::npos)
        << slab(1.5, 1.33f);
    const auto range = [&](double first, double last) {
        return warnings("MakeNamedMedium \"m\" \"string type\" \"homogeneous\" " +
                        Bulk(HgTable({first, last}, {0, 0}, {1, 1}, {0, 0})));
    };
    EXPECT_EQ(range(400, 700), "");
    EXPECT_NE(range(450, 700).find("has nothing below 450 nm;"), std::string::npos);
    EXPECT_NE(range(400, 650).find("has nothing above 650 nm;"), std::string::npos);
    EXPECT_NE(range(450, 650).find("has nothing below 450 nm and above 650 nm;"), std::string::npos);
    EXPECT_NE(range(450, 650).find("scene.pbrt:1:60: warning: "), std::string::npos) << range(450, 650);
}

}  // namespace
}  // namespace lacquer::test::bulk_test
