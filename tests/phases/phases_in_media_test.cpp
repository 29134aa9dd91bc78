// All phase functions in the media of a scene: transmittance, energy, slabs of the same, and wavelengths.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "media/medium_fixtures.h"
#include "pbrt/integrators/medium_tracking.h"
#include "pbrt/phases/fibre_extinction.h"
#include "phases/phase_scenes.h"
#include "support/nanovdb_fog.h"

namespace lacquer::test::phases_in_media_test {
namespace {

constexpr double kAlpha = 1e-5;  // some hundred checks in this file

const Vec3 kAxis = Normalize({0.6f, 0.3f, 0.7f});
const std::string kOrientation = "\"vector3 orientation\" [0.6 0.3 0.7] ";

/// A phase function by its parameters; the definitions that it refers to, for a slab or a medium.
struct Phase {
    std::string name, parameters;
    bool isMixture = false, isChromatic = false;
};
const std::vector<Phase> kPhases = {
    {"isotropic", "\"string phase\" \"isotropic\" "},
    {"hg", "\"string phase\" \"hg\" \"float g\" 0.7 "},
    {"vmf", "\"string phase\" \"vmf\" \"float kappa\" 4 "},
    {"table", "\"string phase\" \"table\" \"float table\" [3 0.5 0.2 0.1 1 4] "},
    {"spectral table",
     "\"string phase\" \"table\" \"float angles\" [0 5 60 120 180] \"float wavelengths\" [450 550 650] "
     "\"float table\" [30 8 1 0.2 0.1  2 2 2 1 1  0.1 0.1 0.5 4 6] ",
     false, true},
    {"mixture", "\"string phase\" \"mixture\" \"string phases\" [\"a\" \"b\"] \"float weights\" [3 1] ",
     true},
    {"sggx",
     "\"string phase\" \"sggx\" \"float roughness\" 0.3 \"string flakes\" \"surface\" " + kOrientation},
    {"fibre", "\"string phase\" \"fibre\" \"float stddev\" 0.2 " + kOrientation},
};
const Phase& Find(const std::string& name) {
    return *std::find_if(kPhases.begin(), kPhases.end(), [&](const Phase& p) { return p.name == name; });
}

/// What a mixture mixes, as slabs or as media.
std::string PartsOfMixture(const std::string& make, const std::string& type) {
    const auto part = [&](const std::string& name, const std::string& parameters) {
        return fmt::format("{} \"{}\" \"string type\" \"{}\" {} ", make, name, type, parameters);
    };
    return part("a", "\"string phase\" \"fibre\" \"float stddev\" 0.1 \"vector3 orientation\" [1 0.2 0] ") +
           part("b", "\"string phase\" \"hg\" \"float g\" -0.5 ");
}

std::string MediumText(const std::string& type, const Phase& phase, const std::string& coefficients) {
    return (phase.isMixture ? PartsOfMixture("MakeNamedMedium", "homogeneous") : "") +
           fmt::format("MakeNamedMedium \"m\" \"string type\" \"{}\" {} {} ", type, phase.parameters,
                       coefficients);
}

std::string Coefficient(const std::string& name, RGB value) {
    return fmt::format("\"rgb {}\" [{} {} {}] ", name, value.r, value.g, value.b);
}
std::string Grey(const std::string& name, double value) { return Coefficient(name, RGB(float(value))); }

/// All media of a scene: those of the registry, which the first test compares.
const std::string kTypes[] = {"cloud", "homogeneous", "nanovdb", "rgbgrid", "uniformgrid"};

/// The parameters of a medium that fills the unit ball: with one density where it is homogeneous, with
/// several else.
std::string Coefficients(const std::string& type, RGB sigmaA, RGB sigmaS) {
    const std::string both = Coefficient("sigma_a", sigmaA) + Coefficient("sigma_s", sigmaS);
    const std::string box = "\"point3 p0\" [-1 -1 -1] \"point3 p1\" [1 1 1] ";
    const std::string voxels = "\"integer nx\" 2 \"integer ny\" 2 " + box;
    if (type == "nanovdb") return both + "\"string filename\" \"" + FogFile() + "\" ";
    if (type == "cloud") return both + box;
    if (type == "uniformgrid") return both + voxels + "\"float density\" [2 0.5 1 3] ";
    if (type != "rgbgrid") return both;
    std::string a, s;
    for (const float density : {2.f, 0.5f, 1.f, 3.f}) {
        a += fmt::format("{} {} {} ", density * sigmaA.r, density * sigmaA.g, density * sigmaA.b);
        s += fmt::format("{} {} {} ", density * sigmaS.b, density * sigmaS.r, density * sigmaS.g);
    }
    return voxels + "\"rgb sigma_a\" [" + a + "] \"rgb sigma_s\" [" + s + "] ";
}

/// Extinction along w by definition, for those that have one.
double ExtinctionOf(const std::string& name, Vec3 w, Vec3 axis) {
    const auto flakes = [&](double stddev, Vec3 t) {
        return FibreProjectedArea(stddev, double(Length(Cross(w, Normalize(t)))));
    };
    if (name == "sggx") {  // S has the eigenvalues r^2, r^2, 1
        const double c = double(Dot(w, axis));
        return std::sqrt(0.09 * (1 - c * c) + c * c);
    }
    if (name == "fibre") return flakes(0.2, axis);
    if (name == "mixture") return 0.75 * flakes(0.1, {1, 0.2f, 0}) + 0.25;
    return 1;
}

float ExtinctionAlong(const Medium& medium, Vec3 w) {
    return medium.FactorsAlong(w, SomeWavelengths()).extinction[0];
}

constexpr Vec3 kEyes[] = {{0, 0, -4}, {3, 1, -2}, {-1, 3, 2}};

TEST(PhasesInMedia, TransmittanceOfAbsorptionIsThatOfTheExtinctionAlongTheRay) {
    for (const Phase& phase : kPhases)
        for (const Vec3 eye : kEyes) {
            const std::string scene =
                View("volpath", 5, eye) + kWhite +
                MediumText("homogeneous", phase, Grey("sigma_a", 0.7) + Grey("sigma_s", 0)) + kBall;
            const double expected = std::exp(-1.4 * ExtinctionOf(phase.name, Normalize(eye), kAxis));
            const RunningMean mean = CenterRadiance(BuildText(scene), 16);
            EXPECT_NEAR(mean.Mean(), expected, 3e-6) << phase.name;
            EXPECT_LT(mean.Variance(), 1e-12) << "no draw decides";
        }
}

TEST(PhasesInMedia, AreTestedInAllMedia) {
    EXPECT_EQ(Registry<MediumKind>::Names(), std::vector<std::string>(std::begin(kTypes), std::end(kTypes)));
}

// Standard errors of 1 to 2 % of the transmittance. Flakes that count as matter without a direction would
// have an optical depth that is off by more than 10 %, which the last lines check.
TEST(PhasesInMedia, UnscatteredLightIsThatOfTheExtinctionAlongTheRay) {
    const std::string box =
        "MediumInterface \"m\" \"\" Material \"interface\" Shape \"sphere\" \"float radius\" 0.5 ";
    const Vec3 eye = kEyes[1];
    for (const std::string& type : kTypes) {
        const std::string coefficients = Coefficients(type, RGB(0.4f), RGB(0.8f));
        const auto medium = MakeMedium(type, coefficients);
        constexpr int kSteps = 1000;
        double depth = 0;
        for (int i = 0; i < kSteps; ++i)
            depth += double(medium->At((float(i) / kSteps - 0.4995f) * Normalize(eye), SomeWavelengths())
                                .SigmaT()[0]) /
                     kSteps;
        for (const Phase& phase : kPhases)
            for (const std::string integrator : {"volpath", "simplevolpath"}) {
                const double expected = std::exp(-depth * ExtinctionOf(phase.name, Normalize(eye), kAxis));
                const std::string scene =
                    View(integrator, 0, eye) + kWhite + MediumText(type, phase, coefficients) + box;
                const std::string name = phase.name + integrator + type;
                EXPECT_TRUE(Passes(FullTestName() + name, kAlpha, [&](uint64_t seed) {
                    const RunningMean mean = CenterRadiance(BuildText(scene), 20000, seed);
                    EXPECT_LT(mean.StandardError(), 0.02 * expected) << name;
                    return ZTest(mean, expected, 1e-4, "transmittance");
                })) << name;
            }
    }
    EXPECT_GT(std::abs(ExtinctionOf("fibre", Normalize(kEyes[1]), kAxis) - 1), 0.1);
    EXPECT_GT(std::abs(ExtinctionOf("sggx", Normalize(kEyes[1]), kAxis) - 1), 0.1);
}

TEST(PhasesInMedia, OrientationsTurnWithTheMedium) {
    const Transform turn =
        Transform::Translate({5, 0, 1}) * Transform::Rotate(50, {1, 2, -1}) * Transform::Scale({3, 3, 3});
    for (const std::string name : {"sggx", "fibre"}) {
        const auto plain = MakeMedium("homogeneous", Find(name).parameters);
        const auto turned = MakeMedium("homogeneous", Find(name).parameters, turn);
        Rng rng(SeedOf(FullTestName()));
        for (int i = 0; i < 100; ++i) {
            const Vec3 w = RandomDirection(rng), there = Normalize(turn.Vector(w));
            EXPECT_NEAR(ExtinctionAlong(*plain, w), ExtinctionAlong(*turned, there), 1e-5f);
            EXPECT_NEAR(ExtinctionAlong(*plain, w), ExtinctionOf(name, w, kAxis), 1e-5);
            EXPECT_NEAR(plain->Along({{0, 0, 0}, w}, SomeWavelengths()).SigmaT()[0],
                        2 * ExtinctionAlong(*plain, w), 1e-5f);
        }
        EXPECT_GT(std::abs(ExtinctionAlong(*turned, kAxis) - ExtinctionAlong(*plain, kAxis)), 0.05f)
            << "control";
    }
}

const std::string kColouredScattering = "\"rgb sigma_a\" [0 0 0] \"rgb sigma_s\" [0.5 2 4] ";

// White surroundings, nothing absorbed. The balance heuristic divides the throughputs by their mean
// where all that happens is scattering: their mean is 1 without any noise, and a weight that forgets a
// density shows at once.
TEST(PhasesInMedia, AFurnaceIsOneWithoutNoise) {
    for (const Phase& phase : kPhases)
        for (const std::string& type : kTypes) {
            const std::string medium = MediumText(type, phase, Coefficients(type, RGB(0), {0.5f, 2, 4}));
            const RunningMean mean =
                CenterRadiance(BuildText(View("volpath", 4000, kEyes[1]) + kWhite + medium + kBall),
                               Scaled(4000), SeedOf(phase.name));
            EXPECT_NEAR(mean.Mean(), 1, 1e-4) << phase.name << ' ' << type;
            EXPECT_LT(mean.Variance(), 1e-6) << phase.name << ' ' << type;
        }
}

// Each wavelength by itself has noise, which the others take back: standard errors below 0.4 %.
TEST(PhasesInMedia, AFurnaceIsOneAtEachWavelength) {
    const auto empty = SpectralRadiance(View("volpath", 5, kEyes[1]) + kWhite, 4, 1);
    const int samples = Scaled(160000);
    for (const Phase& phase : kPhases) {
        const std::string scene = View("volpath", 4000, kEyes[1]) + kWhite +
                                  MediumText("homogeneous", phase, kColouredScattering) + kBall;
        EXPECT_TRUE(Passes(FullTestName() + phase.name, kAlpha, [&](uint64_t seed) {
            const auto all = SpectralRadiance(scene, samples, seed);
            std::vector<Outcome> outcomes;
            for (size_t l = 0; l < all.size(); ++l) {
                EXPECT_LT(all[l].StandardError(), 1.6 / std::sqrt(samples) * empty[l].Mean());
                outcomes.push_back(ZTest(all[l], empty[l].Mean(), 1e-5 * empty[l].Mean(), phase.name));
            }
            return WorstOf(outcomes);
        })) << phase.name;
    }
}

TEST(PhasesInMedia, ALossOfOneInFiftyIsFound) {
    const auto empty = SpectralRadiance(View("volpath", 5, kEyes[1]) + kWhite, 4, 1);
    const std::string lossy = "\"rgb sigma_a\" [0.02 0.02 0.02] \"rgb sigma_s\" [0.5 2 4] ";
    const auto all = SpectralRadiance(View("volpath", 4000, kEyes[1]) + kWhite +
                                          MediumText("homogeneous", Find("spectral table"), lossy) + kBall,
                                      40000, SeedOf(FullTestName()));
    for (size_t l = 0; l < all.size(); ++l) EXPECT_LT(ZTest(all[l], empty[l].Mean(), 0, "").pValue, kAlpha);
}

// A wall that is sampled as a light: the weights between light samples and scattering. The standard errors
// are below 0.2 %.
TEST(PhasesInMedia, AFurnaceWithASampledWallIsOne) {
    const std::string wall =
        "AttributeBegin Material \"diffuse\" \"rgb reflectance\" [0 0 0] AreaLightSource \"diffuse\" \"rgb "
        "L\" [1 1 1] ReverseOrientation Shape \"sphere\" \"float radius\" 9 AttributeEnd ";
    for (const std::string name : {"spectral table", "mixture"}) {
        const std::string scene = View("volpath", 4000, kEyes[1]) + wall +
                                  MediumText("homogeneous", Find(name), kColouredScattering) + kBall;
        EXPECT_TRUE(Passes(FullTestName() + name, kAlpha, [&](uint64_t seed) {
            return ZTest(CenterRadiance(BuildText(scene), Scaled(160000), seed), 1, 1e-4, name);
        })) << name;
    }
}

/// A thin wide box with a medium: 1 thick, 400 wide.
const std::string kWideBox =
    "MediumInterface \"m\" \"\" Material \"interface\" Shape \"trianglemesh\" \"point3 P\" [-200 -200 -0.5 "
    "200 "
    "-200 -0.5 -200 200 -0.5 200 200 -0.5 -200 -200 0.5 200 -200 0.5 -200 200 0.5 200 200 0.5] \"integer "
    "indices\" [0 2 1 1 2 3 4 5 6 5 7 6 0 1 4 1 5 4 2 6 3 3 6 7 0 4 2 2 4 6 1 3 5 3 7 5] ";
constexpr double kDepth = 1.5, kAlbedo = 0.9;  ///< optical thickness at extinction 1

std::string BoxScene(const Phase& phase, const std::string& light) {
    return View("volpath", 500, {1.5f, 1, 2}) + light +
           MediumText("homogeneous", phase,
                      Grey("sigma_a", kDepth * (1 - kAlbedo)) + Grey("sigma_s", kDepth * kAlbedo)) +
           kWideBox;
}
/// The same as a slab without boundaries, whose tangent is x.
std::string SlabScene(const Phase& phase, const std::string& light) {
    return View("volpath", 500, {1.5f, 1, 2}) + light +
           (phase.isMixture ? PartsOfMixture("MakeNamedMaterial", "slab") : "") +
           "MakeNamedMaterial \"s\" \"string type\" \"slab\" \"float eta\" 1 " + phase.parameters +
           Grey("sigma_t", kDepth) + Grey("albedo", kAlbedo) +
           "Material \"layered\" \"string stack\" [\"interface\" \"s\" \"interface\"] Shape \"trianglemesh\" "
           "\"point3 P\" [-2 -2 0 2 -2 0 -2 2 0 2 2 0] \"point2 uv\" [0 0 1 0 0 1 1 1] \"integer indices\" "
           "[0 "
           "1 2 1 3 2] ";
}
// On the camera's side, and on the other one.
const std::vector<std::pair<std::string, Vec3>> kLights = {{"reflected", {-1, 0.5f, 1.2f}},
                                                           {"transmitted", {0.4f, -1, -1.5f}}};

// Two ways without a common line but for the phase function: free flights in space, and the stack's walks by
// depth. Power: standard errors are 0.5 to 1.5 % of the values (7 % where fibres hardly reflect), so some 7 %
// are found; see the control.
TEST(PhasesInMedia, AWideBoxIsASlabOfTheSame) {
    for (const Phase& phase : kPhases)
        for (const auto& light : kLights)
            EXPECT_TRUE(Passes(FullTestName() + phase.name + light.first, kAlpha,
                               [&](uint64_t seed) {
                                   return Compare(BoxScene(phase, Distant(light.second)),
                                                  SlabScene(phase, Distant(light.second)), 40000, seed);
                               }))
                << phase.name << ' ' << light.first;
}

TEST(PhasesInMedia, ASlabOfOtherFlakesIsFound) {
    // Turned by 15 degrees, thicker by a half.
    const Phase turned{
        "fibre", "\"string phase\" \"fibre\" \"float stddev\" 0.2 \"vector3 orientation\" [0.77 0.15 0.62] "},
        loose{"fibre", "\"string phase\" \"fibre\" \"float stddev\" 0.3 " + kOrientation};
    for (const Phase& other : {turned, loose}) {
        double least = 1;
        for (const auto& light : kLights)
            least = std::min(least,
                             Compare(BoxScene(Find("fibre"), Distant(light.second)),
                                     SlabScene(other, Distant(light.second)), 40000, SeedOf(FullTestName()))
                                 .pValue);
        EXPECT_LT(least, kAlpha);
    }
}

/// Against three renders with the row of one wavelength each. 750 nm has the last row.
Outcome AgreesWithMonochromaticRenders(const std::function<std::string(const Phase&)>& scene,
                                       const Phase& spectral, int samples, uint64_t seed) {
    const char* const rows[] = {"30 8 1 0.2 0.1", "2 2 2 1 1", "0.1 0.1 0.5 4 6"};
    const auto all = SpectralRadiance(scene(spectral), samples, seed);
    std::vector<Outcome> outcomes;
    for (int row = 0; row < 3; ++row) {
        const Phase one{"row", fmt::format("\"string phase\" \"table\" \"float angles\" [0 5 60 120 180] "
                                           "\"float table\" [{}] ",
                                           rows[row])};
        const auto alone = SpectralRadiance(scene(one), samples / 2, Hash(seed, row));
        for (int l = row; l < (row == 2 ? 4 : row + 1); ++l) {
            const RunningMean &x = all[size_t(l)], &y = alone[size_t(l)];
            const double error = std::hypot(x.StandardError(), y.StandardError());
            outcomes.push_back(
                {NormalTwoSided((x.Mean() - y.Mean()) / error),
                 fmt::format("{} nm: {} and {} +- {}", 450 + 100 * l, x.Mean(), y.Mean(), error)});
        }
    }
    return WorstOf(outcomes);
}

/// In a ball, with scattering that depends on the wavelength as well, lit by a sphere that is sampled.
std::string BallScene(const std::string& type, const Phase& phase) {
    return View("volpath", 200, kEyes[1]) +
           "AttributeBegin Translate -3 1 3 AreaLightSource \"diffuse\" \"rgb L\" [20 20 20] Shape "
           "\"sphere\" AttributeEnd " +
           MediumText(type, phase, Coefficients(type, RGB(0.2f), {3, 2, 1})) + kBall;
}

// Power: errors are below 2 % of the values, which differ by more than a factor 1.5 between rows; a table
// that is 25 nm off is found.
TEST(SpectralTablesLong, AreThreeMonochromaticRenders) {
    const auto slab = [](const Phase& phase) { return SlabScene(phase, Distant(kLights[0].second)); };
    const auto box = [](const Phase& phase) { return BoxScene(phase, Distant(kLights[1].second)); };
    const Phase& spectral = Find("spectral table");
    for (const std::string& type : kTypes)
        EXPECT_TRUE(Passes(FullTestName() + type, kAlpha, [&](uint64_t seed) {
            return AgreesWithMonochromaticRenders([&](const Phase& phase) { return BallScene(type, phase); },
                                                  spectral, 80000, seed);
        })) << type;
    EXPECT_TRUE(Passes(FullTestName() + "/box", kAlpha, [&](uint64_t seed) {
        return AgreesWithMonochromaticRenders(box, spectral, 160000, seed);
    }));
    EXPECT_TRUE(Passes(FullTestName() + "/slab", kAlpha, [&](uint64_t seed) {
        return AgreesWithMonochromaticRenders(slab, spectral, 160000, seed);
    }));
}

TEST(SpectralTablesLong, ThatAre25NmOffAreFound) {
    Phase shifted = Find("spectral table");
    const std::string from = "[450 550 650]";
    shifted.parameters.replace(shifted.parameters.find(from), from.size(), "[475 575 675]");
    const auto find = [&](const std::function<std::string(const Phase&)>& scene, int samples) {
        const Outcome found = AgreesWithMonochromaticRenders(scene, shifted, samples, SeedOf(FullTestName()));
        EXPECT_LT(found.pValue, kAlpha) << found.details;
    };
    find([](const Phase& phase) { return SlabScene(phase, Distant(kLights[0].second)); }, 160000);
    for (const std::string& type : kTypes)
        find([&](const Phase& phase) { return BallScene(type, phase); }, 80000);
}

TEST(PhasesInMedia, BadParametersAreErrors) {
    const auto expect = [](const std::string& parameters, const std::string& says) {
        const std::string found = MediumErrorOf("homogeneous", parameters);
        EXPECT_NE(found.find(says), std::string::npos) << parameters << ": " << found;
    };
    expect("\"string phase\" \"sgx\"", "\"sggx\"");
    expect("\"float kappa\" 3", "\"vmf\"");
    expect("\"string phase\" \"vmf\" \"float g\" 0", "\"hg\"");
    expect("\"string phase\" \"sggx\" \"string orientationmap\" \"a.png\"", "no surface");
    expect("\"string phase\" \"sggx\" \"texture roughness\" \"t\"", "\"float roughness\"");
    expect("\"texture g\" \"t\"", "\"float g\"");
    expect("\"string phase\" \"mixture\"", "earlier media");
    expect("\"string phase\" \"mixture\" \"string phases\" [\"fog\"]", "no medium named \"fog\"");
    expect("\"string phase\" \"table\" \"float table\" [1 2 3] \"float wavelengths\" [400 500]", "3 values");
    expect("\"string phase\" \"table\" \"float table\" [1 2 3] \"float angles\" [0 180]", "expected 2");
    expect("\"string phase\" \"table\" \"float table\" [1 2] \"float angles\" [0 90]", "180");
    expect("\"string phase\" \"table\" \"float table\" [1 2 3] \"float angles\" [0 0 180]", "increasing");
    expect("\"string phase\" \"table\" \"float table\" [1 2] \"float wavelengths\" [-3]", "not positive");
    expect("\"string phase\" \"table\" \"float table\" [1 2 0 0] \"float wavelengths\" [400 500]", "500 nm");
    expect("\"string phase\" \"table\" \"float table\" [1 2] \"string tablefile\" \"t.txt\"", "remove one");
    // pbrt's own is forgiving.
    EXPECT_EQ(MediumErrorOf("homogeneous", "\"float g\" 3"), "");
}

}  // namespace
}  // namespace lacquer::test::phases_in_media_test
