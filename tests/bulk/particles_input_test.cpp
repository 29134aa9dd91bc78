// What particles.json means, and what of it makes no sense.
#include "bulk/input/particles_input.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "bulk/table/bulk_computation.h"
#include "bulk/table/bulk_problem.h"
#include "pbrt/core/json_places.h"
#include "support/bulk_tables.h"

namespace lacquer::test::particles_input_test {
namespace {

using namespace bulk;

constexpr const char* kFat = R"({
  "wavelengths": [400, 700, 100],
  "host": {"index": 1.33},
  "species": [
    {"name": "fat", "index": 1.46,
     "radius": {"lognormal": {"median": 0.25, "sigma": 0.4}},
     "volume fraction": 0.03}
  ],
  "arrangement": {"kind": "uniform", "count": 10, "mode": "medium"},
  "length": "um",
  "seed": 7
}
)";

constexpr const char* kRadiusOfFat = R"({"lognormal": {"median": 0.25, "sigma": 0.4}})";

/// The text with something else in one place.
std::string With(const std::string& what, const std::string& by, std::string text = kFat) {
    const size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return text.replace(at, what.size(), by);
}

ParticlesInput Read(const std::string& text, const ParticlesOverrides& overrides = {}) {
    return ReadParticles(WriteFile("particles.json", text), overrides);
}

TEST(ParticlesInput, IsWhatTheFileSays) {
    const ParticlesInput input = Read(kFat);
    const BulkSettings& s = input.settings;
    EXPECT_EQ(s.wavelengths, (std::vector<double>{400, 500, 600, 700}));
    EXPECT_EQ(s.hostIndex, 1.33);
    ASSERT_EQ(s.ensemble.species.size(), 1u);
    EXPECT_EQ(s.ensemble.species[0].name, "fat");
    EXPECT_EQ(s.ensemble.species[0].volumeFraction, 0.03);
    EXPECT_EQ(s.ensemble.species[0].radius.Moment(3), RadiusDistribution::LogNormal(0.25, 0.4).Moment(3));
    EXPECT_EQ(s.indices[0].At(500), Complex(1.46));
    EXPECT_EQ(s.ensemble.arrangement, Arrangement::Uniform);
    EXPECT_EQ(s.ensemble.count, 10);
    EXPECT_EQ(s.mode, AverageMode::Medium);
    EXPECT_EQ(s.method, BulkMethod::Clusters);
    EXPECT_EQ(s.seed, 7u);
    EXPECT_TRUE(input.sizes.empty());
    EXPECT_EQ(input.json.find('\n'), std::string::npos);
}

TEST(ParticlesInput, ShortFormsHaveDefaults) {
    const BulkSettings s = Read(R"({"wavelengths": 550, "host": {"index": [1.5, 0]},
        "species": [{"index": [1.7, 0.1], "radius": 0.1, "volume fraction": 0.2}]})")
                               .settings;
    EXPECT_EQ(s.wavelengths, std::vector<double>{550});
    EXPECT_EQ(s.hostIndex, 1.5);
    EXPECT_EQ(s.indices[0].At(550), Complex(1.7, 0.1));
    EXPECT_EQ(s.ensemble.species[0].radius.Largest(), 0.1);
    EXPECT_EQ(s.ensemble.arrangement, Arrangement::Cut);
    EXPECT_EQ(s.ensemble.count, 100);
    EXPECT_EQ(s.mode, AverageMode::Medium);
    EXPECT_EQ(s.seed, 1u);
}

TEST(ParticlesInput, TheCommandLineWins) {
    const BulkSettings s = Read(kFat, {{450, 650}, 3}).settings;
    EXPECT_EQ(s.wavelengths, (std::vector<double>{450, 650}));
    EXPECT_EQ(s.seed, 3u);
}

