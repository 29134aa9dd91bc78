#include "pbrt/core/params.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>

namespace lacquer::test::params_test {
namespace {

using Values = Parameter::Values;

int lineOfNext = 0;

Parameter Base(const std::string& type, const std::string& name, Values kind) {
    Parameter p;
    p.type = type;
    p.name = name;
    p.kind = kind;
    p.loc = {"scene.pbrt", ++lineOfNext, 5};
    return p;
}
Parameter Floats(const std::string& type, const std::string& name, std::vector<float> values) {
    Parameter p = Base(type, name, Values::Floats);
    p.floats = std::move(values);
    return p;
}
Parameter Ints(const std::string& name, std::vector<int> values) {
    Parameter p = Base("integer", name, Values::Integers);
    p.integers = std::move(values);
    return p;
}
Parameter Strings(const std::string& type, const std::string& name, std::vector<std::string> values) {
    Parameter p = Base(type, name, Values::Strings);
    p.strings = std::move(values);
    return p;
}
Parameter Bool(const std::string& name, bool value) {
    Parameter p = Base("bool", name, Values::Bools);
    p.bools = {value};
    return p;
}
Parameter Inherited(Parameter p) {
    p.fromAttribute = true;
    return p;
}

/// Parameters stand on the lines 1, 2, ... of scene.pbrt, in the order in which they are made.
class ParamsTest : public testing::Test {
  protected:
    void SetUp() override { lineOfNext = 0; }
    static Params Of(std::vector<Parameter> parameters, FileResolver files = {}) {
        return Params("material \"diffuse\"", {"scene.pbrt", 99, 1}, std::move(parameters),
                      &ColorSpace::SRGB(), std::move(files));
    }
};

void ExpectError(const std::function<void()>& act, int line, const std::string& part) {
    try {
        act();
        FAIL() << "no error; expected: " << part;
    } catch (const SceneError& e) {
        EXPECT_EQ(e.Loc().line, line) << e.what();
        EXPECT_NE(e.Message().find(part), std::string::npos) << e.what() << "\nlacks: " << part;
    }
}

void ExpectSpectrumError(Parameter p, SpectrumKind kind, const std::string& part) {
    const int line = p.loc.line;
    const Params params("light", {"scene.pbrt", 99, 1}, {std::move(p)}, &ColorSpace::SRGB());
    ExpectError([&] { params.GetSpectrum("L", kind); }, line, part);
}

TEST_F(ParamsTest, ScalarsGiveTheValueOrTheDefault) {
    const Params p =
        Of({Floats("float", "f", {1.5f}), Ints("i", {3}), Bool("b", true), Strings("string", "s", {"x"}),
            Floats("point2", "p2", {1, 2}), Floats("point3", "p3", {1, 2, 3}),
            Floats("vector3", "v", {4, 5, 6}), Strings("texture", "t", {"wood"})});
    EXPECT_EQ(p.GetFloat("f", 0), 1.5f);
    EXPECT_EQ(p.GetFloat("g", 7), 7.f);
    EXPECT_EQ(p.GetInt("i", 0), 3);
    EXPECT_EQ(p.GetInt("j", 4), 4);
    EXPECT_TRUE(p.GetBool("b", false));
    EXPECT_TRUE(p.GetBool("c", true));
    EXPECT_EQ(p.GetString("s", ""), "x");
    EXPECT_EQ(p.GetString("r", "y"), "y");
    EXPECT_EQ(p.GetPoint2("p2", {}), Vec2(1, 2));
    EXPECT_EQ(p.GetPoint3("p3", {}), Vec3(1, 2, 3));
    EXPECT_EQ(p.GetVector3("v", {}), Vec3(4, 5, 6));
    EXPECT_EQ(p.GetVector3("w", {7, 8, 9}), Vec3(7, 8, 9));
    EXPECT_EQ(p.GetTextureName("t"), "wood");
    EXPECT_EQ(p.GetTextureName("u"), std::nullopt);
    EXPECT_EQ(p.GetOptionalFloat("f"), 1.5f);
    EXPECT_EQ(p.GetOptionalFloat("g"), std::nullopt);
    EXPECT_EQ(p.GetOptionalString("s"), "x");
    EXPECT_TRUE(p.UnusedParameters().empty());
}

TEST_F(ParamsTest, ArraysGiveAllValuesOrNone) {
    const Params p = Of({Floats("float", "f", {1, 2}), Ints("i", {3, 4}), Strings("string", "s", {"x", "y"}),
                         Floats("point2", "p2", {1, 2, 3, 4}), Floats("point3", "p3", {1, 2, 3, 4, 5, 6}),
                         Floats("vector3", "v", {4, 5, 6}), Floats("normal", "n", {0, 0, 1})});
    EXPECT_EQ(p.GetFloats("f"), (std::vector<float>{1, 2}));
    EXPECT_EQ(p.GetInts("i"), (std::vector<int>{3, 4}));
    EXPECT_EQ(p.GetStrings("s"), (std::vector<std::string>{"x", "y"}));
    EXPECT_EQ(p.GetPoint2s("p2"), (std::vector<Vec2>{{1, 2}, {3, 4}}));
    EXPECT_EQ(p.GetPoint3s("p3"), (std::vector<Vec3>{{1, 2, 3}, {4, 5, 6}}));
    EXPECT_EQ(p.GetVector3s("v"), (std::vector<Vec3>{{4, 5, 6}}));
    EXPECT_EQ(p.GetNormals("n"), (std::vector<Vec3>{{0, 0, 1}}));
    EXPECT_TRUE(p.GetFloats("none").empty());
    EXPECT_TRUE(p.GetPoint3s("none").empty());
}

TEST_F(ParamsTest, LookUpsNeedTheExactType) {
    const Params p = Of({Ints("fov", {30})});
    EXPECT_EQ(p.GetFloat("fov", 90), 90.f);
}

TEST_F(ParamsTest, WrongCountsAreErrorsAtTheParameter) {
    const Params p = Of({Floats("float", "f", {1, 2}), Floats("point3", "p", {1, 2}),
                         Strings("string", "s", {}), Floats("point3", "ps", {1, 2, 3, 4})});
    ExpectError([&] { p.GetFloat("f", 0); }, 1, "\"float f\" needs 1 value, has 2");
    ExpectError([&] { p.GetPoint3("p", {}); }, 2, "\"point3 p\" needs 3 values, has 2");
    ExpectError([&] { p.GetString("s", ""); }, 3, "needs 1 value, has 0");
    ExpectError([&] { p.GetPoint3s("ps"); }, 4, "needs a multiple of 3 values, has 4");
}

TEST_F(ParamsTest, LastDuplicateWins) {
    const Params p = Of({Floats("float", "f", {1}), Floats("float", "f", {2})});
    EXPECT_EQ(p.GetFloat("f", 0), 2.f);
    EXPECT_EQ(p.LocOf("f").line, 2);
    EXPECT_TRUE(p.UnusedParameters().empty());
}

TEST_F(ParamsTest, OwnParametersWinOverInheritedAndTheNewestInheritedOverOlder) {
    const Params own = Of({Floats("float", "f", {1}), Inherited(Floats("float", "f", {2}))});
    EXPECT_EQ(own.GetFloat("f", 0), 1.f);
    EXPECT_EQ(own.LocOf("f").line, 1);
    lineOfNext = 0;
    const Params inherited = Of({Inherited(Floats("float", "f", {2})), Inherited(Floats("float", "f", {3}))});
    EXPECT_EQ(inherited.GetFloat("f", 0), 3.f);
    EXPECT_EQ(inherited.LocOf("f").line, 2);
}

TEST_F(ParamsTest, RangesAndChoicesAreChecked) {
    const Params p = Of({Ints("i", {5}), Floats("float", "f", {-1}), Strings("string", "s", {"reapet"})});
    EXPECT_EQ(p.GetIntInRange("i", 0, 0, 5), 5);
    ExpectError([&] { p.GetIntInRange("i", 0, 0, 4); }, 1, "\"integer i\" must lie in [0, 4], is 5");
    ExpectError([&] { p.GetFloatInRange("f", 0, 0, 1); }, 2, "\"float f\" must lie in [0, 1], is -1");
    ExpectError(
        [&] {
            p.GetChoice("s", "clamp", {"clamp", "repeat", "black"});
        },
        3, "is \"clamp\", \"repeat\" or \"black\", not \"reapet\"; did you mean \"repeat\"?");
    EXPECT_EQ(p.GetChoice("other", "clamp", {"clamp", "repeat"}), "clamp");
}

TEST_F(ParamsTest, NaNIsInNoRange) {
    const Params p = Of({Floats("float", "f", {std::numeric_limits<float>::quiet_NaN()})});
    ExpectError([&] { p.GetFloatInRange("f", 0, 0, 1); }, 1, "not finite");
}

TEST_F(ParamsTest, UnusedParametersNameTheNearestOneAskedFor) {
    const Params p = Of({Floats("rgb", "reflectence", {1, 1, 1}), Floats("float", "xyzzy", {1})});
    p.GetSpectrum("reflectance", SpectrumKind::Albedo);
    p.GetFloat("roughness", 0);
    const std::vector<Diagnostic> unused = p.UnusedParameters();
    ASSERT_EQ(unused.size(), 2u);
    EXPECT_EQ(unused[0].ToString(),
              "scene.pbrt:1:5: error: material \"diffuse\" has no parameter \"rgb reflectence\"; did "
              "you mean \"reflectance\"?");
    EXPECT_EQ(unused[1].message, "material \"diffuse\" has no parameter \"float xyzzy\"");
    EXPECT_THROW(p.CheckAllUsed(), SceneErrors);
}

TEST_F(ParamsTest, ARightNameOfTheWrongTypeSaysWhatWasExpected) {
    const Params p = Of({Ints("fov", {30}), Floats("float", "L", {1})});
    p.GetFloat("fov", 90);
    p.GetSpectrum("L", SpectrumKind::Illuminant);
    const std::vector<Diagnostic> unused = p.UnusedParameters();
    ASSERT_EQ(unused.size(), 2u);
    EXPECT_EQ(unused[0].message,
              "\"integer fov\" has the type \"integer\", but material \"diffuse\" expects \"float fov\"");
    EXPECT_EQ(unused[1].message,
              "\"float L\" has the type \"float\", but material \"diffuse\" expects \"rgb L\", "
              "\"blackbody L\" or \"spectrum L\"");
}

TEST_F(ParamsTest, InheritedIgnoredAndShadowedParametersMayStayUnused) {
    const Params p =
        Of({Inherited(Floats("float", "a", {1})), Floats("float", "b", {1}), Ints("c", {1}), Ints("c", {2})});
    p.Ignore("float", "b");
    p.GetInt("c", 0);
    EXPECT_TRUE(p.UnusedParameters().empty());
    p.CheckAllUsed();
}

TEST_F(ParamsTest, AnUnusedDuplicateIsReportedOnce) {
    const Params p = Of({Ints("c", {1}), Ints("c", {2})});
    ASSERT_EQ(p.UnusedParameters().size(), 1u);
    EXPECT_EQ(p.UnusedParameters()[0].loc.line, 2);
}

TEST_F(ParamsTest, HasAndLocOfMarkNothing) {
    const Params p = Of({Floats("float", "f", {1})});
    EXPECT_TRUE(p.Has("f"));
    EXPECT_FALSE(p.Has("g"));
    EXPECT_EQ(p.LocOf("f").line, 1);
    EXPECT_EQ(p.LocOf("g").line, 99);
    EXPECT_EQ(p.UnusedParameters().size(), 1u);
    ExpectError([&] { p.Fail("f", "bad"); }, 1, "bad");
}

TEST_F(ParamsTest, SpectraOfEveryForm) {
    const Params p =
        Of({Floats("rgb", "grey", {.25f, .25f, .25f}), Floats("blackbody", "hot", {5000}),
            Strings("spectrum", "named", {"glass-BK7"}), Floats("spectrum", "table", {400, 1, 500, 3}),
            Floats("rgb", "light", {.5f, .5f, .5f})});
    EXPECT_FLOAT_EQ(p.GetSpectrum("grey", SpectrumKind::Albedo)->Evaluate(500), .25f);
    EXPECT_FLOAT_EQ(p.GetSpectrum("hot", SpectrumKind::Illuminant)->Evaluate(579.6f), 1);  // Wien's peak
    EXPECT_NEAR(p.GetSpectrum("named", SpectrumKind::Unbounded)->Evaluate(587.5618f), 1.5168f, 1e-4f);
    const std::unique_ptr<Spectrum> table = p.GetSpectrum("table", SpectrumKind::Unbounded);
    EXPECT_FLOAT_EQ(table->Evaluate(450), 2);
    EXPECT_EQ(table->Evaluate(501), 0.f);
    // Half of the white of the colour space, whose luminous integral is that of the observer.
    const std::unique_ptr<Spectrum> light = p.GetSpectrum("light", SpectrumKind::Illuminant);
    EXPECT_NEAR(InnerProduct(*light, CieY()) / kCieYIntegral, .5f, 1e-4f);
    EXPECT_EQ(p.GetSpectrum("none", SpectrumKind::Albedo), nullptr);
    EXPECT_TRUE(p.UnusedParameters().empty());
    EXPECT_EQ(p.GetRgb("grey"), RGB(.25f));
    EXPECT_EQ(p.GetRgb("hot"), std::nullopt);
}

TEST_F(ParamsTest, RgbIsReadInItsOwnColorSpace) {
    Parameter p = Floats("rgb", "L", {1, 0, 0});
    p.colorSpace = ColorSpace::Find("rec2020");
    const Params params = Of({p});
    const XYZ xyz = SpectrumToXYZ(*params.GetSpectrum("L", SpectrumKind::Illuminant));
    // Rec. 2020 red at (.708, .292); a smooth spectrum reaches it to about 0.02, and sRGB's red is at (.64,
    // .33).
    EXPECT_NEAR(Chromaticity(xyz).x, .708f, .03f);
}

TEST_F(ParamsTest, TheLastFormOfASpectrumWinsAndTheOtherIsReported) {
    const Params p = Of({Floats("spectrum", "L", {300, 1, 900, 1}), Floats("rgb", "L", {.5f, .5f, .5f})});
    EXPECT_FLOAT_EQ(p.GetSpectrum("L", SpectrumKind::Albedo)->Evaluate(500), .5f);
    const std::vector<Diagnostic> unused = p.UnusedParameters();
    ASSERT_EQ(unused.size(), 1u);
    EXPECT_EQ(unused[0].loc.line, 1);
    EXPECT_NE(unused[0].message.find("is given in another form as well"), std::string::npos);
    // An own form wins over an inherited one, wherever it stands.
    const Params inherited =
        Of({Floats("spectrum", "L", {300, 1, 900, 1}), Inherited(Floats("rgb", "L", {.5f, .5f, .5f}))});
    EXPECT_FLOAT_EQ(inherited.GetSpectrum("L", SpectrumKind::Albedo)->Evaluate(500), 1);
    EXPECT_TRUE(inherited.UnusedParameters().empty());
}

TEST_F(ParamsTest, SpectraOutsideOfTheirDomainAreErrors) {
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    ExpectSpectrumError(Floats("rgb", "L", {.5f, 1.5f, 0}), SpectrumKind::Albedo, "1.5 is outside of [0, 1]");
    ExpectSpectrumError(Floats("rgb", "L", {.5f, -1, 0}), SpectrumKind::Albedo, "-1 is negative");
    ExpectSpectrumError(Floats("rgb", "L", {.5f, -1, 0}), SpectrumKind::Unbounded, "-1 is negative");
    ExpectSpectrumError(Floats("rgb", "L", {.5f, -1, 0}), SpectrumKind::Illuminant, "-1 is negative");
    ExpectSpectrumError(Floats("rgb", "L", {nan, 1, 0}), SpectrumKind::Illuminant, "not finite");
    ExpectSpectrumError(Floats("rgb", "L", {inf, 1, 0}), SpectrumKind::Illuminant, "not finite");
    ExpectSpectrumError(Floats("rgb", "L", {1, 1}), SpectrumKind::Albedo, "needs 3 values, has 2");
    ExpectSpectrumError(Floats("blackbody", "L", {0}), SpectrumKind::Illuminant,
                        "the temperature must be positive");
    ExpectSpectrumError(Floats("blackbody", "L", {-300}), SpectrumKind::Illuminant,
                        "the temperature must be positive");
    ExpectSpectrumError(Floats("blackbody", "L", {nan}), SpectrumKind::Illuminant, "not finite");
    ExpectSpectrumError(Floats("blackbody", "L", {1e9f}), SpectrumKind::Illuminant, "between 1 K and 1e8 K");
    ExpectSpectrumError(Floats("blackbody", "L", {3000, 1}), SpectrumKind::Illuminant,
                        "needs 1 value, has 2");
    ExpectSpectrumError(Floats("spectrum", "L", {400, 1, 500}), SpectrumKind::Albedo,
                        "pairs of wavelength and value, has 3");
    ExpectSpectrumError(Floats("spectrum", "L", {400, 1, 400, 2}), SpectrumKind::Albedo,
                        "wavelengths must increase");
    ExpectSpectrumError(Floats("spectrum", "L", {500, 1, 400, 2}), SpectrumKind::Albedo,
                        "but 400 follows 500");
    ExpectSpectrumError(Floats("spectrum", "L", {-5, 1, 400, 2}), SpectrumKind::Albedo,
                        "the wavelength -5 is not positive");
    ExpectSpectrumError(Floats("spectrum", "L", {400, -1, 500, 2}), SpectrumKind::Albedo,
                        "the value -1 at 400 nm is negative");
    ExpectSpectrumError(Floats("spectrum", "L", {400, nan, 500, 2}), SpectrumKind::Albedo, "not finite");
    ExpectSpectrumError(Floats("spectrum", "L", {}), SpectrumKind::Albedo, "has no values");
    ExpectSpectrumError(Strings("spectrum", "L", {"a", "b"}), SpectrumKind::Albedo, "needs 1 name, has 2");
    ExpectSpectrumError(
        Strings("spectrum", "L", {"metal-Cu-eat"}), SpectrumKind::Unbounded,
        "\"metal-Cu-eat\" is neither a named spectrum nor a readable file; did you mean \"metal-Cu-eta\"?");
}

TEST_F(ParamsTest, EveryLookUpRejectsNumbersThatAreNotFinite) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(), kInfinity, -kInfinity}) {
        lineOfNext = 0;
        const Params p = Of({Floats("float", "f", {bad}), Floats("point2", "p2", {0, bad}),
                             Floats("point3", "p3", {0, bad, 0}), Floats("vector3", "v", {bad, 0, 0}),
                             Floats("rgb", "c", {1, 1, bad}), Floats("normal", "n", {0, 0, 1, bad, 0, 1})});
        ExpectError([&] { p.GetFloat("f", 0); }, 1, "\"float f\" has a value that is not finite");
        ExpectError([&] { p.GetOptionalFloat("f"); }, 1, "not finite");
        ExpectError([&] { p.GetFloatInRange("f", 0, 0, 1); }, 1, "not finite");
        ExpectError([&] { p.GetFloats("f"); }, 1, "not finite");
        ExpectError([&] { p.GetPoint2("p2", {}); }, 2, "not finite");
        ExpectError([&] { p.GetPoint2s("p2"); }, 2, "not finite");
        ExpectError([&] { p.GetPoint3("p3", {}); }, 3, "not finite");
        ExpectError([&] { p.GetPoint3s("p3"); }, 3, "not finite");
        ExpectError([&] { p.GetVector3("v", {}); }, 4, "not finite");
        ExpectError([&] { p.GetVector3s("v"); }, 4, "not finite");
        ExpectError([&] { p.GetRgb("c"); }, 5, "not finite");
        ExpectError([&] { p.GetNormals("n"); }, 6, "not finite");
    }
    // Defaults may be infinite.
    EXPECT_EQ(Of({}).GetFloat("f", kInfinity), kInfinity);
}

