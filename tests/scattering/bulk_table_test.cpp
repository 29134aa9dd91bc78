// Files of bulk scattering: what is read is what was written, and what is no such file is an error with its
// place.
#include "pbrt/scattering/bulk_table.h"

#include <fmt/format.h>

#include "support/bulk_tables.h"

namespace lacquer::bulk_table_test {
namespace {

using namespace test;

/// A file of two wavelengths and three angles, p being isotropic and linear in the cosine.
const std::string kFile = R"({
  "format": "lacquer-bulk",
  "version": 1,
  "units": {"length": "mm", "angle": "deg", "wavelength": "nm"},
  "mode": "medium",
  "isotropic": true,
  "host_index": 1.33,
  "made": {"by": "hand", "seed": 1, "input": {"list": [1, 2.5, "three"], "a": null}},
  "wavelengths": [400, 700],
  "angles": [0, 90, 180],
  "sigma_s": [2.5, 1.25],
  "sigma_a": [0, 0.125],
  "g": [0, 0.333333333],
  "standard_error": {"sigma_s": [0.01, 0.02], "phase": [0.001, 0.002]},
  "phase": [
    [0.0795774715, 0.0795774715, 0.0795774715],
    [0.159154943, 0.0795774715, 0]
  ],
  "mueller": [
    [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15],
    [0, 0, -1e-05, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1]
  ]
}
)";

TEST(BulkTable, OfAFileIsWhatItSays) {
    const BulkTable table = ReadBulkTable(WriteFile("t.json", kFile));
    EXPECT_EQ(table.mode, "medium");
    EXPECT_EQ(table.hostIndex, 1.33);
    EXPECT_EQ(table.wavelengths, (std::vector<double>{400, 700}));
    EXPECT_EQ(table.angles, (std::vector<double>{0, 90, 180}));
    EXPECT_EQ(table.sigmaS, (std::vector<double>{2.5, 1.25}));
    EXPECT_EQ(table.sigmaA, (std::vector<double>{0, 0.125}));
    EXPECT_EQ(table.g, (std::vector<double>{0, 0.333333333}));
    EXPECT_EQ(table.errorSigmaS, (std::vector<double>{0.01, 0.02}));
    EXPECT_TRUE(table.errorSigmaA.empty());
    EXPECT_EQ(table.errorPhase, (std::vector<double>{0.001, 0.002}));
    ASSERT_EQ(table.phase.size(), 2u);
    EXPECT_EQ(table.phase[1], (std::vector<double>{0.159154943, 0.0795774715, 0}));
    ASSERT_EQ(table.mueller.size(), 2u);
    EXPECT_EQ(table.mueller[1][2], -1e-5);
    EXPECT_EQ(table.made, R"({"by":"hand","seed":1,"input":{"list":[1,2.5,"three"],"a":null}})");
}

TEST(BulkTable, ReadAndWrittenAgainHasTheSameBytes) {
    // The file above but for the blanks in "made", and numbers with all their digits.
    BulkTable table =
        HgTable({400, 512.345678901, 700}, {0.9, -0.3, 0}, {1. / 3, 1e-30, 1.23456789012e30}, {0, -0., 7});
    table.mode = "chapter";
    table.made = R"({ "by": "test \" é", "seed": 18446744073709551615, "x": [0.1, 1e300, -2] })";
    table.errorSigmaA = {1e-3, 2. / 3, 0};
    table.mueller.assign(3, std::vector<double>(5 * 181, -1. / 7));
    for (const std::string& text :
         {WriteBulkTable(ReadBulkTable(WriteFile("a.json", kFile))), WriteBulkTable(table)}) {
        const BulkTable read = ReadBulkTable(WriteFile("b.json", text));
        EXPECT_EQ(WriteBulkTable(read), text);
    }
    // Nine digits are kept, and no more than the last one is lost.
    const BulkTable read = ReadBulkTable(WriteFile("c.json", table));
    for (size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(read.wavelengths[i] / table.wavelengths[i], 1, 5e-9);
        EXPECT_NEAR(read.sigmaS[i] / table.sigmaS[i], 1, 5e-9);
        for (size_t j = 0; j < 181; ++j) EXPECT_NEAR(read.phase[i][j] / table.phase[i][j], 1, 5e-9);
    }
    EXPECT_EQ(read.errorSigmaA.size(), 3u);
    EXPECT_TRUE(read.errorSigmaS.empty());
}

