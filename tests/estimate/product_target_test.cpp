// Coordinates of products: the same distribution, seen so that its ridge is straight.
#include "estimate/infer/product_target.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "estimate/random.h"

namespace lacquer::estimate {
namespace {

/// Light of 1 ... 2500 and albedos, one with bounds of its own, and a parameter that has no part in it.
ParameterSpace Space() {
    Parameter light{"light", "cm^2", {1000, 400, 1, 2500}}, r{"r", "", {.4, .3, 0, 1}},
        g{"g", "", {.4, .3, .01, .95}};
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
}  // namespace lacquer::estimate
