#include "measure/color_survey.h"

#include <cmath>
#include <numbers>

#include "measure/bsdf_survey.h"
#include "pbrt/core/color_space.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/sampling.h"

namespace lacquer::measure {

namespace {

constexpr double kRadians = std::numbers::pi / 180;

/// "stdillum-D50" is not D50: it is what the scene format means by this name.
std::unique_ptr<Spectrum> IlluminantOf(size_t index) {
    const std::string name = kIlluminants[index];
    if (name == "D50") return DaylightSpectrum(5000);
    return NamedSpectrum("stdillum-" + name);
}

/// What turns reflectances at some wavelengths into tristimulus values under an illuminant.
class Observer1931 {
  public:
    Observer1931(const Spectrum& illuminant, const std::vector<float>& wavelengths) {
        double sum = 0;
        for (const float lambda : wavelengths) {
            const auto power = double(illuminant.Evaluate(lambda));
            weights_.push_back(power * glm::dvec3(CieX().Evaluate(lambda), CieY().Evaluate(lambda),
                                                  CieZ().Evaluate(lambda)));
            sum += weights_.back().y;
        }
        for (glm::dvec3& w : weights_) w *= 100 / sum;
    }
    glm::dvec3 XYZOf(const std::vector<double>& reflectance) const {
        glm::dvec3 xyz(0);
        for (size_t i = 0; i < weights_.size(); ++i) xyz += reflectance[i] * weights_[i];
        return xyz;
    }

  private:
    std::vector<glm::dvec3> weights_;
};

/// White under each illuminant: of the finest steps, since those of 5 nm are as good.
glm::dvec3 WhiteOf(size_t illuminant) {
    static const std::array<glm::dvec3, kIlluminants.size()> whites = [] {
        const std::vector<float> fine = ColorWavelengths(false);
        const std::vector<double> one(fine.size(), 1);
        std::array<glm::dvec3, kIlluminants.size()> w;
        for (size_t i = 0; i < w.size(); ++i) w[i] = Observer1931(*IlluminantOf(i), fine).XYZOf(one);
        return w;
    }();
    return whites[illuminant];
}

/// Three numbers for sample `index` of a part: an additive recurrence from a random start [Roberts 2018].
BxDFRandom SpreadNumbers(Rng start, int64_t index) {
    // Powers of the inverse of the root of x^4 = x + 1.
    constexpr double a = 0.8191725133961644;
    const auto at = [&](double step) {
        const double x = double(start.Uniform()) + double(index) * step;
        return float(x - std::floor(x)) * 0x1.fffffep-1f;
    };
    const float lobe = at(a), u = at(a * a);
    return {lobe, {u, at(a * a * a)}};
}

/// Reflectances of one geometry at all wavelengths, added up over samples.
class GeometrySum {
  public:
    GeometrySum(const SpectralSubject& subject, const ColorGeometry& geometry, double azimuthDeg)
        : s_(subject), g_(geometry), azimuthDeg_(azimuthDeg), sum_(subject.NumWavelengths()) {}

    /// @param index  of a sample among the `count` ones of its part
    /// @param part   random numbers that these share
    void Add(int64_t sample, int64_t index, int64_t count, const Rng& part, const Rng& rng) {
        if (g_.kind == ColorGeometry::Kind::Diffuse)
            AddFromHemisphere(sample, SpreadNumbers(part, index), rng);
        else
            AddFromOneAngle(sample, index, count, rng);
    }
    std::vector<double> Mean(int64_t count) const {
        std::vector<double> mean = sum_;
        for (double& m : mean) m /= double(count);
        return mean;
    }

  private:
    void AddFromOneAngle(int64_t sample, int64_t index, int64_t count, Rng rng) {
        const bool isRing = g_.kind == ColorGeometry::Kind::Annular;
        const double around = isRing ? 360 * (double(index) + double(rng.Uniform())) / double(count) : 0;
        const Vec3 light = DirectionAt(g_.lightDeg, azimuthDeg_ + around);
        const Vec3 detector = DirectionAt(g_.detectorDeg, azimuthDeg_);
        s_.EvaluateOnce(sample, detector, light, TransportMode::Radiance, rng,
                        [&](SampledSpectrum f, size_t first, size_t n) { Take(Pi * f, first, n); });
    }
    /// The light that the detector sees comes from where a path from it goes.
    void AddFromHemisphere(int64_t sample, const BxDFRandom& u, const Rng& rng) {
        const Vec3 detector = DirectionAt(g_.detectorDeg, azimuthDeg_);
        const Vec3 mirror(-detector.x, -detector.y, detector.z);
        s_.SampleOnce(sample, detector, u, TransportMode::Radiance, rng,
                      [&](const BxDFSample& drawn, size_t first, size_t n) {
                          const bool isTrapped = g_.hasGlossTrap && double(Dot(drawn.wi, mirror)) >
                                                                        std::cos(kTrapDeg * kRadians);
                          if (drawn.wi.z > 0 && !isTrapped) Take(drawn.weight, first, n);
                      });
    }
    template <class Value>
    void Take(const Value& value, size_t first, size_t count) {
        for (size_t lane = 0; lane < count; ++lane) {
            const auto v = double(value[int(lane)]);
            if (std::isfinite(v)) sum_[first + lane] += v;
        }
    }

