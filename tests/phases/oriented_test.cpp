// Files of oriented ensembles in media and slabs: extinction, albedo and p by direction and wavelength.
#include "pbrt/phases/oriented.h"

#include "media/medium_fixtures.h"
#include "pbrt/phases/bulk.h"
#include "pbrt/phases/hg.h"
#include "pbrt/phases/mixture.h"
#include "pbrt/phases/sggx.h"
#include "phases/phase_checks.h"
#include "phases/phase_scenes.h"
#include "support/oriented_tables.h"

namespace lacquer::test::oriented_test {
namespace {

constexpr double kAlpha = 1e-5;  // some fifty runs in this file

const Vec3 kAxis = Normalize({0.6f, 0.3f, 0.7f});
const std::string kOrientation = "\"vector3 orientation\" [0.6 0.3 0.7] ";

/// Reciprocal, and even across the axis: a mean scattering in all directions, more along the axis or across
/// it, times a lobe of Henyey and Greenstein.
OrientedMedium Lobe(double sigma, double along, double g, double absorption = 0) {
    const auto weight = [=](Vec3 w) { return 1 + along * double(w.z) * double(w.z); };
    return {[=](Vec3 n, Vec3 s) {
                const double c = double(Dot(n, s));
                return sigma * weight(n) * weight(s) * (1 - g * g) /
                       (4 * M_PI * std::pow(1 + g * g - 2 * g * c, 1.5));
            },
            [=](Vec3 n) { return absorption * (1.5 - double(n.z) * double(n.z)); }};
}
/// That differ at each of the four wavelengths of the tests: 750 nm is beyond the last one.
std::vector<OrientedMedium> FourLobes(bool absorbs = true) {
    const double loss = absorbs ? 1 : 0;
    return {Lobe(1.5, 2, 0.5, 0.3 * loss), Lobe(1, -0.6, 0.3, 0), Lobe(0.5, 1, -0.3, 0.6 * loss),
            Lobe(0.3, -0.8, 0.1, 0.1 * loss)};
}
const std::vector<double> kNodes = {400, 500, 600, 700};
OrientedBulkTable FourColours(bool absorbs = true) { return OrientedTable(kNodes, FourLobes(absorbs)); }

/// The phase function of a table about an axis, at the four wavelengths.
struct Made {
    explicit Made(const OrientedBulkTable& table, Vec3 axis = kAxis)
        : numbers(table), phase(numbers, axis, Four()) {}
    const PhaseFunction& operator*() const { return phase; }
    OrientedPhaseTable numbers;
    OrientedPhase phase;
};

/// Across the axis, along it, and in between.
std::vector<Vec3> SomeDirections() {
    Vec3 x, y;
    CoordinateSystem(kAxis, &x, &y);
    return {kAxis, x, Normalize(x + 0.003f * kAxis), Normalize(0.4f * x - kAxis + 0.1f * y),
            Normalize(y - 0.3f * kAxis)};
}

std::string Bulk(const OrientedBulkTable& table, const std::string& name = "t.json") {
    return "\"string bulk\" \"" + WriteFile(name, table) + "\" ";
}

// ---- The table ----

TEST(OrientedTable, MadeReciprocalHasItsIntegralsAndSaysWhatChanged) {
    OrientedBulkTable table = FourColours();
    const OrientedGrid grid(table);
    for (const double change : table.errorReciprocity) EXPECT_LT(change, 0.02);
    // Noise of 20 % on what is reciprocal.
    Rng rng(SeedOf(FullTestName()));
    std::vector<double> scattered;
    for (size_t at = 0; at < grid.Size(); ++at)
        scattered.push_back(table.sigmaS[0][at / (grid.NumAngles() * grid.NumAzimuths())] *
                            double(table.phase[0][at]) * (1 + 0.4 * (double(rng.Uniform()) - 0.5)));
    const double change = MakeReciprocal(grid, table.sigmaS[0], scattered);
    EXPECT_NEAR(change, 0.07, 0.02);  // a mean of |0.4 (u - 1/2)| is 0.1; halves of pairs cancel
    for (size_t i = 0; i < grid.NumIncidences(); ++i) {
        EXPECT_NEAR(grid.OverSphere<double>(scattered, i) / table.sigmaS[0][i], 1, 1e-10);
        for (size_t j = 0; j < grid.NumAngles(); ++j) {
            const auto [a, b] = grid.Reciprocal(i, j);
            for (size_t k = 0; k < grid.NumAzimuths(); ++k)
                EXPECT_NEAR(scattered[grid.Index(i, j) + k] / scattered[grid.Index(a, b) + k], 1, 1e-12);
        }
    }
    // And stays as it is.
    EXPECT_LT(MakeReciprocal(grid, table.sigmaS[0], scattered), 1e-11);
}

// ---- The phase function ----

// 200,000 draws over some 700 cells for each of 5 directions and 4 wavelengths; controls draw about another
// axis and at another wavelength.
TEST(OrientedPhase, SamplesFollowP) {
    const Made made(FourColours()), turned(FourColours(), {0.6f, 0.3f, 0.5f});
    for (const Vec3 wo : SomeDirections()) {
        const SphereGrid grid = SphereGrid::Fine(kAxis, 24);
        for (int l = 0; l < kNumTested; ++l) {
            const AtWavelength at(*made, l);
            EXPECT_TRUE(Passes(fmt::format("{} {} {}", FullTestName(), l, wo.x), SidakAlpha(1e-3, 20),
                               [&](uint64_t seed) { return SamplesFollow(at, at, wo, grid, seed); }));
        }
        EXPECT_LT(SamplesFollow(AtWavelength(*made, 0), AtWavelength(*made, 2), wo, grid, 1).pValue, 1e-6);
    }
    const SphereGrid grid = SphereGrid::Fine(kAxis, 24);
    EXPECT_LT(SamplesFollow(*turned, *made, SomeDirections()[3], grid, 1).pValue, 1e-6);
}

TEST(OrientedPhase, IntegratesToOneAndItsRecordsAgree) {
    const Made made(FourColours());
    for (int l = 0; l < kNumTested; ++l) {
        const AtWavelength at(*made, l);
        EXPECT_TRUE(RecordsAreConsistent(at, SeedOf(FullTestName())));
        for (const Vec3 wo : SomeDirections()) {
            const SphereGrid grid = SphereGrid::Fine(kAxis, 24);
            EXPECT_NEAR(grid.Integral([&](Vec3 wi) { return at.Evaluate(wo, wi).p; }), 1, 2e-4) << wo.x;
        }
    }
}

// Also within a thousandth of a radian of the plane across the axis, and of the axis.
TEST(OrientedPhase, IsReciprocalAlsoAtGrazingAngles) {
    const Made made(FourColours());
    Rng rng(SeedOf(FullTestName()));
    const Frame frame = Frame::FromZ(kAxis);
    for (int l = 0; l < kNumTested; ++l) {
        const AtWavelength at(*made, l);
        EXPECT_LT(ReciprocityError(at, rng.NextBits()), 2e-5);
        double worst = 0;
        for (int i = 0; i < 2000; ++i) {
            const float z = 1e-3f * (rng.Uniform() - 0.5f), phi = 2 * Pi * rng.Uniform();
            const Vec3 grazing = frame.FromLocal(SphericalDirection(std::sqrt(1 - z * z), z, phi));
            const Vec3 along = Normalize(kAxis + 1e-3f * RandomDirection(rng));
            for (const Vec3 other : {RandomDirection(rng), along}) {
                const auto there =
                    double(at.Extinction(grazing) * at.Albedo(grazing) * at.Evaluate(grazing, other).p);
                const auto back =
                    double(at.Extinction(other) * at.Albedo(other) * at.Evaluate(other, grazing).p);
                worst = std::max(worst, std::abs(there / back - 1));
            }
        }
        EXPECT_LT(worst, 2e-5);
    }
    // The control: p alone is not symmetric.
    const Vec3 wo = SomeDirections()[0], wi = SomeDirections()[1];
    EXPECT_GT(std::abs((*made).Evaluate(wo, wi).p / (*made).Evaluate(wi, wo).p - 1), 0.3f);
}

/// What the closed forms say at one of the four wavelengths: rows linear between nodes, constant beyond.
double AtLambda(int l, const std::function<double(const OrientedMedium&)>& value) {
    const std::vector<OrientedMedium> media = FourLobes();
    if (l == 3) return value(media[3]);
    return 0.5 * (value(media[size_t(l)]) + value(media[size_t(l) + 1]));
}

// Linear interpolation over 5 degrees is right to a few parts in a thousand; p changes by factors.
TEST(OrientedPhase, HasTheExtinctionAlbedoAndPOfItsMedium) {
    const Made made(FourColours());
    const Frame frame = Frame::FromZ(kAxis);
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 40; ++i) {
        const Vec3 n = RandomDirection(rng), s = RandomDirection(rng);
        const Vec3 wo = -frame.FromLocal(n), wi = frame.FromLocal(s);
        const DirectionalFactors factors = (*made).FactorsAlong(wo, Four());
        for (int l = 0; l < kNumTested; ++l) {
            const double scattering = AtLambda(l, [&](const auto& m) { return ScatteredOut(m, n); });
            const double absorption = AtLambda(l, [&](const auto& m) { return m.absorbed(n); });
            const double pair = AtLambda(l, [&](const auto& m) { return m.scattered(n, s); });
            const double extinction = double(factors.extinction[l] * made.numbers.MeanExtinction(Four()[l]));
            EXPECT_NEAR(extinction / (scattering + absorption), 1, 4e-3) << l;
            EXPECT_NEAR(double(factors.albedo[l] * made.numbers.LargestAlbedo()) * extinction / scattering, 1,
                        4e-3);
            EXPECT_NEAR(double((*made).EvaluateSpectral(wo, wi).p[l]) * scattering / pair, 1, 0.02);
        }
    }
}

TEST(OrientedPhase, TurnsWithItsAxis) {
    const OrientedBulkTable table = FourColours();
    const Made upright(table, {0, 0, 1}), tilted(table, kAxis * 7.f);
    const Transform about = Transform::Rotate(73, {0, 0, 1});
    const Frame frame = Frame::FromZ(kAxis);
    Rng rng(SeedOf(FullTestName()));
    float difference = 0;
    for (int i = 0; i < 1000; ++i) {
        const Vec3 wo = RandomDirection(rng), wi = RandomDirection(rng);
        const Vec3 o = frame.FromLocal(about.Vector(wo)), in = frame.FromLocal(about.Vector(wi));
        EXPECT_NEAR((*tilted).Evaluate(o, in).p / (*upright).Evaluate(wo, wi).p, 1, 2e-4f);
        EXPECT_NEAR((*tilted).Extinction(o) / (*upright).Extinction(wo), 1, 1e-5f);
        EXPECT_NEAR((*tilted).Albedo(o) / (*upright).Albedo(wo), 1, 1e-5f);
        difference = std::max(difference, std::abs((*tilted).Extinction(wo) - (*upright).Extinction(wo)));
    }
    EXPECT_GT(difference, 0.3f) << "a control";
}

TEST(OrientedPhase, OfOneWavelengthIsTheSameAtAll) {
    const Made made(OrientedTable({550}, {Lobe(1, 2, 0.5, 0.1)}));
    EXPECT_FALSE((*made).IsChromatic());
    EXPECT_TRUE(Made(FourColours()).phase.IsChromatic());
    SampledWavelengths one = Four();
    one.TerminateSecondary();
    const OrientedPhaseTable numbers(FourColours());
    EXPECT_FALSE(OrientedPhase(numbers, kAxis, one).IsChromatic());
}

TEST(OrientedPhase, InMixturesIsWeightedByWhatScatters) {
    const Made a(FourColours()), b(OrientedTable({550}, {Lobe(1, 3, 0.2, 0.8)}), Vec3(1, 0, 0));
    const HenyeyGreensteinPhase hg(0.3f);
    const PhaseFunction* const parts[] = {&a.phase, &b.phase, &hg};
    const float weights[] = {1, 2, 1};
    const MixturePhase mixture(parts, weights, Four());
    const SphereGrid grid = SphereGrid::Fine(kAxis, 24);
    for (int l = 0; l < kNumTested; ++l) {
        const AtWavelength at(mixture, l);
        EXPECT_LT(ReciprocityError(at, SeedOf(FullTestName())), 2e-5);
        EXPECT_TRUE(RecordsAreConsistent(at, SeedOf(FullTestName())));
        const Vec3 wo = SomeDirections()[3];
        EXPECT_TRUE(Passes(fmt::format("{} {}", FullTestName(), l), SidakAlpha(1e-3, 4),
                           [&](uint64_t seed) { return SamplesFollow(at, at, wo, grid, seed); }));
        // What the parts scatter and meet, added up.
        double extinction = 0, scattered = 0;
        for (size_t k = 0; k < 3; ++k) {
            const DirectionalFactors part = parts[k]->FactorsAlong(wo, Four());
            extinction += double(weights[k] / 4 * part.extinction[l]);
            scattered += double(weights[k] / 4 * part.extinction[l] * part.albedo[l]);
        }
        EXPECT_NEAR(at.Extinction(wo), extinction, 1e-5);
        EXPECT_NEAR(at.Albedo(wo), scattered / extinction, 1e-5);
        EXPECT_LT(at.Albedo(wo), 0.95f);
    }
}

// ---- Rendered ----

std::string MediumText(const std::string& parameters) {
    return "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" " + parameters;
}
std::string SlabScene(const std::string& parameters, const std::string& light) {
    return View("volpath", 500, {1.5f, 1, 2}) + light +
           "MakeNamedMaterial \"s\" \"string type\" \"slab\" \"float eta\" 1 " + parameters +
           "Material \"layered\" \"string stack\" [\"interface\" \"s\" \"interface\"] Shape \"trianglemesh\" "
           "\"point3 P\" [-2 -2 0 2 -2 0 -2 2 0 2 2 0] \"point2 uv\" [0 0 1 0 0 1 1 1] \"integer indices\" "
           "[0 1 "
           "2 1 3 2] ";
}
/// A box, 1 thick and 400 wide: the slab of thickness 1, by free flights in space.
std::string BoxScene(const std::string& parameters, const std::string& light) {
    return View("volpath", 500, {1.5f, 1, 2}) + light + MediumText(parameters) +
           "MediumInterface \"m\" \"\" Material \"interface\" Shape \"trianglemesh\" \"point3 P\" [-200 -200 "
           "-0.5 200 -200 -0.5 -200 200 -0.5 200 200 -0.5 -200 -200 0.5 200 -200 0.5 -200 200 0.5 200 200 "
           "0.5] \"integer indices\" [0 2 1 1 2 3 4 5 6 5 7 6 0 1 4 1 5 4 2 6 3 3 6 7 0 4 2 2 4 6 1 3 5 3 7 "
           "5] ";
}
const std::vector<std::pair<std::string, Vec3>> kLights = {{"reflected", {-1, 0.5f, 1.2f}},
                                                           {"transmitted", {0.4f, -1, -1.5f}}};

// In media the mean over the wavelengths of a path is 1 without any noise, for the balance heuristic divides
// by it; slabs carry one wavelength. The loss is 1 in 50 along the axis, and none across it.
TEST(OrientedFurnace, IsOneAndALossOfOneInFiftyIsFound) {
    std::vector<OrientedMedium> lossy = FourLobes(false);
    for (OrientedMedium& medium : lossy)
        medium.absorbed = [scattered = medium](Vec3 n) {
            return ScatteredOut(scattered, n) / 49 * double(n.z) * double(n.z);
        };
    for (const bool isLossy : {false, true}) {
        const std::string bulk =
            Bulk(OrientedTable(kNodes, isLossy ? lossy : FourLobes(false))) + kOrientation;
        const std::string start = View("volpath", 4000, {3, 1, -2}) + kWhite;
        const std::string grid =
            "MakeNamedMedium \"m\" \"string type\" \"uniformgrid\" \"point3 p0\" [-1 -1 -1] \"float "
            "density\" "
            "[2 0.5 1 3] \"integer nx\" 2 \"integer ny\" 2 " +
            bulk;
        for (const std::string& medium : {MediumText(bulk), grid}) {
            const RunningMean mean =
                CenterRadiance(BuildText(start + medium + kBall), Scaled(20000), SeedOf(FullTestName()));
            if (isLossy)
                EXPECT_LT(ZTest(mean, 1, 1e-4, "").pValue, kAlpha) << mean.Mean();
            else
                EXPECT_NEAR(mean.Mean(), 1, 2e-4);
        }
        const std::string slab = SlabScene(bulk + "\"float thickness\" 2 ", kWhite);
        const auto furnace = [&](uint64_t seed) {
            const RunningMean mean = CenterRadiance(BuildText(slab), Scaled(400000), seed);
            EXPECT_LT(mean.StandardError(), 0.6 / std::sqrt(Scaled(400000)));
            return ZTest(mean, 1, 1e-4, "slab");
        };
        if (isLossy)
            EXPECT_LT(furnace(1).pValue, kAlpha);
        else
            EXPECT_TRUE(Passes(FullTestName(), kAlpha, furnace));
    }
}

TEST(OrientedFurnace, IsOneAtEachWavelength) {
    const std::string medium = MediumText(Bulk(FourColours(false)) + kOrientation);
    EXPECT_TRUE(
        Passes(FullTestName(), kAlpha, [&](uint64_t seed) { return FurnaceAtEachWavelength(medium, seed); }));
}

/// Light that is scattered once in the unit ball about the axis, over the light's irradiance, along z through
/// its middle: by the closed forms.
double SingleScattering(int l, Vec3 toLight) {
    const Frame frame = Frame::FromZ(kAxis);
    const Vec3 n = frame.ToLocal(-toLight), s = frame.ToLocal({0, 0, -1});
    const auto extinction = [&](Vec3 w) {
        return AtLambda(l, [&](const auto& m) { return ScatteredOut(m, w) + m.absorbed(w); });
    };
    const double in = extinction(n), out = extinction(s);
    constexpr int kSteps = 20000;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double z = -1 + 2 * (i + 0.5) / kSteps, along = z * double(toLight.z);
        sum += std::exp(-out * (z + 1) - in * (-along + std::sqrt(along * along + 1 - z * z)));
    }
    return sum * 2 / kSteps * AtLambda(l, [&](const auto& m) { return m.scattered(n, s); });
}

