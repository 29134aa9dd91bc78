// Tables over angle and wavelength: values, samples, files and parameters.
#include "pbrt/phases/table.h"

#include <gtest/gtest.h>

#include <fstream>

#include "media/medium_fixtures.h"
#include "pbrt/phases/hg.h"
#include "pbrt/phases/isotropic.h"
#include "pbrt/phases/mixture.h"
#include "pbrt/phases/sggx.h"
#include "pbrt/phases/table_file.h"
#include "phases/phase_checks.h"

namespace lacquer::table_test {
namespace {

using namespace test;

const Vec3 kWo = Normalize({0.3f, -0.5f, 0.7f});

/// Rows that differ at each angle, one of them with a peak 0.1 degrees wide; angles at unequal steps.
PhaseNumbers ThreeRows() {
    return {
        {500, 600, 700}, {0, 0.05f, 0.1f, 2, 40, 90, 130, 180}, {2e5f, 5e4f, 5, 1, 0.5f, 0.2f, 0.1f, 0.4f,  //
                                                                 4,    4,    3, 3, 2,    1,    1,    5,     //
                                                                 0,    1,    1, 1, 8,    1,    2,    0}};
}

SphereGrid GridOf(const PhaseFunction& phase) {
    if (phase.HasDirectionalExtinction()) return SphereGrid::Fine(-kWo);
    SphereGrid grid = SphereGrid::Geometric(-kWo);
    grid.subT = 64;  // kinks at the nodes
    return grid;
}

struct Chromatic {
    SpectralPhaseTable table{ThreeRows()};
    SpectralTabulatedPhase tabulated{table, Four()};
    HenyeyGreensteinPhase hg{-0.4f};
    SggxPhase flakes{{0, 1, 1}, 0.3f, true};
    const PhaseFunction* parts[3] = {&tabulated, &hg, &flakes};
    float weights[3] = {2, 1, 1};
    MixturePhase mixture{parts, weights};
    std::vector<std::pair<std::string, const PhaseFunction*>> All() const {
        return {{"table", &tabulated}, {"mixture", &mixture}};
    }
};

// The kinks at the nodes cost most: 1e-3 where a peak is 0.1 degrees wide.
TEST(SpectralPhases, IntegrateToOneAtEachWavelength) {
    const Chromatic c;
    for (const auto& [name, phase] : c.All()) {
        ASSERT_TRUE(phase->IsChromatic());
        for (int i = 0; i < kNumTested; ++i) {
            const AtWavelength at(*phase, i);
            EXPECT_NEAR(GridOf(*phase).Integral([&](Vec3 wi) { return at.Evaluate(kWo, wi).p; }), 1, 1.5e-3)
                << name << ' ' << i;
        }
    }
}

// 200,000 draws over some 400 cells: the row of another wavelength fails; see the control.
TEST(SpectralPhases, SamplesFollowThePdfOfTheirWavelength) {
    const Chromatic c;
    for (const auto& [name, each] : c.All())
        for (int i = 0; i < kNumTested; ++i) {
            const auto* phase = each;
            const AtWavelength at(*phase, i);
            EXPECT_TRUE(
                Passes(fmt::format("{} {} {}", FullTestName(), name, i), SidakAlpha(1e-3, 8),
                       [&](uint64_t seed) { return SamplesFollow(at, at, kWo, GridOf(*phase), seed); }));
        }
    // The first one is what those see that know no others.
    EXPECT_TRUE(Passes(FullTestName() + "/first", 1e-4, [&](uint64_t seed) {
        return SamplesFollow(c.mixture, AtWavelength(c.mixture, 0), kWo, GridOf(c.mixture), seed);
    }));
}

TEST(SpectralPhases, SamplesOfAnotherWavelengthAreFound) {
    const Chromatic c;
    // 550 nm is halfway between the first rows: a row 5 nm off.
    const SpectralTabulatedPhase shifted(c.table, SampledWavelengths::At(Lanes(455, 555, 655, 755)));
    for (const auto& [sampled, model] :
         {std::pair<AtWavelength, AtWavelength>{{c.tabulated, 1}, {c.tabulated, 2}},
          {{c.mixture, 1}, {c.mixture, 2}},
          {{shifted, 1}, {c.tabulated, 1}}}) {
        const Outcome outcome = SamplesFollow(sampled, model, kWo, GridOf(model), SeedOf(FullTestName()));
        EXPECT_LT(outcome.pValue, 1e-6) << outcome.details;
    }
}

TEST(SpectralPhases, RecordsAgreeWithEvaluate) {
    const Chromatic c;
    EXPECT_TRUE(RecordsAreConsistent(c.tabulated, SeedOf(FullTestName())));
    for (int i = 0; i < kNumTested; ++i) {
        EXPECT_TRUE(RecordsAreConsistent(AtWavelength(c.tabulated, i), SeedOf(FullTestName())));
        EXPECT_LT(ReciprocityError(AtWavelength(c.mixture, i), SeedOf(FullTestName())), 1e-5);
    }
}

TEST(SpectralPhases, GrayOnesAreTheSameAtAllWavelengths) {
    const HenyeyGreensteinPhase hg(0.3f);
    EXPECT_FALSE(hg.IsChromatic());
    const SpectralPhaseValue value = hg.EvaluateSpectral(kWo, {0, 0, 1});
    EXPECT_EQ(value.p, SampledSpectrum(hg.Evaluate(kWo, {0, 0, 1}).p));
    EXPECT_EQ(value.pdfReverse, SampledSpectrum(hg.Evaluate(kWo, {0, 0, 1}).pdfReverse));
}

/// p by the definition, in double: linear in the cosine between nodes, and in the wavelength between rows.
double ByDefinition(const PhaseNumbers& numbers, double lambda, double angleDeg) {
    const auto cosine = [](double deg) { return std::cos(deg * M_PI / 180); };
    const auto row = [&](size_t r) {
        const std::span<const float> v = numbers.Row(r);
        double area = 0, value = 0;
        for (size_t i = 0; i + 1 < v.size(); ++i) {
            const double a = double(numbers.angles[i]), b = double(numbers.angles[i + 1]);
            area += M_PI * double(v[i] + v[i + 1]) * (cosine(a) - cosine(b));
            const double x = (cosine(a) - cosine(angleDeg)) / (cosine(a) - cosine(b));
            if (angleDeg >= a && angleDeg <= b) value = double(v[i]) + x * double(v[i + 1] - v[i]);
        }
        return value / area;
    };
    const std::vector<float>& w = numbers.wavelengths;
    for (size_t r = 0; r + 1 < w.size(); ++r)
        if (lambda >= double(w[r]) && lambda < double(w[r + 1])) {
            const double x = (lambda - double(w[r])) / double(w[r + 1] - w[r]);
            return (1 - x) * row(r) + x * row(r + 1);
        }
    return row(lambda < double(w[0]) ? 0 : w.size() - 1);
}

TEST(SpectralPhaseTable, IsLinearBetweenNodesAndWavelengths) {
    const PhaseNumbers numbers = ThreeRows();
    const SpectralPhaseTable table(numbers);
    const SpectralTabulatedPhase phase(table, Four());
    for (const double deg : {0., 0.01, 0.07, 0.12, 1., 2., 30., 89., 90., 91., 150., 179.9}) {
        const double radians = deg * M_PI / 180;
        const Vec3 wi(float(std::sin(radians)), 0, float(std::cos(radians)));
        const SpectralPhaseValue value = phase.EvaluateSpectral({0, 0, -1}, wi);
        for (int i = 0; i < kNumWavelengths; ++i) {
            const double expected = ByDefinition(numbers, double(Four()[i]), deg);
            // The angle of float directions: 1e-7 rad in 0.05 degrees of a peak.
            EXPECT_NEAR(double(value.p[i]), expected, 3e-4 * expected + 1e-6) << deg << ' ' << Four()[i];
        }
    }
}

TEST(SpectralPhaseTable, FindsTheIntervalOfAnyNodes) {
    Rng rng(SeedOf(FullTestName()));
    for (const int n : {2, 3, 17, 400}) {
        PhaseNumbers numbers{{}, {0}, std::vector<float>(size_t(n), 1)};
        for (int i = 1; i < n - 1; ++i)  // crowded at both ends
            numbers.angles.push_back(180 * std::pow(rng.Uniform(), float(1 + i % 5)));
        numbers.angles.push_back(180);
        std::sort(numbers.angles.begin(), numbers.angles.end());
        const SpectralPhaseTable table(numbers);
        const auto node = [&](size_t i) {
            return float(2 * Sqr(std::sin(double(numbers.angles[i]) * (M_PI / 360))));
        };
        for (int k = 0; k < 2000; ++k) {
            const float t = k == 0 ? 0 : k == 1 ? 2 : 2 * std::pow(rng.Uniform(), float(k % 4 + 1));
            const SpectralPhaseTable::Node found = table.Find(t);
            ASSERT_LT(found.index + 1, size_t(n));
            ASSERT_TRUE(node(found.index) <= t && t <= node(found.index + 1)) << n << ' ' << t;
            ASSERT_NEAR(Lerp(found.x, node(found.index), node(found.index + 1)), t, 3e-7);
        }
        EXPECT_EQ(table.Find(NAN).index, size_t(n) - 2);
    }
}

TEST(SpectralPhaseTable, SurvivesBadNumbers) {
    const PhaseNumbers nothing{{400, 500}, {0, 180}, {0, NAN, -1, 0}};
    const SpectralPhaseTable isotropic(nothing);
    const SpectralTabulatedPhase phase(isotropic, Four());
    EXPECT_FLOAT_EQ(phase.Evaluate(kWo, {0, 0, 1}).p, Inv4Pi);
    // Angles that differ but have one cosine, empty intervals at both ends and inside.
    const PhaseNumbers gaps{
        {}, {0, 1e-30f, 2e-30f, 10, 20, 30, 40, 179.99999f, 180}, {0, 0, 0, 0, 5, 0, 0, 3, 3}};
    const SpectralPhaseTable gappy(gaps);
    EXPECT_TRUE(RecordsAreConsistent(SpectralTabulatedPhase(gappy, Four()), SeedOf(FullTestName())));
}

/// A lobe that falls from 1 to 0 between these angles, and nothing else.
PhaseNumbers Lobe(float from, float to) {
    if (from == 0) return {{}, {0, to, 180}, {1, 0, 0}};
    if (to == 180) return {{}, {0, from, 180}, {0, 0, 1}};
    return {{}, {0, from, to, 2 * to - from, 180}, {0, 0, 1, 0, 0}};
}

/// The fraction of draws whose density is 0 where they have ended up, and so are lost.
double LostFraction(const PhaseNumbers& numbers, uint64_t seed) {
    const SpectralPhaseTable table(numbers);
    const SpectralTabulatedPhase phase(table, Four());
    Rng rng(seed);
    constexpr int kDraws = 40000;
    int lost = 0;
    for (int i = 0; i < kDraws; ++i) lost += !(phase.Sample(RandomDirection(rng), rng).pdf > 0);
    return double(lost) / kDraws;
}

// What is accepted loses less than 0.4 % at the limit, where directions are rounded into places without
// light. The controls: what is refused by a factor of ten loses several times as much.
TEST(SpectralPhaseTable, LobesThatDirectionsDoNotResolveAreRefused) {
    for (const auto& [from, to] :
         {std::pair(0.f, 1e-4f), {10.f, 10.0003f}, {90.f, 90.0003f}, {179.76f, 180.f}}) {
        EXPECT_EQ(WhyTooNarrow(Lobe(from, to)), "") << from;
        EXPECT_LT(LostFraction(Lobe(from, to), SeedOf(FullTestName())), 4e-3) << from;
    }
    for (const auto& [from, to] :
         {std::pair(0.f, 1e-5f), {0.f, 1e-20f}, {90.f, 90.00001f}, {179.97f, 180.f}}) {
        EXPECT_NE(WhyTooNarrow(Lobe(from, to)), "") << from;
        EXPECT_GT(LostFraction(Lobe(from, to), SeedOf(FullTestName())), 0.012) << from;
    }
    // Steps that are fine enough for a narrow lobe, with little light in each, are no such lobes.
    PhaseNumbers fine{{400, 500}, {}, {}};
    for (int i = 0; i < 2000; ++i) fine.angles.push_back(1e-6f * float(i));
    fine.angles.push_back(180);
    for (int i = 0; i < 2 * 2001; ++i) fine.values.push_back(i % 2001 < 1999 ? 1 : 0);
    EXPECT_EQ(WhyTooNarrow(fine), "");
    for (int i = 80; i < 2001; ++i) fine.values[size_t(2001 + i)] = 0;
    EXPECT_NE(WhyTooNarrow(fine).find("100 % of the light at 500 nm is scattered between 0 and "),
              std::string::npos)
        << WhyTooNarrow(fine);
    // Nor is a needle with less than a hundredth of the light, as this one would be with two.
    const PhaseNumbers two{{}, {0, 1e-5f, 90, 180}, {5.5e11f, 0.1f, 0.1f, 0.1f}};
    EXPECT_NE(WhyTooNarrow(two), "");
    const PhaseNumbers needle{{}, {0, 1e-20f, 90, 180}, {3e38f, 0.1f, 0.1f, 0.1f}};
    EXPECT_EQ(WhyTooNarrow(needle), "");
    EXPECT_TRUE(RecordsAreConsistent(SpectralTabulatedPhase(SpectralPhaseTable(needle), Four()),
                                     SeedOf(FullTestName())));
}

TEST(PhaseTables, LobesThatAreTooNarrowAreErrorsAtTheTable) {
    const std::string error = MediumErrorOf(
        "homogeneous", "\"string phase\" \"table\" \"float angles\" [0 1e-6 180] \"float table\" [1 0 0]");
    EXPECT_NE(error.find("\"float table\": 100 % of the light is scattered between 0 and 1e-06 degrees"),
              std::string::npos)
        << error;
    EXPECT_EQ(MediumErrorOf("homogeneous",
                            "\"string phase\" \"table\" \"float angles\" [0 1e-4 180] "
                            "\"float table\" [1 0 0]"),
              "");
}

TEST(SpectralPhaseTable, OfHenyeyAndGreensteinIsTheirs) {
    PhaseNumbers numbers;
    const HenyeyGreensteinPhase hg(0.7f);
    for (int i = 0; i <= 180; ++i) {
        numbers.angles.push_back(float(i));
        const float a = Radians(float(i));
        numbers.values.push_back(7 * hg.Evaluate({0, 0, -1}, {std::sin(a), 0, std::cos(a)}).p);
    }
    const SpectralPhaseTable table(numbers);
    const SpectralTabulatedPhase phase(table, Four());
    EXPECT_FALSE(phase.IsChromatic());
    for (float a = 0; a < Pi; a += 0.013f) {
        const Vec3 wi(std::sin(a), 0, std::cos(a));
        const float p = hg.Evaluate({0, 0, -1}, wi).p;
        EXPECT_NEAR(phase.Evaluate({0, 0, -1}, wi).p / p, 1, 2e-3f) << a;
    }
}

/// The phase function of a homogeneous medium of these parameters.
class PhaseOf {
  public:
    explicit PhaseOf(const std::string& parameters) : medium_(MakeMedium("homogeneous", parameters)) {}
    SampledSpectrum operator()(Vec3 wo, Vec3 wi) {
        return medium_->Phase(Four(), arena_).EvaluateSpectral(wo, wi).p;
    }

