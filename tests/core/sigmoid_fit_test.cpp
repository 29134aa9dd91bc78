// The fit of spectra to colours, which otherwise only the build runs, and without sanitizers.
#include "pbrt/core/sigmoid_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

namespace lacquer::test::sigmoid_fit_test {
namespace {

/// Three overlapping bells as an observer, white light. The unit of wavelengths is ten times that of the
/// program's tables, so that the quadrature has a tenth of its nodes and the fit costs a tenth; the model
/// does not know the unit.
SigmoidTable CoarseTable() {
    std::vector<double> nm, illuminant;
    std::vector<FitVec3> observer;
    FitVec3 sum{};
    const auto bell = [](double x, double mean, double width) {
        return std::exp(-0.5 * (x - mean) * (x - mean) / (width * width));
    };
    for (double x = 36; x <= 83; x += 0.5) {
        nm.push_back(x);
        illuminant.push_back(1);
        observer.push_back({bell(x, 60, 6), bell(x, 55, 6), bell(x, 45, 5)});
        for (size_t c = 0; c < 3; ++c) sum[c] += observer.back()[c];
    }
    const double total = sum[0] + sum[1] + sum[2];
    const FitMat3 xyzFromRgb =
        XyzFromRgbMatrix({{{0.45, 0.35}, {0.33, 0.42}, {0.28, 0.28}}}, {sum[0] / total, sum[1] / total});
    return FitSigmoidTable({nm, observer, illuminant, xyzFromRgb},
                           static_cast<int>(std::thread::hardware_concurrency()));
}

// Of a grey the spectrum is known: constant, and of the grey's value. The fit ends within 0.1 of CIELAB,
// which at L = 1 is 2e-4 of reflectance and less than 2e-3 everywhere.
TEST(SigmoidFit, GreysHaveConstantSpectra) {
    const SigmoidTable table = CoarseTable();
    constexpr size_t kRes = kSigmoidTableRes;
    for (size_t l = 0; l < 3; ++l)
        for (size_t k = 1; k + 1 < kRes; ++k) {
            const float* c = &table.coefficients[(((l * kRes + k) * kRes + kRes - 1) * kRes + kRes - 1) * 3];
            for (const double x : {40., 55., 70.})
                EXPECT_NEAR(EvaluateSigmoid({double(c[0]), double(c[1]), double(c[2])}, x),
                            SigmoidTableZNode(static_cast<int>(k)), 4e-3)
                    << "l " << l << ", z " << table.zNodes[k];
        }
}

}  // namespace
}  // namespace lacquer::test::sigmoid_fit_test