TEST(ParticlesInput, WavelengthsAreARangeOnlyIfTheThirdNumberIsNoLargerThanTheSecond) {
    const auto read = [](const char* list) {
        return Read(With("[400, 700, 100]", list)).settings.wavelengths;
    };
    EXPECT_EQ(read("[400, 500, 600]"), (std::vector<double>{400, 500, 600}));
    EXPECT_EQ(read("[400, 500]"), (std::vector<double>{400, 500}));
    EXPECT_EQ(read("[400, 500, 500]"), (std::vector<double>{400}));
    EXPECT_EQ(read("[400, 401, 0.1]").size(), 11u);
    EXPECT_EQ(read("[400, 700, 50]").size(), 7u);
}

TEST(ParticlesInput, LengthsHaveTheirUnit) {
    const BulkSettings nm = Read(With("0.25", "250", With("\"um\"", "\"nm\""))).settings,
                       mm = Read(With("0.25", "0.00025", With("\"um\"", "\"mm\""))).settings;
    const double expected = RadiusDistribution::LogNormal(0.25, 0.4).Largest();
    EXPECT_NEAR(nm.ensemble.species[0].radius.Largest(), expected, 1e-12);
    EXPECT_NEAR(mm.ensemble.species[0].radius.Largest(), expected, 1e-12);
}

TEST(ParticlesInput, IndicesComeFromTheRenderersMaterialsAndFromTables) {
    const BulkSettings gold = Read(With("1.46", "\"metal-Au\"")).settings;
    // Gold is yellow: it absorbs blue light and reflects red light.
    EXPECT_GT(gold.indices[0].At(400).real(), 1.3);
    EXPECT_LT(gold.indices[0].At(700).real(), 0.3);
    EXPECT_GT(gold.indices[0].At(700).imag(), 3);
    const BulkSettings glass = Read(With("1.46", "\"glass-BK7\"")).settings;
    EXPECT_NEAR(glass.indices[0].At(600).real(), 1.5163, 1e-4);
    EXPECT_EQ(glass.indices[0].At(600).imag(), 0);
    const BulkSettings table =
        Read(With("1.46", R"({"wavelengths": [400, 800], "n": [1.5, 1.6], "k": [0.2, 0]})")).settings;
    EXPECT_LT(std::abs(table.indices[0].At(600) - Complex(1.55, 0.1)), 1e-12);
}

TEST(ParticlesInput, EveryArrangementHasItsParameters) {
    const auto read = [](const std::string& arrangement) {
        return Read(With(R"({"kind": "uniform", "count": 10, "mode": "medium"})", arrangement)).settings;
    };
    EXPECT_EQ(read(R"({"kind": "cut", "count": 3})").ensemble.arrangement, Arrangement::Cut);
    EXPECT_FALSE(read(R"({"kind": "cut", "multiple scattering": "kept"})").removesMultipleScattering);
    EXPECT_TRUE(read(R"({"kind": "cut", "multiple scattering": "removed"})").removesMultipleScattering);
    const EnsembleSettings disc = read(R"({"kind": "poisson-disc", "distance": 1.8})").ensemble;
    EXPECT_EQ(disc.arrangement, Arrangement::PoissonDisc);
    EXPECT_EQ(disc.minDistance, 1.8);
    const EnsembleSettings clumped = read(R"({"kind": "clumped", "children": 9, "spread": 3})").ensemble;
    EXPECT_EQ(clumped.children, 9);
    EXPECT_EQ(clumped.spread, 3);
    const EnsembleSettings gaussian = read(R"({"kind": "disc", "deviations": [3, 3, 0.5]})").ensemble;
    EXPECT_EQ(gaussian.arrangement, Arrangement::Gaussian);
    EXPECT_EQ(gaussian.deviations, Eigen::Vector3d(3, 3, 0.5));
    const auto oriented = [](const std::string& arrangement) {
        return Read(With(R"({"kind": "uniform", "count": 10, "mode": "medium"})", arrangement)).oriented;
    };
    EXPECT_FALSE(oriented(R"({"kind": "disc", "deviations": [3, 3, 0.5], "oriented": false})"));
    EXPECT_EQ(oriented(R"({"kind": "disc", "deviations": [3, 3, 0.5], "oriented": true, "incidences": 16})")
                  ->numIncidences,
              16);
    EXPECT_EQ(oriented(R"({"kind": "disc", "deviations": [3, 3, 0.5], "oriented": true, "azimuths": 9})")
                  ->numAzimuths,
              9);
    const BulkSettings list = read(R"({"kind": "list", "particles": [{"center": [0, 0, 0], "radius": 0.2},
        {"center": [0.4, 0, 0], "radius": 0.2}, {"center": [2, 0, 0]}]})");
    EXPECT_EQ(list.mode, AverageMode::Aggregate);
    ASSERT_EQ(list.ensemble.particles.size(), 3u);
    EXPECT_EQ(list.ensemble.count, 3);
    // About the middle of their box, from -0.2 to 2.3.
    EXPECT_LT((list.ensemble.particles[1].center - Point(-0.65, 0, 0)).norm(), 0.1);
    EXPECT_LT(
        (list.ensemble.particles[1].center - list.ensemble.particles[0].center - Point(0.4, 0, 0)).norm(),
        1e-12);
    EXPECT_EQ(list.ensemble.particles[1].radius, 0.2);
}

