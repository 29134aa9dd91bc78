// Short ways to parse a scene text and to claim what is wrong with it.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "pbrt/scene/parser.h"

namespace lacquer::test {

inline SceneDescription ParseScene(const std::string& text) {
    return ParseText(text, "scene.pbrt", "", nullptr);
}

/// `text` after a WorldBegin on the same line.
inline SceneDescription ParseWorld(const std::string& text) { return ParseScene("WorldBegin " + text); }

/// What parsing says is wrong; empty if nothing is.
inline std::vector<Diagnostic> ErrorsOf(const std::string& text) {
    try {
        ParseScene(text);
    } catch (const SceneErrors& e) {
        return e.Diagnostics();
    }
    return {};
}

/// Exactly one error, at line:column, whose message contains `part`.
inline void ExpectOneError(const std::string& text, int line, int column, const std::string& part) {
    const std::vector<Diagnostic> errors = ErrorsOf(text);
    ASSERT_EQ(errors.size(), 1u) << "for: " << text
                                 << (errors.empty() ? "" : "\nfirst two: " + errors[0].ToString()) +
                                        (errors.size() < 2 ? "" : "\n" + errors[1].ToString());
    EXPECT_EQ(errors[0].loc.line, line) << errors[0].ToString();
    EXPECT_EQ(errors[0].loc.column, column) << errors[0].ToString();
    EXPECT_NE(errors[0].message.find(part), std::string::npos) << errors[0].ToString() << "\nlacks: " << part;
}

/// A folder of its own for a test's files, removed at the end.
class TestFolder {
  public:
    TestFolder() {
        const auto* info = testing::UnitTest::GetInstance()->current_test_info();
        path_ = std::filesystem::path(testing::TempDir()) /
                ("lacquer_" + std::string(info->test_suite_name()) + "_" + info->name());
        std::filesystem::remove_all(path_);
        std::filesystem::create_directories(path_);
    }
    ~TestFolder() { std::filesystem::remove_all(path_); }
    TestFolder(const TestFolder&) = delete;
    TestFolder& operator=(const TestFolder&) = delete;

    std::string Path(const std::string& name) const { return (path_ / name).string(); }
    std::string Write(const std::string& name, const std::string& text) const {
        std::filesystem::create_directories((path_ / name).parent_path());
        std::ofstream(path_ / name, std::ios::binary) << text;
        return Path(name);
    }

  private:
    std::filesystem::path path_;
};

}  // namespace lacquer::test
