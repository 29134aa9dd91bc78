#include <gtest/gtest.h>

#include <functional>

#include "pbrt/base/filter.h"

namespace lacquer::filters_test {
namespace {

struct Setting {
    std::string name;
    std::vector<std::pair<std::string, float>> values;
};

std::unique_ptr<Filter> Make(const Setting& setting) {
    std::vector<Parameter> parameters;
    for (const auto& [name, value] : setting.values) {
        Parameter p;
        p.type = "float";
        p.name = name;
        p.floats = {value};
        parameters.push_back(p);
    }
    const Params params("pixel filter \"" + setting.name + "\"", {"scene.pbrt", 3, 1}, parameters, nullptr);
    std::unique_ptr<Filter> filter = Registry<FilterKind>::Find(setting.name)(params);
    params.CheckAllUsed();
    return filter;
}

const std::vector<Setting> kSettings = {
    {"box", {}},
    {"box", {{"xradius", 1.25f}, {"yradius", 3}}},
    {"gaussian", {}},
    {"gaussian", {{"xradius", 2.3f}, {"yradius", 0.9f}, {"sigma", 0.4f}}},
    {"gaussian", {{"sigma", 100}}},
    {"mitchell", {}},
    {"mitchell", {{"xradius", 3}, {"B", 0}, {"C", 0.5f}}},
    {"sinc", {}},
    {"sinc", {{"xradius", 3}, {"yradius", 2}, {"tau", 2}}},
    {"triangle", {}},
    {"triangle", {{"xradius", 0.7f}, {"yradius", 1.9f}}},
};

/// Midpoint rule with n^2 points over the support.
double Quadrature(const Filter& filter, const std::function<double(Point2)>& integrand) {
    const int n = 512;
    const Vec2 r = filter.Radius();
    double sum = 0;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const Point2 u{(float(i) + 0.5f) / n, (float(j) + 0.5f) / n};
            sum += integrand((2.f * u - Point2(1, 1)) * r);
        }
    return sum * 4 * double(r.x) * double(r.y) / (n * n);
}

double AbsoluteIntegral(const Filter& filter) {
    return Quadrature(filter, [&](Point2 p) { return std::abs(double(filter.Evaluate(p))); });
}

// The midpoint errors of the tables (cells of h = 1/16 pixel) and of the quadrature are below h^2/24 max|f''|
// plus what the kinks at zeros of |f| add, h^2 |f'| each: less than 2e-3 of the integral of |f| for the
// shapes above.
constexpr double kTableError = 2e-3;

TEST(Filters, AreEvenAndEndAtTheRadius) {
    for (const Setting& setting : kSettings) {
        const auto filter = Make(setting);
        const Vec2 r = filter->Radius();
        for (float x = 0.01f; x < 1; x += 0.07f)
            for (float y = 0.02f; y < 1; y += 0.07f) {
                const float f = filter->Evaluate({x * r.x, y * r.y});
                EXPECT_EQ(filter->Evaluate({-x * r.x, y * r.y}), f);
                EXPECT_EQ(filter->Evaluate({x * r.x, -y * r.y}), f);
                EXPECT_EQ(filter->Evaluate({-x * r.x, -y * r.y}), f);
                EXPECT_EQ(filter->Evaluate({(1.001f + x) * r.x, y * r.y}), 0);
                EXPECT_EQ(filter->Evaluate({x * r.x, (1.001f + y) * r.y}), 0);
            }
    }
}

TEST(Filters, IntegralIsThatOfTheFunction) {
    for (const Setting& setting : kSettings) {
        const auto filter = Make(setting);
        const double integral = Quadrature(*filter, [&](Point2 p) { return double(filter->Evaluate(p)); });
        EXPECT_NEAR(double(filter->Integral()), integral, kTableError * AbsoluteIntegral(*filter))
            << setting.name;
    }
}

TEST(Filters, WeightsHaveTheSignOfTheFunctionAndOneMagnitude) {
    for (const Setting& setting : kSettings) {
        const auto filter = Make(setting);
        const double magnitude = AbsoluteIntegral(*filter);
        const float peak = filter->Evaluate({0, 0});
        int negative = 0;
        for (float x = 0.0005f; x < 1; x += 0.0031f)
            for (float y = 0.0011f; y < 1; y += 0.0037f) {
                const FilterSample sample = filter->Sample({x, y});
                EXPECT_NEAR(std::abs(double(sample.weight)), magnitude, kTableError * magnitude)
                    << setting.name;
                EXPECT_LE(std::abs(sample.offset.x), filter->Radius().x);
                EXPECT_LE(std::abs(sample.offset.y), filter->Radius().y);
                // Within half a cell of a zero the table may have the other sign.
                const float value = filter->Evaluate(sample.offset);
                if (std::abs(value) > 0.03f * peak) {
                    EXPECT_EQ(value > 0, sample.weight > 0) << setting.name;
                }
                negative += sample.weight < 0;
            }
        EXPECT_EQ(negative > 0, setting.name == "mitchell" || setting.name == "sinc") << setting.name;
    }
}

TEST(Filters, WeightedSamplesIntegrateAgainstTheFunction) {
    const std::vector<std::function<double(Point2)>> integrands = {
        [](Point2 p) { return double(1 + p.x + 0.5f * p.y); }, [](Point2 p) { return double(p.x * p.x); },
        [](Point2 p) { return double(p.y * p.y + p.x * p.y); },
        [](Point2 p) { return double(std::cos(2 * p.x)); }};
    const int n = 1024;
    for (const Setting& setting : kSettings) {
        const auto filter = Make(setting);
        std::vector<double> sums(integrands.size()), largest(integrands.size());
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) {
                const FilterSample s = filter->Sample({(float(i) + 0.5f) / n, (float(j) + 0.5f) / n});
                for (size_t k = 0; k < integrands.size(); ++k) {
                    const double value = integrands[k](s.offset);
                    sums[k] += double(s.weight) * value;
                    largest[k] = std::max(largest[k], std::abs(value));
                }
            }
        // The midpoint rule in u misplaces each change of sign by up to half a step: eight of them in both
        // directions together, each counting twice.
        const bool changesSign = setting.name == "mitchell" || setting.name == "sinc";
        const double error = (kTableError + (changesSign ? 8.0 / n : 0)) * AbsoluteIntegral(*filter);
        for (size_t k = 0; k < integrands.size(); ++k) {
            const double exact =
                Quadrature(*filter, [&](Point2 p) { return double(filter->Evaluate(p)) * integrands[k](p); });
            EXPECT_NEAR(sums[k] / (n * n), exact, error * largest[k]) << setting.name << ' ' << k;
        }
    }
}