// Only the places of particles to each other count in the mode "aggregate"; in others realisations are turned
// about the origin, and the mean field knows it.
TEST(ParticlesInput, ListsFarFromTheOriginAreThoseAtIt) {
    const auto read = [](double x, double y, double z, const char* mode) {
        std::string text = With("[400, 700, 100]", "600", With(kRadiusOfFat, "0.2"));
        const std::string second = fmt::format("[{}, {}, {}]", x + 0.3, y + 0.1, z + 0.35);
        return Read(With(R"({"kind": "uniform", "count": 10, "mode": "medium"})",
                         fmt::format(R"({{"kind": "list", "mode": "{}", "particles": [
                             {{"center": [{}, {}, {}]}}, {{"center": {}}}]}})",
                                     mode, x, y, z, second),
                         text))
            .settings;
    };
    const BulkSettings at = read(0, 0, 0, "aggregate"), far = read(300, -200, 50, "aggregate");
    EXPECT_NEAR(MemoryOf(far, Ensemble(far.ensemble), 1) / MemoryOf(at, Ensemble(at.ensemble), 1), 1, 1e-12);
    EXPECT_EQ(NumAnglesOf(far, Ensemble(far.ensemble)), NumAnglesOf(at, Ensemble(at.ensemble)));
    const auto table = [](const BulkSettings& settings) {
        BulkComputation computation(settings);
        computation.AddRealizations(4, nullptr);
        return computation.Table();
    };
    const BulkTable first = table(at), second = table(far);
    EXPECT_NEAR(second.sigmaS[0] / first.sigmaS[0], 1, 1e-8);
    for (size_t i = 0; i < first.angles.size(); i += 10)
        EXPECT_NEAR(second.phase[0][i] / first.phase[0][i], 1, 1e-8);
    // The same without the shift: what a cluster beside the origin scatters is that of one at it.
    BulkSettings beside = at;
    for (Particle& particle : beside.ensemble.particles) particle.center += Point(1, -0.7, 0.4);
    EXPECT_GT(MemoryOf(beside, Ensemble(beside.ensemble), 1), 1.5 * MemoryOf(at, Ensemble(at.ensemble), 1));
    const BulkTable third = table(beside);
    EXPECT_NEAR(third.sigmaS[0] / first.sigmaS[0], 1, 1e-8);
    // A control: the mean field of the mode "medium" is another one there.
    const BulkSettings medium = read(1, -0.7, 0.4, "medium");
    EXPECT_GT(medium.ensemble.particles[0].center.norm(), 1);
    const double shifted = table(medium).sigmaS[0], centered = table(read(0, 0, 0, "medium")).sigmaS[0];
    EXPECT_GT(std::abs(shifted / centered - 1), 1e-3);
}