// Four wavelengths, four lights. Power: 2 %, of which interpolation takes a part; controls leave out the
// turning of the axis, or swap two colours.
TEST(OrientedMedia, ScatterOnceAsTheIntegralSays) {
    const auto empty = SpectralRadiance(View("volpath", 5, {0, 0, -4}) + kWhite, 4, 1);
    const Vec3 lights[] = {Normalize(Vec3(0.5f, 0.2f, 0.7f)), Normalize(Vec3(1, 0, 0.05f)),
                           Normalize(Vec3(0.3f, -0.5f, -0.8f)), -kAxis};
    const auto worst = [&](const std::string& parameters, uint64_t seed) {
        std::vector<Outcome> outcomes;
        for (const Vec3& toLight : lights) {
            const std::string scene =
                View("volpath", 1, {0, 0, -4}) + Distant(toLight) + MediumText(parameters) + kBall;
            const auto all = SpectralRadiance(scene, Scaled(40000), Hash(seed, toLight.x));
            for (int l = 0; l < kNumTested; ++l) {
                const RunningMean& mean = all[size_t(l)];
                const double expected = 3 * empty[size_t(l)].Mean() * SingleScattering(l, toLight);
                EXPECT_LT(mean.StandardError(), 0.02 * std::sqrt(40000. / Scaled(40000)) * expected);
                outcomes.push_back(
                    ZTest(mean, expected, 0.015 * expected, fmt::format("{} {}", l, toLight.x)));
            }
        }
        return WorstOf(outcomes);
    };
    const std::string file = Bulk(FourColours());
    EXPECT_TRUE(
        Passes(FullTestName(), kAlpha, [&](uint64_t seed) { return worst(file + kOrientation, seed); }));
    EXPECT_LT(worst(file, 1).pValue, kAlpha);
    std::vector<OrientedMedium> swapped = FourLobes();
    std::swap(swapped[1], swapped[2]);
    EXPECT_LT(worst(Bulk(OrientedTable(kNodes, swapped), "other.json") + kOrientation, 1).pValue, kAlpha);
}

