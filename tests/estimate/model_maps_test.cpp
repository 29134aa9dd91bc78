// What a seed makes: relief, noise, cells, slopes; statistics, periodicity, derivatives.
#include <gtest/gtest.h>

#include <set>

#include "estimate/gradient_check.h"
#include "estimate/models/material_model.h"
#include "estimate/models/relief.h"
#include "estimate/models/streams.h"

namespace lacquer::estimate::model_maps_test {
namespace {

double MeanSquare(std::span<const double> values) { return Dot(values, values) / double(values.size()); }

// ---- Relief ----

// The mean square over seeds is rms^2, whatever the extent and the resolution. Of 200 seeds the mean has a
// deviation of about 1 / sqrt(200 n) with n waves that matter; the limit is five of those measured.
TEST(SpectralRelief, RmsHeightIsTheParameterAtAnyExtentAndSize) {
    for (const auto& [size, extent] : {std::pair{64, 10.}, {128, 10.}, {128, 25.}}) {
        SpectralRelief relief(size, extent);
        std::vector<double> height(size_t(size) * size_t(size));
        double sum = 0, squares = 0, slopes = 0;
        constexpr int kSeeds = 200;
        for (uint64_t seed = 0; seed < kSeeds; ++seed) {
            relief.SetPhases(Hash(seed));
            relief.Forward(0.03, 1.1, 1.1, height);
            const double m = MeanSquare(height);
            sum += m / kSeeds;
            squares += m * m / kSeeds;
            Field gx, gy;
            SlopesOf({size, extent, true}, height, &gx, &gy);
            slopes += MeanSquare(gx) / kSeeds;
        }
        const double deviation = std::sqrt((squares - sum * sum) / kSeeds);
        EXPECT_NEAR(sum, 0.03 * 0.03, 5 * deviation) << size << " " << extent;
        EXPECT_LT(deviation, 0.02 * sum);
        // Slopes: sqrt(2) pi s rms, less what differences of neighbours miss: (pi f p)^2 / 3 at the
        // frequencies of the spectrum.
        const double p = extent / size, missed = std::pow(std::numbers::pi * 1.1 * p, 2) / 2;
        const double expected = std::pow(std::sqrt(2) * std::numbers::pi * 1.1 * 0.03, 2);
        EXPECT_NEAR(slopes, expected * (1 - missed), expected * (missed * missed + 0.03));
    }
}

TEST(SpectralRelief, LowFrequenciesDoNotDependOnTheResolution) {
    SpectralRelief coarse(64, 10), fine(128, 10);
    std::vector<double> a(64 * 64), b(128 * 128);
    coarse.SetPhases(9);
    fine.SetPhases(9);
    coarse.Forward(1, 0.5, 0.5, a);
    fine.Forward(1, 0.5, 0.5, b);
    // What the coarse one lacks has amplitudes below exp(-20). Both have their point (0, 0) at phase 0: point
    // i of the coarse one is 2 i of the fine one.
    for (size_t i = 0; i < 64; i += 7)
        for (size_t j = 0; j < 64; j += 5) EXPECT_NEAR(a[i * 64 + j], b[2 * i * 128 + 2 * j], 1e-8);
}

TEST(SpectralRelief, GradientIsThatOfDifferences) {
    SpectralRelief relief(16, 4);
    relief.SetPhases(3);
    const auto weights = RandomNumbers(256, 5, -1, 1);
    std::vector<double> height(256);
    const auto f = [&](std::span<const double> p) {
        relief.Forward(p[0], p[1], p[2], height);
        return Dot(height, weights);
    };
    const std::array<double, 3> at{0.3, 0.8, 0.4};
    for (size_t k = 0; k < 3; ++k) {
        const double difference = DifferenceAlong(
            [&](double t) {
                auto p = at;
                p[k] += t;
                return f(p);
            },
            1e-3 * at[k]);
        f(at);
        const auto adjoint = relief.Backward(weights);
        const double value[] = {adjoint.rms, adjoint.sx, adjoint.sy};
        EXPECT_NEAR(value[k], difference, 1e-8 * std::abs(difference)) << k;
    }
}

// So narrow a spectrum that no frequency is left is flat ground, not NaN.
TEST(SpectralRelief, NarrowestSpectrumIsFlat) {
    SpectralRelief relief(16, 0.01);
    relief.SetPhases(3);
    std::vector<double> height(256);
    relief.Forward(1, 0.01, 0.01, height);
    EXPECT_EQ(MeanSquare(height), 0);
    EXPECT_EQ(relief.Backward(height).sx, 0);
}

// ---- Noise ----

TEST(NoiseMap, HasItsMeanAndDeviation) {
    for (const NoiseKind kind : {NoiseKind::Spectral, NoiseKind::BandLimited, NoiseKind::Ridged}) {
        NoiseMap map(kind, NoiseMap::kTexels);
        for (uint64_t seed = 0; seed < 3; ++seed) {
            map.SetSeed(Hash(seed));
            double sum = 0;
            for (const double v : map.Values()) {
                ASSERT_TRUE(v >= 0 && v <= 1);
                sum += v;
            }
            const double mean = sum / double(map.Values().size());
            // What is clamped moves both: 1 % of a normal distribution lies below 0, and of the ridged one a
            // longer tail.
            const double tail = kind == NoiseKind::Ridged ? 0.02 : 0.006;
            EXPECT_NEAR(mean, 0.37, tail);
            EXPECT_NEAR(std::sqrt(MeanSquare(map.Values()) - mean * mean), 0.16, 2 * tail);
        }
    }
}

// Power falls as k^-3.2: between bands of four and of eight times as many waves the ratio is 2^3.2.
TEST(NoiseMap, SpectrumFallsAsItsExponentSays) {
    NoiseMap map(NoiseKind::Spectral, NoiseMap::kTexels);
    Fft2 fft(NoiseMap::kTexels);
    ComplexGrid half = fft.MakeHalf();
    map.SetSeed(2);
    fft.Forward(map.Values(), &half);
    const auto power = [&](double k) {
        double sum = 0;
        int count = 0;
        for (int ky = -60; ky <= 60; ++ky)
            for (int kx = 1; kx <= 60; ++kx)
                if (std::abs(std::hypot(kx, ky) - k) < 0.5) {
                    const size_t i = half.Index(ky < 0 ? ky + NoiseMap::kTexels : ky, kx);
                    sum += half.re[i] * half.re[i] + half.im[i] * half.im[i];
                    ++count;
                }
        return sum / count;
    };
    // About 60 and 120 waves, each with a deviation of its mean: 15 % together; 4 sigma.
    EXPECT_NEAR(std::log(power(20) / power(40)), 3.2 * std::log(2), 0.6);
}

// A smaller part of the same noise has less of it: the low frequencies are missing.
TEST(NoiseMap, SmallerMapsVaryLess) {
    NoiseMap whole(NoiseKind::Spectral, 512), quarter(NoiseKind::Spectral, 128);
    whole.SetSeed(1);
    quarter.SetSeed(1);
    const auto sd = [](std::span<const double> v) {
        const double mean = Dot(v, std::vector<double>(v.size(), 1.)) / double(v.size());
        return std::sqrt(MeanSquare(v) - mean * mean);
    };
    // Variance outside of a wavelength: sum over k of k^-3.2 k falls as k^-1.2, so its root as 4^-0.6 at 4
    // times the lowest.
    EXPECT_NEAR(sd(quarter.Values()) / sd(whole.Values()), std::pow(4, -0.6), 0.06);
}

TEST(NoiseMap, InterpolationIsPeriodicAndHasItsDerivatives) {
    NoiseMap map(NoiseKind::Spectral, 64);
    map.SetSeed(4);
    Random random(6);
    for (int i = 0; i < 50; ++i) {
        const double u = 300 * random.Uniform() - 150, v = 300 * random.Uniform() - 150;
        const auto s = map.At(u, v);
        EXPECT_NEAR(s.value, map.At(u + 64, v - 128).value, 1e-11);
        const double step = 1e-3 * std::min(u - std::floor(u), std::ceil(u) - u);
        EXPECT_NEAR(s.byU, (map.At(u + step, v).value - map.At(u - step, v).value) / (2 * step), 1e-6);
        const double stepV = 1e-3 * std::min(v - std::floor(v), std::ceil(v) - v);
        EXPECT_NEAR(s.byV, (map.At(u, v + stepV).value - map.At(u, v - stepV).value) / (2 * stepV), 1e-6);
    }
    EXPECT_NEAR(map.At(5, 3).value, map.Values()[3 * 64 + 5], 1e-15);
}

// ---- Cells ----

/// Distances of a point to all sites, found by asking at the sites themselves: those of a fine grid of
/// queries.
TEST(Cells, NearestSitesAreThoseOfASearchOverAll) {
    for (const CellKind kind : {CellKind::Jittered, CellKind::PoissonDisc, CellKind::Stretched}) {
        Cells cells(kind, 7, 9);
        cells.SetSeed(5);
        const auto sites = cells.SitePositions();
        NearestSites nearest(cells);
        Random random(8);
        double x = 0, y = 0;
        for (int i = 0; i < 600; ++i) {
            // Steps to the side as well, within a bucket and into the next.
            const bool jumps = i % 4 == 0;
            x = jumps ? 7 * random.Uniform() : x > 6.7 ? x - 6.7 : x + 0.3;
            y = jumps ? 9 * random.Uniform() : y;
            std::vector<double> distances;
            for (const auto& site : sites)
                for (int dx = -1; dx <= 1; ++dx)
                    for (int dy = -1; dy <= 1; ++dy)
                        distances.push_back(std::hypot(site[0] + 7 * dx - x, site[1] + 9 * dy - y));
            std::sort(distances.begin(), distances.end());
            const auto near = nearest.At(x + 14, y - 27);
            EXPECT_NEAR(near.f1, distances[0], 1e-9);
            EXPECT_NEAR(near.f2, distances[1], 1e-9);
            const auto right = nearest.At(x + 14 + 1e-6, y - 27), up = nearest.At(x + 14, y - 27 + 1e-6);
            if (right.site != near.site || up.site != near.site) continue;
            EXPECT_NEAR(near.f1ByX, (right.f1 - near.f1) * 1e6, 1e-4);
            EXPECT_NEAR(near.f1ByY, (up.f1 - near.f1) * 1e6, 1e-4);
        }
    }
}

TEST(Cells, PoissonDiscKeepsItsDistanceAndDensity) {
    Cells cells(CellKind::PoissonDisc, 32, 32);
    cells.SetSeed(3);
    const auto sites = cells.SitePositions();
    double nearest = 1e9;
    for (size_t i = 0; i < sites.size(); ++i)
        for (size_t j = 0; j < i; ++j) {
            const double dx = std::abs(sites[i][0] - sites[j][0]), dy = std::abs(sites[i][1] - sites[j][1]);
            nearest = std::min(nearest, std::hypot(std::min(dx, 32 - dx), std::min(dy, 32 - dy)));
        }
    EXPECT_GE(nearest, 0.8 - 1e-5);
    EXPECT_GT(double(sites.size()), 0.93 * 32 * 32);
    EXPECT_LE(sites.size(), size_t(32 * 32));
}

// ---- Slopes ----

TEST(Slopes, OfAPlaneAreItsOwn) {
    const MapGrid grid{16, 8, false};
    std::vector<double> height;
    for (int row = 0; row < 16; ++row)
        for (int column = 0; column < 16; ++column)
            height.push_back(0.3 * grid.X(column) - 0.2 * grid.Y(row));
    Field gx, gy;
    SlopesOf(grid, height, &gx, &gy);
    for (size_t i = 0; i < gx.size(); ++i) {
        EXPECT_NEAR(gx[i], 0.3, 1e-13);
        EXPECT_NEAR(gy[i], -0.2, 1e-13);
    }
}

TEST(Slopes, AdjointIsAdjoint) {
    for (const bool isPeriodic : {false, true}) {
        const MapGrid grid{16, 8, isPeriodic};
        const auto height = RandomNumbers(256, 1, -1, 1), byX = RandomNumbers(256, 2, -1, 1);
        const auto byY = RandomNumbers(256, 3, -1, 1);
        Field gx, gy, byHeight(256, 0.);
        SlopesOf(grid, height, &gx, &gy);
        SlopesAdjoint(grid, byX, byY, byHeight);
        EXPECT_NEAR(Dot(gx, byX) + Dot(gy, byY), Dot(height, byHeight), 1e-11);
    }
}

// ---- Models ----

std::vector<double> MeansOf(const MaterialModel& model) {
    std::vector<double> p;
    for (const ModelParameter& parameter : model.Parameters())
        p.push_back(parameter.optional ? parameter.fixedValue : parameter.prior.mean);
    return p;
}

TEST(Models, TablesAreInOrder) {
    ASSERT_EQ(AllModels().size(), 6u);
    const size_t published[] = {8, 10, 10, 10, 13, 23};  // without the shifts, which are a seed's here
    for (size_t m = 0; m < 6; ++m) {
        const MaterialModel& model = *AllModels()[m];
        std::set<std::string_view> names;
        size_t free = 0;
        for (const ModelParameter& p : model.Parameters()) {
            EXPECT_TRUE(names.insert(p.name).second) << p.name;
            free += !p.optional;
            for (const Prior& prior : {p.prior, p.demoPrior}) {
                EXPECT_LT(prior.low, prior.high) << p.name;
                EXPECT_GT(prior.sd, 0) << p.name;
            }
            EXPECT_TRUE(p.prior.mean >= p.prior.low && p.prior.mean <= p.prior.high) << p.name;
        }
        EXPECT_EQ(free, published[m]) << model.Name();
        EXPECT_EQ(model.Find("light"), 0);
        EXPECT_EQ(model.Find("b"), 3);
        EXPECT_GE(model.Find("vig"), 0);
        EXPECT_EQ(FindModel(model.Name()), &model);
    }
    EXPECT_EQ(FindModel("lether"), nullptr);
}

// Maps that tile: steps over the border are like steps inside. The control: without periodicity they are not.
TEST(Models, PeriodicMapsTile) {
    for (const MaterialModel* model : AllModels()) {
        if (!model->CanTile()) continue;
        const auto p = MeansOf(*model);
        for (const bool isPeriodic : {true, false}) {
            const MapGrid grid{128, 20, isPeriodic};
            const Surface s = MakeSurface(*model, grid, {}, p, 4);
            const Field& field = s.height.empty() ? s.slopeX : s.height;
            double border = 0, inside = 0;
            for (size_t i = 0; i < 128; ++i) {
                border += std::pow(field[i * 128] - field[i * 128 + 127], 2);
                for (size_t j = 0; j < 127; ++j)
                    inside += std::pow(field[i * 128 + j + 1] - field[i * 128 + j], 2) / 127;
            }
            // 128 steps along a border, of which neighbours agree: a factor of three either way.
            const bool repeatsAnyway =
                model->Name() == "bump" || model->Name() == "metal" || model->Name() == "flakes";
            if (isPeriodic || model->Name() == "bump" || model->Name() == "metal") {
                EXPECT_LT(border, 3 * inside + 1e-30) << model->Name();
            }
            if (!isPeriodic && !repeatsAnyway) {
                EXPECT_GT(border, 3 * inside) << model->Name();
            }
        }
    }
}

TEST(Models, SeedsAndKindsMakeDifferentMaps) {
    const MapGrid grid{64, 20, false};
    for (const MaterialModel* model : AllModels()) {
        const auto p = MeansOf(*model);
        const auto mapOf = [&](uint64_t seed, const ModelKinds& kinds) {
            return MakeSurface(*model, grid, kinds, p, seed).slopeX;
        };
        const Field first = mapOf(1, {});
        EXPECT_EQ(first, mapOf(1, {})) << model->Name();
        EXPECT_NE(first, mapOf(2, {})) << model->Name();
        EXPECT_EQ(first != mapOf(1, {CellKind::PoissonDisc, NoiseKind::Spectral}), model->HasCells())
            << model->Name();
        EXPECT_EQ(first != mapOf(1, {CellKind::Stretched, NoiseKind::Spectral}), model->HasCells())
            << model->Name();
        EXPECT_EQ(first != mapOf(1, {CellKind::Jittered, NoiseKind::Ridged}), model->HasNoise())
            << model->Name();
        EXPECT_EQ(first != mapOf(1, {CellKind::Jittered, NoiseKind::BandLimited}), model->HasNoise())
            << model->Name();
    }
}

/// Differences of sum of w field over all fields, by each parameter, against the way back.
double WorstGap(const MaterialModel& model, double factor) {
    const MapGrid grid{16, 20, false};
    auto p = MeansOf(model);
    for (size_t i = 0; i < p.size(); ++i)  // away from the edges of clamps
        if (model.Parameters()[i].name == "rough") p[i] = 0.35;
    const auto run = model.MakeRun(grid, {}, p);
    run->SetSeed(12);
    Surface surface;
    run->Forward(p, &surface);
    const auto fields = [](Surface* s) {
        std::vector<double*> all;
        for (Field* f : {&s->slopeX, &s->slopeY, &s->roughness, &s->albedo[0], &s->albedo[1], &s->albedo[2]})
            for (double& v : *f) all.push_back(&v);
        for (double* v :
             {&s->roughnessX, &s->roughnessY, &s->topF0, &s->topRoughness, &s->flakeRoughness, &s->glowWeight,
              &s->glowF0, &s->glowRoughness, &s->flakeF0[0], &s->flakeF0[1], &s->flakeF0[2]})
            all.push_back(v);
        return all;
    };
    const size_t count = fields(&surface).size();
    const auto weights = RandomNumbers(count, 21, -1, 1);
    Surface adjoint = surface.ZeroAdjoint();
    const auto into = fields(&adjoint);
    for (size_t i = 0; i < count; ++i) *into[i] = weights[i];
    std::vector<double> gradient(p.size(), 0.);
    run->Backward(p, surface, &adjoint, gradient);
    double worst = 0, scale = 0;
    for (const double g : gradient) scale = std::max(scale, std::abs(g));
    for (size_t k = 0; k < p.size(); ++k) {
        const double size = std::max(std::abs(p[k]), 0.1 * model.Parameters()[k].prior.sd);
        // Rough parameters have a kink at each texel and each edge: steps that meet none of a thousand.
        const double step = (model.Parameters()[k].smooth ? 1e-4 : 1e-6) * size;
        const double difference = DifferenceAlong(
            [&](double t) {
                auto q = p;
                q[k] += t;
                Surface moved;
                run->Forward(q, &moved);
                const auto from = fields(&moved);
                double sum = 0;
                for (size_t i = 0; i < count; ++i) sum += weights[i] * *from[i];
                return sum;
            },
            step);
        worst = std::max(worst,
                         std::abs(factor * gradient[k] - difference) / (std::abs(difference) + 1e-3 * scale));
    }
    return worst;
}

// Steps of 1e-4 of smooth parameters leave 1e-9; those of 1e-6 have rounding of 1e-8. The control:
// derivatives that are wrong by one in ten thousand.
TEST(Models, GradientsAreThoseOfDifferences) {
    for (const MaterialModel* model : AllModels()) {
        EXPECT_LT(WorstGap(*model, 1), 1e-6) << model->Name();
        EXPECT_GT(WorstGap(*model, 1.0001), 5e-5) << model->Name();
    }
}

// Sentences list them: "red albedo, roughness and height of cells".
TEST(Models, LabelsOfParametersStandWellInLists) {
    for (const MaterialModel* model : AllModels()) {
        std::set<std::string_view> labels;
        for (const ModelParameter& p : model->Parameters()) {
            EXPECT_EQ(p.meaning.label.find_first_of(",;:/=^()"), std::string_view::npos) << p.meaning.label;
            EXPECT_FALSE(p.meaning.label.starts_with("the ") || p.meaning.label.starts_with("a "));
            EXPECT_TRUE(labels.insert(p.meaning.label).second) << model->Name() << ": " << p.meaning.label;
        }
    }
}

}  // namespace
}  // namespace lacquer::estimate::model_maps_test
