// Files of lobe tables: what is written is read again, and what is broken says how.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <limits>

#include "gaussfit/lobe/lobe_table.h"
#include "pbrt/core/embedded.h"
#include "pbrt/core/error.h"

namespace lacquer::gaussfit::lobe_table_test {
namespace {

constexpr const char* kPath = "some/table.txt";

std::string GoodText() { return std::string(EmbeddedData("lobes/beckmann-reflection.txt")); }

/// The checksum as docs/gaussfit.md describes it, written anew.
std::string Signed(std::string text) {
    text.resize(text.rfind("\nchecksum ") + 1);
    uint64_t hash = 14695981039346656037u;
    for (const char c : text) {
        hash ^= static_cast<unsigned char>(c);
        hash *= 1099511628211u;
    }
    return text + fmt::format("checksum {:016x}\n", hash);
}

std::string Replaced(std::string text, const std::string& what, const std::string& by) {
    const size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return text.replace(at, what.size(), by);
}

/// The message of the FileError that a text gives, without the path; empty if there is none.
std::string ProblemOf(const std::string& text) {
    try {
        LobeTable::Parse(text, kPath);
    } catch (const FileError& e) {
        EXPECT_EQ(e.Path(), kPath);
        return e.Problem();
    }
    return "";
}

/// The same for a content.
std::string ProblemOf(const LobeTable::Content& content) {
    try {
        const LobeTable table(content, kPath);
    } catch (const FileError& e) {
        return e.Problem();
    }
    return "";
}

TEST(LobeTable, EveryModelHasATableThatIsReadAndWrittenWithoutLoss) {
    for (const LobeModel& model : LobeModels()) {
        const std::string name = fmt::format("lobes/{}.txt", model.name);
        ASSERT_TRUE(HasEmbeddedData(name)) << name;
        const std::string text(EmbeddedData(name));
        const LobeTable table = LobeTable::Parse(text, name);
        EXPECT_EQ(table.Get().model, &model);
        EXPECT_EQ(table.ToText(), text) << name;
        EXPECT_NE(EmbeddedLobeTable(model.distribution, model.event), nullptr) << name;
    }
}

TEST(LobeTable, TheChecksumIsTheDocumentedOne) { EXPECT_EQ(Signed(GoodText()), GoodText()); }

TEST(LobeTable, EveryTruncationIsFound) {
    const std::string good = GoodText();
    const size_t firstLine = good.find('\n');
    for (size_t length = 0; length < good.size(); length += 7) {
        const std::string problem = ProblemOf(good.substr(0, length));
        EXPECT_NE(problem, "") << length;
        if (length <= firstLine) continue;
        EXPECT_EQ(problem, "is truncated: it does not end with a checksum") << length;
    }
    EXPECT_EQ(ProblemOf(good.substr(0, good.size() - 1)), "is truncated: it does not end with a checksum");
}

TEST(LobeTable, EveryChangedByteIsFound) {
    const std::string good = GoodText();
    int found = 0, total = 0;
    for (size_t i = 0; i < good.size(); i += 11, ++total) {
        std::string text = good;
        text[i] = text[i] == '5' ? '6' : '5';
        found += !ProblemOf(text).empty();
    }
    EXPECT_EQ(found, total);
    const std::string problem = ProblemOf(Replaced(good, "smoothing 1e-05", "smoothing 1e-04"));
    EXPECT_TRUE(problem.starts_with("is damaged: its checksum is ")) << problem;
}

TEST(LobeTable, OtherFilesAndVersionsSayWhatTheyAre) {
    EXPECT_EQ(ProblemOf(std::string()), "is no table of lobes");
    EXPECT_EQ(ProblemOf("{\"version\": 1}\n"), "is no table of lobes");
    const std::string other = Signed(Replaced(GoodText(), "lacquer-lobe-table 1", "lacquer-lobe-table 2"));
    EXPECT_EQ(ProblemOf(other), "is a table of lobes of version 2; this program reads version 1");
}

TEST(LobeTable, ContentsOutOfRangeNameTheLineOrTheValue) {
    const auto problem = [](const std::string& what, const std::string& by) {
        return ProblemOf(Signed(Replaced(GoodText(), what, by)));
    };
    EXPECT_EQ(problem("model beckmann-reflection", "model lambert"), "line 2: unknown model \"lambert\"");
    EXPECT_NE(problem("degrees 0 4 5", "degrees 0 4 6").find("line 3: value out of range: shape"),
              std::string::npos);
    EXPECT_EQ(problem("eta 1 1", "eta 0.5 1"), "value out of range: eta from 0.5 to 1");
    EXPECT_EQ(problem("eta 1 1", "eta 1 one"), "line 4: \"one\" where an index was expected");
    EXPECT_TRUE(
        problem("grazing-cosine 0", "grazing-cosine 7").starts_with("value out of range: grazing cosine 7"));
    EXPECT_EQ(problem("patch 0.005 0.1", "patch 0.005 0.2"), "value out of range: a gap between patches");
    EXPECT_EQ(problem("by-spread", "by-magic"),
              "line 11: \"by-magic\" where by-spread or by-cosine was expected");
    EXPECT_EQ(problem("option rounds", "choice rounds"), "line 9: unknown entry \"choice\"");
}

TEST(LobeTable, ControlValuesOutOfRangeAreRefused) {
    const LobeTable table = LobeTable::Parse(GoodText(), kPath);
    const auto with = [&](size_t index, float value) {
        LobeTable::Content content = table.Get();
        content.patches[1].control[index] = value;
        return ProblemOf(content);
    };
    const float nan = std::numeric_limits<float>::quiet_NaN(),
                infinity = std::numeric_limits<float>::infinity();
    EXPECT_EQ(with(1, 1), "");
    EXPECT_EQ(with(0, nan), "value out of range: control value nan of the mean, number 0");
    EXPECT_EQ(with(1, -1), "value out of range: control value -1 of L11, number 1");
    EXPECT_EQ(with(1, 0), "value out of range: control value 0 of L11, number 1");
    EXPECT_EQ(with(6, infinity), "value out of range: control value inf of L22, number 6");
    EXPECT_EQ(with(7, 1.5f), "value out of range: control value 1.5 of a weight, number 7");

    LobeTable::Content content = table.Get();
    content.patches[0].control.pop_back();
    EXPECT_EQ(ProblemOf(content), "119 control values in a patch, expected 120");
    content.patches.clear();
    EXPECT_EQ(ProblemOf(content), "value out of range: no patches");
}

TEST(LobeTable, TooFewAndTooManyControlValuesNameTheLine) {
    std::string text = GoodText();
    // Cut the last row of values, then double it.
    const size_t end = text.rfind("\nchecksum "), begin = text.rfind('\n', end - 1);
    const std::string row = text.substr(begin, end - begin);
    EXPECT_EQ(ProblemOf(Signed(text.substr(0, begin) + text.substr(end))),
              "line 71: the control values end here, too early");
    const std::string problem = ProblemOf(Signed(text.substr(0, end) + row + text.substr(end)));
    EXPECT_NE(problem.find("line 73: unknown entry"), std::string::npos) << problem;
}

}  // namespace
}  // namespace lacquer::gaussfit::lobe_table_test