// Free flights in space with four wavelengths, and the stack's walks by depth with one. Power: standard
// errors of 1 to 2 %.
TEST(OrientedSlabs, AreWideBoxesOfTheSame) {
    const std::string bulk = Bulk(FourColours()), turned = bulk + kOrientation;
    double control = 1;
    for (const auto& light : kLights) {
        EXPECT_TRUE(Passes(FullTestName() + light.first, kAlpha, [&](uint64_t seed) {
            return Compare(BoxScene(turned, Distant(light.second)), SlabScene(turned, Distant(light.second)),
                           60000, seed);
        })) << light.first;
        control = std::min(control, Compare(BoxScene(turned, Distant(light.second)),
                                            SlabScene(bulk, Distant(light.second)), 60000, 1)
                                        .pValue);
    }
    EXPECT_LT(control, kAlpha);
}

// The table of an isotropic medium, written as that of an oriented one, in slabs and boxes, in reflection and
// in transmission. Power: standard errors of 0.5 to 1 %; controls have a g of 0.4 for 0.5.
TEST(OrientedTablesLong, OfIsotropicMediaRenderAsIsotropicOnes) {
    const auto isotropic = [](double g) {
        return Bulk(OrientedTable({400, 700}, {Lobe(1.35, 0, g), Lobe(1.35, 0, g)}, 61)) + kOrientation;
    };
    const std::string hg = "\"string bulk\" \"" +
                           WriteFile("hg.json", HgTable({400, 700}, {0.5, 0.5}, {1.35, 1.35}, {0, 0})) +
                           "\" ";
    for (const auto& scene : {SlabScene, BoxScene}) {
        double control = 1;
        for (const auto& light : kLights) {
            const std::string first = scene(hg, Distant(light.second));
            EXPECT_TRUE(Passes(FullTestName() + light.first, kAlpha, [&](uint64_t seed) {
                return Compare(first, scene(isotropic(0.5), Distant(light.second)), 100000, seed);
            })) << light.first;
            control = std::min(
                control, Compare(first, scene(isotropic(0.4), Distant(light.second)), 100000, 1).pValue);
        }
        EXPECT_LT(control, kAlpha);
    }
}