TEST(BulkTable, NormIsThatOfLinesInTheCosine) {
    const std::vector<double> angles = {0, 60, 90, 180}, isotropic(4, 1 / (4 * M_PI));
    EXPECT_NEAR(NormOfPhase(angles, isotropic), 1, 1e-15);
    // Cosines 1, 1/2, 0, -1: trapezia of 3/2, 7/4, 5/2.
    EXPECT_NEAR(NormOfPhase(angles, std::vector<double>{2, 4, 3, 2}), 2 * M_PI * (1.5 + 1.75 + 2.5), 1e-14);
    // A lobe of a millionth of a degree has no cancellation: an area of p theta^2 / 4 of a line in it.
    const double t = 1e-6 * M_PI / 180;
    EXPECT_NEAR(
        NormOfPhase(std::vector<double>{0, 1e-6, 180}, std::vector<double>{1, 0, 0}) / (M_PI * t * t / 2), 1,
        1e-12);
}

/// The message for the file with one text replaced by another, in which a @ stands before the place that the
/// message must name.
void ExpectError(const std::string& from, std::string to, const std::string& says) {
    std::string text = kFile;
    if (from.empty()) {
        text = to;
    } else {
        const size_t at = text.find(from);
        ASSERT_NE(at, std::string::npos) << from;
        text.replace(at, from.size(), to);
    }
    const size_t mark = text.find('@');
    std::string place = ":";
    if (mark != std::string::npos) {
        const size_t start = text.rfind('\n', mark) + 1;  // 0 for the first line
        place = fmt::format(
            ":{}:{}: error: ", std::count(text.begin(), text.begin() + std::ptrdiff_t(mark), '\n') + 1,
            mark - start + 1);
        text.erase(mark, 1);
    }
    const std::string path = WriteFile("t.json", text);
    try {
        ReadBulkTable(path);
        ADD_FAILURE() << "no error: " << to;
    } catch (const SceneError& error) {
        const std::string what = error.what();
        EXPECT_NE(what.find(path + place), std::string::npos) << what << "\nexpected at " << place;
        EXPECT_NE(what.find(says), std::string::npos) << what << "\nexpected " << says;
        EXPECT_LT(what.size(), path.size() + 250) << what;
    }
}

TEST(BulkTable, WhatIsNoJsonIsAnErrorAtItsPlace) {
    ExpectError("", "@", "this is no JSON: unexpected end of input");
    ExpectError("", "@x", "this is no JSON: invalid literal");
    ExpectError("", "{\n \"format\"@", "unexpected end of input; expected ':'");
    ExpectError("", "@[1, 2]", "found a list of 2; expected an object, as \"lacquer bulk\" writes it");
    ExpectError("1.33", "@NaN", "invalid literal");
    ExpectError("1.33", "@1e999", "1e999 is beyond the range of numbers");
    ExpectError("[400, 700]", "[400, 700@}", "unexpected '}'; expected ']'");
    ExpectError("\"by\": \"hand\"", "\"by\": \"@\xff", "ill-formed UTF-8");
    ExpectError("\"a\": null", "\"a\": " + std::string(61, '[') + "@" + std::string(2000000, '['),
                "nested more than 64 deep");
    ExpectError("{", "{} @{", "unexpected '{'");
}

TEST(BulkTable, WrongHeadsAreErrorsAtTheirPlace) {
    ExpectError("\"lacquer-bulk\"", "@\"lacquer-bluk\"", "found \"lacquer-bluk\"; expected \"lacquer-bulk\"");
    ExpectError("\"version\": 1", "\"version\": @2", "found 2; expected 1, the only version");
    ExpectError("", "@{}", "there is no \"format\"");
    ExpectError("\"mm\"", "@\"m\"", "found \"m\"; expected \"mm\"");
    ExpectError("\"angle\": \"deg\", ", "", "there is no \"angle\"");
    ExpectError("\"deg\",", "\"deg\", @\"time\": 1,", "unknown key \"time\"");
    ExpectError("\"mode\": \"medium\"", "\"mode\": @\"media\"",
                "expected one of aggregate, medium, chapter, independent");
    ExpectError("true", "@1", "found 1; expected true or false");
    ExpectError("1.33", "@0", "found 0");
    ExpectError("1.33", "@\"1.33\"", "found \"1.33\"; expected a number");
    ExpectError("1.33", "@-1.33", "found -1.33; expected a number of at least 0");
    ExpectError(R"({"by": "hand", "seed": 1, "input": {"list": [1, 2.5, "three"], "a": null}})", "@[1]",
                "found a list of 1; expected an object");
    ExpectError("\"sigma_s\"", "@\"sigma_S\"", "unknown key \"sigma_S\"; did you mean \"sigma_s\"?");
    ExpectError("\"g\": [0", "\"g\": [0, 0],\n  @\"g\": [0", "twice");
}

