// Phase function "table": numbers over the scattering angle, and over the wavelength.
//
//   "float table" []        required  values in any unit: at equal steps of the cosine from -1 (straight
//                                     back) to 1 (straight on), or
//   "float angles" []       -         at these angles, from 0 (straight on) to 180 [degrees]
//   "float wavelengths" []  -         the table has a row of values for each of them [nm]
//   "string tablefile"      -         in place of these three: see table_file.h
#include "pbrt/phases/table.h"

#include <fmt/format.h>

#include "pbrt/core/check.h"
#include "pbrt/phases/angular.h"
#include "pbrt/phases/table_file.h"

namespace lacquer {

PhaseTable::PhaseTable(std::span<const float> samples) : values(samples.begin(), samples.end()) {
    LACQUER_CHECK(samples.size() >= 2);
    for (float& value : values)
        if (!(value > 0) || !std::isfinite(value)) value = 0;

    // Trapezia are exact for what is linear between samples.
    const size_t last = values.size() - 1;
    double area = 0;
    std::vector<double> sums{0};
    for (size_t i = 0; i < last; ++i) {
        area += (double(values[i]) + double(values[i + 1])) / double(last);
        sums.push_back(area);
    }
    if (area == 0) {
        std::fill(values.begin(), values.end(), Inv4Pi);
        for (size_t i = 0; i <= last; ++i) cdf.push_back(float(i) / float(last));
        return;
    }
    for (float& value : values) value = float(double(value) / (2 * M_PI * area));
    for (const double sum : sums) cdf.push_back(float(sum / area));
}

TabulatedPhase::TabulatedPhase(std::span<const float> values, std::span<const float> cdf)
    : values_(values), cdf_(cdf) {
    LACQUER_CHECK(values.size() >= 2 && values.size() == cdf.size());
}

PhaseValue TabulatedPhase::Evaluate(Vec3 wo, Vec3 wi) const {
    const float last = float(values_.size() - 1);
    const float x = std::clamp(0.5f * (1 - Dot(wo, wi)) * last, 0.f, last);
    const size_t i = std::min(size_t(x), values_.size() - 2);
    return SymmetricPhase(Lerp(x - float(i), values_[i], values_[i + 1]));
}

PhaseSample TabulatedPhase::Sample(Vec3 wo, Rng& rng) const {
    // Find the segment, then the place in it.
    const Point2 u = rng.Uniform2D();
    const int n = int(cdf_.size());
    const size_t i = size_t(FindInterval(n, [&](int k) { return cdf_[size_t(k)] <= u.x; }));
    const float left = (u.x - cdf_[i]) / (cdf_[i + 1] - cdf_[i]);
    const float x =
        (float(i) + SampleLinear(std::min(left, OneMinusEpsilon), values_[i], values_[i + 1])) / float(n - 1);
    return PhaseRecord(*this, wo, AroundAxis(-wo, std::clamp(2 - 2 * x, 0.f, 2.f), u.y));
}

namespace {

/// The cosine at an angle less that at a larger one, without cancellation. @param a, b  [degrees]
double CosineRange(double a, double b) {
    constexpr double kHalf = M_PI / 360;
    return 2 * std::sin(kHalf * (a + b)) * std::sin(kHalf * (b - a));
}

/// What directions of floats can tell, with some margin [degrees]: their components have steps of 1e-7, and
/// 1 - cos as many bits as other floats.
double Resolution(double angle) {
    constexpr double kSteps = double(1e-4f), kStraightBack = 0.23, kBits = 0x1p-18 * 180 / M_PI;
    return std::clamp(kBits * std::tan(angle * (M_PI / 360)), kSteps, kStraightBack);
}

/// The light of a row up to an angle, as a part of all of it.
class RowLight {
  public:
    RowLight(const std::vector<float>& angles, std::span<const float> values)
        : angles_(angles), values_(values) {
        for (size_t i = 0; i + 1 < angles.size(); ++i)
            sums_.push_back(sums_.back() + Trapezium(i, double(angles[i + 1]), double(values[i + 1])));
    }
    double UpTo(double angle) const {
        if (angle <= 0) return 0;
        if (angle >= 180) return 1;
        const int n = int(angles_.size());
        const size_t i = size_t(FindInterval(n, [&](int k) { return double(angles_[size_t(k)]) <= angle; }));
        const double low = double(angles_[i]), v0 = double(values_[i]), v1 = double(values_[i + 1]);
        const double x = CosineRange(low, angle) / CosineRange(low, double(angles_[i + 1]));
        return (sums_[i] + Trapezium(i, angle, v0 + x * (v1 - v0))) / sums_.back();
    }