  private:
    std::unique_ptr<Medium> medium_;
    Arena arena_;
};

std::string FileWith(const std::string& text) {
    const std::string path = testing::TempDir() + FullTestName() + ".txt";
    std::ofstream(path) << text;
    return path;
}

TEST(PhaseTables, InlineAndFromAFileAreTheSame) {
    const std::string path = FileWith(
        "# a table\nwavelengths 500 700  # nm\n0 1 8\n 60 3 4 # of the cosine: 0.5\n90 2 2\n\n180\t5 1");
    PhaseOf file("\"string phase\" \"table\" \"string tablefile\" \"" + path + "\""),
        angles(
            "\"string phase\" \"table\" \"float table\" [1 3 2 5  8 4 2 1] \"float angles\" [0 60 90 180] "
            "\"float wavelengths\" [500 700]"),
        // Cosines -1 ... 1 in steps of 1/2.
        cosines(
            "\"string phase\" \"table\" \"float table\" [5 3.5 2 3 1  1 1.5 2 4 8] \"float wavelengths\" "
            "[500 700]");
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 1000; ++i) {
        const Vec3 wo = RandomDirection(rng), wi = RandomDirection(rng);
        const SampledSpectrum a = file(wo, wi), b = angles(wo, wi), c = cosines(wo, wi);
        for (int l = 0; l < kNumWavelengths; ++l) {
            ASSERT_NEAR(a[l], b[l], 1e-6f * a[l]);
            ASSERT_NEAR(a[l], c[l], 1e-5f * a[l]);
        }
    }
    EXPECT_GT(file({0, 0, -1}, {0, 0, 1})[3], 2 * file({0, 0, -1}, {0, 0, 1})[0]);
}

TEST(PhaseTables, OfOneRowAreThoseByTheCosine) {
    PhaseOf old("\"string phase\" \"table\" \"float table\" [5 3.5 2 3 1]"),
        angles("\"string phase\" \"table\" \"float table\" [1 3 2 5] \"float angles\" [0 60 90 180]");
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 1000; ++i) {
        const Vec3 wo = RandomDirection(rng), wi = RandomDirection(rng);
        ASSERT_NEAR(old(wo, wi)[0], angles(wo, wi)[2], 1e-5f);
    }
}