TEST_F(ParamsTest, LongNamesAreClippedInMessages) {
    const std::string name(1000000, 'x');
    const Params p =
        Of({Floats("float", name, {1, 2}), Strings("string", "s", {name}), Ints(name + "z", {1})});
    for (const auto& act : std::vector<std::function<void()>>{[&] { p.GetFloat(name, 0); },
                                                              [&] {
                                                                  p.GetChoice("s", "a", {"a", "b"});
                                                              },
                                                              [&] { p.CheckAllUsed(); }}) {
        try {
            act();
            FAIL();
        } catch (const std::exception& e) {
            EXPECT_LT(std::string(e.what()).size(), 300u);
        }
    }
}

// Emission and extinction may exceed 1, and so may tables whatever they are used for.
TEST_F(ParamsTest, OnlyReflectancesGivenAsRgbAreBounded) {
    const Params p = Of({Floats("rgb", "L", {2, 3, 4}), Floats("spectrum", "s", {300, 5, 900, 5})});
    EXPECT_NE(p.GetSpectrum("L", SpectrumKind::Illuminant), nullptr);
    EXPECT_NE(p.GetSpectrum("L", SpectrumKind::Unbounded), nullptr);
    EXPECT_FLOAT_EQ(p.GetSpectrum("s", SpectrumKind::Albedo)->Evaluate(500), 5);
}

