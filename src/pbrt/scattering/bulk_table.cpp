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

using Json = nlohmann::ordered_json;  // what was made how keeps its order

constexpr const char* kFormat = "lacquer-bulk";
constexpr int kVersion = 1;
constexpr double kNormTolerance = 1e-6;
/// Numbers for each angle in "mueller".
constexpr size_t kMuellerElements = 5;

const std::vector<std::string> kModes = {"aggregate", "medium", "chapter", "independent", "structure"};
const std::vector<std::string> kKeys = {"format",     "version", "units",          "mode",   "isotropic",
                                        "host_index", "made",    "wavelengths",    "angles", "sigma_s",
                                        "sigma_a",    "g",       "standard_error", "phase",  "mueller"};
/// Of oriented ensembles.
const std::vector<std::string> kOrientedKeys = {
    "format",  "version", "units", "mode",        "isotropic", "host_index", "made",          "angles",
    "sigma_s", "sigma_a", "g",     "wavelengths", "azimuths",  "phase",      "standard_error"};
const std::vector<std::string> kErrorKeys = {"sigma_s", "sigma_a", "phase"};
constexpr const char* kReciprocityKey = "reciprocity";
constexpr std::pair<const char*, const char*> kUnits[] = {
    {"length", "mm"}, {"angle", "deg"}, {"wavelength", "nm"}};

/// Checks while it reads. Values are named by JSON pointers.
class BulkReader : JsonReader {
  public:
    BulkReader(std::string_view text, const std::string& path)
        : JsonReader(text, path, "as \"lacquer bulk\" writes it") {}

    std::variant<BulkTable, OrientedBulkTable> Read() {
        if (IsOriented()) return ReadOriented();
        BulkTable table;
        ReadHead(kKeys, &table);
        ReadIsotropic(&table);
        return table;
    }

  private:
    bool IsOriented() const {
        Require("/format", kFormat);
        Require("/version", kVersion, ", the only version that this program knows");
        const Json& isIsotropic = At("/isotropic");
        if (!isIsotropic.is_boolean())
            Fail("/isotropic", fmt::format("found {}; expected true or false", KindOf(isIsotropic)));
        return isIsotropic == false;
    }
    void ReadIsotropic(BulkTable* table) {
        for (const auto& [key, list, limit] :
             {std::tuple("sigma_s", &table->sigmaS, kInf), {"sigma_a", &table->sigmaA, kInf}})
            *list = Numbers(fmt::format("/{}", key), PerWavelength(), 0, limit);
        ReadErrors(kErrorKeys, table);
        ReadPhase(table);
        ReadMueller(table);
    }
    OrientedBulkTable ReadOriented() {
        OrientedBulkTable table;
        ReadHead(kOrientedKeys, &table);
        RequireSymmetricAngles();
        const Length length{table.NumIncidences(), "one for each angle up to 90 degrees"};
        table.sigmaS = Rows("/sigma_s", length, kSmallestSigma, kInf);
        table.sigmaA = Rows("/sigma_a", length, 0, kInf);
        const Json& azimuths = At("/azimuths");
        constexpr int kMaxAzimuths = 10000;
        table.numAzimuths = int(Number("/azimuths", azimuths, 2, kMaxAzimuths));
        if (!azimuths.is_number_integer())
            Fail("/azimuths", fmt::format("found {}; expected a whole number", KindOf(azimuths)));
        const Json& file = At("/phase");
        if (!file.is_string() || file == "")
            Fail("/phase",
                 fmt::format("found {}; expected the name of an image beside this file, which has the phase "
                             "functions of an oriented ensemble",
                             KindOf(file)));
        table.phaseFile = file.get<std::string>();
        std::vector<std::string> keys = kErrorKeys;
        keys.emplace_back(kReciprocityKey);
        ReadErrors(keys, &table);
        ReadErrorList(kReciprocityKey, &table.errorReciprocity);
        return table;
    }

    /// There is no p of what does not scatter.
    static constexpr double kSmallestSigma = 1e-30;

    Length PerWavelength() const { return {head_->wavelengths.size(), "one for each wavelength"}; }

