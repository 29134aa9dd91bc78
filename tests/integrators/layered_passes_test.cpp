// The passes layered.surface, layered.single and layered.rest: against closed forms, and as parts of a whole.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "integrators/render_fixtures.h"
#include "pbrt/integrators/rendered_image.h"
#include "pbrt/scattering/fresnel.h"

namespace lacquer::layered_passes_test {
namespace {

using test::RunningMean;

constexpr int kSide = 16;
const std::vector<std::string> kParts = {"layered.surface", "layered.single", "layered.rest"};

std::unique_ptr<Image> RenderPasses(const std::string& text, const std::vector<std::string>& names) {
    const RenderSetup setup = test::BuildText(text);
    const auto passes = MakePasses(names, setup);
    RenderOptions options;
    options.passes = passes.get();
    test::RenderAll(setup, options);
    return setup.film->AppendPasses(*setup.film->Develop());
}

/// A plane of a material before an orthographic camera, its normal `viewDeg` from the direction of view.
std::string Plane(const std::string& light, double viewDeg, const std::string& material, int samples,
                  const std::string& integrator = "\"path\" \"integer maxdepth\" 1") {
    return fmt::format(
        R"(Camera "orthographic" Film "rgb" "integer xresolution" {0} "integer yresolution" {0}
           "string sensor" "cie1931" Sampler "independent" "integer pixelsamples" {1} PixelFilter "box"
           Integrator {2} WorldBegin {3} Translate 0 0 1000 Rotate {4} 1 0 0 {5} Shape "disk" "float radius" 900)",
        kSide, samples, integrator, light, 180 - viewDeg, material);
}
/// A light from infinity whose direction is `lightDeg` from the normal of that plane, on the other side.
std::string Distant(double viewDeg, double lightDeg) {
    const double angle = (viewDeg - lightDeg) * double(Pi) / 180;
    return fmt::format(R"(LightSource "distant" "point3 from" [0 {} {}] "point3 to" [0 0 0] )",
                       -std::sin(angle), -std::cos(angle));
}

RunningMean LuminanceOf(const Image& image, const std::string& layer) {
    RunningMean mean;
    const int first = image.FindChannel(layer + ".R");
    EXPECT_GE(first, 0) << layer;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x)
            mean.Add(double(ColorSpace::SRGB().Luminance(
                {image.Get({x, y}, first), image.Get({x, y}, first + 1), image.Get({x, y}, first + 2)})));
    return mean;
}

/// Mean over all directions of what a smooth boundary reflects: int 2 cos F d cos, by the midpoint rule.
double MeanReflectance(double eta) {
    constexpr int kSteps = 20000;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double cosine = (i + 0.5) / kSteps;
        sum += 2 * cosine * double(FresnelDielectric(float(cosine), float(eta)));
    }
    return sum / kSteps;
}

/// A smooth coat of index 1.5 over a Lambertian base: a geometric series.
struct CoatOverBase {
    double eta = 1.5, reflectance = 0.5;

    double Transmittance(double angleDeg) const {
        return 1 - double(FresnelDielectric(float(std::cos(angleDeg * double(Pi) / 180)), float(eta)));
    }
    double Inside() const { return MeanReflectance(1 / eta); }
    /// Quotient of the light that meets the base once more to that which does not.
    double Return() const { return reflectance * Inside(); }

    // Under light of radiance 1 from everywhere.
    double Surface(double viewDeg) const { return 1 - Transmittance(viewDeg); }
    double Single(double viewDeg) const {
        return reflectance * (1 - MeanReflectance(eta)) * Transmittance(viewDeg) / (eta * eta);
    }
    // Under light of irradiance cos(lightDeg) from one direction: T T rho / (pi eta^2) of it.
    double SingleOf(double viewDeg, double lightDeg) const {
        return Transmittance(viewDeg) * Transmittance(lightDeg) * reflectance / (double(Pi) * eta * eta) *
               std::cos(lightDeg * double(Pi) / 180);
    }
    double RestOver(double single) const { return single * Return() / (1 - Return()); }
};

std::string Coated(const std::string& estimator, double roughness = 0,
                   const std::string& reflectance = "\"rgb reflectance\" [.5 .5 .5]") {
    return fmt::format(
        R"(Material "coateddiffuse" "float thickness" 0 "integer maxdepth" 200 "float roughness" {} {} "string estimator" "{}" )",
        roughness, reflectance, estimator);
}

/// Grey values are exact but for the noise of what is drawn: 4.5 standard errors, and what the tables of
/// closed forms may be off by.
void ExpectMean(const RunningMean& mean, double expected, const std::string& what, double power = 0.02) {
    EXPECT_NEAR(mean.Mean(), expected, 4.5 * mean.StandardError() + 1e-3 * expected) << what;
    EXPECT_LT(4.5 * mean.StandardError(), power * expected) << what;
}