TEST(Filters, HaveTheirKnownValues) {
    const auto gaussian = Make({"gaussian", {}});
    const auto g = [](double t) { return std::exp(-t * t / 0.5) / (0.5 * std::sqrt(2 * 3.141592653589793)); };
    EXPECT_NEAR(double(gaussian->Evaluate({0.5f, 1})), (g(0.5) - g(1.5)) * (g(1) - g(1.5)), 1e-6);
    // Cubic with B = C = 1/3: 8/9 at 0, 1/18 at 1 of its own unit, which is half the radius.
    const auto mitchell = Make({"mitchell", {}});
    EXPECT_NEAR(mitchell->Evaluate({0, 0}), 64.f / 81, 1e-6f);
    EXPECT_NEAR(mitchell->Evaluate({1, 0}), 8.f / 162, 1e-6f);
    EXPECT_NEAR(mitchell->Integral(), 1, 1e-3f);
    const auto sinc = Make({"sinc", {}});
    EXPECT_EQ(sinc->Evaluate({0, 0}), 1);
    EXPECT_NEAR(sinc->Evaluate({1, 0}), 0, 1e-6f);
    EXPECT_NEAR(sinc->Evaluate({0.5f, 0}), (2 * InvPi) * (std::sin(Pi / 6) / (Pi / 6)), 1e-6f);
    EXPECT_NEAR(Make({"triangle", {}})->Evaluate({0.5f, -1}), 1.5f, 1e-6f);
}

TEST(Filters, HaveTheirDefaultRadii) {
    for (const auto& [name, radius] : std::vector<std::pair<std::string, float>>{
             {"box", 0.5f}, {"gaussian", 1.5f}, {"mitchell", 2.f}, {"sinc", 4.f}, {"triangle", 2.f}})
        EXPECT_EQ(Make({name, {}})->Radius(), Vec2(radius, radius)) << name;
}

TEST(Filters, NumbersNextToTheEndsLeadToWhereTheFunctionIs) {
    // Half of the cells and more are empty: at eight sigmas there is no float of it.
    const std::unique_ptr<Filter> filter = Make({"gaussian", {{"sigma", 0.05f}}});
    for (const float u : {0.f, 1e-7f, 0.5f, OneMinusEpsilon})
        for (const float v : {0.f, OneMinusEpsilon}) {
            const Point2 offset = filter->Sample({u, v}).offset;
            EXPECT_LT(std::max(std::abs(offset.x), std::abs(offset.y)), 0.4f) << u << " " << v;
        }
}

TEST(Filters, AbsurdParametersAreErrors) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const std::string name : {"box", "gaussian", "mitchell", "sinc", "triangle"})
        for (const float radius : {0.f, -1.f, 65.f, 2e9f, Infinity, nan}) {
            EXPECT_THROW(Make({name, {{"xradius", radius}}}), SceneError) << name << ' ' << radius;
            EXPECT_THROW(Make({name, {{"yradius", radius}}}), SceneError) << name << ' ' << radius;
        }
    for (const float value : {0.f, -1.f, 1e-5f, 1e9f, Infinity, nan})
        EXPECT_THROW(Make({"gaussian", {{"sigma", value}}}), SceneError) << value;
    for (const float value : {0.f, -3.f, 1e9f, nan})
        EXPECT_THROW(Make({"sinc", {{"tau", value}}}), SceneError);
    for (const float value : {1e9f, -1e9f, nan}) {
        EXPECT_THROW(Make({"mitchell", {{"B", value}}}), SceneError);
        EXPECT_THROW(Make({"mitchell", {{"C", value}}}), SceneError);
    }
}

TEST(Filters, ExtremeButLegalParametersStayFinite) {
    for (const std::string name : {"box", "gaussian", "mitchell", "sinc", "triangle"})
        for (const float radius : {1e-4f, 64.f}) {
            const auto filter = Make({name, {{"xradius", radius}, {"yradius", radius}}});
            for (const Point2 u :
                 {Point2(0, 0), Point2(0.3f, 0.8f), Point2(OneMinusEpsilon, OneMinusEpsilon)}) {
                const FilterSample sample = filter->Sample(u);
                EXPECT_TRUE(std::isnormal(sample.weight)) << name << ' ' << radius;
                EXPECT_LE(std::abs(sample.offset.x), radius) << name;
            }
        }
}

}  // namespace
}  // namespace lacquer::filters_test
