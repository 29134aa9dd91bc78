// Coordinates of products: the same distribution, seen so that its ridge is straight.
#include "estimate/infer/product_target.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "estimate/infer/hmc.h"
#include "estimate/random.h"

namespace lacquer::estimate::product_target_test {
namespace {

/// Light of 1 ... 2500 and albedos, one with bounds of its own, and a parameter that has no part in it.
ParameterSpace Space(double lowestGreen = .01) {
    Parameter light{"light", "cm^2", {1000, 400, 1, 2500}}, r{"r", "", {.4, .3, 0, 1}},
        g{"g", "", {.4, .3, lowestGreen, .95}};
    r.productWith = g.productWith = "light";
    return ParameterSpace({light, r, {"rough", "", {.2, .1, .01, .5}}, g});
}

/// Prior, and a product that is known to a hundredth.
class Ridge final : public Target {
  public:
    explicit Ridge(const ParameterSpace& space) : space_(space) {}
    Eigen::Index Size() const override { return 4; }
    double LogDensity(const Vector& y, Vector* gradient) const override {
        const Vector x = space_.ToNatural(y), slopes = space_.Slopes(y);
        const double u = (std::log(x[0] * x[1]) - std::log(500.)) / 0.01;
        const double value = space_.LogPriorOfLogit(y, gradient) - 0.5 * u * u;
        if (gradient) {
            (*gradient)[0] -= u / 0.01 / x[0] * slopes[0];
            (*gradient)[1] -= u / 0.01 / x[1] * slopes[1];
        }
        return value;
    }

  private:
    const ParameterSpace& space_;
};

TEST(ProductTarget, LogitsComeBack) {
    const ParameterSpace space = Space();
    const Ridge ridge(space);
    const ProductTarget target(space, ridge);
    Matrix y(4, 100);
    for (Eigen::Index k = 0; k < y.cols(); ++k) y.col(k) = 2 * Random(1, uint64_t(k)).Normals(4);
    EXPECT_LT((target.ToLogits(target.FromLogits(y)) - y).cwiseAbs().maxCoeff(), 1e-9);
}

// The density in the new coordinates is that of logits times the determinant of dy/dt, by differences.
TEST(ProductTarget, DensityHasItsJacobian) {
    const ParameterSpace space = Space();
    const Ridge ridge(space);
    const ProductTarget target(space, ridge);
    for (uint64_t k = 0; k < 20; ++k) {
        const Vector t = target.FromLogits(Random(2, k).Normals(4));
        Matrix jacobian(4, 4);
        for (Eigen::Index i = 0; i < 4; ++i) {
            Matrix ends(4, 2);
            ends.col(0) = ends.col(1) = t;
            ends(i, 0) -= 1e-5;
            ends(i, 1) += 1e-5;
            const Matrix y = target.ToLogits(ends);
            jacobian.col(i) = (y.col(1) - y.col(0)) / 2e-5;
        }
        const Vector y = target.ToLogits(t);
        const double expected = ridge.LogDensity(y, nullptr) + std::log(std::abs(jacobian.determinant()));
        EXPECT_NEAR(target.LogDensity(t, nullptr), expected, 1e-6 * std::max(1., std::abs(expected)));
        // The control: without the Jacobian.
        EXPECT_GT(std::abs(target.LogDensity(t, nullptr) - ridge.LogDensity(y, nullptr)), 1e-3);
    }
}

TEST(ProductTarget, GradientsAreDifferences) {
    const ParameterSpace space = Space();
    const Ridge ridge(space);
    const ProductTarget target(space, ridge);
    for (uint64_t k = 0; k < 20; ++k) {
        const Vector t = target.FromLogits(Random(3, k).Normals(4));
        Vector gradient;
        target.LogDensity(t, &gradient);
        for (Eigen::Index i = 0; i < 4; ++i) {
            Vector low = t, high = t;
            low[i] -= 1e-6;
            high[i] += 1e-6;
            const double difference =
                (target.LogDensity(high, nullptr) - target.LogDensity(low, nullptr)) / 2e-6;
            EXPECT_NEAR(gradient[i], difference, 1e-5 * std::max(1., std::abs(difference))) << k << ' ' << i;
        }
    }
}

/// The same ridge in the logarithm of the product and the logit of the light, whose other end is a wall: an
/// albedo of 1.
class WalledRidge final : public Target {
  public:
    explicit WalledRidge(const ParameterSpace& space) : space_(space), ridge_(space) {}
    Eigen::Index Size() const override { return 4; }
    double LogDensity(const Vector& t, Vector* gradient) const override {
        if (gradient) {
            gradient->resize(4);
            for (Eigen::Index i = 0; i < 4; ++i) {
                Vector low = t, high = t;
                low[i] -= 1e-6;
                high[i] += 1e-6;
                (*gradient)[i] = (LogDensity(high, nullptr) - LogDensity(low, nullptr)) / 2e-6;
            }
        }
        const double light = space_.ToNatural(t)[0], red = std::exp(t[1]) / light;
        if (!(red > 0 && red < 1)) return -std::numeric_limits<double>::infinity();
        Vector y = t;
        y[1] = std::log(red / (1 - red));
        return ridge_.LogDensity(y, nullptr) - std::log(1 - red);
    }

  private:
    const ParameterSpace& space_;
    Ridge ridge_;
};

TEST(ProductTarget, ChainsMeetNoBoundAlongARidge) {
    const ParameterSpace space = Space(0);
    const Ridge ridge(space);
    const ProductTarget target(space, ridge);
    const WalledRidge walled(space);
    const auto numDivergent = [](const Target& of, const Vector& start) {
        const Hmc hmc(7, 500, {});
        std::vector<ChainState> states;
        for (int i = 0; i < 4; ++i) states.push_back(hmc.Start(of, start));
        int count = 0;
        for (const std::vector<Draw>& chain : RunChains(hmc, of, 2500, &states))
            for (size_t i = 500; i < chain.size(); ++i) count += chain[i].isDivergent;
        return count;
    };
    const Vector x = Eigen::Vector4d(1000, .5, .2, .4), y = space.ToLogit(x);
    EXPECT_EQ(numDivergent(target, target.FromLogits(y)), 0);
    Vector start = y;
    start[1] = std::log(500.);
    EXPECT_GT(numDivergent(walled, start), 100);  // the control
}

// No bound is met on the way: far from the middle, points are still inside. Only albedos of .01 ... .95 and
// of 0 ... 1 whose products have no common light are nowhere.
TEST(ProductTarget, AllPointsAreInside) {
    const ParameterSpace space = Space();
    const Ridge ridge(space);
    const ProductTarget target(space, ridge);
    for (uint64_t k = 0; k < 200; ++k) {
        const Vector t = (3 * Random(4, k).Normals(4)).cwiseMax(-3).cwiseMin(6);
        EXPECT_TRUE(std::isfinite(target.LogDensity(t, nullptr))) << k;
        const Vector x = space.ToNatural(target.ToLogits(t));
        for (Eigen::Index i = 0; i < 4; ++i) {
            EXPECT_GT(x[i], space[size_t(i)].prior.low) << k;
            EXPECT_LT(x[i], space[size_t(i)].prior.high) << k;
        }
    }
    Vector none = target.FromLogits(Vector::Zero(4));
    none[1] = 3;    // a product of almost 2500, which only as much light can give
    none[3] = -12;  // one of .015, which only a light below 1.5 can give
    EXPECT_EQ(target.LogDensity(none, nullptr), -std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace lacquer::estimate::product_target_test