  private:
    double Trapezium(size_t i, double angle, double value) const {
        return (double(values_[i]) + value) * CosineRange(double(angles_[i]), angle);
    }
    const std::vector<float>& angles_;
    std::span<const float> values_;
    std::vector<double> sums_{0};
};

}  // namespace

std::string WhyTooNarrow(const PhaseNumbers& numbers) {
    constexpr double kMinShare = 0.01, kMinPart = 0.5;
    const std::vector<float>& angles = numbers.angles;
    for (size_t row = 0; row < numbers.NumRows(); ++row) {
        const RowLight light(angles, numbers.Row(row));
        for (size_t first = 0, last = 0; first + 1 < angles.size(); ++first) {
            const double from = double(angles[first]);
            last = std::max(last, first);
            while (last + 1 < angles.size() &&
                   double(angles[last + 1]) - from < Resolution(double(angles[last + 1])))
                ++last;
            // A peak of its own, and no part of a wider one.
            const double to = double(angles[last]), around = 2 * Resolution(to);
            const double share = light.UpTo(to) - light.UpTo(from);
            if (last == first || share < kMinShare ||
                share < kMinPart * (light.UpTo(to + around) - light.UpTo(from - around)))
                continue;
            const std::string where =
                numbers.wavelengths.empty() ? "" : fmt::format(" at {} nm", numbers.wavelengths[row]);
            return fmt::format(
                "{:.3g} % of the light{} is scattered between {} and {} degrees, which is narrower than "
                "directions can tell; expected at least {:.3g} degrees there",
                100 * share, where, angles[first], angles[last], Resolution(to));
        }
    }
    return {};
}

SpectralPhaseTable::SpectralPhaseTable(const PhaseNumbers& numbers) : wavelengths_(numbers.wavelengths) {
    LACQUER_CHECK(numbers.angles.size() >= 2 &&
                  numbers.values.size() == numbers.NumRows() * numbers.angles.size());
    for (const float angle : numbers.angles)
        nodes_.push_back(float(2 * Sqr(std::sin(double(angle) * (M_PI / 360)))));
    const size_t n = nodes_.size();
    for (size_t row = 0; row < numbers.NumRows(); ++row) {
        std::vector<double> values, sums{0};
        for (const float v : numbers.Row(row)) values.push_back(v > 0 && std::isfinite(v) ? double(v) : 0.);
        // Trapezia are exact for what is linear between nodes.
        const auto sumUp = [&] {
            for (size_t i = 0; i + 1 < n; ++i)
                sums.push_back(sums.back() + 0.5 * (values[i] + values[i + 1]) *
                                                 (double(nodes_[i + 1]) - double(nodes_[i])));
        };
        sumUp();
        if (sums.back() == 0) {
            values.assign(n, 1);
            sums.assign(1, 0);
            sumUp();
        }
        // More than any lobe has that directions resolve, and what narrower parts have stays finite.
        constexpr double kMaxValue = 1e15;
        for (const double v : values)
            values_.push_back(float(std::min(v / (2 * M_PI * sums.back()), kMaxValue)));
        for (const double sum : sums) cdf_.push_back(float(sum / sums.back()));
    }
    uint32_t node = 0;
    for (size_t k = 0; k < n; ++k) {
        while (node + 2 < n && nodes_[node + 1] <= 2 * Sqr(float(k) / float(n))) ++node;
        guide_.push_back(node);
    }
}

SpectralPhaseTable::Place SpectralPhaseTable::PlaceOf(float lambda) const {
    const int last = int(wavelengths_.size()) - 1;
    if (last <= 0 || !(lambda > wavelengths_.front())) return {};
    if (lambda >= wavelengths_.back()) return {last, 0};
    const int i = FindInterval(last + 1, [&](int k) { return wavelengths_[size_t(k)] <= lambda; });
    const float low = wavelengths_[size_t(i)], high = wavelengths_[size_t(i) + 1];
    return {i, (lambda - low) / (high - low)};
}

SpectralPhaseTable::Node SpectralPhaseTable::Find(float oneMinusCos) const {
    oneMinusCos = std::min(2.f, oneMinusCos);  // also where it is no number
    // Angles at equal steps are nearly at equal steps of the sine of their half: a step or two from here.
    const size_t steps = guide_.size();
    size_t i = guide_[std::min(size_t(std::sqrt(0.5f * oneMinusCos) * float(steps)), steps - 1)];
    while (i > 0 && nodes_[i] > oneMinusCos) --i;
    while (i + 2 < nodes_.size() && nodes_[i + 1] <= oneMinusCos) ++i;
    const float width = nodes_[i + 1] - nodes_[i];  // angles that differ may have one cosine
    return {i, width > 0 ? std::clamp((oneMinusCos - nodes_[i]) / width, 0.f, 1.f) : 1.f};
}

float SpectralPhaseTable::SampleRow(int row, float u) const {
    const int n = int(nodes_.size());
    const size_t first = size_t(row) * nodes_.size();
    const auto i = size_t(FindInterval(n, [&](int k) { return cdf_[first + size_t(k)] <= u; }));
    const float below = cdf_[first + i], above = cdf_[first + i + 1];
    const float left = std::min((u - below) / (above - below), OneMinusEpsilon);
    return Lerp(SampleLinear(left, values_[first + i], values_[first + i + 1]), nodes_[i], nodes_[i + 1]);
}

SpectralTabulatedPhase::SpectralTabulatedPhase(const SpectralPhaseTable& table,
                                               const SampledWavelengths& lambda)
    : table_(table) {
    for (int i = 0; i < kNumWavelengths; ++i) places_[size_t(i)] = table.PlaceOf(lambda[i]);
}

PhaseValue SpectralTabulatedPhase::Evaluate(Vec3 wo, Vec3 wi) const {
    return SymmetricPhase(table_.Value(places_[0], table_.Find(OneMinusCos(-wo, wi))));
}

PhaseSample SpectralTabulatedPhase::Sample(Vec3 wo, Rng& rng) const {
    return PhaseRecord(*this, wo, SampleAt(0, wo, rng));
}

SpectralPhaseValue SpectralTabulatedPhase::EvaluateSpectral(Vec3 wo, Vec3 wi) const {
    const SpectralPhaseTable::Node node = table_.Find(OneMinusCos(-wo, wi));
    SampledSpectrum p;
    for (int i = 0; i < kNumWavelengths; ++i) p.Set(i, table_.Value(places_[size_t(i)], node));
    return {p, p, p};
}

Vec3 SpectralTabulatedPhase::SampleAt(int wavelength, Vec3 wo, Rng& rng) const {
    const SpectralPhaseTable::Place& at = places_[size_t(wavelength)];
    const int row = at.weight > 0 && rng.Uniform() < at.weight ? at.row + 1 : at.row;
    const Point2 u = rng.Uniform2D();
    return AroundAxis(-wo, std::min(table_.SampleRow(row, u.x), 2.f), u.y);
}

namespace {

class TableModel final : public PhaseModel {
  public:
    explicit TableModel(std::span<const float> samples) : table_(samples) {}
    const PhaseFunction* Make(const PhaseContext&, Arena& arena) const override {
        return arena.New<TabulatedPhase>(table_);
    }