// Flakes have a closed form of their own. Power: as above; controls have other flakes.
TEST(OrientedTables, OfFlakesRenderAsTheFlakes) {
    const auto flakes = [](float roughness) {
        const SggxPhase sggx({0, 0, 1}, roughness, true);
        const OrientedMedium medium{
            [=](Vec3 n, Vec3 s) { return 1.5 * double(sggx.Extinction(n) * sggx.Evaluate(-n, s).p); }};
        return Bulk(OrientedTable({550}, {medium}, 61)) + kOrientation;
    };
    const std::string sggx =
        "\"string phase\" \"sggx\" \"float roughness\" 0.5 \"string flakes\" \"surface\" " + kOrientation;
    const std::string box = sggx + "\"rgb sigma_s\" [1.5 1.5 1.5] \"rgb sigma_a\" [0 0 0] ",
                      slab = sggx + "\"rgb sigma_t\" [1.5 1.5 1.5] \"rgb albedo\" [1 1 1] ";
    double control = 1;
    for (const auto& light : kLights) {
        const std::string sun = Distant(light.second);
        EXPECT_TRUE(Passes(FullTestName() + light.first, kAlpha, [&](uint64_t seed) {
            const Outcome both[] = {
                Compare(BoxScene(box, sun), BoxScene(flakes(0.5f), sun), 100000, seed),
                Compare(SlabScene(slab, sun), SlabScene(flakes(0.5f), sun), 100000, seed + 9)};
            return WorstOf(both);
        })) << light.first;
        control =
            std::min(control, Compare(BoxScene(box, sun), BoxScene(flakes(0.4f), sun), 100000, 1).pValue);
    }
    EXPECT_LT(control, kAlpha);
}