/// What is wrong with a text, as "line:column: message".
std::string ProblemOf(const std::string& text) {
    try {
        Read(text);
    } catch (const SceneError& error) {
        return fmt::format("{}:{}: {}", error.Loc().line, error.Loc().column, error.Message());
    }
    return "none";
}

struct Broken {
    std::string what, by;
    const char* problem;  ///< how the message begins
};

const std::string kArrangement = R"({"kind": "uniform", "count": 10, "mode": "medium"})";
const std::string kRadius = kRadiusOfFat;
const std::string kSeed = R"("seed": 7)";
const std::string kCount = R"("count": 10)";

std::string List(const char* particles) {
    return fmt::format(R"({{"kind": "list", "particles": {}}})", particles);
}

/// Each text has a '@' before the place that its message must name.
void ExpectProblems(std::initializer_list<Broken> table) {
    for (const Broken& row : table) {
        std::string text = With(row.what, row.by);
        const size_t mark = text.find('@');
        ASSERT_NE(mark, std::string::npos) << row.by;
        text.erase(mark, 1);
        const FileLoc place = JsonPlaces(text, "").LocOf(mark);
        const std::string found = ProblemOf(text),
                          expected = fmt::format("{}:{}: {}", place.line, place.column, row.problem);
        EXPECT_EQ(found.substr(0, expected.size()), expected) << found << "\nin " << row.by;
    }
}

TEST(BrokenParticles, TextsAndKeysAreToldWithTheirPlace) {
    ExpectProblems({
        {"7\n}", "7,\n@}", "this is no JSON"},
        {kSeed, R"("seed": @1e999)", "1e999 is beyond the range of numbers"},
        {kSeed, R"("seed": )" + std::string(63, '[') + "@[[[", "brackets are nested more than 64"},
        {kFat, "@[1]", "found a list of 1; expected an object, the particles of a medium"},
        {kFat, "@", "this is no JSON"},
        {R"("species")", R"(@"speceis")", R"(unknown key "speceis"; did you mean "species"?)"},
        {kSeed, R"("seed": 7, @"seed": 8)", "this key stands in the file twice"},
        {R"("volume fraction")", R"(@"volume_fraction")",
         R"(unknown key "volume_fraction"; did you mean "volume fraction"?)"},
        {R"("volume fraction": 0.03)", R"(@"name": "x")", "this key stands in the file twice"},
        {R"("median")", R"(@"mean")", R"(unknown key "mean")"},
        {R"("median")", R"(@"k": 1, "median")", R"(unknown key "k")"},
        {R"("um")", R"(@"furlong")", R"(found "furlong"; expected one of um, nm, mm)"},
        {kSeed, R"("seed": @-1)", "found -1; expected a number in [0, "},
        {kSeed, R"("method": @"cluster")",
         R"(found "cluster"; expected one of clusters, independent, structure; did you mean "clusters"?)"},
        {kSeed, R"("sizes": @[5])", "found a list of 1; expected 2 to 8"},
        {kSeed, R"("sizes": [9, @5])", "5 stands after 9"},
    });
    EXPECT_EQ(ProblemOf(With(R"("host": {"index": 1.33},)", "")), "1:1: there is no \"host\"");
    EXPECT_EQ(ProblemOf(With("[400, 700, 100]", "550", With(",\n     \"volume fraction\": 0.03", ""))),
              "5:5: there is no \"volume fraction\"");
}