    /// @param head  of the table that is read from here on
    void ReadHead(const std::vector<std::string>& keys, BulkHead* head) {
        head_ = head;
        CheckKeys("", keys);
        std::vector<std::string> quantities;
        for (const auto& [quantity, unit] : kUnits) {
            Require(fmt::format("/units/{}", quantity), unit);
            quantities.push_back(quantity);
        }
        CheckKeys("/units", quantities);
        const Json& mode = At("/mode");
        if (!mode.is_string() ||
            std::find(kModes.begin(), kModes.end(), mode.get_ref<const std::string&>()) == kModes.end())
            Fail("/mode", fmt::format("found {}; expected one of {}", KindOf(mode), fmt::join(kModes, ", ")));
        head_->mode = mode.get<std::string>();
        head_->hostIndex = Number("/host_index", At("/host_index"), 0, kInf);
        if (head_->hostIndex == 0) Fail("/host_index", "found 0; expected an index of refraction");
        if (Root().contains("made")) {
            if (!At("/made").is_object())
                Fail("/made", fmt::format("found {}; expected an object", KindOf(At("/made"))));
            head_->made = At("/made").dump();
        }
        ReadGrid();
        head_->g = Numbers("/g", PerWavelength(), -1, 1);
    }

    void ReadGrid() {
        // Steps that single precision tells apart.
        constexpr double kStepNm = 1e-3, kStepDeg = 2e-5;
        head_->wavelengths = Numbers("/wavelengths", {}, 1, 1e6);
        if (head_->wavelengths.empty()) Fail("/wavelengths", "this list is empty; expected wavelengths [nm]");
        RequireGrowing("/wavelengths", head_->wavelengths, kStepNm);
        const std::vector<double>& angles = head_->angles = Numbers("/angles", {}, 0, 180);
        if (angles.size() < 2 || angles.front() != 0 || angles.back() != 180)
            Fail("/angles", angles.empty()
                                ? "this list is empty; expected angles from 0 to 180 [degrees]"
                                : fmt::format("these angles go from {} to {}; expected 0 (straight "
                                              "on) to 180 (straight back) [degrees]",
                                              angles.front(), angles.back()));
        RequireGrowing("/angles", angles, kStepDeg);
    }

    void RequireSymmetricAngles() const {
        const std::vector<double>& angles = head_->angles;
        constexpr double kTolerance = 1e-6;
        if (angles.size() % 2 == 0)
            Fail("/angles", fmt::format("this list has {} angles; expected an odd number, with 90 degrees in "
                                        "the middle",
                                        angles.size()));
        for (size_t i = 0; i < angles.size(); ++i) {
            const double mirrored = 180 - angles[angles.size() - 1 - i];
            if (!(std::abs(angles[i] - mirrored) <= kTolerance))
                Fail(fmt::format("/angles/{}", i),
                     fmt::format("found {}; expected {}, for the angles of an oriented ensemble lie "
                                 "symmetrically about 90 degrees",
                                 angles[i], mirrored));
        }
    }

    void ReadErrorList(const char* key, std::vector<double>* list) const {
        if (Root().contains("standard_error") && Root()["standard_error"].contains(key))
            *list = Numbers(fmt::format("/standard_error/{}", key), PerWavelength(), 0, kInf);
    }
    void ReadErrors(const std::vector<std::string>& keys, BulkHead* head) const {
        if (!Root().contains("standard_error")) return;
        CheckKeys("/standard_error", keys);
        ReadErrorList("sigma_s", &head->errorSigmaS);
        ReadErrorList("sigma_a", &head->errorSigmaA);
        ReadErrorList("phase", &head->errorPhase);
    }

    /// A list for each wavelength. @param length  of each
    std::vector<std::vector<double>> Rows(const std::string& pointer, const Length& length, double low,
                                          double high) const {
        const Json& rows = At(pointer);
        const size_t count = head_->wavelengths.size();
        if (!rows.is_array() || rows.size() != count)
            Fail(pointer,
                 fmt::format("found {}; expected a list of {}, a list of numbers for each wavelength",
                             KindOf(rows), count));
        std::vector<std::vector<double>> result;
        for (size_t i = 0; i < count; ++i)
            result.push_back(Numbers(fmt::format("{}/{}", pointer, i), length, low, high));
        return result;
    }
    void ReadPhase(BulkTable* table) const {
        table->phase = Rows("/phase", {table->angles.size(), "one for each angle"}, 0, kInf);
        for (size_t i = 0; i < table->phase.size(); ++i)
            if (const double norm = NormOfPhase(table->angles, table->phase[i]);
                !(std::abs(norm - 1) <= kNormTolerance))
                Fail(fmt::format("/phase/{}", i),
                     fmt::format("the phase function at {} nm integrates to {:.9g} over all directions; "
                                 "expected 1 to within {} (linear in the cosine between angles)",
                                 table->wavelengths[i], norm, kNormTolerance));
    }
    void ReadMueller(BulkTable* table) const {
        if (Root().contains("mueller"))
            table->mueller = Rows(
                "/mueller", {kMuellerElements * table->angles.size(), "five for each angle"}, -kInf, kInf);
    }

