// Tables of bulk scattering from closed forms, and files of them.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "pbrt/scattering/bulk_table.h"

namespace lacquer::test {

/// p of Henyey and Greenstein at the angles, scaled so that its NormOfPhase() is 1.
inline std::vector<double> HgRow(const std::vector<double>& anglesDeg, double g) {
    std::vector<double> row;
    for (const double angle : anglesDeg) {
        const double c = std::cos(angle * M_PI / 180);
        row.push_back((1 - g * g) / (4 * M_PI * std::pow(1 + g * g - 2 * g * c, 1.5)));
    }
    const double norm = NormOfPhase(anglesDeg, row);
    for (double& p : row) p /= norm;
    return row;
}

/// The mean cosine of a p that is linear in the cosine between nodes: of trapezia by Simpson's rule, exact.
inline double MeanCosine(const std::vector<double>& anglesDeg, const std::vector<double>& row) {
    double sum = 0;
    for (size_t i = 0; i + 1 < row.size(); ++i) {
        const double a = std::cos(anglesDeg[i] * M_PI / 180), b = std::cos(anglesDeg[i + 1] * M_PI / 180);
        sum += (a - b) / 6 * (a * row[i] + (a + b) * (row[i] + row[i + 1]) + b * row[i + 1]);
    }
    return 2 * M_PI * sum;
}

/// n angles at equal steps, 0 to 180 degrees.
inline std::vector<double> EqualAngles(int n) {
    std::vector<double> angles;
    for (int i = 0; i < n; ++i) angles.push_back(180. * i / (n - 1));
    return angles;
}

/// A medium of Henyey and Greenstein's p with a mean cosine for each wavelength.
inline BulkTable HgTable(std::vector<double> wavelengths, const std::vector<double>& g,
                         std::vector<double> sigmaS, std::vector<double> sigmaA, int numAngles = 181) {
    BulkTable table;
    table.mode = "medium";
    table.wavelengths = std::move(wavelengths);
    table.angles = EqualAngles(numAngles);
    table.sigmaS = std::move(sigmaS);
    table.sigmaA = std::move(sigmaA);
    for (const double each : g) {
        table.phase.push_back(HgRow(table.angles, each));
        table.g.push_back(MeanCosine(table.angles, table.phase.back()));
    }
    return table;
}

/// Writes a file of this test; its path.
inline std::string WriteFile(const std::string& name, const std::string& text) {
    const testing::TestInfo& info = *testing::UnitTest::GetInstance()->current_test_info();
    const std::filesystem::path folder =
        std::filesystem::path(testing::TempDir()) / info.test_suite_name() / info.name();
    std::filesystem::create_directories(folder);
    std::ofstream(folder / name, std::ios::binary) << text;
    return (folder / name).string();
}
inline std::string WriteFile(const std::string& name, const BulkTable& table) {
    return WriteFile(name, WriteBulkTable(table));
}

}  // namespace lacquer::test
