#include "pbrt/scattering/bulk_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "pbrt/core/check.h"
#include "pbrt/core/file_bytes.h"
#include "pbrt/core/json_reader.h"

namespace lacquer {
namespace {

constexpr const char* kFormat = "lacquer-bulk";
constexpr int kVersion = 1;
constexpr double kNormTolerance = 1e-6;
/// Numbers for each angle in "mueller".
constexpr size_t kMuellerElements = 5;

const std::vector<std::string> kModes = {"aggregate", "medium", "chapter", "independent", "structure"};
const std::vector<std::string> kKeys = {"format",     "version", "units",          "mode",   "isotropic",
                                        "host_index", "made",    "wavelengths",    "angles", "sigma_s",
                                        "sigma_a",    "g",       "standard_error", "phase",  "mueller"};
const std::vector<std::string> kErrorKeys = {"sigma_s", "sigma_a", "phase"};
constexpr std::pair<const char*, const char*> kUnits[] = {
    {"length", "mm"}, {"angle", "deg"}, {"wavelength", "nm"}};

/// Checks while it reads. Values are named by JSON pointers.
class BulkReader : JsonReader {
  public:
    BulkReader(std::string_view text, const std::string& path)
        : JsonReader(text, path, "as \"lacquer bulk\" writes it") {}

    BulkTable Read() {
        ReadHead();
        ReadGrid();
        for (const auto& [key, list, limit] :
             {std::tuple("sigma_s", &table_.sigmaS, kInf), {"sigma_a", &table_.sigmaA, kInf}})
            *list = Numbers(fmt::format("/{}", key), PerWavelength(), 0, limit);
        table_.g = Numbers("/g", PerWavelength(), -1, 1);
        ReadErrors();
        ReadPhase();
        ReadMueller();
        return std::move(table_);
    }

  private:
    Length PerWavelength() const { return {table_.wavelengths.size(), "one for each wavelength"}; }

    void ReadHead() {
        Require("/format", kFormat);
        Require("/version", kVersion, ", the only version that this program knows");
        // First: the file of an oriented ensemble has other keys.
        if (At("/isotropic") == false)
            Fail("/isotropic",
                 "this file is of an oriented ensemble, whose scattering depends on the direction; expected "
                 "\"isotropic\": true: oriented ensembles are not read yet");
        Require("/isotropic", true);
        CheckKeys("", kKeys);
        std::vector<std::string> quantities;
        for (const auto& [quantity, unit] : kUnits) {
            Require(fmt::format("/units/{}", quantity), unit);
            quantities.push_back(quantity);
        }
        CheckKeys("/units", quantities);
        const Json& mode = At("/mode");
        if (!mode.is_string() || std::find(kModes.begin(), kModes.end(), mode) == kModes.end())
            Fail("/mode", fmt::format("found {}; expected one of {}", KindOf(mode), fmt::join(kModes, ", ")));
        table_.mode = mode.get<std::string>();
        table_.hostIndex = Number("/host_index", At("/host_index"), 0, kInf);
        if (table_.hostIndex == 0) Fail("/host_index", "found 0; expected an index of refraction");
        if (Root().contains("made")) {
            if (!At("/made").is_object())
                Fail("/made", fmt::format("found {}; expected an object", KindOf(At("/made"))));
            table_.made = At("/made").dump();
        }
    }

    void ReadGrid() {
        // Steps that single precision tells apart.
        constexpr double kStepNm = 1e-3, kStepDeg = 2e-5;
        table_.wavelengths = Numbers("/wavelengths", {}, 1, 1e6);
        if (table_.wavelengths.empty()) Fail("/wavelengths", "this list is empty; expected wavelengths [nm]");
        RequireGrowing("/wavelengths", table_.wavelengths, kStepNm);
        const std::vector<double>& angles = table_.angles = Numbers("/angles", {}, 0, 180);
        if (angles.size() < 2 || angles.front() != 0 || angles.back() != 180)
            Fail("/angles", angles.empty()
                                ? "this list is empty; expected angles from 0 to 180 [degrees]"
                                : fmt::format("these angles go from {} to {}; expected 0 (straight "
                                              "on) to 180 (straight back) [degrees]",
                                              angles.front(), angles.back()));
        RequireGrowing("/angles", angles, kStepDeg);
    }

    void ReadErrors() {
        if (!Root().contains("standard_error")) return;
        CheckKeys("/standard_error", kErrorKeys);
        const auto readList = [&](const char* key, std::vector<double>& list) {
            if (Root()["standard_error"].contains(key))
                list = Numbers(fmt::format("/standard_error/{}", key), PerWavelength(), 0, kInf);
        };
        readList("sigma_s", table_.errorSigmaS);
        readList("sigma_a", table_.errorSigmaA);
        readList("phase", table_.errorPhase);
    }

