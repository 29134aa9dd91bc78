#include "pbrt/phases/table_file.h"

#include <fmt/format.h>

#include "pbrt/core/file_bytes.h"
#include "pbrt/core/words.h"

namespace lacquer {
namespace {

/// A number and its place.
struct Number {
    float value = 0;
    FileLoc loc;
};

/// Reads line by line.
class TableReader {
  public:
    TableReader(std::string_view text, const std::string& path) : words_(text, path), path_(path) {
        word_ = words_.Next();
    }

    PhaseNumbers Read() {
        if (word_ == "wavelengths") ReadWavelengths();
        const size_t rows = numbers_.NumRows();
        std::vector<std::vector<float>> columns(rows);
        while (!word_.empty()) {
            const std::vector<Number> line = Line();
            if (line.size() != rows + 1)
                throw SceneError(line[0].loc, fmt::format("{} values stand after this angle; expected {}",
                                                          line.size() - 1, ExpectedValues()));
            AddAngle(line[0]);
            for (size_t i = 0; i < rows; ++i) columns[i].push_back(NotNegative(line[i + 1]));
        }
        if (numbers_.angles.size() < 2 || numbers_.angles.back() != 180)
            throw SceneError(words_.Loc(), "the table ends before 180 degrees (straight back)");
        for (size_t i = 0; i < rows; ++i) {
            if (*std::max_element(columns[i].begin(), columns[i].end()) == 0)
                throw SceneError({path_, 0, 0},
                                 fmt::format("the values of column {} are all 0; light must go "
                                             "somewhere",
                                             i + 1));
            numbers_.values.insert(numbers_.values.end(), columns[i].begin(), columns[i].end());
        }
        if (const std::string why = WhyTooNarrow(numbers_); !why.empty())
            throw SceneError({path_, 0, 0}, why);
        return std::move(numbers_);
    }

  private:
    /// The numbers up to the end of the line.
    std::vector<Number> Line() {
        std::vector<Number> numbers;
        for (const int line = words_.Loc().line; !word_.empty() && words_.Loc().line == line;
             word_ = words_.Next())
            numbers.push_back({ParseNumber(word_, words_.Loc()), words_.Loc()});
        return numbers;
    }
    void ReadWavelengths() {
        const FileLoc head = words_.Loc();
        word_ = words_.Next();
        if (!word_.empty() && words_.Loc().line == head.line)
            for (const Number& n : Line()) {
                const float least = numbers_.wavelengths.empty() ? 0 : numbers_.wavelengths.back();
                if (!(n.value > least))
                    throw SceneError(n.loc, fmt::format("the wavelength {} stands after {}; expected "
                                                        "increasing ones above 0 [nm]",
                                                        n.value, least));
                numbers_.wavelengths.push_back(n.value);
            }
        if (numbers_.wavelengths.empty())
            throw SceneError(head, "no wavelengths stand in this line; expected one or more [nm]");
    }
    std::string ExpectedValues() const {
        if (numbers_.wavelengths.empty()) return "one, for the file has no line of \"wavelengths\"";
        return fmt::format("{}, one for each wavelength", numbers_.wavelengths.size());
    }
    void AddAngle(const Number& angle) {
        std::vector<float>& angles = numbers_.angles;
        if (angles.empty() && angle.value != 0)
            throw SceneError(angle.loc,
                             fmt::format("the first angle is {}; expected 0 (straight on)", angle.value));
        if (!angles.empty() && !(angle.value > angles.back() && angle.value <= 180))
            throw SceneError(angle.loc, fmt::format("the angle {} stands after {}; expected increasing ones "
                                                    "up to 180 [degrees]",
                                                    angle.value, angles.back()));
        angles.push_back(angle.value);
    }
    static float NotNegative(const Number& number) {
        if (number.value < 0)
            throw SceneError(
                number.loc, fmt::format("{} is negative; expected values of a phase function", number.value));
        return number.value;
    }

    Words words_;
    std::string path_;
    std::string_view word_;
    PhaseNumbers numbers_;
};

}  // namespace

PhaseNumbers ReadPhaseTableFile(const std::string& path, const FileLoc& loc) {
    const FileBytes bytes = ReadFileBytes(path, loc, {.maxBytes = size_t(64) << 20});
    return TableReader(bytes.View(), path).Read();
}

}  // namespace lacquer