TEST_F(ParamsTest, SpectrumFilesAreFoundInTheScenesFolder) {
    const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "lacquer_params_spectra";
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "good.spd") << "400 1 500 2";
    std::ofstream(folder / "bad.spd") << "400 1\n500 x";
    const Params p = Of({Strings("spectrum", "good", {"good.spd"}), Strings("spectrum", "bad", {"bad.spd"}),
                         Strings("spectrum", "missing", {"missing.spd"})},
                        FileResolver(folder.string()));
    EXPECT_FLOAT_EQ(p.GetSpectrum("good", SpectrumKind::Albedo)->Evaluate(500), 2);
    try {
        p.GetSpectrum("bad", SpectrumKind::Albedo);
        FAIL();
    } catch (const SceneError& e) {
        EXPECT_EQ(e.Loc().ToString(), (folder / "bad.spd").string() + ":2:5");
        EXPECT_NE(e.Message().find("read for \"spectrum bad\" at scene.pbrt:2:5"), std::string::npos)
            << e.Message();
    }
    try {
        p.GetSpectrum("missing", SpectrumKind::Albedo);
        FAIL();
    } catch (const FileError& e) {
        EXPECT_EQ(e.Loc().line, 3);
        EXPECT_EQ(e.Message(),
                  "missing.spd: cannot be opened: No such file or directory (the spectrum file of "
                  "\"spectrum missing\")");
    }
    std::filesystem::remove_all(folder);
}