// ---- Files ----

TEST(OrientedFile, ReadAndWrittenAgainIsTheSame) {
    OrientedBulkTable table = FourColours();
    table.made = R"({"by":"test"})";
    table.errorSigmaS = {0.1, 0.2, 0.3, 0.4};
    const std::string path = WriteFile("a.json", table);
    const auto read = [](const std::string& from) {
        auto found = std::get<OrientedBulkTable>(ReadBulkFile(from));
        ReadOrientedPhase(from, {}, &found);
        return found;
    };
    const OrientedBulkTable found = read(path);
    EXPECT_EQ(found.phaseFile, "a.exr");
    EXPECT_EQ(found.phase, table.phase);
    EXPECT_EQ(found.errorReciprocity.size(), 4u);
    EXPECT_EQ(WriteBulkTable(read(WriteFile("a.json", found))), WriteBulkTable(found));
    EXPECT_THROW(ReadBulkTable(path), SceneError);
}

TEST(OrientedFile, ThatIsWrongIsAnErrorWithItsPlace) {
    const OrientedBulkTable good = OrientedTable({550}, {Lobe(1, 1, 0.2)}, 13);
    const auto expect = [](const OrientedBulkTable& table, const std::string& says) {
        const std::string error = MediumErrorOf("homogeneous", Bulk(table));
        EXPECT_NE(error.find(says), std::string::npos) << error;
    };
    OrientedBulkTable bad = good;
    bad.phase[0][100] *= 1.5f;
    expect(bad, "t.exr: error: the phase function for an incidence of 0 degrees at 550 nm integrates to 1.0");
    bad = good;
    bad.phase[0][900] = -1;
    expect(bad, "is -1 for an incidence of ");
    bad = good;
    bad.sigmaS[0][3] *= 1.01;
    expect(bad, "(reciprocity)");
    bad = good;
    bad.sigmaA[0][2] = 1e31;
    expect(bad, "a coefficient is 1e+31 per mm");
    EXPECT_EQ(MediumErrorOf("homogeneous", Bulk(good)), "");

    const std::string path = WriteFile("u.json", good);
    std::ifstream in(path);
    const std::string text((std::istreambuf_iterator<char>(in)), {});
    const auto expectText = [&](const std::string& from, const std::string& to, const std::string& says) {
        std::string changed = text;
        changed.replace(changed.find(from), from.size(), to);
        const std::string error =
            MediumErrorOf("homogeneous", "\"string bulk\" \"" + WriteFile("v.json", changed) + "\" ");
        EXPECT_NE(error.find(says), std::string::npos) << error;
    };
    expectText("[0, 15, ", "[0, 14, ",
               "v.json:9:17: error: found 14; expected 15, for the angles of an oriented");
    expectText("[0, 15, ", "[0, ", "expected an odd number, with 90 degrees in the middle");
    expectText("\"azimuths\": 13", "\"azimuths\": 14", "expected 14 x 91");
    expectText("\"azimuths\": 13", "\"azimuths\": 13.5", "expected a whole number");
    expectText("\"azimuths\"", "\"azimuth\"", "did you mean \"azimuths\"?");
    expectText("\"u.exr\"", "3", "expected the name of an image");
    expectText("[550]", "[551]", "has no channel \"p.551\"");
    // And orientations that are of no use.
    const std::string error =
        MediumErrorOf("homogeneous", "\"string bulk\" \"" +
                                         WriteFile("hg.json", HgTable({400, 700}, {0, 0}, {1, 1}, {0, 0})) +
                                         "\" " + kOrientation);
    EXPECT_NE(error.find("\"orientation\" has no effect"), std::string::npos) << error;
}

}  // namespace
}  // namespace lacquer::test::oriented_test
