// Materials that leave as files of the RGL database and come back by the material "measured".
#include "measure/tensor_table.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "measure/spectral_subject.h"
#include "pbrt/core/sampling.h"
#include "pbrt/scene/parser.h"
#include "support/bxdf_checks.h"

namespace lacquer::measure::tensor_table_test {
namespace {

using lacquer::test::SeedOf;

constexpr float kWavelengths[] = {450, 520, 590, 660};

SceneMaterial MaterialOf(const std::string& directives) {
    return LoadMaterial(ParseText("WorldBegin " + directives, "scene.pbrt", "", nullptr), "m");
}

/// A file that is there while this is.
class TensorFileOnDisk {
  public:
    explicit TensorFileOnDisk(const TensorTable& table)
        : path_((std::filesystem::temp_directory_path() /
                 ("lacquer-" + std::to_string(getpid()) + "-exported.bsdf"))
                    .string()) {
        std::ofstream(path_, std::ios::binary) << table.Bytes("made by a test");
    }
    ~TensorFileOnDisk() { std::filesystem::remove(path_); }
    SceneMaterial Read() const {
        return MaterialOf("MakeNamedMaterial \"m\" \"string type\" \"measured\" \"string filename\" \"" +
                          path_ + "\"");
    }

  private:
    std::string path_;
};

SceneMaterial RoundTrip(const SceneMaterial& original, int samples) {
    const TensorTable table = TabulateTensor(original, Point2(0.5f), {samples, 1}, nullptr);
    return TensorFileOnDisk(table).Read();
}

std::string CopperOf(const std::string& roughness) {
    return "MakeNamedMaterial \"m\" \"string type\" \"conductor\" \"bool remaproughness\" false " + roughness;
}
const std::string kCopper = CopperOf("\"float roughness\" 0.2");
const std::string kBrushed = CopperOf("\"float uroughness\" 0.15 \"float vroughness\" 0.4");
/// @param albedo  of the slab; 0: the stack has values in closed form, without noise
std::string VarnishOver(const std::string& roughness, const std::string& albedo = "0 0 0") {
    return "MakeNamedMaterial \"coat\" \"string type\" \"dielectric\" \"float roughness\" " + roughness +
           " \"bool remaproughness\" false MakeNamedMaterial \"slab\" \"string type\" \"slab\" \"float eta\" "
           "1.5 "
           "\"float thickness\" 1 \"rgb sigma_t\" [0.2 0.5 1] \"rgb albedo\" [" +
           albedo +
           "] "
           "MakeNamedMaterial \"base\" \"string type\" \"diffuse\" \"rgb reflectance\" [0.7 0.5 0.3] "
           "MakeNamedMaterial \"m\" \"string type\" \"layered\" \"string stack\" [\"coat\" \"slab\" "
           "\"base\"]";
}

/// |f - expected| cos over 30 pairs of directions as a part of their mean expected value, and the largest
/// part of a value that a pair differs by, which is that of pairs away from the horizon: both within 75
/// degrees. A third of the pairs leaves at 75 to 88 degrees; half of them are in the highlight.
struct Difference {
    double mean = 0, largest = 0;
};
Difference DifferenceOf(const SceneMaterial& expected, const SceneMaterial& found, int samples) {
    const std::span<const float> lambda(kWavelengths);
    const SpectralSubject a(*expected.setup.material, Point2(0.5f), lambda, {}),
        b(*found.setup.material, Point2(0.5f), lambda, {});
    Rng rng(SeedOf("TensorTable"));
    Observer observer;
    Difference d;
    double sum = 0;
    for (int i = 0; i < 30;) {
        Vec3 wo = SampleCosineHemisphere(rng.Uniform2D()), wi = SampleCosineHemisphere(rng.Uniform2D());
        const float theta = Radians(75 + 13 * rng.Uniform()), phi = 2 * Pi * rng.Uniform();
        if (i % 3 == 0) wo = SphericalDirection(std::sin(theta), std::cos(theta), phi);
        const auto s = expected.bsdf->At(i).Sample(wo, {rng.Uniform(), rng.Uniform2D()}, {.rng = &rng});
        if (i % 2 == 0) wi = s ? s->wi : Vec3(0, 0, -1);
        if (!(wo.z > 0.03f) || !(wi.z > 0.03f)) continue;
        ++i;
        double f[4], g[4], error[4];
        a.Evaluate(wo, wi, TransportMode::Radiance, samples, rng, f, error, observer);
        b.Evaluate(wo, wi, TransportMode::Radiance, 1, rng, g, error, observer);
        for (int k = 0; k < 4; ++k) {
            d.mean += std::abs(f[k] - g[k]) * double(wi.z);
            sum += f[k] * double(wi.z);
            if (std::min(wo.z, wi.z) > std::cos(Radians(75)))
                d.largest = std::max(d.largest, std::abs(g[k] / f[k] - 1));
        }
    }
    d.mean /= sum;
    return d;
}

/// Luminance of what a white environment gives at an angle.
double AlbedoOf(const SceneMaterial& m, float thetaDeg, int samples) {
    const Vec3 wo = SphericalDirection(std::sin(Radians(thetaDeg)), std::cos(Radians(thetaDeg)), 0.4f);
    Rng rng(SeedOf("TensorTable/albedo"));
    double sum = 0;
    for (int64_t i = 0; i < samples; ++i) {
        const auto s = m.bsdf->At(i).Sample(wo, {rng.Uniform(), rng.Uniform2D()}, {.rng = &rng});
        if (s && s->wi.z > 0) sum += Luminance(glm::dvec3(m.bsdf->ToRGB(s->weight, i))) / samples;
    }
    return sum;
}
/// The largest difference of albedos, as a part. Weights spread by less than 1: of 100,000 draws, four
/// standard errors of both are 0.4 %.
double AlbedoDifferenceOf(const SceneMaterial& expected, const SceneMaterial& found) {
    double largest = 0;
    for (const float deg : {0.f, 30.f, 60.f, 80.f}) {
        const double a = AlbedoOf(expected, deg, 100000), b = AlbedoOf(found, deg, 100000);
        largest = std::max(largest, std::abs(b / a - 1));
    }
    return largest;
}

// What is left is interpolation, most of it toward the horizon.
TEST(TensorTable, RoughMetalComesBack) {
    const SceneMaterial m = MaterialOf(kCopper), back = RoundTrip(m, 1);
    const Difference d = DifferenceOf(m, back, 1);
    EXPECT_LT(d.mean, 0.005);
    EXPECT_LT(d.largest, 0.02);
    EXPECT_LT(AlbedoDifferenceOf(m, back), 0.01);
}

// Azimuths of wo are 15 degrees apart, and the flanks of the highlight fall by half within a few.
TEST(TensorTable, BrushedMetalComesBack) {
    const SceneMaterial m = MaterialOf(kBrushed), back = RoundTrip(m, 1);
    const Difference d = DifferenceOf(m, back, 1);
    EXPECT_LT(d.mean, 0.03);
    EXPECT_LT(d.largest, 0.25);
    EXPECT_LT(AlbedoDifferenceOf(m, back), 0.01);
}

TEST(TensorTable, ClearVarnishComesBack) {
    const SceneMaterial m = MaterialOf(VarnishOver("0.1")), back = RoundTrip(m, 1);
    ASSERT_FALSE(m.bsdf->IsStochastic());
    const Difference d = DifferenceOf(m, back, 1);
    EXPECT_LT(d.mean, 0.01);
    EXPECT_LT(d.largest, 0.02);
    EXPECT_LT(AlbedoDifferenceOf(m, back), 0.01);
}

// With noise: of the table, whose values are means of sixteen evaluations, so that single ones are tens of
// per cent off and albedos one, and of 1,000 evaluations of each pair.
TEST(TensorTable, ScatteringVarnishComesBack) {
    const SceneMaterial m = MaterialOf(VarnishOver("0.1", "0.5 0.7 0.9")), back = RoundTrip(m, 16);
    ASSERT_TRUE(m.bsdf->IsStochastic());
    EXPECT_LT(DifferenceOf(m, back, 1000).mean, 0.05);
    EXPECT_LT(AlbedoDifferenceOf(m, back), 0.02);
}

// The same comparison finds a roughness of 0.22 for 0.2, and a groove that runs the other way.
TEST(TensorTableControl, AnotherMaterialIsFound) {
    const SceneMaterial m = MaterialOf(kCopper), back = RoundTrip(m, 1);
    const Difference d = DifferenceOf(MaterialOf(CopperOf("\"float roughness\" 0.22")), back, 1);
    EXPECT_GT(d.mean, 0.06);
    EXPECT_GT(d.largest, 0.1);
    EXPECT_GT(AlbedoDifferenceOf(MaterialOf(VarnishOver("0.1")), back), 0.5);
    const SceneMaterial brushed = MaterialOf(kBrushed);
    EXPECT_GT(DifferenceOf(MaterialOf(CopperOf("\"float uroughness\" 0.4 \"float vroughness\" 0.15")),
                           RoundTrip(brushed, 1), 1)
                  .mean,
              0.5);
}

// pbrt-v4 ends with an error after spectra below 0, and draws nothing from a table of zeros.
TEST(TensorTable, HoldsNothingNegative) {
    for (const std::string& text :
         {kBrushed, CopperOf("\"rgb reflectance\" [0 0 0] \"float roughness\" 0.3")}) {
        const TensorTable t = TabulateTensor(MaterialOf(text), Point2(0.5f), {1, 1}, nullptr);
        for (const auto* values : {&t.ndf, &t.sigma, &t.vndf, &t.spectra})
            EXPECT_GE(*std::min_element(values->begin(), values->end()), 0);
        EXPECT_GT(*std::min_element(t.luminance.begin(), t.luminance.end()), 0);
    }
}

TEST(TensorTable, FindsOutWhatIsAnisotropic) {
    for (const auto& [text, isAnisotropic] :
         {std::pair{kCopper, false},
          {kBrushed, true},
          {CopperOf("\"float uroughness\" 0.2 \"float vroughness\" 0.23"), true},
          {VarnishOver("0.1"), false}})
        EXPECT_EQ(IsAnisotropic(*MaterialOf(text).bsdf, 1), isAnisotropic) << text;
}

TEST(TensorTable, LightFromAboveMeetsTheseLobes) {
    EXPECT_FALSE(Any(LobesFromAbove(*MaterialOf(kCopper).bsdf, 1), Lobes::Specular | Lobes::Transmission));
    EXPECT_FALSE(
        Any(LobesFromAbove(*MaterialOf(VarnishOver("0.1")).bsdf, 1), Lobes::Specular | Lobes::Transmission));
    EXPECT_TRUE(IsSpecular(LobesFromAbove(*MaterialOf(VarnishOver("0")).bsdf, 1)));
}

}  // namespace
}  // namespace lacquer::measure::tensor_table_test