TEST(BrokenParticles, SizesAreToldWithTheirPlace) {
    ExpectProblems({
        {"0.25", "@0", "found 0; expected a radius above 0"},
        {"0.25", "@-0.0", "found -0.0; expected a radius above 0"},
        {"0.25", "@-1", "found -1; expected a radius above 0"},
        {"0.25", "@1e308", "found 1e+308; expected a radius above 0"},
        {"0.25", "@1e200", "found 1e+200, which is 1e+200 um; expected a length from"},
        {"0.25", "@1e-9", "found 1e-09, which is 1e-09 um; expected a length from"},
        {"0.25", R"(@"NaN")", R"(found "NaN"; expected a radius above 0)"},
        {"0.25", "@null", "found null; expected a radius above 0"},
        {"0.25", "@NaN", "this is no JSON"},
        {kRadius, "@20",
         "the largest radius, 20 um, has the size parameter 417.8 at 400 nm; expected at most 200"},
        {"0.4}", "@99}", "found 99; expected a number in [0, 2]"},
        {kRadius, "@{}", "expected a number, or an object with one of"},
        {kRadius, R"({"table": {"radii": @[], "weights": []}})", "found a list of 0"},
        {kRadius, R"({"table": {"radii": [1, 2], "weights": @[1]}})",
         "this list has 1 numbers; expected 2, one for each radius"},
        {kRadius, R"({"table": {"radii": [0.1], "weights": @[0]}})", "all weights are 0"},
        {"0.03", "@0", "found 0; expected a part of the volume"},
        {"0.03", "@1.5", "found 1.5; expected a part of the volume"},
        {"0.03", "@0.55",
         "the volume fractions add up to 0.55; hard spheres are moved at random (Monte Carlo) up to 0.5"},
    });
}

TEST(BrokenParticles, IndicesAndWavelengthsAreToldWithTheirPlace) {
    ExpectProblems({
        {"1.46", "[1.46, @-0.1]",
         "found -0.1; expected at least 0: with the time factor exp(-iwt) absorption is a positive "
         "imaginary part"},
        {"1.46", "@-1", "found -1; expected a number in [0, 100]"},
        {"1.46", "@0", "found 0; expected an index of refraction"},
        {"1.46", "@1.33", "at 400 nm this is the index of the host, 1.33; such particles scatter nothing"},
        {"1.46", R"(@"metal-Ay")", R"(unknown material "metal-Ay"; did you mean "metal-A)"},
        {"1.46", R"(@"cie-y")", R"(unknown material "cie-y")"},
        {"1.46", R"({"wavelengths": @[450, 800], "n": [1.5, 1.6]})",
         "this index is known from 450 to 800 nm; 400 nm is asked for"},
        {"1.46", R"({"wavelengths": [300, 800], "n": @[1.5]})",
         "this list has 1 numbers; expected 2, one for each wavelength"},
        {"1.46", R"({"wavelengths": [300, 800], "n": [1.5, 1.6], "k": [0.1, @-0.1]})",
         "found -0.1; expected at least 0: with the time factor exp(-iwt)"},
        {"1.46", R"({"wavelengths": [800, @300], "n": [1.5, 1.6]})", "300 stands after 800"},
        {"1.46", "@[1, 2, 3]", "found a list of 3; expected an index of refraction"},
        {"1.33", "[1.33, @0.1]",
         "found 0.1; expected 0: cross sections are those of particles in a host that does not absorb"},
        {"1.33", "@0", "found 0; expected a number in [0.1, 10]"},
        {"1.33", R"(@"glass-BK7")", R"(found "glass-BK7"; expected a number in [0.1, 10])"},
        {"[400, 700, 100]", "@[700, 400, 50]", "from 700 to 400 by 50: expected a number"},
        {"[400, 700, 100]", "@[400, 700, 0.01]", "from 400 to 700 by 0.01"},
        {"[400, 700, 100]", "[400, 700, 900, @800]", "800 stands after 900"},
        {"[400, 700, 100]", "@[]", "found a list of 0"},
        {"[400, 700, 100]", "@0", "found 0; expected a number in [1, 1000000]"},
        {"[400, 700, 100]", R"(@"red")", R"(found "red"; expected a number, a growing list)"},
    });
    EXPECT_NE(ProblemOf(With("1.46", "\"metal-Au\"", With("[400, 700, 100]", "900")))
                  .find("this index is known from 360 to 830 nm; 900 nm is asked for"),
              std::string::npos);
}

