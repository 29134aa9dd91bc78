// A goniometer's file of the RGL kind as the data of an estimation: its values are those of the model that it
// was made from, direction by direction.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "bxdfs/measured_fixture.h"
#include "cmd/estimate/layered_problem.h"

namespace lacquer::cmd::measured_data_test {
namespace {

using test::FacetModel;

Vec3 DirectionOf(double theta, double phi) {
    const auto t = Radians(float(theta)), p = Radians(float(phi));
    return SphericalDirection(std::sin(t), std::cos(t), p);
}

/// The largest error of a row, relative to the model's value, where that is not in the far tail of its lobe.
double LargestError(const estimate::Measurement& data, const FacetModel& model) {
    double largest = 0, peak = 0;
    std::vector<double> expected;
    for (const estimate::DirectionAngles& d : data.directions) {
        expected.push_back(
            double(model.Brdf(DirectionOf(d.thetaO, d.phiO), DirectionOf(d.thetaI, d.phiI), 550)));
        peak = std::max(peak, expected.back());
    }
    for (Eigen::Index i = 0; i < data.NumRows(); ++i)
        if (expected[size_t(i)] > .02 * peak)
            largest = std::max(largest, std::abs(data.values(i, 1) / expected[size_t(i)] - 1));
    return largest;
}

TEST(MeasuredData, RglFileHasTheValuesOfItsModel) {
    const FacetModel model;
    const std::string path = test::WriteTestFile("facets.bsdf", TensorFileBytes(model.Fields()));
    const estimate::Measurement data = ReadMeasured(path, 1);
    std::filesystem::remove(path);
    EXPECT_TRUE(data.IsColor());
    EXPECT_EQ(data.values.cols(), 3);
    EXPECT_EQ(data.values.rows(), data.NumRows());
    EXPECT_GE(data.NumRows(), 30);
    EXPECT_GT(data.values.minCoeff(), 0);
    // Red is reflected less than blue by this model.
    EXPECT_LT(data.values.col(0).sum(), data.values.col(2).sum());
    // The file's tables are coarse, and the channels' green is not one wavelength.
    EXPECT_LT(LargestError(data, model), .08);
    // The controls: lobes half as wide again, and a tenth brighter or darker.
    EXPECT_GT(LargestError(data, {.alphaX = .45f, .alphaY = .45f}), .3);
    estimate::Measurement brighter = data;
    brighter.values *= 1.2;
    EXPECT_GT(LargestError(brighter, model), .1);
}

}  // namespace
}  // namespace lacquer::cmd::measured_data_test