TEST(PhaseTables, BadFilesNameThePlace) {
    const auto error = [](const std::string& text) -> std::string {
        const std::string path = FileWith(text);
        try {
            ReadPhaseTableFile(path, {});
        } catch (const SceneError& e) {
            return std::string(e.what()).substr(std::string(e.what()).find(".txt") + 4);
        }
        return "";
    };
    const auto expect = [&](const std::string& text, const std::string& place, const std::string& says) {
        const std::string found = error(text);
        EXPECT_TRUE(found.starts_with(place)) << found;
        EXPECT_NE(found.find(says), std::string::npos) << found;
    };
    expect("", ":1:1", "ends before 180");
    expect("0 1\n90 2\n", ":3:", "ends before 180");
    expect("wavelengths\n0 1\n180 1", ":1:1", "no wavelengths");
    expect("wavelengths 500 400\n", ":1:17", "increasing");
    expect("wavelengths -1\n", ":1:13", "above 0");
    expect("wavelengths 400 500\n0 1\n180 1 1", ":2:1", "expected 2");
    expect("0 1\n180 1 1", ":2:1", "\"wavelengths\"");
    expect("1 1\n180 1", ":1:1", "expected 0");
    expect("0 1\n90 1\n80 1\n180 1", ":3:1", "increasing");
    expect("0 1\n190 1", ":2:1", "up to 180");
    expect("0 1\n90 -2\n180 1", ":2:4", "negative");
    expect("0 1\n90 x\n180 1", ":2:4", "x");
    expect("0 nan\n180 1", ":1:3", "nan");
    expect("wavelengths 400 500\n0 1 0\n180 1 0", "", "column 2");
    expect("0 1\n1e-6 0\n180 0", "", "100 % of the light");
    EXPECT_EQ(error("0 1\n180 0\n"), "");
}

}  // namespace
}  // namespace lacquer::table_test
