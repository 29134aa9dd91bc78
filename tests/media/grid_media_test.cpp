// Media on grids, and clouds: values, bounds, emission, messages.
#include <gtest/gtest.h>

#include "media/medium_fixtures.h"
#include "pbrt/core/noise.h"
#include "pbrt/media/temperature_emission.h"
#include "pbrt/media/voxel_grid.h"

namespace lacquer::test::grid_media_test {
namespace {

const std::string kNoScattering = " \"rgb sigma_s\" [0 0 0] ";

float SigmaAt(const Medium& medium, Point3 p) { return medium.At(p, SomeWavelengths()).SigmaT()[0]; }

/// The field of a grid by its definition: the sum over all voxels of value times tent.
double SumOfTents(const std::vector<float>& values, Int3 n, Point3 u) {
    double sum = 0;
    for (int k = 0; k < n.z; ++k)
        for (int j = 0; j < n.y; ++j)
            for (int i = 0; i < n.x; ++i) {
                double weight = 1;
                const Int3 at(i, j, k);
                for (int axis = 0; axis < 3; ++axis)
                    weight *= std::max(0., 1 - std::abs(double(u[axis]) * n[axis] - 0.5 - at[axis]));
                sum += weight * double(values[size_t((k * n.y + j) * n.x + i)]);
            }
    return sum;
}

TEST(FloatGrid, IsTheSumOfTents) {
    Rng rng(SeedOf(FullTestName()));
    for (const Int3 n : {Int3(1, 1, 1), Int3(2, 3, 4), Int3(7, 1, 2)}) {
        std::vector<float> values(size_t(n.x) * size_t(n.y) * size_t(n.z));
        for (float& v : values) v = rng.Uniform();
        const FloatGrid grid(n, values);
        for (int i = 0; i < 500; ++i) {
            const Point3 u = RandomPoint(rng);
            ASSERT_NEAR(grid.Lookup(u), SumOfTents(values, n, u), 3e-6)
                << "some roundings of coordinates up to 7";
        }
        for (int i = 0; i < 8; ++i)
            EXPECT_NEAR(grid.Lookup(Bounds3({0, 0, 0}, {1, 1, 1}).Corner(i)),
                        SumOfTents(values, n, Bounds3({0, 0, 0}, {1, 1, 1}).Corner(i)), 3e-6);
    }
}

TEST(FloatGrid, MaximumOfABoxIsReachedAndNotExceeded) {
    Rng rng(SeedOf(FullTestName()));
    const Int3 n(5, 3, 2);
    std::vector<float> values(30);
    for (float& v : values) v = rng.Uniform();
    const FloatGrid grid(n, values);
    for (int i = 0; i < 100; ++i) {
        const Bounds3 box(RandomPoint(rng), RandomPoint(rng));
        const float maximum = grid.Maximum(box);
        float found = 0;
        for (int j = 0; j < 12 * 12 * 12; ++j)
            found = std::max(
                found, grid.Lookup(box.min + Vec3(float(j % 12), float(j / 12 % 12), float(j / 144)) / 11.f *
                                                 box.Diagonal()));
        ASSERT_LE(found, maximum * 1.00001f);
        // Steps of 1/11 of the box, whose edges are at most 5 voxels: the values change by less than 5/22 per
        // axis.
        ASSERT_GE(found, maximum - 0.45f);
    }
    EXPECT_FLOAT_EQ(grid.Maximum({Point3(0), Point3(1)}), grid.Maximum());
}

TEST(UniformGrid, HasItsValuesAtTheCentresInFileOrder) {
    const auto medium =
        MakeMedium("uniformgrid",
                   "\"integer nx\" 2 \"integer ny\" 3 \"integer nz\" 1 \"float density\" [1 2 3 4 5 6] "
                   "\"point3 p0\" [2 0 0] \"point3 p1\" [4 6 1]" +
                       kNoScattering);
    for (int i = 0; i < 6; ++i)
        EXPECT_FLOAT_EQ(SigmaAt(*medium, {2.5f + float(i % 2), 1 + 2 * float(i / 2), 0.5f}), float(i + 1));
    EXPECT_FLOAT_EQ(SigmaAt(*medium, {3, 2, 0.5f}), 2.5f) << "linear between centres";
    EXPECT_FLOAT_EQ(SigmaAt(*medium, {2, 1, 0.5f}), 0.5f) << "half at the faces";
    EXPECT_FLOAT_EQ(SigmaAt(*medium, {2, 0, 0}), 0.125f) << "an eighth at the corners";
    EXPECT_EQ(SigmaAt(*medium, {1.99f, 1, 0.5f}), 0) << "nothing outside";
    EXPECT_EQ(SigmaAt(*medium, {2.5f, 1, 1.01f}), 0);
    EXPECT_FALSE(medium->IsEmissive());
    EXPECT_FALSE(medium->IsHomogeneous());
    EXPECT_GE(medium->MemoryBytes(), 6 * sizeof(float));
}

TEST(UniformGrid, FollowsTheTransformAndKeepsSigmaPerWorldUnit) {
    Rng rng(SeedOf(FullTestName()));
    const std::string text =
        "\"integer nx\" 3 \"integer ny\" 2 \"integer nz\" 2 \"float density\" [1 2 3 4 5 6 6 5 4 3 2 1] "
        "\"point3 p0\" [1 2 -1] \"point3 p1\" [0 0 1] \"float scale\" 2 \"rgb sigma_a\" [.5 .5 .5]"
        "\"rgb sigma_s\" [3 3 3]";
    const auto plain = MakeMedium("uniformgrid", text);
    const Transform placed =
        Transform::Translate({1, 2, 3}) * Transform::Rotate(40, {1, 2, 1}) * Transform::Scale({2, 5, -0.1f});
    const auto moved = MakeMedium("uniformgrid", text, placed);
    for (int i = 0; i < 100; ++i) {
        const Point3 p = 1.2f * RandomPoint(rng) * Vec3(1, 2, 1);
        const MediumProperties a = plain->At(p, SomeWavelengths()),
                               b = moved->At(placed.Point(p), SomeWavelengths());
        EXPECT_NEAR(a.sigma_a[0], b.sigma_a[0], 1e-4);
        EXPECT_NEAR(a.sigma_s[0], b.sigma_s[0], 5e-4);
        EXPECT_NEAR(a.sigma_s[0], 6 * a.sigma_a[0], 1e-5);
    }
    EXPECT_FLOAT_EQ(plain->At({0.5f, 0.5f, -0.5f}, SomeWavelengths()).sigma_a[0], 2)
        << "p0 and p1 in any order";
}

TEST(UniformGrid, BoundsHold) {
    Rng rng(SeedOf(FullTestName()));
    for (const Int3 n : {Int3(1, 1, 1), Int3(3, 2, 5), Int3(20, 20, 20)})
        for (const float scale : {0.1f, 3.f, 200.f}) {
            const std::string text = "\"integer nx\" " + std::to_string(n.x) + " \"integer ny\" " +
                                     std::to_string(n.y) + " \"integer nz\" " + std::to_string(n.z) +
                                     " \"float density\" " + RandomList(n.x * n.y * n.z, rng) +
                                     " \"float scale\" " + std::to_string(scale) +
                                     " \"rgb sigma_s\" [3 1 0.1]";
            const auto medium = MakeMedium("uniformgrid", text, Transform::Rotate(30, {1, 1, 0}));
            const Bounds3 box = Transform::Rotate(30, {1, 1, 0}).Bounds({Point3(0), Point3(1)});
            EXPECT_TRUE(BoundsHold(*medium, box, rng));
        }
}

TEST(UniformGrid, BoundsAreTight) {
    // Negative control of the test above, and what makes tracking fast: 0.8 of the bounds do not hold.
    Rng rng(SeedOf(FullTestName()));
    const auto medium = MakeMedium("uniformgrid",
                                   "\"integer nx\" 4 \"integer ny\" 4 \"integer nz\" 4 \"float scale\" 100 "
                                   "\"float density\" " +
                                       RandomList(64, rng));
    EXPECT_FALSE(BoundsHold(*medium, {Point3(0), Point3(1)}, rng, 300, 40, 1e-5, 0.8));
    // Mean over the ray's points of sigma_t, and of the bound.
    const Ray ray{{-0.1f, 0.4f, 0.45f}, Normalize(Vec3(1, 0.1f, 0.05f))};
    double sigma = 0, bound = 0;
    MajorantWalk walk = medium->Majorants(ray, 2, SomeWavelengths());
    for (MajorantSegment s; walk.Next(&s);) bound += double((s.tMax - s.tMin) * s.sigmaMaj[0]);
    for (int i = 0; i < 1000; ++i) sigma += 2e-3 * double(SigmaAt(*medium, ray((float(i) + 0.5f) * 2e-3f)));
    EXPECT_LT(sigma, bound);
    EXPECT_GT(sigma, 0.7 * bound);
}

TEST(UniformGrid, EmitsATentWithoutLescale) {
    const auto medium = MakeMedium("uniformgrid", "\"float density\" 1 \"rgb Le\" [2 2 2] " + kNoScattering);
    ASSERT_TRUE(medium->IsEmissive());
    const SampledWavelengths lambda = SomeWavelengths();
    const float white = 2 * ColorSpace::SRGB().Illuminant().Sample(lambda)[0] / kCieYIntegral;
    EXPECT_NEAR(medium->At(Point3(0.5f), lambda).Le[0] / white, 1, 1e-5);
    EXPECT_NEAR(medium->At({0.5f, 0, 0.5f}, lambda).Le[0] / white, 0.5, 1e-5);
    EXPECT_NEAR(medium->At(Point3(1), lambda).Le[0] / white, 0.125, 1e-5);
}

TEST(UniformGrid, EmitsByALescaleGrid) {
    const auto medium = MakeMedium("uniformgrid",
                                   "\"integer nx\" 2 \"float density\" [1 1] \"float Lescale\" [0 3] "
                                   "\"rgb Le\" [1 1 1]");
    const SampledWavelengths lambda = SomeWavelengths();
    const float white = ColorSpace::SRGB().Illuminant().Sample(lambda)[0] / kCieYIntegral;
    EXPECT_EQ(medium->At({0.25f, 0.5f, 0.5f}, lambda).Le[0], 0);
    EXPECT_NEAR(medium->At({0.75f, 0.5f, 0.5f}, lambda).Le[0] / white, 3, 1e-5);
    EXPECT_NEAR(medium->At({0.5f, 0.5f, 0.5f}, lambda).Le[0] / white, 1.5, 1e-5);
    EXPECT_FALSE(MakeMedium("uniformgrid", "\"float density\" 1 \"float Lescale\" 0 \"rgb Le\" [1 1 1]")
                     ->IsEmissive());
    EXPECT_FALSE(MakeMedium("uniformgrid", "\"float density\" 1 \"rgb Le\" [0 0 0]")->IsEmissive());
}

TEST(UniformGrid, GlowsByTemperature) {
    const auto medium = MakeMedium("uniformgrid",
                                   "\"integer nx\" 3 \"float density\" [1 1 1] \"float Lescale\" [2 2 2] "
                                   "\"float temperature\" [600 1150 500] \"float temperatureoffset\" 500 "
                                   "\"float temperaturescale\" 4");
    ASSERT_TRUE(medium->IsEmissive());
    const SampledWavelengths lambda = SomeWavelengths();
    const auto expected = [&](float kelvin) { return 2 * BlackbodySpectrum(kelvin).Sample(lambda)[0]; };
    EXPECT_NEAR(medium->At({0.5f, 0.5f, 0.5f}, lambda).Le[0] / expected(2600), 1, 1e-4);
    EXPECT_NEAR(medium->At({1 / 6.f, 0.5f, 0.5f}, lambda).Le[0] / expected(400), 1, 1e-3);
    EXPECT_EQ(medium->At({5 / 6.f, 0.5f, 0.5f}, lambda).Le[0], 0) << "up to 100 K nothing";
    const auto old = MakeMedium(
        "uniformgrid", "\"float density\" 1 \"float temperature\" 1000 \"float temperaturecutoff\" 400");
    EXPECT_NEAR(old->At(Point3(0.5f), lambda).Le[0] / BlackbodySpectrum(600).Sample(lambda)[0], 1, 1e-4);
}

TEST(NormalizedBlackbody, IsThatOfTheSpectrum) {
    for (float kelvin = 101; kelvin < 1e6f; kelvin *= 1.3f)
        for (float u = 0.05f; u < 1; u += 0.1f) {
            const SampledWavelengths lambda = SampledWavelengths::SampleVisible(u);
            const SampledSpectrum found = NormalizedBlackbody(kelvin, lambda);
            const SampledSpectrum expected = BlackbodySpectrum(kelvin).Sample(lambda);
            for (int i = 0; i < kNumWavelengths; ++i)
                // Exponents of 80 have a relative error of 80 2^-24, and e^-87 is the smallest number that
                // there is.
                ASSERT_NEAR(found[i], expected[i], 1e-4f * expected[i] + 1e-28f)
                    << kelvin << " K, " << lambda[i] << " nm";
        }
    for (const float kelvin : {1e9f, 1e30f, Infinity})
        EXPECT_TRUE(NormalizedBlackbody(kelvin, SomeWavelengths()).IsValid());
}

TEST(RgbGrid, HasTheColoursAtTheCentresAndMixesSpectra) {
    const auto medium =
        MakeMedium("rgbgrid", "\"integer nx\" 2 \"rgb sigma_a\" [1 0.2 0.1  0.3 2 1] \"float scale\" 3");
    const SampledWavelengths lambda = SomeWavelengths();
    const auto a = ColorSpace::SRGB().MakeSpectrum({1, 0.2f, 0.1f}, SpectrumKind::Unbounded)->Sample(lambda);
    const auto b = ColorSpace::SRGB().MakeSpectrum({0.3f, 2, 1}, SpectrumKind::Unbounded)->Sample(lambda);
    for (int i = 0; i < kNumWavelengths; ++i) {
        EXPECT_NEAR(medium->At({0.25f, 0.5f, 0.5f}, lambda).sigma_a[i], 3 * a[i], 1e-4);
        EXPECT_NEAR(medium->At({0.75f, 0.5f, 0.5f}, lambda).sigma_a[i], 3 * b[i], 1e-4);
        EXPECT_NEAR(medium->At({0.4f, 0.5f, 0.5f}, lambda).sigma_a[i], 3 * (0.7f * a[i] + 0.3f * b[i]), 1e-4);
        EXPECT_EQ(medium->At({0.4f, 0.1f, 0.5f}, lambda).sigma_s[i], 3)
            << "what is not given is 1 in the whole box";
    }
    EXPECT_EQ(medium->At({1.1f, 0.5f, 0.5f}, lambda).sigma_s[0], 0);
    EXPECT_FALSE(medium->IsEmissive());
}

TEST(RgbGrid, EmitsWithoutAPhotometricFactor) {
    const auto medium =
        MakeMedium("rgbgrid", "\"rgb sigma_a\" [1 1 1] \"rgb Le\" [0.5 0.4 0.3] \"float Lescale\" 4");
    const SampledWavelengths lambda = SomeWavelengths();
    const auto Le =
        ColorSpace::SRGB().MakeSpectrum({0.5f, 0.4f, 0.3f}, SpectrumKind::Illuminant)->Sample(lambda);
    EXPECT_NEAR(medium->At(Point3(0.5f), lambda).Le[0] / Le[0], 4, 1e-4);
    EXPECT_TRUE(medium->IsEmissive());
}

TEST(RgbGrid, BoundsHold) {
    Rng rng(SeedOf(FullTestName()));
    for (const char* name : {"sigma_a", "sigma_s"}) {
        const std::string text =
            "\"integer nx\" 3 \"integer ny\" 2 \"integer nz\" 4 \"float scale\" 5 \"rgb " +
            std::string(name) + "\" " + RandomList(72, rng, 4);
        const auto medium = MakeMedium("rgbgrid", text);
        EXPECT_TRUE(BoundsHold(*medium, {Point3(0), Point3(1)}, rng));
        EXPECT_FALSE(BoundsHold(*medium, {Point3(0), Point3(1)}, rng, 300, 40, 1e-5, 0.6)) << "control";
    }
}

TEST(Noise, GradientIsThatOfDifferences) {
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 1000; ++i) {
        const Point3 p = 40.f * RandomPoint(rng) - 20.f;
        const Vec3 gradient = NoiseGradient(p);
        for (int axis = 0; axis < 3; ++axis) {
            Vec3 h(0);
            h[axis] = 1.f / 128;
            // Central differences of a function with third derivatives below some hundreds: h^2/6 of that;
            // rounding of 20 2^-24 over 2 h.
            ASSERT_NEAR(gradient[axis], (Noise(p + h) - Noise(p - h)) * 64, 0.01);
        }
    }
    EXPECT_EQ(NoiseGradient(Point3(1e9f)), Vec3(0));
}

TEST(Noise, HasTheBoundThatCloudsUse) {
    // With the best gradient at each corner, the two largest coordinates of what lies between corner and
    // point add up. Largest value over a lattice of step 1/100; the sum changes by less than 4 per unit along
    // each axis [its weights by 15/8 each of terms up to 2], so it is larger in between by 3 x 4 / 200 at
    // most - and by far less at its maximum, where it is flat.
    double most = 0;
    const auto fade = [](double t) { return t * t * t * (t * (t * 6 - 15) + 10); };
    for (int z = 0; z <= 50; ++z)  // the cube's halves are the same
        for (int y = 0; y <= 50; ++y)
            for (int x = 0; x <= 50; ++x) {
                double sum = 0;
                for (int corner = 0; corner < 8; ++corner) {
                    const double d[3] = {x / 100., y / 100., z / 100.};
                    double weight = 1, smallest = 2, all = 0;
                    for (int axis = 0; axis < 3; ++axis) {
                        const bool far = corner >> axis & 1;
                        const double distance = far ? 1 - d[axis] : d[axis];
                        weight *= far ? fade(d[axis]) : 1 - fade(d[axis]);
                        smallest = std::min(smallest, distance);
                        all += distance;
                    }
                    sum += weight * (all - smallest);
                }
                most = std::max(most, sum);
            }
    EXPECT_LT(most, 1.0365);
    EXPECT_GT(most, 1.03);
}

/// The density of a cloud by the formula, with differences for the gradient.
double CloudFormula(Point3 p, float density, float wispiness, float frequency) {
    Point3 q = frequency * p;
    float amplitude = 0.05f * wispiness, lambda = 10;
    for (int i = 0; i < 2; ++i) {
        const float h = 1.f / 256;
        Vec3 gradient;
        for (int axis = 0; axis < 3; ++axis) {
            Vec3 step(0);
            step[axis] = h;
            gradient[axis] = (Noise(lambda * q + step) - Noise(lambda * q - step)) / (2 * h);
        }
        q += amplitude * gradient;
        amplitude /= 2;
        lambda *= 1.99f;
    }
    double d = 0, weight = 0.5;
    float scale = 1;
    for (int i = 0; i < 5; ++i) {
        d += weight * double(Noise(scale * q));
        weight /= 2;
        scale *= 1.99f;
    }
    d = std::clamp((1 - double(p.y)) * 4.5 * double(density) * d, 0., 1.) +
        2 * std::max(0., 0.5 - double(p.y));
    return std::clamp(d, 0., 1.);
}

TEST(Cloud, HasTheDensityOfTheFormula) {
    Rng rng(SeedOf(FullTestName()));
    const auto medium = MakeMedium("cloud",
                                   "\"point3 p0\" [-1 -1 -1] \"point3 p1\" [1 2 1] \"float density\" 2 "
                                   "\"float wispiness\" 0.7 \"float frequency\" 3" +
                                       kNoScattering);
    int between = 0;
    for (int i = 0; i < 1000; ++i) {
        const Point3 p = Point3(-1) + RandomPoint(rng) * Vec3(2, 3, 2);
        const double expected = CloudFormula(p, 2, 0.7f, 3);
        // The differences are wrong by some 1e-3, which the swirls scale by 0.05, the slopes of the sum by
        // some 10.
        ASSERT_NEAR(double(SigmaAt(*medium, p)), expected, 5e-3);
        between += expected > 0.01 && expected < 0.99;
    }
    EXPECT_GT(between, 50) << "not only empty and full";
    EXPECT_EQ(SigmaAt(*medium, {0, -0.5f, 0}), 1);
    EXPECT_EQ(SigmaAt(*medium, {0, -1.5f, 0}), 0) << "outside of the box";
}

TEST(Cloud, StandsInMediumSpace) {
    const Transform placed =
        Transform::Translate({5, 1, 0}) * Transform::Rotate(90, {0, 0, 1}) * Transform::Scale(Vec3(2));
    const auto plain = MakeMedium("cloud", ""), moved = MakeMedium("cloud", "", placed);
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 100; ++i) {
        const Point3 p = RandomPoint(rng);
        EXPECT_NEAR(SigmaAt(*plain, p), SigmaAt(*moved, placed.Point(p)), 1e-3);
    }
}