    /// A list for each wavelength. @param length  of each
    std::vector<std::vector<double>> Rows(const std::string& pointer, const Length& length, double low,
                                          double high) const {
        const Json& rows = At(pointer);
        const size_t count = table_.wavelengths.size();
        if (!rows.is_array() || rows.size() != count)
            Fail(pointer,
                 fmt::format("found {}; expected a list of {}, a list of numbers for each wavelength",
                             KindOf(rows), count));
        std::vector<std::vector<double>> result;
        for (size_t i = 0; i < count; ++i)
            result.push_back(Numbers(fmt::format("{}/{}", pointer, i), length, low, high));
        return result;
    }
    void ReadPhase() {
        table_.phase = Rows("/phase", {table_.angles.size(), "one for each angle"}, 0, kInf);
        for (size_t i = 0; i < table_.phase.size(); ++i)
            if (const double norm = NormOfPhase(table_.angles, table_.phase[i]);
                !(std::abs(norm - 1) <= kNormTolerance))
                Fail(fmt::format("/phase/{}", i),
                     fmt::format("the phase function at {} nm integrates to {:.9g} over all directions; "
                                 "expected 1 to within {} (linear in the cosine between angles)",
                                 table_.wavelengths[i], norm, kNormTolerance));
    }
    void ReadMueller() {
        if (Root().contains("mueller"))
            table_.mueller = Rows(
                "/mueller", {kMuellerElements * table_.angles.size(), "five for each angle"}, -kInf, kInf);
    }

    BulkTable table_;
};

/// Nine significant digits; a zero has no sign, for JSON's integers have none either.
std::string TextOf(double number) {
    LACQUER_CHECK(std::isfinite(number));
    return fmt::format("{:.9g}", number == 0 ? 0. : number);
}

std::string TextOf(std::span<const double> numbers) {
    std::string text = "[";
    for (const double number : numbers) text += (text.size() > 1 ? ", " : "") + TextOf(number);
    return text + "]";
}

/// A row in each line.
std::string TextOf(const std::vector<std::vector<double>>& rows, size_t length) {
    std::string text = "[";
    for (const std::vector<double>& row : rows) {
        LACQUER_CHECK(row.size() == length);
        text += (text.size() > 1 ? ",\n    " : "\n    ") + TextOf(row);
    }
    return text + "\n  ]";
}

/// The standard errors that there are; empty if there are none.
std::string ErrorsOf(const BulkTable& table) {
    std::string text;
    const auto add = [&](const std::string& key, const std::vector<double>& list) {
        if (list.empty()) return;
        LACQUER_CHECK(list.size() == table.wavelengths.size());
        text += fmt::format("{}\"{}\": {}", text.empty() ? "" : ", ", key, TextOf(list));
    };
    add(kErrorKeys[0], table.errorSigmaS);
    add(kErrorKeys[1], table.errorSigmaA);
    add(kErrorKeys[2], table.errorPhase);
    return text;
}

}  // namespace

BulkTable ReadBulkTable(const std::string& path, const FileLoc& loc) {
    const FileBytes bytes = ReadFileBytes(path, loc, {.maxBytes = size_t(64) << 20});
    return BulkReader(bytes.View(), path).Read();
}

std::string WriteBulkTable(const BulkTable& table) {
    const size_t numWavelengths = table.wavelengths.size(), numAngles = table.angles.size();
    LACQUER_CHECK(table.sigmaS.size() == numWavelengths && table.sigmaA.size() == numWavelengths &&
                  table.g.size() == numWavelengths && table.phase.size() == numWavelengths);
    LACQUER_CHECK(table.mueller.empty() || table.mueller.size() == numWavelengths);
    LACQUER_CHECK(table.made.empty() || JsonReader::Json::accept(table.made));
    std::string text = "{";
    const auto addEntry = [&](const char* key, const std::string& value) {
        text += fmt::format("{}\n  \"{}\": {}", text.size() > 1 ? "," : "", key, value);
    };
    std::vector<std::string> units;
    for (const auto& [quantity, unit] : kUnits)
        units.push_back(fmt::format("\"{}\": \"{}\"", quantity, unit));
    addEntry("format", fmt::format("\"{}\"", kFormat));
    addEntry("version", std::to_string(kVersion));
    addEntry("units", fmt::format("{{{}}}", fmt::join(units, ", ")));
    addEntry("mode", JsonReader::Json(table.mode).dump());
    addEntry("isotropic", "true");
    addEntry("host_index", TextOf(table.hostIndex));
    if (!table.made.empty()) addEntry("made", JsonReader::Json::parse(table.made).dump());
    addEntry("wavelengths", TextOf(table.wavelengths));
    addEntry("angles", TextOf(table.angles));
    addEntry("sigma_s", TextOf(table.sigmaS));
    addEntry("sigma_a", TextOf(table.sigmaA));
    addEntry("g", TextOf(table.g));
    if (const std::string errors = ErrorsOf(table); !errors.empty())
        addEntry("standard_error", "{" + errors + "}");
    addEntry("phase", TextOf(table.phase, numAngles));
    if (!table.mueller.empty()) addEntry("mueller", TextOf(table.mueller, kMuellerElements * numAngles));
    return text + "\n}\n";
}

double NormOfPhase(std::span<const double> anglesDeg, std::span<const double> phase) {
    LACQUER_CHECK(anglesDeg.size() == phase.size());
    constexpr double kHalf = M_PI / 360;
    double sum = 0;
    for (size_t i = 0; i + 1 < phase.size(); ++i) {
        // The difference of two cosines, without cancellation.
        const double a = anglesDeg[i], b = anglesDeg[i + 1];
        const double range = 2 * std::sin(kHalf * (a + b)) * std::sin(kHalf * (b - a));
        sum += 0.5 * (phase[i] + phase[i + 1]) * range;
    }
    return 2 * M_PI * sum;
}

}  // namespace lacquer