TEST(BulkTable, WrongNumbersAreErrorsAtTheirPlace) {
    ExpectError("[400, 700]", "@[]", "empty");
    ExpectError("[400, 700]", "@400", "found 400; expected a list of numbers");
    ExpectError("[400, 700]", "[700, @400]", "400 stands after 700");
    ExpectError("[400, 700]", "[400, @400]", "400 stands after 400");
    ExpectError("[400, 700]", "[@-400, 700]", "found -400");
    ExpectError("[400, 700]", "[400, @null]", "found null");
    ExpectError("[0, 90, 180]", "@[0, 90, 170]", "go from 0 to 170; expected 0 (straight on) to 180");
    ExpectError("[0, 90, 180]", "@[1, 90, 180]", "go from 1 to 180");
    ExpectError("[0, 90, 180]", "[0, @190, 180]", "found 190");
    ExpectError("[0, 90, 180]", "[0, 90, @90.00000001, 180]",
                "stands after 90; expected numbers that grow by");
    ExpectError("[0, 90, 180]", "@[]", "empty");
    ExpectError("[2.5, 1.25]", "@[2.5]", "this list has 1 numbers; expected 2, one for each wavelength");
    ExpectError("[2.5, 1.25]", "[2.5, @-1]", "found -1; expected a number of at least 0");
    ExpectError("[0, 0.125]", "[@-1e-300, 0]", "found -1e-300");
    ExpectError("[0, 0.333333333]", "[0, @1.5]", "found 1.5; expected a number in [-1, 1]");
    ExpectError("  \"g\": [0, 0.333333333],\n", "", "there is no \"g\"");
    ExpectError("[0.01, 0.02]", "@[0.01]", "this list has 1 numbers");
    ExpectError("{\"sigma_s\": [0.01", "{@\"sigmas\": [0.01", "did you mean \"sigma_s\"?");
    ExpectError("{\"sigma_s\": [0.01, 0.02], \"phase\": [0.001, 0.002]}", "@7",
                "found 7; expected an object");
    ExpectError("[0.159154943, 0.0795774715, 0]", "[0.159154943, @-0.08, 0]", "found -0.08");
    ExpectError("[0.159154943, 0.0795774715, 0]", "@[0.159154943, 0.0795774715]",
                "expected 3, one for each angle");
    ExpectError("[0.159154943, 0.0795774715, 0]", "@[0.159154943, 0.0795776715, 0]",
                "at 700 nm integrates to 1.00000126 over");
    ExpectError("[0.159154943, 0.0795774715, 0]", "@[0, 0, 0]", "integrates to 0 over");
    ExpectError("[0.159154943, 0.0795774715, 0]", "@[1e300, 1e308, 1e308]", "integrates to");
    ExpectError(",\n    [0.159154943, 0.0795774715, 0]", "", "found a list of 1; expected a list of 2");
    ExpectError("[1, 2, 3, 4, 5, 6,", "@[2, 3, 4, 5, 6,",
                "this list has 14 numbers; expected 15, five for each angle");
    ExpectError("14, 15]", "14, @\"15\"]", "found \"15\"");
}

TEST(BulkTable, FilesThatAreNotThereAreFileErrors) {
    try {
        ReadBulkTable("nowhere/t.json", {"scene.pbrt", 3, 5});
        ADD_FAILURE();
    } catch (const FileError& error) {
        EXPECT_EQ(std::string(error.what()),
                  "scene.pbrt:3:5: error: nowhere/t.json: cannot be opened: No such file or directory");
    }
}

}  // namespace
}  // namespace lacquer::bulk_table_test