TEST(BrokenParticles, ArrangementsAreToldWithTheirPlace) {
    ExpectProblems({
        {R"("uniform")", R"(@"unifrom")",
         R"(found "unifrom"; expected one of uniform, cut, clumped, poisson-disc, gaussian, disc, list; did)"},
        {R"("medium")", R"(@"media")", R"(found "media"; expected one of medium, aggregate, chapter)"},
        {kCount, R"("count": @0)", "found 0; expected a number in [1, 2000000]"},
        {kCount, R"("count": @2.5)", "found 2.5; expected a whole number"},
        {kCount, R"("count": @1000000)", "1000000 particles at 400 nm are "},
        {kCount, R"(@"distance": 2)", R"(unknown key "distance")"},
        {kArrangement, "@7", "found 7; expected an object"},
        {kArrangement, R"(@{"kind": "disc"})", R"(there is no "deviations")"},
        {kArrangement, R"({"kind": "disc", "deviations": [1, @0, 1]})", "found 0; expected a length above 0"},
        {kArrangement, R"({"kind": "disc", "deviations": [1, 1, 1], "oriented": @1})",
         "found 1; expected true or false"},
        {kArrangement, R"({"kind": "cut", "mode": "aggregate", "multiple scattering": @"removed"})",
         "clusters as such are what they are; expected \"mode\": \"medium\""},
        {kArrangement, R"({"multiple scattering": @"remove"})",
         "found \"remove\"; expected one of kept, removed; did you mean \"removed\"?"},
        {kArrangement, R"({"kind": "disc", "deviations": [1, 1, 1], @"multiple scattering": "removed"})",
         "unknown key \"multiple scattering\""},
        {kArrangement, R"({"kind": "disc", "deviations": [1, 1, 1], "azimuths": @9})",
         "only the tables of oriented ensembles have it"},
        {kArrangement, R"({"kind": "disc", "deviations": [1, 1, 1], "oriented": true, "incidences": @1})",
         "found 1; expected a number in [2, 181]"},
        {kCount, R"(@"oriented": true)", R"(unknown key "oriented")"},
        {kArrangement, List(R"([{"center": [0,0,0], "radius": 1}, {"center": [9,0,0], "radius": 1},
            @{"center": [0,0,1.5], "radius": 1}])"),
         "this particle, number 3, overlaps number 1 by 0.5 um: their centres are 1.5 um apart, their radii "
         "add up to 2 um"},
        {kArrangement, List(R"([{"center": @[0,0]}])"), "this list has 2 numbers; expected 3"},
        {kArrangement, List(R"([{"center": [0,0,0], "radius": @90}])"), "the largest radius, 90 um, has"},
        {kArrangement, List("@[]"), "found a list of 0; expected a list of particles"},
        {kArrangement, List(R"([{"center": [0,0,0], "species": @"fit"}])"),
         R"(found "fit"; expected one of fat; did you mean "fat"?)"},
    });
    EXPECT_EQ(ProblemOf(With(kArrangement, R"({"kind": "poisson-disc", "distance": 4})")),
              "7:25: the volume fractions add up to 0.03; spheres this far apart are put one after another "
              "up to 0.003906");
    EXPECT_NE(ProblemOf(With("0.03", "1e-300")).find("the particles of a realisation lie in a ball of"),
              std::string::npos);
}

