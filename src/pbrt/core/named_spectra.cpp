// The spectra that scene files know by name, and spectra from files.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "pbrt/core/embedded.h"
#include "pbrt/core/error.h"
#include "pbrt/core/file_bytes.h"
#include "pbrt/core/spectrum.h"
#include "pbrt/core/words.h"

namespace lacquer {

namespace {

/// Refractive index of a glass by the Sellmeier equation n^2 = 1 + sum B_i l^2 / (l^2 - C_i), l in um.
/// The wavelength is clamped to where all named spectra end.
class SellmeierSpectrum final : public Spectrum {
  public:
    explicit SellmeierSpectrum(const std::vector<double>& coefficients) {
        std::copy_n(coefficients.begin(), 6, coefficients_);
        for (int nm = int(kLambdaMin) - 1; nm <= int(kLambdaMax) + 1; ++nm)
            max_ = std::max(max_, Evaluate(float(nm)));
    }
    float Evaluate(float lambda) const override {
        const double um = 1e-3 * double(std::clamp(lambda, kLambdaMin - 1, kLambdaMax + 1)), um2 = um * um;
        double n2 = 1;
        for (int i = 0; i < 3; ++i) n2 += coefficients_[i] * um2 / (um2 - coefficients_[i + 3]);
        return float(std::sqrt(n2));
    }
    float MaxValue() const override { return max_; }

  private:
    double coefficients_[6];  // B1 B2 B3, C1 C2 C3 [um^2]
    float max_ = 0;
};

struct Folder {
    const char* path;
    std::unique_ptr<Spectrum> (*make)(const std::string& file);
};

PiecewiseLinearSpectrum Tabulated(const std::string& file, size_t column = 1) {
    std::vector<float> lambda, values;
    for (const std::vector<double>& row : EmbeddedTable(file)) {
        lambda.push_back(float(row.at(0)));
        values.push_back(float(row.at(column)));
    }
    return PiecewiseLinearSpectrum::Extended(std::move(lambda), std::move(values));
}

std::unique_ptr<Spectrum> MakeIlluminant(const std::string& file) {
    auto spectrum = std::make_unique<PiecewiseLinearSpectrum>(Tabulated(file));
    spectrum->Scale(kCieYIntegral / InnerProduct(*spectrum, CieY()));
    return spectrum;
}

std::unique_ptr<Spectrum> MakeTable(const std::string& file) {
    return std::make_unique<PiecewiseLinearSpectrum>(Tabulated(file));
}

std::unique_ptr<Spectrum> MakeGlass(const std::string& file) {
    return std::make_unique<SellmeierSpectrum>(EmbeddedTable(file).at(0));
}

constexpr Folder kFolders[] = {{"spectra/illuminants/", MakeIlluminant},
                               {"spectra/metals/", MakeTable},
                               {"spectra/glasses/", MakeGlass}};
constexpr std::string_view kSuffix = ".txt";
/// Tables of three columns: what red, green and blue pixels see, named with these suffixes.
constexpr std::string_view kSensors = "sensors/";
constexpr std::string_view kColors[] = {"_r", "_g", "_b"};
/// In the illuminants' folder, but a table of its own kind.
constexpr std::string_view kDaylightComponents = "daylight-components";

DenselySampledSpectrum ObserverColumn(size_t column) {
    const std::vector<std::vector<double>> rows = EmbeddedTable("spectra/observer/cie1931.txt");
    std::vector<float> lambda, values;
    for (const std::vector<double>& row : rows) {
        lambda.push_back(float(row.at(0)));
        values.push_back(float(row.at(column)));
    }
    return DenselySampledSpectrum(PiecewiseLinearSpectrum(std::move(lambda), std::move(values)));
}

/// A column of a sensor's table, or null.
std::unique_ptr<Spectrum> SensorCurve(std::string_view name) {
    for (size_t c = 0; c < 3; ++c) {
        if (!name.ends_with(kColors[c])) continue;
        const std::string file = fmt::format("{}{}{}", kSensors, name.substr(0, name.size() - 2), kSuffix);
        if (HasEmbeddedData(file)) return std::make_unique<PiecewiseLinearSpectrum>(Tabulated(file, c + 1));
    }
    return nullptr;
}

constexpr size_t kMaxSpectrumFile = size_t(16) << 20;

}  // namespace

const DenselySampledSpectrum& CieX() {
    static const DenselySampledSpectrum x = ObserverColumn(1);
    return x;
}

const DenselySampledSpectrum& CieY() {
    static const DenselySampledSpectrum y = ObserverColumn(2);
    return y;
}

const DenselySampledSpectrum& CieZ() {
    static const DenselySampledSpectrum z = ObserverColumn(3);
    return z;
}

std::unique_ptr<Spectrum> NamedSpectrum(std::string_view name) {
    if (name == "cie-x") return std::make_unique<DenselySampledSpectrum>(CieX());
    if (name == "cie-y") return std::make_unique<DenselySampledSpectrum>(CieY());
    if (name == "cie-z") return std::make_unique<DenselySampledSpectrum>(CieZ());
    if (name == kDaylightComponents) return nullptr;
    for (const Folder& folder : kFolders) {
        const std::string file = fmt::format("{}{}{}", folder.path, name, kSuffix);
        if (HasEmbeddedData(file)) return folder.make(file);
    }
    return SensorCurve(name);
}

std::vector<std::string> NamedSpectra() {
    std::vector<std::string> names = {"cie-x", "cie-y", "cie-z"};
    for (const Folder& folder : kFolders)
        for (const std::string& file : EmbeddedNames(folder.path))
            if (file.ends_with(kSuffix)) names.push_back(file.substr(0, file.size() - kSuffix.size()));
    std::erase(names, kDaylightComponents);
    for (const std::string& file : EmbeddedNames(kSensors))
        for (const std::string_view color : kColors)
            names.push_back(file.substr(0, file.size() - kSuffix.size()) + std::string(color));
    return names;
}

std::unique_ptr<Spectrum> ReadSpectrumFile(const std::string& path) {
    const FileBytes file = ReadFileBytes(path, {}, {kMaxSpectrumFile});
    Words words(file.View(), path);
    std::vector<float> lambda, values;
    for (std::string_view word = words.Next(); !word.empty(); word = words.Next()) {
        const float nm = ParseNumber(word, words.Loc());
        if (nm <= 0) throw SceneError(words.Loc(), fmt::format("the wavelength {} is not positive", nm));
        if (!lambda.empty() && nm <= lambda.back())
            throw SceneError(words.Loc(),
                             fmt::format("wavelengths must increase, but {} follows {}", nm, lambda.back()));
        word = words.Next();
        if (word.empty())
            throw SceneError(words.Loc(), fmt::format("the file ends before the value at {} nm", nm));
        const float value = ParseNumber(word, words.Loc());
        if (value < 0)
            throw SceneError(words.Loc(), fmt::format("the value {} at {} nm is negative", value, nm));
        lambda.push_back(nm);
        values.push_back(value);
    }
    if (lambda.empty())
        throw SceneError({path, 0, 0}, "the spectrum file has no samples: no pairs of wavelength and value");
    return std::make_unique<PiecewiseLinearSpectrum>(std::move(lambda), std::move(values));
}

}  // namespace lacquer