constexpr const char* kEstimators[] = {"auto",       "bidirectional", "forward",     "unidirectional",
                                       "halfvector", "pairproduct",   "multiproduct"};

/// By scattered rays: under a sky.
TEST(LayeredPasses, OfASmoothCoatUnderASkyAreTheSeries) {
    const CoatOverBase coat;
    for (const char* estimator : kEstimators)
        for (const double viewDeg : {0., 60., 80.}) {
            const auto image =
                RenderPasses(Plane("LightSource \"infinite\" ", viewDeg, Coated(estimator), 256), kParts);
            const std::string what = fmt::format("{} {}", estimator, viewDeg);
            const double single = coat.Single(viewDeg);
            ExpectMean(LuminanceOf(*image, "layered.surface"), coat.Surface(viewDeg), what + " surface", 0.1);
            ExpectMean(LuminanceOf(*image, "layered.single"), single, what + " single", 0.1);
            ExpectMean(LuminanceOf(*image, "layered.rest"), coat.RestOver(single), what + " rest", 0.1);
            // The control: with the light that meets the base twice, it would not be.
            const RunningMean is = LuminanceOf(*image, "layered.single");
            EXPECT_GT(std::abs(is.Mean() - single * (1 + coat.Return())),
                      4.5 * is.StandardError() + 1e-3 * single)
                << what;
        }
}

/// By light samples: under a light in one direction, which the mirror reflection does not meet.
TEST(LayeredPasses, OfASmoothCoatUnderALampAreTheSeries) {
    const CoatOverBase coat;
    for (const char* estimator : kEstimators)
        for (const auto& [viewDeg, lightDeg] : {std::pair(0., 50.), {60., 20.}, {20., 82.}, {80., 70.}}) {
            const auto image =
                RenderPasses(Plane(Distant(viewDeg, lightDeg), viewDeg, Coated(estimator), 256), kParts);
            const std::string what = fmt::format("{} {} {}", estimator, viewDeg, lightDeg);
            const double single = coat.SingleOf(viewDeg, lightDeg);
            EXPECT_EQ(LuminanceOf(*image, "layered.surface").Mean(), 0) << what;
            ExpectMean(LuminanceOf(*image, "layered.single"), single, what + " single", 0.05);
            ExpectMean(LuminanceOf(*image, "layered.rest"), coat.RestOver(single), what + " rest", 0.1);
        }
}

/// The reflectance falls from 0.9 at 360 nm to 0.1 at 830 nm: single and rest have other colours, which are
/// those of the same film for the series at each wavelength.
TEST(LayeredPasses, HaveTheColoursOfTheSeries) {
    const auto reflectanceAt = [](float lambda) { return 0.9 - 0.8 * (double(lambda) - 360) / 470; };
    const std::string reflectance = "\"spectrum reflectance\" [360 .9 830 .1]";
    const double viewDeg = 30, lightDeg = 55;
    const std::string text = Plane(Distant(viewDeg, lightDeg), viewDeg, Coated("auto", 0, reflectance), 1024);
    const auto image = RenderPasses(text, kParts);
    // The expected values, developed by a film of the same kind.
    const auto expected = [&](bool isRest) {
        const RenderSetup setup = test::BuildText(text);
        constexpr int kWavelengths = 4096;
        for (int i = 0; i < kWavelengths; ++i) {
            const SampledWavelengths lambda =
                setup.film->SampleWavelengths((float(i) + 0.5f) / float(kWavelengths));
            SampledSpectrum::Lanes L = ColorSpace::SRGB().Illuminant().Sample(lambda).Raw();
            for (int k = 0; k < kNumWavelengths; ++k) {
                const CoatOverBase coat{.reflectance = reflectanceAt(lambda[k])};
                static const double kInside = MeanReflectance(1 / 1.5);
                const double single = coat.SingleOf(viewDeg, lightDeg), again = coat.reflectance * kInside;
                L[k] *= float((isRest ? single * again / (1 - again) : single) / double(kCieYIntegral));
            }
            setup.film->AddSample({0, 0}, SampledSpectrum(L), lambda, 1);
        }
        return setup.film->Develop();
    };
    for (const auto& [layer, isRest] : {std::pair("layered.single", false), {"layered.rest", true}}) {
        const auto reference = expected(isRest);
        for (int c = 0; c < 3; ++c) {
            RunningMean mean;
            const int channel = image->FindChannel(std::string(layer) + ".R") + c;
            for (int y = 0; y < kSide; ++y)
                for (int x = 0; x < kSide; ++x) mean.Add(double(image->Get({x, y}, channel)));
            const double value = double(reference->Get({0, 0}, c));
            EXPECT_NEAR(mean.Mean(), value, 4.5 * mean.StandardError() + 2e-3 * value) << layer << c;
            EXPECT_LT(4.5 * mean.StandardError(), 0.05 * value) << layer << c;
        }
    }
}

