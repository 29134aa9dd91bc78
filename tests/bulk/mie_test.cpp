#include "bulk/mie/mie.h"

#include <gtest/gtest.h>

#include <numbers>

#include "bulk/reference_case.h"

namespace lacquer::test::mie_test {
namespace {

using namespace bulk;
using std::numbers::pi;

struct KnownSphere {
    double x;
    Complex m;
    double extinction, scattering, g, backscattering;
};

TEST(Mie, EfficienciesAreThePublishedOnes) {
    const KnownSphere known[] = {
        {pi, {1.5, 0.1}, 3.112749197593, 2.183391563569, 0.788439689836, 0.170379576739},
        {2 * pi, {1.5, 0.1}, 2.583726907378, 1.356670730307, 0.826687321310, 0.170730851584},
        {3 * pi, {1.5, 0.1}, 2.428892833381, 1.197878726979, 0.911698225085, 0.115758843801},
        {2 * pi * 0.525 / 0.6328, 1.55, 3.105425531466, 3.105425531466, 0.633136758041, 2.925340649659},
    };
    for (const KnownSphere& row : known) {
        const MieEfficiencies q = EfficienciesOf(MieOfSphere(row.x, row.m, MieDegree(row.x)), row.x);
        EXPECT_NEAR(q.extinction, row.extinction, 1e-11) << row.x;
        EXPECT_NEAR(q.scattering, row.scattering, 1e-11) << row.x;
        EXPECT_NEAR(q.g, row.g, 1e-11) << row.x;
        // Of alternating terms: it converges last, and these numbers may have another degree.
        EXPECT_NEAR(q.backscattering, row.backscattering, 2e-9) << row.x;
    }
}

TEST(Mie, SingleSpheresAgreeWithAnotherProgram) {
    for (const char* name :
         {"sphere_300nm", "sphere_600nm", "sphere_900nm", "sphere_bh", "sphere_metal", "sphere_rayleigh",
          "sphere_titania_in_resin", "sphere_water_700nm", "sphere_x20"}) {
        const ReferenceCase row = ReferenceCase::Read(name);
        const auto& known = row.numbers.at("prototype").at("fixed_beta0");
        const double x = row.spheres[0].Radius();
        const MieCoefficients mie = MieOfSphere(x, row.spheres[0].layers[0].index, known.at("sphere_degree"));
        const MieEfficiencies q = EfficienciesOf(mie, x);
        const double area = pi * x * x, extinction = known.at("k2C_ext_theta");
        EXPECT_NEAR(q.extinction * area / extinction, 1, 1e-10) << name;
        EXPECT_NEAR(q.Absorption() * area, double(known.at("k2C_abs_theta")), 1e-10 * extinction) << name;
        const auto& p = row.numbers.at("prototype").at("fixed_beta0_azimuth_mean").at("p");
        for (size_t i = 0; i <= 180; ++i) {
            const double intensity = AmplitudesAt(mie, std::cos(double(i) * pi / 180)).Intensity();
            EXPECT_NEAR(intensity / (q.scattering * area) / double(p[i]), 1, 1e-8) << name << " " << i;
        }
    }
}

TEST(Mie, SmallSpheresScatterAsRayleighSays) {
    // Q_sca = 8/3 x^4 |(m^2 - 1)/(m^2 + 2)|^2, with an error of the order of x^2.
    for (const double x : {1e-4, 1e-3, 1e-2})
        for (const Complex m : {Complex(1.5, 0), Complex(0.3, 0), Complex(1.5, 0.4), Complex(0.2, 3)}) {
            const MieEfficiencies q = EfficienciesOf(MieOfSphere(x, m, 3), x);
            const Complex polarizability = (m * m - 1.) / (m * m + 2.);
            const double expected = 8. / 3 * std::pow(x, 4) * std::norm(polarizability);
            EXPECT_NEAR(q.scattering / expected, 1, 4 * x * x + 1e-12 / x) << x << m;
            const double absorption = 4 * x * polarizability.imag();
            EXPECT_NEAR(q.Absorption(), absorption, (20 * x * x + 1e-6) * q.extinction) << x << m;
        }
}

TEST(Mie, LayersOfOneIndexAreOneSphere) {
    for (const double x : {0.1, 1., pi, 2 * pi, 12., 40.})
        for (const Complex m : {Complex(1.5, 0), Complex(1.33, 0.01), Complex(0.8, 2), Complex(1, 0)}) {
            const SphereLayer layers[] = {{0.2 * x, m}, {0.7 * x, m}, {0.95 * x, m}, {x, m}};
            const int degree = MieDegree(x) + 3;
            const MieCoefficients one = MieOfSphere(x, m, degree), all = MieOfLayers(layers, degree);
            for (size_t n = 0; n < one.a.size(); ++n) {
                EXPECT_LT(std::abs(one.a[n] - all.a[n]), 1e-10) << x << m << n;
                EXPECT_LT(std::abs(one.b[n] - all.b[n]), 1e-10) << x << m << n;
            }
        }
}

TEST(Mie, AShellOfTheHostIsNotThere) {
    for (const auto& [inner, outer] :
         {std::pair<double, double>{2, 5}, {0.1, 3}, {30, 40}, {95, 100}, {0.01, 70}, {1e-4, 45}})
        for (const Complex m : {Complex(1.5, 0.02), Complex(0.2, 3), Complex(2.75, 0)}) {
            const SphereLayer layers[] = {{inner, m}, {outer, 1}};
            const int degree = MieDegree(outer);
            const MieCoefficients core = MieOfSphere(inner, m, degree), both = MieOfLayers(layers, degree);
            for (size_t n = 0; n < core.a.size(); ++n) {
                EXPECT_LT(std::abs(core.a[n] - both.a[n]), 1e-12) << inner << " " << outer << m << n;
                EXPECT_LT(std::abs(core.b[n] - both.b[n]), 1e-12) << inner << " " << outer << m << n;
            }
        }
}

TEST(Mie, SmallCoatedSpheresHaveTheirStaticPolarizability) {
    // [Bohren and Huffman 1983, eq. 5.36], f the share of the core's volume.
    const double x = 1e-3, f = 0.4;
    for (const auto& [core, shell] :
         {std::pair<Complex, Complex>{{1.2, 0}, {2.1, 0}}, {{0.2, 3.4}, {1.5, 0}}, {{1.5, 0}, {0.2, 3.4}}}) {
        const SphereLayer layers[] = {{x * std::cbrt(f), core}, {x, shell}};
        const Complex e1 = core * core, e2 = shell * shell;
        const Complex polarizability = ((e2 - 1.) * (e1 + 2. * e2) + f * (e1 - e2) * (1. + 2. * e2)) /
                                       ((e2 + 2.) * (e1 + 2. * e2) + f * (2. * e2 - 2.) * (e1 - e2));
        // a_1 = -(2i/3) x^3 polarizability.
        const Complex a1 = MieOfLayers(layers, 3).a[0];
        const Complex expected = Complex(0, -2. / 3) * x * x * x * polarizability;
        EXPECT_LT(std::abs(a1 - expected), 2e-5 * std::abs(expected)) << core << shell;
    }
}

TEST(Mie, CoatedSpheresWithoutAbsorptionConserveEnergy) {
    for (const double x : {0.5, 3., 9.42477796, 30.}) {
        // Also where sin(m x) is zero at a boundary.
        const SphereLayer layers[] = {{0.5 * x, 1.4}, {2 * pi / 3 * (x / pi), 1.5}, {x, 2.2}};
        const MieEfficiencies q = EfficienciesOf(MieOfLayers(layers, MieDegree(2.2 * x)), x);
        EXPECT_NEAR(q.Absorption() / q.extinction, 0, 1e-9) << x;
    }
}

TEST(Mie, ForwardAmplitudeIsTheExtinction) {
    const double x = 7;
    const MieCoefficients mie = MieOfSphere(x, {1.4, 0.03}, MieDegree(x));
    EXPECT_NEAR(4 / (x * x) * AmplitudesAt(mie, 1).s1.real(), EfficienciesOf(mie, x).extinction, 1e-12);
}

TEST(Mie, DegreesHoldTheSeries) {
    EXPECT_EQ(MieDegree(2 * pi * 500 / 700), 13);
    for (const double x : {0.01, 0.5, 4.5, 8., 20., 300.}) {
        const auto q = [&](int degree) {
            return EfficienciesOf(MieOfSphere(x, {1.5, 0.001}, degree), x).extinction;
        };
        const int degree = MieDegree(x);
        EXPECT_NEAR(q(degree) / q(degree + 10), 1, 1e-7) << x;
        // Control: a third of it does not.
        if (x > 1) {
            EXPECT_GT(std::abs(q(degree / 3) / q(degree + 10) - 1), 1e-3) << x;
        }
    }
}

}  // namespace
}  // namespace lacquer::test::mie_test
