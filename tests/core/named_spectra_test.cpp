#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "pbrt/core/color_space.h"
#include "pbrt/core/error.h"
#include "pbrt/core/spectrum.h"

namespace lacquer::test::named_spectra_test {
namespace {

float ValueOf(const char* name, float lambda) {
    const std::unique_ptr<Spectrum> spectrum = NamedSpectrum(name);
    EXPECT_NE(spectrum, nullptr) << name;
    return spectrum ? spectrum->Evaluate(lambda) : 0.f;
}

class SpectrumFile {
  public:
    explicit SpectrumFile(const std::string& text) {
        const auto* info = testing::UnitTest::GetInstance()->current_test_info();
        path_ = testing::TempDir() + "lacquer_spectrum_" + info->name() + ".spd";
        std::ofstream(path_, std::ios::binary) << text;
    }
    ~SpectrumFile() { std::filesystem::remove(path_); }
    SpectrumFile(const SpectrumFile&) = delete;
    SpectrumFile& operator=(const SpectrumFile&) = delete;
    const std::string& Path() const { return path_; }

  private:
    std::string path_;
};

void ExpectFileProblem(const std::string& text, int line, int column, const std::string& part) {
    const SpectrumFile file(text);
    try {
        ReadSpectrumFile(file.Path());
        FAIL() << "no error for " << text;
    } catch (const SceneError& e) {
        EXPECT_EQ(e.Loc().file, file.Path());
        EXPECT_EQ(e.Loc().line, line) << e.what();
        EXPECT_EQ(e.Loc().column, column) << e.what();
        EXPECT_NE(e.Message().find(part), std::string::npos) << e.what();
    }
}

TEST(NamedSpectra, AllNamesOfTheFormatAreThere) {
    std::vector<std::string> wanted = {"stdillum-A",   "stdillum-D50", "stdillum-D65", "illum-acesD60",
                                       "illum-cieD50", "cie-x",        "cie-y",        "cie-z"};
    for (int i = 1; i <= 12; ++i) wanted.push_back("stdillum-F" + std::to_string(i));
    for (const char* glass : {"BK7", "BAF10", "FK51A", "LASF9", "F5", "F10", "F11"})
        wanted.push_back(std::string("glass-") + glass);
    for (const char* metal : {"Ag", "Al", "Au", "Cu", "CuZn", "MgO", "TiO2"})
        for (const char* part : {"-eta", "-k"}) wanted.push_back(std::string("metal-") + metal + part);
    for (const char* camera :
         {"canon_eos_100d", "canon_eos_1dx_mkii", "canon_eos_200d", "canon_eos_200d_mkii", "canon_eos_5d",
          "canon_eos_5d_mkii", "canon_eos_5d_mkiii", "canon_eos_5d_mkiv", "canon_eos_5ds", "canon_eos_m",
          "hasselblad_l1d_20c", "nikon_d810", "nikon_d850", "sony_ilce_6400", "sony_ilce_7m3",
          "sony_ilce_7rm3", "sony_ilce_9"})
        for (const char* color : {"_r", "_g", "_b"}) wanted.push_back(std::string(camera) + color);
    std::vector<std::string> names = NamedSpectra();
    std::sort(wanted.begin(), wanted.end());
    std::sort(names.begin(), names.end());
    EXPECT_EQ(names, wanted);
    for (const std::string& name : names) EXPECT_NE(NamedSpectrum(name), nullptr) << name;
}

TEST(NamedSpectra, CamerasSeeTheirColors) {
    // Green is relative to its maximum, at 520 nm; the other pixels see their ends of the spectrum.
    for (const char* camera : {"nikon_d850", "canon_eos_m", "sony_ilce_7m3"}) {
        const std::string name = camera;
        EXPECT_FLOAT_EQ(ValueOf((name + "_g").c_str(), 520), 1);
        EXPECT_GT(ValueOf((name + "_r").c_str(), 600), 4 * ValueOf((name + "_b").c_str(), 600));
        EXPECT_GT(ValueOf((name + "_b").c_str(), 450), 4 * ValueOf((name + "_r").c_str(), 450));
    }
    EXPECT_FLOAT_EQ(ValueOf("nikon_d850_b", 415), (0.0186500111f + 0.1738003248f) / 2);
}

TEST(NamedSpectra, OtherNamesAreNull) {
    for (const char* name : {"", "glass-SF11", "metal-Cu", "stdillum-d65", "daylight-components",
                             "../observer/cie1931", "nikon_d850", "nikon_d850_x", "_r"})
        EXPECT_EQ(NamedSpectrum(name), nullptr) << name;
}

// The integrals are sums at 1 nm of the published table; 1e-4 is half of the last digit of kCieYIntegral in
// float.
TEST(NamedSpectra, TheObserverHasItsPublishedIntegrals) {
    const ConstantSpectrum one(1);
    EXPECT_NEAR(InnerProduct(CieX(), one), 106.865469f, 1e-4f);
    EXPECT_NEAR(InnerProduct(CieY(), one), kCieYIntegral, 1e-4f);
    EXPECT_NEAR(InnerProduct(CieZ(), one), 106.892251f, 1e-4f);
    EXPECT_EQ(CieY().Evaluate(555), 1.f);
    EXPECT_EQ(CieY().Evaluate(359), 0.f);
}

TEST(NamedSpectra, IlluminantsHaveLuminousIntegralOneAndTheirWhitePoints) {
    struct White {
        const char* name;
        float x, y, tolerance;
    };
    // Chromaticities of CIE 15:2004; stdillum-D50 has that of the format, which is not the standard one.
    // Lamps of 5 nm bands read linearly move by up to 3e-4 (the lines of F10 to F12 most).
    for (const White& w :
         {White{"stdillum-A", .44758f, .40745f, 2e-4f}, White{"illum-cieD50", .34567f, .35851f, 2e-4f},
          White{"stdillum-D50", .33690f, .35810f, 2e-4f}, White{"stdillum-D65", .31272f, .32903f, 2e-4f},
          White{"illum-acesD60", .32168f, .33767f, 2e-4f}, White{"stdillum-F2", .3721f, .3751f, 1e-3f},
          White{"stdillum-F7", .3129f, .3292f, 1e-3f}, White{"stdillum-F11", .3805f, .3769f, 2e-3f}}) {
        const std::unique_ptr<Spectrum> s = NamedSpectrum(w.name);
        const XYZ xyz = SpectrumToXYZ(*s);
        EXPECT_NEAR(xyz.y, 1, 1e-5f) << w.name;
        EXPECT_NEAR(Chromaticity(xyz).x, w.x, w.tolerance) << w.name;
        EXPECT_NEAR(Chromaticity(xyz).y, w.y, w.tolerance) << w.name;
    }
}

// Published table values; interpolation between rows 0.05 eV apart moves them by less than 1 %.
TEST(NamedSpectra, MetalsHaveTheirTabulatedIndices) {
    EXPECT_NEAR(ValueOf("metal-Ag-eta", 495.9f), .130f, .002f);
    EXPECT_NEAR(ValueOf("metal-Au-eta", 495.9f), .916f, .005f);
    EXPECT_NEAR(ValueOf("metal-Au-k", 495.9f), 1.840f, .01f);
    EXPECT_NEAR(ValueOf("metal-CuZn-eta", 550), .527f, 1e-3f);
    EXPECT_NEAR(ValueOf("metal-CuZn-k", 550), 2.765f, 1e-3f);
    EXPECT_NEAR(ValueOf("metal-MgO-eta", 589.26f), 1.73737f, 1e-3f);
}

// The catalogue's n_d has five decimals; the formula reproduces them, up to one unit of the last.
TEST(NamedSpectra, GlassesHaveTheIndexOfTheCatalogue) {
    struct Glass {
        const char* name;
        float nd;
    };
    for (const Glass& g :
         {Glass{"glass-BK7", 1.51680f}, Glass{"glass-BAF10", 1.67003f}, Glass{"glass-FK51A", 1.48656f},
          Glass{"glass-LASF9", 1.85025f}, Glass{"glass-F5", 1.67271f}, Glass{"glass-F10", 1.72828f},
          Glass{"glass-F11", 1.78472f}}) {
        EXPECT_NEAR(ValueOf(g.name, 587.5618f), g.nd, 1.5e-5f) << g.name;
        const std::unique_ptr<Spectrum> s = NamedSpectrum(g.name);
        EXPECT_GT(s->Evaluate(400), s->Evaluate(700)) << "normal dispersion: " << g.name;
        EXPECT_FALSE(s->IsConstant());
        EXPECT_GE(s->MaxValue(), s->Evaluate(360));
    }
    EXPECT_NEAR(ValueOf("glass-BK7", 546.0740f), 1.51872f, 1.5e-5f);  // n_e
}

TEST(NamedSpectra, TablesGoOnAsConstantsBeyondTheirEnds) {
    // The lamps' tables reach from 380 to 780 nm.
    EXPECT_EQ(ValueOf("stdillum-F2", 360), ValueOf("stdillum-F2", 380));
    EXPECT_EQ(ValueOf("stdillum-F2", 830), ValueOf("stdillum-F2", 780));
    EXPECT_EQ(ValueOf("glass-F5", 100), ValueOf("glass-F5", 359));
    EXPECT_GT(ValueOf("metal-MgO-eta", 830), 1.f);
}

TEST(SpectrumFiles, PairsWithCommentsAreLinearBetweenAndZeroOutside) {
    const SpectrumFile file("# header\n400 1 # one\n\n  500\t+3\r\n600 .5e1");
    const std::unique_ptr<Spectrum> s = ReadSpectrumFile(file.Path());
    EXPECT_FLOAT_EQ(s->Evaluate(450), 2);
    EXPECT_FLOAT_EQ(s->Evaluate(550), 4);
    EXPECT_EQ(s->Evaluate(399), 0.f);
    EXPECT_EQ(s->Evaluate(601), 0.f);
}

TEST(SpectrumFiles, ProblemsHaveLineAndColumn) {
    ExpectFileProblem("400 1\n500 x2\n", 2, 5, "\"x2\" is not a number");
    ExpectFileProblem("400 1\n 400 2", 2, 2, "wavelengths must increase");
    ExpectFileProblem("400 1\n500", 2, 4, "the file ends before the value at 500 nm");
    ExpectFileProblem("-4 1", 1, 1, "not positive");
    ExpectFileProblem("400 -1", 1, 5, "negative");
    ExpectFileProblem("400 nan", 1, 5, "not a number");
    ExpectFileProblem("400 1e99", 1, 5, "not a number");
    ExpectFileProblem("", 0, 0, "no samples");
    ExpectFileProblem("# nothing\n", 0, 0, "no samples");
    ExpectFileProblem("# nothing", 0, 0, "no pairs");
}

TEST(SpectrumFiles, UnreadableFilesAreFileErrors) {
    EXPECT_THROW(ReadSpectrumFile("/nonexistent/a.spd"), FileError);
    EXPECT_THROW(ReadSpectrumFile(testing::TempDir()), FileError);
    EXPECT_THROW(ReadSpectrumFile("/dev/zero"), FileError);
    const std::string pipe = testing::TempDir() + "lacquer_spectrum_pipe.spd";
    std::filesystem::remove(pipe);
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    EXPECT_THROW(ReadSpectrumFile(pipe), FileError);
    std::filesystem::remove(pipe);
}

TEST(WhiteBalance, MapsOneWhiteToTheOther) {
    const Point2 from(.44758f, .40745f), to(.31272f, .32903f);
    const XYZ mapped = WhiteBalance(from, to) * FromChromaticity(from, 1);
    const XYZ wanted = FromChromaticity(to, 1);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(mapped[i], wanted[i], 1e-6f);
    const glm::mat3 identity = WhiteBalance(to, to);
    for (int i = 0; i < 9; ++i) EXPECT_NEAR(identity[i / 3][i % 3], i % 4 == 0 ? 1.f : 0.f, 1e-6f);
}

// The Bradford matrix from D65 to D50 as published with four digits of the whites.
TEST(WhiteBalance, AgreesWithThePublishedMatrix) {
    const glm::mat3 m = WhiteBalance({.31273f, .32902f}, {.34567f, .35850f});
    const float rows[3][3] = {
        {1.04781f, .02289f, -.05013f}, {.02954f, .99048f, -.01705f}, {-.00923f, .01504f, .75213f}};
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(m[c][r], rows[r][c], 5e-4f);
}

// 6500 K on the old temperature scale is D65; CIE's published D65 differs from the formula by its rounding of
// M1, M2.
TEST(Daylight, At6500IsD65) {
    const std::unique_ptr<DenselySampledSpectrum> daylight = DaylightSpectrum(6500);
    const std::unique_ptr<Spectrum> d65 = NamedSpectrum("stdillum-D65");
    const float ratio = d65->Evaluate(560) / daylight->Evaluate(560);
    for (int nm = 380; nm <= 780; nm += 20)
        EXPECT_NEAR(ratio * daylight->Evaluate(float(nm)) / d65->Evaluate(float(nm)), 1, 2e-3f) << nm;
    EXPECT_NEAR(daylight->Evaluate(560), 1, 1e-3f);  // the components give 100 there, times 0.01
    const Point2 white = Chromaticity(SpectrumToXYZ(*daylight));
    EXPECT_NEAR(white.x, .3127f, 2e-4f);
    EXPECT_NEAR(white.y, .3290f, 2e-4f);
}

TEST(Daylight, HasTheChromaticityOfItsFormulaOnBothBranches) {
    for (const float kelvin : {4500.f, 5003.f, 8000.f, 20000.f}) {
        const double t = double(kelvin) * 1.4388 / 1.4380;
        const double x = t <= 7000 ? .244063 + 99.11 / t + 2.9678e6 / (t * t) - 4.607e9 / (t * t * t)
                                   : .23704 + 247.48 / t + 1.9018e6 / (t * t) - 2.0064e9 / (t * t * t);
        const Point2 white = Chromaticity(SpectrumToXYZ(*DaylightSpectrum(kelvin)));
        EXPECT_NEAR(double(white.x), x, 3e-4) << kelvin;
        EXPECT_NEAR(double(white.y), -3 * x * x + 2.87 * x - .275, 3e-4) << kelvin;
    }
}

TEST(Daylight, IsABlackbodyBelow4000) {
    const BlackbodySpectrum blackbody(3000 * 1.4388f / 1.4380f);
    const std::unique_ptr<DenselySampledSpectrum> daylight = DaylightSpectrum(3000);
    for (const float nm : {400.f, 555.f, 700.f})
        EXPECT_FLOAT_EQ(daylight->Evaluate(nm), blackbody.Evaluate(nm));
}

TEST(Daylight, IsFiniteHoweverHot) {
    for (const float kelvin : {25001.f, 1e6f, 1e30f}) {
        const std::unique_ptr<DenselySampledSpectrum> s = DaylightSpectrum(kelvin);
        EXPECT_TRUE(std::isfinite(s->Evaluate(400)));
        EXPECT_GT(s->Evaluate(400), 0);
    }
}

}  // namespace
}  // namespace lacquer::test::named_spectra_test
