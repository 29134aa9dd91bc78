// From a sphere to a rendered slab: what this program computes renders as another program's numbers do.
#include <numbers>

#include "bulk/reference_case.h"
#include "bulk/table/bulk_computation.h"
#include "phases/phase_scenes.h"
#include "support/bulk_tables.h"

namespace lacquer::test::rendered_test {
namespace {

using namespace bulk;

constexpr double kNanometres = 600;  // of all tables here; sizes are in wavelengths

/// A sphere of the reference data, and the thickness of a slab of such spheres [mean free paths].
struct LoneSphere {
    const char* name;
    double opticalThickness;
};
// Mean cosines of 0.60, 0.84 and 0.79; the third absorbs 30 % at each event.
constexpr LoneSphere kSpheres[] = {
    {"sphere_titania_in_resin", 6}, {"sphere_water_700nm", 12}, {"sphere_300nm", 4}};

/// Of a slab of 1 mm, from the cross sections and p of MSTM.
BulkTable ByMstm(const LoneSphere& sphere) {
    const nlohmann::json numbers = ReferenceCase::Read(sphere.name).numbers.at("mstm");
    const nlohmann::json& cross = numbers.at("fixed_beta0");
    const nlohmann::json& mean = numbers.at("fixed_beta0_azimuth_mean");
    BulkTable table;
    table.mode = "independent";
    table.wavelengths = {kNanometres};
    table.angles = EqualAngles(181);
    const double extinction = cross.at("k2C_ext_theta");
    const double absorption = std::max(0., cross.at("k2C_abs_theta").get<double>());
    table.sigmaS = {sphere.opticalThickness * (1 - absorption / extinction)};
    table.sigmaA = {sphere.opticalThickness * absorption / extinction};
    table.g = {mean.at("g")};
    table.phase = {mean.at("p").get<std::vector<double>>()};
    const double norm = NormOfPhase(table.angles, table.phase[0]);
    for (double& p : table.phase[0]) p /= norm;
    return table;
}

/// The same by this program, from size and index alone: a cluster of one.
BulkTable ByClusterOfOne(const LoneSphere& sphere, double sizeFactor = 1) {
    const Sphere lone = ReferenceCase::Read(sphere.name).spheres.front();
    const double k = 2 * std::numbers::pi / (kNanometres / 1000);
    const double x = sizeFactor * lone.Radius(), radius = x / k, area = std::numbers::pi * radius * radius;
    BulkSettings settings;
    settings.ensemble.arrangement = Arrangement::List;
    settings.ensemble.particles = {{{0, 0, 0}, radius, 0}};
    const double efficiency =
        EfficienciesOf(MieOfSphere(x, lone.layers[0].index, MieDegree(x)), x).extinction;
    const double perCubicMicrometre = sphere.opticalThickness / 1000 / (area * efficiency);
    settings.ensemble.species = {
        {"sphere", RadiusDistribution::Constant(radius), perCubicMicrometre * 4. / 3 * area * radius}};
    settings.indices = {OpticalIndex(lone.layers[0].index)};
    settings.wavelengths = {kNanometres};
    settings.mode = AverageMode::Aggregate;
    BulkComputation computation(settings);
    computation.AddRealizations(1, nullptr);
    return computation.Table();
}

/// p of angles that are some degrees larger.
BulkTable Shifted(BulkTable table, size_t degrees) {
    std::vector<double>& p = table.phase[0];
    for (size_t i = 0; i < p.size(); ++i) p[i] = p[std::min(i + degrees, p.size() - 1)];
    const double norm = NormOfPhase(table.angles, p);
    for (double& value : p) value /= norm;
    return table;
}

enum class Kind { Medium, Stack };
enum class Side { Reflected, Transmitted };

/// How a slab is made, which side of it is lit, and whence it is seen [degrees off its normal].
struct LitSlab {
    Kind kind;
    Side side;
    double angleDeg;
};

/// A wide slab of 1 mm in white surroundings of which a black plane hides all above or all below. What the
/// camera sees at its middle is the slab's reflectance or transmittance for light from the camera.
std::string SlabInHalfSpace(const BulkTable& table, const LitSlab& slab) {
    const std::string bulk = "\"string bulk\" \"" + WriteFile("slab.json", table) + "\" ";
    const auto plane = [](double z) {
        return fmt::format(
            "Shape \"trianglemesh\" \"point3 P\" [-9999 -9000 {0} 9999 -9000 {0} -9999 9999 {0} 9999 9999 "
            "{0}] \"integer indices\" [0 1 2 1 3 2] ",
            z);
    };
    const double x = 2 * std::tan(slab.angleDeg * std::numbers::pi / 180);
    const std::string start = View("volpath", 2000, {float(x), 0, 2}) + kWhite +
                              "Material \"diffuse\" \"rgb reflectance\" [0 0 0] " +
                              plane(slab.side == Side::Reflected ? -4 : 4);
    if (slab.kind == Kind::Stack)
        return start +
               "MakeNamedMaterial \"s\" \"string type\" \"slab\" \"float eta\" 1 \"float thickness\" 1 " +
               bulk + "Material \"layered\" \"string stack\" [\"interface\" \"s\" \"interface\"] " + plane(0);
    return start + "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" " + bulk +
           "Material \"interface\" MediumInterface \"m\" \"\" " + plane(0) + "ReverseOrientation " +
           plane(-1);
}

/// How much more the second of two slabs reflects or transmits, over what the first does, with its standard
/// error. The same random numbers for both: paths differ only where the tables do.
struct Difference {
    double relative = 0, error = 0, mean = 0;
};
std::vector<double> ValuesOf(const BulkTable& table, const LitSlab& slab, int samples) {
    const RenderSetup setup = BuildText(SlabInHalfSpace(table, slab));
    const uint64_t seed = SeedOf(FullTestName());
    std::vector<double> values;
    for (int i = 0; i < samples; ++i) values.push_back(CenterRadiance(setup, 1, Hash(seed, i)).Mean());
    return values;
}
Difference DifferenceOf(const std::vector<double>& first, const std::vector<double>& second) {
    RunningMean means, differences;
    for (size_t i = 0; i < first.size(); ++i) {
        means.Add(first[i]);
        differences.Add(second[i] - first[i]);
    }
    return {differences.Mean() / means.Mean(), differences.StandardError() / means.Mean(), means.Mean()};
}

constexpr LitSlab kSlabs[] = {{Kind::Medium, Side::Reflected, 60},
                              {Kind::Medium, Side::Transmitted, 30},
                              {Kind::Stack, Side::Reflected, 30},
                              {Kind::Stack, Side::Transmitted, 60}};
constexpr double kLimit = 0.003;
constexpr int kSamples = 20000;

// The limit holds for the difference and four of its standard errors, which are below 0.06 %.
TEST(RenderedBulkLong, SlabsOfLoneSpheresAreThoseOfAnotherProgramsNumbers) {
    const int samples = Scaled(kSamples);
    const double limit = kLimit * std::sqrt(double(kSamples) / samples);
    for (const LoneSphere& sphere : kSpheres) {
        const BulkTable theirs = ByMstm(sphere), ours = ByClusterOfOne(sphere);
        EXPECT_NEAR(ours.sigmaS[0] / theirs.sigmaS[0], 1, 1e-9) << sphere.name;
        for (const LitSlab& slab : kSlabs) {
            const Difference found =
                DifferenceOf(ValuesOf(theirs, slab, samples), ValuesOf(ours, slab, samples));
            EXPECT_LT(std::abs(found.relative) + 4 * found.error, limit)
                << sphere.name << ' ' << int(slab.kind) << ' ' << int(slab.side) << ": " << found.mean << ' '
                << found.relative << " +- " << found.error;
            EXPECT_GT(found.mean, 0.03) << sphere.name;
        }
    }
}

// The controls: the phase function of a wavelength that is a third longer, at the same optical thickness, and
// one whose angles are ten degrees too large. Their paths part with those of the right one, so that the
// standard errors are some 0.5 %: a difference of 2.5 % is found, and there are 3 to 30 %.
TEST(RenderedBulk, SlabsOfOtherPhaseFunctionsAreNot) {
    for (const LoneSphere& sphere : kSpheres) {
        const LitSlab slab{Kind::Stack, Side::Reflected, 30};
        const BulkTable theirs = ByMstm(sphere);
        const std::vector<double> right = ValuesOf(theirs, slab, kSamples);
        for (const BulkTable& wrong : {ByClusterOfOne(sphere, 0.75), Shifted(theirs, 10)}) {
            const Difference found = DifferenceOf(right, ValuesOf(wrong, slab, kSamples));
            EXPECT_GT(std::abs(found.relative) - 4 * found.error, kLimit) << sphere.name;
        }
    }
}

}  // namespace
}  // namespace lacquer::test::rendered_test