/// A slab that scatters, of the index of what is around it, above black: single scattering in closed form,
/// albedo p (1 - exp(-tau (1/mu_o + 1/mu_i))) / (mu_o + mu_i) per irradiance mu_i, with p = 1 / (4 pi).
TEST(LayeredPasses, OfASlabAreSingleScattering) {
    const double tau = 0.7, albedo = 0.8, viewDeg = 40, lightDeg = 65;
    const double muO = std::cos(viewDeg * double(Pi) / 180), muI = std::cos(lightDeg * double(Pi) / 180);
    const double single =
        albedo / (4 * double(Pi)) * (1 - std::exp(-tau * (1 / muO + 1 / muI))) / (muO + muI) * muI;
    const std::string parts = fmt::format(
        R"(MakeNamedMaterial "m" "string type" "slab" "float eta" 1 "float thickness" 1
           "rgb sigma_t" [{0} {0} {0}] "rgb albedo" [{1} {1} {1}]
           MakeNamedMaterial "nothing" "string type" "interface"
           MakeNamedMaterial "black" "string type" "diffuse" "rgb reflectance" [0 0 0] )",
        tau, albedo);
    for (const char* estimator : {"auto", "bidirectional", "unidirectional", "forward"}) {
        const std::string stack = fmt::format(
            R"({} Material "layered" "string stack" ["nothing" "m" "black"] "string estimator" "{}" )", parts,
            estimator);
        const auto image = RenderPasses(Plane(Distant(viewDeg, lightDeg), viewDeg, stack, 256), kParts);
        EXPECT_EQ(LuminanceOf(*image, "layered.surface").Mean(), 0) << estimator;
        ExpectMean(LuminanceOf(*image, "layered.single"), single, estimator, 0.05);
        EXPECT_GT(LuminanceOf(*image, "layered.rest").Mean(), 0.1 * single) << estimator;
    }
}

/// Rough coats over rough metal, by estimators that share nothing but the definition: products and long paths
/// of "auto", which draws from lobes, against a walk.
TEST(LayeredPasses, OfRoughStacksAgreeBetweenEstimators) {
    const std::string sky =
        R"(LightSource "infinite" AttributeBegin AreaLightSource "diffuse" "rgb L" [20 20 20]
        Translate 0 300 200 Shape "sphere" "float radius" 80 AttributeEnd )";
    for (const char* distribution : {"trowbridgereitz", "beckmann"}) {
        const auto image = [&](const char* estimator) {
            const std::string material = fmt::format(
                R"(Material "coatedconductor" "float interface.roughness" .2 "float conductor.roughness" .3
                   "string distribution" "{}" "string estimator" "{}" )",
                distribution, estimator);
            return RenderPasses(Plane(sky, 50, material, 256), kParts);
        };
        const auto reference = image("bidirectional");
        for (const char* estimator : {"auto", "halfvector", "pairproduct"}) {
            const auto other = image(estimator);
            for (const std::string& part : kParts) {
                const RunningMean a = LuminanceOf(*reference, part), b = LuminanceOf(*other, part);
                const double error = std::hypot(a.StandardError(), b.StandardError());
                EXPECT_NEAR(a.Mean(), b.Mean(), 4.5 * error)
                    << distribution << ' ' << estimator << ' ' << part;
                EXPECT_LT(4.5 * error, 0.15 * a.Mean()) << distribution << ' ' << estimator << ' ' << part;
            }
        }
    }
}

// ---- Parts of a whole -------------------------------------------------------------------------------------