TEST(Cloud, BoundsHold) {
    Rng rng(SeedOf(FullTestName()));
    for (const char* text : {"", "\"float density\" 0.2", "\"point3 p0\" [-1 0.4 -1] \"point3 p1\" [1 2 1]",
                             "\"float wispiness\" 4 \"float frequency\" 20 \"float density\" 3"}) {
        const auto medium = MakeMedium("cloud", text);
        EXPECT_TRUE(BoundsHold(*medium, {{-1, -1, -1}, {1, 2, 1}}, rng, 100, 40)) << text;
    }
    EXPECT_FALSE(BoundsHold(*MakeMedium("cloud", ""), {Point3(0), Point3(1)}, rng, 100, 40, 1e-5, 0.9))
        << "control";
}

TEST(GridMedia, SayWhatIsWrong) {
    const auto expect = [](const char* type, const char* text, const std::vector<const char*>& parts) {
        const std::string message = MediumErrorOf(type, text);
        EXPECT_FALSE(message.empty()) << type << " " << text;
        for (const char* part : parts)
            EXPECT_NE(message.find(part), std::string::npos) << message << " lacks " << part;
    };
    expect("uniformgrid", "", {"needs \"float density\""});
    expect("uniformgrid", "\"float density\" [1 2] \"integer nx\" 3", {"3 values", "3 x 1 x 1", "has 2"});
    expect("uniformgrid", "\"float density\" [1 -2] \"integer nx\" 2", {"density", "negative", "-2"});
    expect("uniformgrid", "\"float density\" 1 \"integer nx\" 0", {"nx", "0"});
    expect("uniformgrid", "\"float density\" 1 \"integer nx\" 2000000 \"integer ny\" 2000000", {"2^31"});
    expect("uniformgrid", "\"float density\" 1 \"point3 p1\" [1 0 1]", {"volume"});
    expect("uniformgrid", "\"float density\" 1 \"float temperature\" 500 \"rgb Le\" [1 1 1]",
           {"\"Le\"", "\"temperature\""});
    expect("uniformgrid", "\"float density\" [1 1] \"integer nx\" 2 \"float Lescale\" 2",
           {"Lescale", "has 1"});
    expect("uniformgrid", "\"float density\" [1 1] \"integer nx\" 2 \"float temperature\" 2",
           {"temperature", "has 1"});
    expect("uniformgrid", "\"float density\" 1 \"float scale\" -1", {"scale", "-1"});
    expect("rgbgrid", "", {"sigma_a", "sigma_s"});
    expect("rgbgrid", "\"rgb sigma_s\" [1 1 1] \"rgb Le\" [1 1 1]", {"Le", "needs \"sigma_a\""});
    expect("rgbgrid", "\"rgb sigma_s\" [1 1 1 1 1 1]", {"has 2"});
    expect("rgbgrid", "\"rgb sigma_s\" [1 -1 1]", {"(1 -1 1)"});
    expect("rgbgrid", "\"rgb sigma_s\" [1 1 1] \"float Lescale\" -2", {"Lescale", "-2"});
    expect("cloud", "\"float density\" -1", {"density", "-1"});
    expect("cloud", "\"point3 p0\" [1 1 1]", {"volume"});
}

}  // namespace
}  // namespace lacquer::test::grid_media_test
