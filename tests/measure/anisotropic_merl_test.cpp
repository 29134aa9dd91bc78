// Tables by half vector and difference with its azimuth: a reader of the test's own finds the material again.
#include "measure/anisotropic_merl.h"

#include <gtest/gtest.h>

#include <cstring>
#include <numbers>

#include "measure/scene_material.h"
#include "pbrt/core/sampling.h"
#include "pbrt/scene/parser.h"
#include "support/statistics.h"

namespace lacquer::measure::anisotropic_merl_test {
namespace {

constexpr double kHalfTurn = std::numbers::pi;

SceneMaterial MaterialOf(const std::string& rest) {
    return LoadMaterial(
        ParseText("WorldBegin MakeNamedMaterial \"m\" \"string type\" " + rest, "scene.pbrt", "", nullptr),
        "m");
}
const std::string kBrushed =
    "\"conductor\" \"float uroughness\" 0.2 \"float vroughness\" 0.5 \"bool remaproughness\" false";

/// Reads the bytes of a file as docs/guide.md describes them; linear between the middles of its cells.
class Reader {
  public:
    explicit Reader(const std::string& bytes) {
        EXPECT_EQ(bytes.substr(0, 8), "ANISMERL");
        std::memcpy(head_, bytes.data() + 8, sizeof(head_));
        EXPECT_EQ(head_[0], 1u);
        EXPECT_EQ(head_[5], 3u);
        values_.resize((bytes.size() - 32) / 4);
        std::memcpy(values_.data(), bytes.data() + 32, values_.size() * 4);
        EXPECT_EQ(values_.size(), size_t(3) * head_[1] * head_[2] * head_[3] * head_[4]);
    }

    /// Negative where cells around it lie below the surface.
    double At(int channel, glm::dvec3 wo, glm::dvec3 wi) const {
        const glm::dvec3 h = glm::normalize(wo + wi);
        const double thetaHalf = std::acos(std::min(1.0, h.z)), phiHalf = Turned(std::atan2(h.y, h.x), 2);
        // The frame of the half vector: z along it, y level.
        const glm::dvec3 y(-std::sin(phiHalf), std::cos(phiHalf), 0), x = glm::cross(y, h);
        const double thetaDifference = std::acos(std::clamp(glm::dot(wi, h), -1.0, 1.0));
        const double phi = Turned(std::atan2(glm::dot(wi, y), glm::dot(wi, x)), 1);
        const double place[4] = {std::sqrt(thetaHalf / (kHalfTurn / 2)) * head_[1],
                                 phiHalf / (2 * kHalfTurn) * head_[2],
                                 thetaDifference / (kHalfTurn / 2) * head_[3], phi / kHalfTurn * head_[4]};
        double sum = 0;
        for (int corner = 0; corner < 16; ++corner) {
            double weight = 1;
            size_t cell = size_t(channel);
            for (int d = 0; d < 4; ++d) {
                const double shifted = place[d] - 0.5;
                const int low = int(std::floor(shifted)), n = int(head_[d + 1]);
                const bool isUpper = corner >> d & 1;
                weight *= isUpper ? shifted - low : 1 - (shifted - low);
                const int i = low + int(isUpper);
                // Azimuths go round; polar angles end.
                cell = cell * size_t(n) + size_t(d % 2 == 1 ? (i + n) % n : std::clamp(i, 0, n - 1));
            }
            if (weight == 0) continue;
            if (values_[cell] < 0) return -1;
            sum += weight * double(values_[cell]);
        }
        return sum;
    }

  private:
    /// Modulo so many half turns: a difference and the one across it are the same pair exchanged.
    static double Turned(double phi, int halfTurns) {
        const double period = halfTurns * kHalfTurn;
        return phi - std::floor(phi / period) * period;
    }
    uint32_t head_[6];
    std::vector<float> values_;
};

/// Mean of |found - f| cos over mean of f cos, over pairs of directions, the first one at up to `maxDeg`.
/// @param turn  [radians] that the reader is asked for another azimuth
double MeanDifference(const SceneMaterial& m, const Reader& reader, double turn, int numPairs) {
    Rng rng(lacquer::test::SeedOf("AnisotropicMerl"));
    double sum = 0, difference = 0;
    const auto turned = [turn](Vec3 w) {
        const double c = std::cos(turn), s = std::sin(turn);
        return glm::dvec3(c * double(w.x) - s * double(w.y), s * double(w.x) + c * double(w.y), double(w.z));
    };
    int numMissing = 0;
    for (int i = 0; i < numPairs; ++i) {
        const float theta = i % 3 == 0 ? Radians(70 + 15 * rng.Uniform()) : Radians(70 * rng.Uniform());
        const Vec3 wo = SphericalDirection(std::sin(theta), std::cos(theta), 2 * Pi * rng.Uniform()),
                   wi = SampleCosineHemisphere(rng.Uniform2D());
        const glm::dvec3 f = m.bsdf->Evaluate(wo, wi, TransportMode::Radiance, 1, rng).Mean();
        for (int c = 0; c < 3; ++c) {
            const double found = reader.At(c, turned(wo), turned(wi));
            numMissing += int(found < 0);
            difference += found < 0 ? 0 : std::abs(found - f[c]) * double(wi.z);
            sum += found < 0 ? 0 : f[c] * double(wi.z);
        }
    }
    // Directions near the horizon share their cells with pairs below it.
    EXPECT_LT(numMissing, numPairs * 3 / 5);
    return difference / sum;
}

// Cells are 2 to 5 degrees wide where the highlight is; what lies between them is interpolated. Thirty pairs,
// a third of them leaving at 70 to 85 degrees, and thousands.
TEST(AnisotropicMerlTable, BrushedMetalComesBack) {
    const SceneMaterial m = MaterialOf(kBrushed);
    const Reader reader(TabulateAnisotropicMerl(*m.bsdf, {}, {}, nullptr).Bytes());
    EXPECT_LT(MeanDifference(m, reader, 0, 30), 0.02);
    EXPECT_LT(MeanDifference(m, reader, 0, 3000), 0.02);
    // The control: grooves turned by 6 degrees, and across.
    EXPECT_GT(MeanDifference(m, reader, 0.1, 3000), 0.08);
    EXPECT_GT(MeanDifference(m, reader, kHalfTurn / 2, 3000), 0.5);
}

TEST(AnisotropicMerlTable, LambertianIsTheSameWhereverItIsSeen) {
    const SceneMaterial m = MaterialOf("\"diffuse\" \"rgb reflectance\" [0.5 0.25 0.1]");
    const AnisotropicMerlTable t = TabulateAnisotropicMerl(
        *m.bsdf, {.half = 6, .halfAzimuth = 4, .difference = 5, .differenceAzimuth = 3}, {}, nullptr);
    ASSERT_EQ(t.values.size(), 3u * 360u);
    int numBelow = 0;
    for (size_t i = 0; i < t.values.size(); ++i) {
        const bool isBelow = t.values[i] == -1;
        numBelow += int(isBelow);
        if (isBelow) continue;
        EXPECT_NEAR(double(t.values[i]), (i < 360 ? 0.5 : i < 720 ? 0.25 : 0.1) / kHalfTurn, 2e-3) << i;
    }
    EXPECT_GT(numBelow, 100);
    EXPECT_LT(numBelow, 800);
}

}  // namespace
}  // namespace lacquer::measure::anisotropic_merl_test