    const SpectralSubject& s_;
    const ColorGeometry& g_;
    double azimuthDeg_;
    std::vector<double> sum_;
};

glm::dvec3 MeanOf(const ColorSurvey::Parts& parts) {
    glm::dvec3 sum(0);
    for (const glm::dvec3& p : parts) sum += p;
    return sum / double(parts.size());
}
/// The mean without each of the parts in turn.
ColorSurvey::Parts WithoutOne(const ColorSurvey::Parts& parts) {
    const glm::dvec3 sum = MeanOf(parts) * double(parts.size());
    ColorSurvey::Parts without;
    for (size_t i = 0; i < parts.size(); ++i) without[i] = (sum - parts[i]) / double(parts.size() - 1);
    return without;
}
/// Standard error of function(mean) by the jackknife. @param full  its value
template <class Function>
double JackknifeError(const ColorSurvey::Parts& parts, double full, const Function& function) {
    double sum = 0;
    for (const glm::dvec3& xyz : WithoutOne(parts)) sum += Sqr(function(xyz) - full);
    return std::sqrt(sum * double(parts.size() - 1) / double(parts.size()));
}
template <class Function>
Uncertain WithError(const ColorSurvey::Parts& parts, const Function& function) {
    const double value = function(MeanOf(parts));
    return {value, JackknifeError(parts, value, function)};
}
/// Of two hues [degrees], by how much the first is farther round, in [-180, 180).
double HueFrom(double hue, double reference) {
    return hue - reference - 360 * std::floor((hue - reference + 180) / 360);
}

}  // namespace

const std::vector<ColorGeometry>& ColorGeometries() {
    using Kind = ColorGeometry::Kind;
    static const std::vector<ColorGeometry> geometries = {
        {"45:0", Kind::Annular, 45, 0},         {"di:8", Kind::Diffuse, 0, 8},
        {"de:8", Kind::Diffuse, 0, 8, true},    {"45as15", Kind::Directional, 45, -30},
        {"45as25", Kind::Directional, 45, -20}, {"45as45", Kind::Directional, 45, 0},
        {"45as75", Kind::Directional, 45, 30},  {"45as110", Kind::Directional, 45, 65},
    };
    return geometries;
}

std::vector<float> ColorWavelengths(bool isStochastic) {
    std::vector<float> wavelengths;
    for (int lambda = int(kLambdaMin); lambda <= int(kLambdaMax); lambda += isStochastic ? 5 : 1)
        wavelengths.push_back(float(lambda));
    return wavelengths;
}

ColorReading ColorSurvey::At(size_t geometry, size_t illuminant) const {
    const Parts& parts = xyz_[geometry][illuminant];
    const glm::dvec3 white = WhiteOf(illuminant);
    const auto of = [&](const auto& function) {
        return WithError(parts, [&](glm::dvec3 xyz) { return function(LabOf(xyz, white)); });
    };
    ColorReading r;
    for (int i = 0; i < 3; ++i) r.xyz[size_t(i)] = WithError(parts, [i](glm::dvec3 xyz) { return xyz[i]; });
    r.L = of([](const Lab& c) { return c.L; });
    r.a = of([](const Lab& c) { return c.a; });
    r.b = of([](const Lab& c) { return c.b; });
    r.chroma = of([](const Lab& c) { return c.Chroma(); });
    // Hues go around: errors are those of the way from the mean's.
    const double hue = LabOf(MeanOf(parts), white).HueDegrees();
    r.hueDeg = {hue, of([&](const Lab& c) { return HueFrom(c.HueDegrees(), hue); }).error};
    return r;
}

Uncertain ColorSurvey::Difference(const ColorSurvey& a, const ColorSurvey& b, size_t geometry,
                                  size_t illuminant) {
    const Parts &p = a.xyz_[geometry][illuminant], &q = b.xyz_[geometry][illuminant];
    const glm::dvec3 white = WhiteOf(illuminant);
    const Lab meanA = LabOf(MeanOf(p), white), meanB = LabOf(MeanOf(q), white);
    const double value = DeltaE2000(meanA, meanB);
    const double errorA =
        JackknifeError(p, value, [&](glm::dvec3 xyz) { return DeltaE2000(LabOf(xyz, white), meanB); });
    const double errorB =
        JackknifeError(q, value, [&](glm::dvec3 xyz) { return DeltaE2000(meanA, LabOf(xyz, white)); });
    return {value, std::hypot(errorA, errorB)};
}

ColorSurvey SurveyColors(const SpectralSubject& subject, const std::vector<float>& wavelengths,
                         const ColorSurveyOptions& options, Observer* observer) {
    const std::vector<ColorGeometry>& geometries = ColorGeometries();
    std::vector<Observer1931> observers;
    for (size_t i = 0; i < kIlluminants.size(); ++i) observers.emplace_back(*IlluminantOf(i), wavelengths);
    const int64_t count = std::max(1, options.samples / ColorSurvey::kParts);
    std::vector<std::array<ColorSurvey::Parts, kIlluminants.size()>> xyz(geometries.size());
    if (observer) observer->Begin("Colours", int64_t(geometries.size()) * ColorSurvey::kParts, "");
    ParallelFor(int64_t(geometries.size()) * ColorSurvey::kParts, [&](int64_t job) {
        const auto g = size_t(job) / ColorSurvey::kParts, part = size_t(job) % ColorSurvey::kParts;
        GeometrySum sum(subject, geometries[g], options.azimuthDeg);
        const Rng start(Hash(options.seed, job));
        for (int64_t i = 0; i < count; ++i)
            sum.Add(int64_t(part) * count + i, i, count, start, Rng(Hash(options.seed, job, i)));
        const std::vector<double> reflectance = sum.Mean(count);
        for (size_t k = 0; k < kIlluminants.size(); ++k) xyz[g][k][part] = observers[k].XYZOf(reflectance);
        if (observer) observer->Advance(1);
    });
    if (observer) observer->End();
    return ColorSurvey(std::move(xyz));
}

}  // namespace lacquer::measure