// In one pass: with one for each particle this takes minutes.
TEST(ParticlesInput, LongListsAreReadInTheirLength) {
    constexpr int kParticles = 20000;
    std::string particles;
    for (int i = 0; i < kParticles; ++i)
        particles +=
            fmt::format(R"({}{{"center": [{}, 0, 0], "radius": 0.01}})", i > 0 ? "," : "", i * 0.021);
    const auto text = [](const std::string& list) {
        return With(kArrangement, fmt::format(R"({{"kind": "list", "particles": [{}]}})", list),
                    With(kSeed, R"("method": "independent")"));
    };
    EXPECT_EQ(Read(text(particles)).settings.ensemble.particles.size(), size_t(kParticles));
    // The last one twice: the key is found there.
    const std::string problem =
        ProblemOf(text(particles.substr(0, particles.size() - 1) + R"(, "radius": 1})"));
    EXPECT_NE(problem.find("this key stands in the file twice"), std::string::npos) << problem;
}

// The volume fraction is of the particles that the list has, whatever radius the species has besides.
TEST(ParticlesInput, VolumeFractionsAreThoseOfAList) {
    constexpr const char* kParticles =
        R"([{"center": [0,0,0], "radius": 0.1}, {"center": [0,0,1], "radius": 0.2}])";
    const BulkSettings s = Read(With(kArrangement, List(kParticles))).settings;
    const double meanVolume = 4 * 3.141592653589793 / 3 * (0.001 + 0.008) / 2;
    EXPECT_NEAR(Ensemble(s.ensemble).NumberDensity(), 0.03 / meanVolume, 1e-9);
    EXPECT_EQ(s.ensemble.species[0].radius.Largest(), 0.2);
    BulkSettings lone = s;
    lone.method = BulkMethod::Independent;
    BulkSettings table = lone;
    table.ensemble.arrangement = Arrangement::Cut;
    table.ensemble.species[0].radius = RadiusDistribution::Table({{0.1, 1}, {0.2, 1}});
    EXPECT_NEAR(BulkComputation(lone).Table().sigmaS[0] / BulkComputation(table).Table().sigmaS[0], 1, 1e-12);

    const auto two = [](const char* list, const std::string& fraction) {
        const std::string text = With(kArrangement, List(list));
        return With("\"volume fraction\": 0.03}",
                    "\"volume fraction\": 0.03}, {\"name\": \"casein\", \"index\": 1.5, \"radius\": 0.1, "
                    "\"volume fraction\": " +
                        fraction + "}",
                    text);
    };
    constexpr const char* kBoth = R"([{"center": [0,0,0], "radius": 0.2, "species": "fat"},
        {"center": [0,0,1], "species": "casein"}])";
    EXPECT_EQ(ProblemOf(two(kBoth, "0.00375")), "none");
    EXPECT_NE(ProblemOf(two(kBoth, "0.03")).find("found 0.03; expected 0.0533333: of 0.06"),
              std::string::npos)
        << ProblemOf(two(kBoth, "0.03"));
    EXPECT_NE(ProblemOf(two(R"([{"center": [0,0,0], "species": "fat"}])", "0.03"))
                  .find(R"(no particle is of the species "casein")"),
              std::string::npos);
}

TEST(ParticlesInput, WhatIsOddButPossibleIsRead) {
    EXPECT_EQ(ProblemOf(With("\"count\": 10", "\"count\": 1")), "none");
    EXPECT_EQ(ProblemOf(With("0.03", "0.5")), "none");
    EXPECT_EQ(ProblemOf(With("1.46", "[0.1, 0]")), "none");  // a bubble of less than nothing
    EXPECT_EQ(ProblemOf(With("\"seed\": 7", "\"sizes\": [5, 9]")), "none");
    // Touching is no overlap.
    EXPECT_EQ(ProblemOf(With(kArrangement, List(R"([{"center": [0,0,0], "radius": 1},
        {"center": [0,0,2], "radius": 1}])"))),
              "none");
    // Without clusters there are no unknowns.
    EXPECT_EQ(ProblemOf(With("\"seed\": 7", "\"method\": \"independent\"",
                             With("\"count\": 10", "\"count\": 1000000"))),
              "none");
}

}  // namespace
}  // namespace lacquer::test::particles_input_test