TEST(FileResolver, LooksBelowTheDirectoryFirst) {
    const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "lacquer_resolver";
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "here.txt") << "x";
    const FileResolver files(folder.string());
    EXPECT_EQ(files.Resolve("here.txt"), (folder / "here.txt").string());
    EXPECT_EQ(files.Resolve("./here.txt"), (folder / "here.txt").string());
    EXPECT_EQ(files.Resolve("elsewhere.txt"), "elsewhere.txt");
    EXPECT_EQ(files.Resolve("/abs/here.txt"), "/abs/here.txt");
    EXPECT_EQ(files.Resolve(""), "");
    EXPECT_EQ(FileResolver().Resolve("here.txt"), "here.txt");
    // ".." goes with its folder, unless that is a link to elsewhere.
    std::filesystem::create_directories(folder / "a" / "b");
    std::filesystem::create_directory_symlink(folder / "a" / "b", folder / "link");
    std::ofstream(folder / "a" / "here.txt") << "y";
    EXPECT_EQ(files.Resolve("a/../here.txt"), (folder / "here.txt").string());
    EXPECT_EQ(files.Resolve("link/../here.txt"), (folder / "link/../here.txt").string());
    EXPECT_EQ(files.Resolve(std::string(100000, 'x')).size(), 100000u);
    std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace lacquer::test::params_test