std::string Balls(const std::string& estimator, const std::string& integrator,
                  const std::string& media = "") {
    return fmt::format(
        R"({2} LookAt 0 1 -5  0 0 0  0 1 0 Camera "perspective" "float fov" 50
           Film "rgb" "integer xresolution" {0} "integer yresolution" {0} Sampler "zsobol" "integer pixelsamples" 8
           Integrator "{3}" "integer maxdepth" 6 WorldBegin
           LightSource "infinite" "rgb L" [.2 .3 .5]
           LightSource "point" "point3 from" [1 3 -2] "rgb I" [4 3 2]
           AttributeBegin AreaLightSource "diffuse" "rgb L" [3 3 3] Translate -1.5 1.5 0
           Material "coateddiffuse" "string estimator" "{1}" Shape "sphere" "float radius" .4 AttributeEnd
           MakeNamedMaterial "a" "string type" "coateddiffuse" "float roughness" .2 "string estimator" "{1}"
               "rgb reflectance" [.9 .5 .1]
           MakeNamedMaterial "b" "string type" "coatedconductor" "float interface.roughness" .1
               "float conductor.roughness" .2 "string estimator" "{1}"
           MakeNamedMaterial "s" "string type" "coateddiffuse" "float roughness" 0 "float thickness" .5
               "rgb albedo" [.8 .7 .5] "string estimator" "{1}"
           NamedMaterial "a" Shape "sphere" "float radius" .7
           AttributeBegin NamedMaterial "b" Translate 1.3 0 0 Shape "sphere" "float radius" .6 AttributeEnd
           AttributeBegin NamedMaterial "s" Translate -1.3 0 0 Shape "sphere" "float radius" .6 AttributeEnd
           Material "mix" "string materials" ["a" "b"] Translate 0 -.7 0 Rotate 90 1 0 0
           Shape "disk" "float radius" 6)",
        kSide, estimator, media, integrator);
}
const std::string kFog =
    R"(MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_a" [.05 .1 .2] "rgb sigma_s" [.2 .2 .1]
       "rgb Le" [.1 .2 .1] MediumInterface "" "fog")";

/// As PixelsOffTheSum() of passes_test.cpp; with parts that are negative, errors are relative to the sum of
/// the absolute values.
int PixelsOffTheSum(const Image& image) {
    int off = 0;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x)
            for (int c = 0; c < 3; ++c) {
                double sum = 0, size = 0;
                for (int k = 3 + c; k < image.NumChannels(); k += 3) {
                    sum += double(image.Get({x, y}, k));
                    for (int j = 3; j < image.NumChannels(); ++j)
                        size = std::max(size, std::abs(double(image.Get({x, y}, j))));
                }
                off += std::abs(sum - double(image.Get({x, y}, c))) > 3e-5 * size;
            }
    return off;
}

TEST(LayeredPasses, SumToTheLightOfStacks) {
    for (const char* estimator : kEstimators) {
        EXPECT_EQ(
            PixelsOffTheSum(*RenderPasses(Balls(estimator, "path"),
                                          {"emission", "layered.surface", "layered.single", "layered.rest"})),
            0)
            << estimator;
        EXPECT_EQ(PixelsOffTheSum(*RenderPasses(
                      Balls(estimator, "volpath", kFog),
                      {"emission", "volume", "layered.surface", "layered.single", "layered.rest"})),
                  0)
            << estimator;
    }
    // The control: without a part it is not the whole.
    for (size_t left = 0; left < kParts.size(); ++left) {
        std::vector<std::string> names = kParts;
        names[left] = "emission";
        EXPECT_GT(PixelsOffTheSum(*RenderPasses(Balls("auto", "path"), names)), 50) << kParts[left];
    }
}

/// What is no stack has no part.
TEST(LayeredPasses, OfOtherMaterialsAreBlack) {
    for (const char* material : {"Material \"diffuse\" ", "Material \"conductor\" \"float roughness\" .3 ",
                                 "Material \"dielectric\" "}) {
        const auto image = RenderPasses(Plane("LightSource \"infinite\" ", 20, material, 8), kParts);
        for (const std::string& part : kParts)
            EXPECT_EQ(LuminanceOf(*image, part).Mean(), 0) << material << part;
    }
}

/// Bits of colours and of other passes.
TEST(LayeredPasses, ChangeNothingElse) {
    for (const char* estimator : kEstimators)
        for (const std::string& text : {Balls(estimator, "path"), Balls(estimator, "volpath", kFog)}) {
            std::vector<std::string> more = kParts;
            more.insert(more.begin(), "diffuse");
            const auto with = RenderPasses(text, more), without = test::RenderText(text);
            const auto diffuse = RenderPasses(text, {"diffuse"});
            for (int y = 0; y < kSide; ++y)
                for (int x = 0; x < kSide; ++x)
                    for (int c = 0; c < 6; ++c) {
                        ASSERT_EQ(with->Get({x, y}, c), diffuse->Get({x, y}, c)) << estimator << c;
                        if (c < 3) {
                            ASSERT_EQ(with->Get({x, y}, c), without->Get({x, y}, c)) << estimator;
                        }
                    }
        }
}

TEST(LayeredPasses, AreRefusedWhereAnEstimatorKnowsNoVertices) {
    const RenderSetup setup = test::BuildText(Plane("LightSource \"infinite\" ", 20, Coated("belcour"), 1));
    try {
        MakePasses({"layered.single"}, setup);
        ADD_FAILURE() << "no error";
    } catch (const LightPathError& e) {
        EXPECT_NE(std::string(e.what()).find("estimators that do: auto, bidirectional"), std::string::npos)
            << e.what();
    }
    EXPECT_NO_THROW(MakePasses({"direct"}, setup));
}

}  // namespace
}  // namespace lacquer::layered_passes_test
