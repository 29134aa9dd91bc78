// Measured cameras: the matrix to XYZ, white balance, and names.
#include "pbrt/film/sensor.h"

#include <gtest/gtest.h>

#include "support/scene_parts.h"

namespace lacquer::sensor_test {
namespace {

const std::vector<std::string> kCameras = {
    "canon_eos_100d",     "canon_eos_1dx_mkii", "canon_eos_200d",    "canon_eos_200d_mkii", "canon_eos_5d",
    "canon_eos_5d_mkii",  "canon_eos_5d_mkiii", "canon_eos_5d_mkiv", "canon_eos_5ds",       "canon_eos_m",
    "hasselblad_l1d_20c", "nikon_d810",         "nikon_d850",        "sony_ilce_6400",      "sony_ilce_7m3",
    "sony_ilce_7rm3",     "sony_ilce_9"};

Sensor MakeSensor(const std::string& text, const std::string& space = "srgb") {
    const Params params = test::ParamsFromText("film", text, space);
    const Sensor sensor(params, 1, params.ColorSpace());
    params.CheckAllUsed();
    return sensor;
}

/// What a sensor makes of light in units of luminance: a midpoint rule of thousands of wavelengths.
RGB Seen(const Sensor& sensor, const Spectrum& light, const Spectrum& reflectance) {
    constexpr int kCount = 2000;
    const float luminance = InnerProduct(light, CieY());
    Vec3 sum(0);
    for (int i = 0; i < kCount; ++i) {
        const auto lambda = SampledWavelengths::SampleVisible((float(i) + 0.5f) / kCount);
        sum += sensor.Response(light.Sample(lambda) * reflectance.Sample(lambda) / luminance, lambda);
    }
    return sensor.RGBFromSensor() * (sum / float(kCount));
}
std::string CameraText(const std::string& name) { return "\"string sensor\" \"" + name + "\" "; }

TEST(FitXYZFromSensor, FindsTheMatrixOfACameraThatSeesAsTheEyeDoes) {
    // Curves that are mixtures of the observer's (Luther's condition): the fit must undo the mixture,
    // exactly.
    const glm::dmat3 mixture(0.9, 0.1, 0.0, 0.3, 0.8, 0.1, 0.05, 0.1, 0.7);
    const auto mixed = [&](int row) {
        return DenselySampledSpectrum([&](float lambda) {
            const glm::dvec3 xyz(CieX().Evaluate(lambda), CieY().Evaluate(lambda), CieZ().Evaluate(lambda));
            return float((mixture * xyz)[row]);
        });
    };
    const DenselySampledSpectrum& white = ColorSpace::SRGB().Illuminant();
    const glm::dmat3 fit = FitXYZFromSensor({mixed(0), mixed(1), mixed(2)}, white, white);
    const glm::dmat3 product = fit * mixture;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) EXPECT_NEAR(product[i][j], i == j ? 1 : 0, 1e-4);
    // Negative control: another light than the one that the camera was balanced for shows.
    const glm::dmat3 other = FitXYZFromSensor({mixed(0), mixed(1), mixed(2)}, *DaylightSpectrum(3500), white);
    EXPECT_GT(std::abs((other * mixture)[2][2] - 1), 0.2);
}

TEST(Sensor, CamerasRenderTheLightTheyAreBalancedForAsNearlyWhite) {
    const ConstantSpectrum one(1);
    for (const std::string& camera : kCameras)
        for (const auto& [text, kelvin] :
             {std::pair<std::string, float>("", 6500), {"\"float whitebalance\" 3200", 3200}}) {
            const RGB rgb = Seen(MakeSensor(CameraText(camera) + text), *DaylightSpectrum(kelvin), one);
            // A least-squares fit over 24 patches: white is one of them, and the others pull by a few per
            // cent.
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(rgb[c], 1, 0.06f) << camera << " " << text << c;
        }
    // Negative control: without the right balance, tungsten light is orange.
    const RGB orange = Seen(MakeSensor(CameraText("nikon_d850")), *DaylightSpectrum(3200), one);
    EXPECT_GT(orange[0] / orange[2], 2);
}

TEST(Sensor, CamerasAgreeWithTheObserverOnCommonColors) {
    // Under daylight, for smooth reflectances: cameras are made to. A curve given to the wrong colour, or one
    // that is off by a tenth, would not.
    const auto light = DaylightSpectrum(6500);
    const Sensor ideal = MakeSensor("");
    for (const RGB color : {RGB(0.6f, 0.2f, 0.2f), RGB(0.2f, 0.5f, 0.2f), RGB(0.2f, 0.3f, 0.6f),
                            RGB(0.6f, 0.5f, 0.2f), RGB(0.4f, 0.4f, 0.4f)}) {
        const auto reflectance = ColorSpace::SRGB().MakeSpectrum(color, SpectrumKind::Albedo);
        const RGB expected = Seen(ideal, *light, *reflectance);
        for (const std::string& camera : kCameras) {
            const RGB rgb = Seen(MakeSensor(CameraText(camera)), *light, *reflectance);
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(rgb[c], expected[c], 0.06f) << camera << " " << c;
        }
    }
}

TEST(Sensor, ExposureIsThatOfTheIdealSensor) {
    const ConstantSpectrum one(1);
    const auto light = DaylightSpectrum(6500);
    const RGB once = Seen(MakeSensor(CameraText("sony_ilce_7m3")), *light, one);
    const RGB twice = Seen(MakeSensor(CameraText("sony_ilce_7m3") + "\"float iso\" 200"), *light, one);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(twice[c], 2 * once[c], 1e-4f);
}

std::string ErrorOf(const std::string& text) {
    try {
        MakeSensor(text);
    } catch (const SceneError& e) {
        return e.what();
    }
    return "";
}

TEST(Sensor, UnknownNamesAreExplained) {
    const std::string unknown = ErrorOf(CameraText("nikon_d580"));
    EXPECT_NE(unknown.find("not \"nikon_d580\""), std::string::npos) << unknown;
    EXPECT_NE(unknown.find("did you mean \"nikon_d8"), std::string::npos) << unknown;
    EXPECT_NE(ErrorOf(CameraText("nikon_d850") + "\"float whitebalance\" 100").find("whitebalance is 100 K"),
              std::string::npos);
}

}  // namespace
}  // namespace lacquer::sensor_test
