// `gaussfit` from arguments to files.
#include "cmd/gaussfit/gaussfit_command.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "cmd/gaussfit/images.h"
#include "gaussfit/lobe/lobe_table.h"
#include "pbrt/core/embedded.h"
#include "pbrt/core/error.h"
#include "support/statistics.h"

namespace lacquer::cmd::gaussfit_command_test {
namespace {

namespace fs = std::filesystem;

/// A folder for one test.
class GaussfitCommand : public testing::Test {
  protected:
    void SetUp() override {
        folder_ =
            fs::temp_directory_path() / ("gaussfit-" + std::to_string(test::SeedOf(test::FullTestName())));
        fs::remove_all(folder_);
        fs::create_directories(folder_);
        arguments_.out = folder_.string();
        arguments_.quiet = true;
        arguments_.models = {"beckmann-reflection"};
    }
    void TearDown() override { fs::remove_all(folder_); }

    std::string Path(const std::string& name) const { return (folder_ / name).string(); }
    void WriteFile(const std::string& name, std::string_view text) const {
        std::ofstream(Path(name), std::ios::binary) << text;
    }
    std::string ReadFile(const std::string& name) const {
        std::ifstream in(Path(name), std::ios::binary);
        std::stringstream text;
        text << in.rdbuf();
        return text.str();
    }
    static std::string_view GoodTable() { return EmbeddedData("lobes/beckmann-reflection.txt"); }

    fs::path folder_;
    GaussfitArguments arguments_;
};

TEST_F(GaussfitCommand, WritesAWholeTableInThePlaceOfAnOldOne) {
    WriteFile("beckmann-reflection.txt", "old");
    EXPECT_EQ(RunGaussfit(arguments_), ExitStatus::Complete);
    const gaussfit::LobeTable table = gaussfit::LobeTable::Parse(ReadFile("beckmann-reflection.txt"), "new");
    EXPECT_STREQ(table.Get().model->name, "beckmann-reflection");
    // Nothing temporary is left.
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

TEST_F(GaussfitCommand, ReportsOnTablesWithoutFittingThemAndNeedsNoNetwork) {
    WriteFile("beckmann-reflection.txt", GoodTable());
    arguments_.noFit = true;
    arguments_.report = Path("report.html");
    EXPECT_EQ(RunGaussfit(arguments_), ExitStatus::Complete);
    EXPECT_EQ(ReadFile("beckmann-reflection.txt"), GoodTable());
    const std::string html = ReadFile("report.html");
    for (const char* part : {"<!DOCTYPE html>", "beckmann-reflection", "data:image/png;base64,", "</html>"})
        EXPECT_NE(html.find(part), std::string::npos) << part;
    for (const char* outside : {"http:", "https:", "<script", "<link", "@import", "nan", "inf "})
        EXPECT_EQ(html.find(outside), std::string::npos) << outside;
}

TEST_F(GaussfitCommand, BrokenTablesAndWrongNamesAreErrors) {
    arguments_.noFit = true;
    EXPECT_THROW(RunGaussfit(arguments_), FileError) << "there is no such file";
    WriteFile("beckmann-reflection.txt", GoodTable().substr(0, 500));
    EXPECT_THROW(RunGaussfit(arguments_), FileError) << "truncated";
    WriteFile("beckmann-reflection.txt", EmbeddedData("lobes/trowbridgereitz-reflection.txt"));
    EXPECT_THROW(RunGaussfit(arguments_), FileError) << "another model";
    arguments_.models = {"beckmann-reflecton"};
    EXPECT_THROW(RunGaussfit(arguments_), CLI::ValidationError);
}

TEST_F(GaussfitCommand, AFolderThatCannotBeMadeIsAnError) {
    WriteFile("file", "");
    arguments_.out = Path("file");
    EXPECT_THROW(RunGaussfit(arguments_), FileError);
}

TEST(GaussfitImages, AreWhatTheFormatsSay) {
    // The signature and the beginning of the header of any PNG file.
    EXPECT_TRUE(
        ColorImage(2, 3).DataUri().starts_with("data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAIAAAAD"));
    // Lightness grows with the value.
    int last = -1;
    for (int i = 0; i <= 20; ++i) {
        const auto color = ColorOf(i / 20.0);
        const int lightness = 2 * color[0] + 7 * color[1] + color[2];
        EXPECT_GT(lightness, last);
        last = lightness;
    }
}

}  // namespace
}  // namespace lacquer::cmd::gaussfit_command_test