  private:
    PhaseTable table_;
};

class SpectralTableModel final : public PhaseModel {
  public:
    explicit SpectralTableModel(const PhaseNumbers& numbers) : table_(numbers) {}
    const PhaseFunction* Make(const PhaseContext& context, Arena& arena) const override {
        return arena.New<SpectralTabulatedPhase>(table_, context.lambda);
    }
    bool IsChromatic() const override { return table_.IsChromatic(); }

  private:
    SpectralPhaseTable table_;
};

void RequireIncreasing(const Params& params, const char* name, const std::vector<float>& values) {
    for (size_t i = 1; i < values.size(); ++i)
        if (!(values[i] > values[i - 1]))
            params.Fail(name, fmt::format("\"float {}\": {} stands after {}; expected increasing values",
                                          name, values[i], values[i - 1]));
}

/// The angles of n equal steps of the cosine, straight on first.
std::vector<float> AnglesOfEqualSteps(size_t n) {
    std::vector<float> angles;
    for (size_t i = 0; i < n; ++i)
        angles.push_back(float(std::acos(1 - 2 * double(i) / double(n - 1)) * (180 / M_PI)));
    return angles;
}

std::vector<float> ReadWavelengths(const Params& params) {
    std::vector<float> wavelengths = params.GetFloats("wavelengths");
    if (wavelengths.empty() && params.Has("wavelengths"))
        params.Fail("wavelengths",
                    "\"float wavelengths\" is empty; expected the wavelength of each row [nm]");
    if (!wavelengths.empty() && !(wavelengths[0] > 0))
        params.Fail("wavelengths", fmt::format("\"float wavelengths\": {} is not positive", wavelengths[0]));
    RequireIncreasing(params, "wavelengths", wavelengths);
    return wavelengths;
}

std::vector<float> ReadAngles(const Params& params) {
    std::vector<float> angles = params.GetFloats("angles");
    if (angles.empty() && !params.Has("angles")) return angles;
    if (angles.size() < 2 || angles.front() != 0 || angles.back() != 180)
        params.Fail("angles",
                    "\"float angles\" must begin with 0 (straight on) and end with 180 (straight "
                    "back) [degrees]");
    RequireIncreasing(params, "angles", angles);
    return angles;
}

/// Errors: SceneError at the table for what no phase function has.
void RequirePositiveRows(const Params& params, const PhaseNumbers& numbers) {
    for (size_t row = 0; row < numbers.NumRows(); ++row) {
        float largest = 0;
        for (const float value : numbers.Row(row)) {
            if (value < 0) params.Fail("table", fmt::format("\"float table\": {} is negative", value));
            largest = std::max(largest, value);
        }
        if (largest > 0) continue;
        const std::string where =
            numbers.wavelengths.empty() ? "" : fmt::format(" at {} nm", numbers.wavelengths[row]);
        params.Fail("table",
                    fmt::format("\"float table\" is 0 everywhere{}; light must go somewhere", where));
    }
}

/// The table in the scene itself.
std::unique_ptr<PhaseModel> ReadInline(const Params& params) {
    PhaseNumbers numbers{ReadWavelengths(params), ReadAngles(params), params.GetFloats("table")};
    const size_t count = numbers.values.size(), rows = numbers.NumRows();
    const bool isByCosine = numbers.angles.empty();
    if (rows == 1 && isByCosine && count < 2)
        params.Fail("table", fmt::format("\"float table\" has {} values; expected two or more, from the "
                                         "cosine -1 (straight back) to 1 (straight on)",
                                         count));
    if (isByCosine) {
        if (count < 2 * rows || count % rows != 0)
            params.Fail("table", fmt::format("\"float table\" has {} values; expected as many, two or more, "
                                             "for each of {} wavelengths",
                                             count, rows));
        numbers.angles = AnglesOfEqualSteps(count / rows);
    } else if (count != rows * numbers.angles.size()) {
        params.Fail("table", fmt::format("\"float table\" has {} values; expected {}, one for each of {} "
                                         "angles at {} wavelength{}",
                                         count, rows * numbers.angles.size(), numbers.angles.size(), rows,
                                         rows == 1 ? "" : "s"));
    }
    RequirePositiveRows(params, numbers);
    if (isByCosine && rows == 1) return std::make_unique<TableModel>(numbers.values);
    // Rows over the cosine begin straight back.
    if (isByCosine)
        for (size_t row = 0; row < rows; ++row) {
            const auto first = numbers.values.begin() + std::ptrdiff_t(row * numbers.angles.size());
            std::reverse(first, first + std::ptrdiff_t(numbers.angles.size()));
        }
    if (const std::string why = WhyTooNarrow(numbers); !why.empty())
        params.Fail("table", "\"float table\": " + why);
    return std::make_unique<SpectralTableModel>(numbers);
}

std::unique_ptr<PhaseModel> Create(const PhaseArgs& args) {
    const Params& params = args.params;
    const std::optional<std::string> file = params.GetOptionalString("tablefile");
    if (!file) return ReadInline(params);
    for (const char* other : {"table", "angles", "wavelengths"})
        if (params.Has(other))
            params.Fail(other, fmt::format("\"{}\" is given beside \"tablefile\", which says it as well; "
                                           "remove one of them",
                                           other));
    return std::make_unique<SpectralTableModel>(
        ReadPhaseTableFile(params.PathOf("tablefile"), params.LocOf("tablefile")));
}

constexpr std::string_view kParameters[] = {"table", "angles", "wavelengths", "tablefile"};
constexpr PhasePlugin kPlugin{Create, kParameters};

}  // namespace

LACQUER_REGISTER(PhaseKind, "table", &kPlugin);

}  // namespace lacquer