    BulkHead* head_ = nullptr;
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

/// An entry of "standard_error" for each list that there is.
class ErrorsText {
  public:
    explicit ErrorsText(const BulkHead& head) : count_(head.wavelengths.size()) {
        Add(kErrorKeys[0], head.errorSigmaS);
        Add(kErrorKeys[1], head.errorSigmaA);
        Add(kErrorKeys[2], head.errorPhase);
    }
    void Add(const std::string& key, const std::vector<double>& list) {
        if (list.empty()) return;
        LACQUER_CHECK(list.size() == count_);
        text_ += fmt::format("{}\"{}\": {}", text_.empty() ? "" : ", ", key, TextOf(list));
    }
    /// Empty if there are none.
    const std::string& Text() const { return text_; }

  private:
    size_t count_;
    std::string text_;
};

/// The entries of a file in their order.
class BulkText {
  public:
    void Add(const char* key, const std::string& value) {
        text_ += fmt::format("{}\n  \"{}\": {}", text_.size() > 1 ? "," : "", key, value);
    }
    void AddHead(const BulkHead& head, bool isIsotropic) {
        LACQUER_CHECK(head.g.size() == head.wavelengths.size());
        LACQUER_CHECK(head.made.empty() || Json::accept(head.made));
        std::vector<std::string> units;
        for (const auto& [quantity, unit] : kUnits)
            units.push_back(fmt::format("\"{}\": \"{}\"", quantity, unit));
        Add("format", fmt::format("\"{}\"", kFormat));
        Add("version", std::to_string(kVersion));
        Add("units", fmt::format("{{{}}}", fmt::join(units, ", ")));
        Add("mode", Json(head.mode).dump());
        Add("isotropic", isIsotropic ? "true" : "false");
        Add("host_index", TextOf(head.hostIndex));
        if (!head.made.empty()) Add("made", Json::parse(head.made).dump());
        Add("wavelengths", TextOf(head.wavelengths));
        Add("angles", TextOf(head.angles));
    }
    void AddErrors(const ErrorsText& errors) {
        if (!errors.Text().empty()) Add("standard_error", "{" + errors.Text() + "}");
    }
    std::string Text() const { return text_ + "\n}\n"; }

  private:
    std::string text_ = "{";
};

}  // namespace

std::variant<BulkTable, OrientedBulkTable> ReadBulkFile(const std::string& path, const FileLoc& loc) {
    const FileBytes bytes = ReadFileBytes(path, loc, {.maxBytes = size_t(64) << 20});
    return BulkReader(bytes.View(), path).Read();
}

BulkTable ReadBulkTable(const std::string& path, const FileLoc& loc) {
    auto table = ReadBulkFile(path, loc);
    if (std::holds_alternative<OrientedBulkTable>(table))
        throw SceneError({path, 0, 0},
                         "this file is of an oriented ensemble, whose scattering depends on the direction; "
                         "expected \"isotropic\": true");
    return std::get<BulkTable>(std::move(table));
}

std::string WriteBulkTable(const BulkTable& table) {
    const size_t numWavelengths = table.wavelengths.size(), numAngles = table.angles.size();
    LACQUER_CHECK(table.sigmaS.size() == numWavelengths && table.sigmaA.size() == numWavelengths &&
                  table.phase.size() == numWavelengths);
    LACQUER_CHECK(table.mueller.empty() || table.mueller.size() == numWavelengths);
    BulkText text;
    text.AddHead(table, true);
    text.Add("sigma_s", TextOf(table.sigmaS));
    text.Add("sigma_a", TextOf(table.sigmaA));
    text.Add("g", TextOf(table.g));
    text.AddErrors(ErrorsText(table));
    text.Add("phase", TextOf(table.phase, numAngles));
    if (!table.mueller.empty()) text.Add("mueller", TextOf(table.mueller, kMuellerElements * numAngles));
    return text.Text();
}

std::string WriteBulkTable(const OrientedBulkTable& table) {
    const size_t numWavelengths = table.wavelengths.size();
    LACQUER_CHECK(table.sigmaS.size() == numWavelengths && table.sigmaA.size() == numWavelengths);
    BulkText text;
    text.AddHead(table, false);
    text.Add("azimuths", std::to_string(table.numAzimuths));
    text.Add("sigma_s", TextOf(table.sigmaS, table.NumIncidences()));
    text.Add("sigma_a", TextOf(table.sigmaA, table.NumIncidences()));
    text.Add("g", TextOf(table.g));
    ErrorsText errors(table);
    errors.Add(kReciprocityKey, table.errorReciprocity);
    text.AddErrors(errors);
    text.Add("phase", Json(table.phaseFile).dump());
    return text.Text();
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
