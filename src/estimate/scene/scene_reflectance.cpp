#include "estimate/scene/scene_reflectance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "measure/bsdf_survey.h"
#include "measure/scene_material.h"
#include "pbrt/base/bxdf_numbers.h"
#include "pbrt/samplers/padded_sobol.h"

namespace lacquer::estimate {

namespace {

constexpr int kSets = measure::BsdfSubject::kNumSets;
/// Independent parts of each estimate, which its error is found from.
constexpr int kParts = 4;

/// Mean of one set of wavelengths in one part of the samples.
SampledSpectrum MeanOf(const BxDF& bxdf, Vec3 wo, Vec3 wi, Sampler* sampler, Int2 pixel, int numSamples,
                       uint64_t seed) {
    SampledSpectrum sum(0.f);
    for (int i = 0; i < numSamples; ++i) {
        sampler->StartPixelSample(pixel, i);
        Rng rng(Hash(seed, pixel.x, pixel.y, i));
        BxDFDimensions dimensions(*sampler);
        dimensions.StartVertex(0);
        const BxDFContext context{.rng = &rng, .needsPdf = false, .dimensions = &dimensions};
        sum += bxdf.Evaluate(wo, wi, context).f;
    }
    return sum / float(numSamples);
}

}  // namespace

/// A material with its numbers, for colours or for single wavelengths.
struct SceneReflectance::Subject {
    MaterialSetup setup;
    std::unique_ptr<const measure::BsdfSubject> colors;
    Arena arena;
    std::vector<const BxDF*> atWavelengths;  ///< one for each direction

    Subject(const SceneReflectance& of, const Vector& x) {
        setup = BuildMaterial(of.parameters_.With(x), of.parameters_.Material(), of.options_.build, nullptr);
        colors = std::make_unique<measure::BsdfSubject>(*setup.material, Point2(0.5f), setup.entity.loc,
                                                        of.isStochastic_);
        TextureContext context;
        context.uv = Point2(0.5f);
        context.n = {0, 0, 1};
        for (const double wavelength : of.wavelengths_) {
            SampledWavelengths lambda =
                SampledWavelengths::SampleUniform(0, float(wavelength), float(wavelength));
            atWavelengths.push_back(setup.material->MakeBxDF(context, lambda, arena));
        }
    }

    /// The channels of one direction, in one part of the samples.
    glm::dvec3 Value(size_t row, Vec3 wo, Vec3 wi, int numSamples, uint64_t seed) const {
        PaddedSobolSampler sampler(numSamples, Randomization::FastOwen, int(seed >> 33));
        if (!atWavelengths.empty()) {
            const SampledSpectrum f =
                MeanOf(*atWavelengths[row], wo, wi, &sampler, Int2(int(row), 0), numSamples, seed);
            return glm::dvec3(double(f.Sum()) / kNumWavelengths);
        }
        glm::dvec3 value(0);
        const int sets = kSets * colors->NumVariants();
        for (int set = 0; set < sets; ++set) {
            const SampledSpectrum f =
                MeanOf(colors->At(set), wo, wi, &sampler, Int2(int(row), set), numSamples, seed);
            value += glm::dvec3(colors->ToRGB(f, set)) / double(sets);
        }
        return value;
    }
};

SceneReflectance::SceneReflectance(const SceneParameters& parameters, std::vector<DirectionAngles> directions,
                                   std::vector<double> wavelengths, const Options& options)
    : parameters_(parameters),
      directions_(std::move(directions)),
      wavelengths_(std::move(wavelengths)),
      options_(options) {
    NameSummaries();
    ChooseSamples(options);
}

void SceneReflectance::NameSummaries() {
    std::vector<std::string> errors;
    for (size_t i = 0; i < directions_.size(); ++i)
        for (const char* channel : {"r", "g", "b"}) {
            const std::string which =
                wavelengths_.empty() ? std::string(channel) : fmt::format("{:g} nm", wavelengths_[i]);
            names_.push_back(fmt::format("{} at {}", which, directions_[i].ToString()));
            errors.push_back("error of " + names_.back());
            if (!wavelengths_.empty()) break;
        }
    names_.insert(names_.end(), errors.begin(), errors.end());
}

void SceneReflectance::ChooseSamples(const Options& options) {
    constexpr int kPilotSamples = 32, kPilotPoints = 6;
    samples_.assign(directions_.size(), kPilotSamples);
    const Eigen::Index m = NumValues(), channels = m / Eigen::Index(directions_.size());
    Matrix errors(m, kPilotPoints + 1);
    isExact_ = true;
    for (int k = 0; k <= kPilotPoints; ++k) {
        Random random(options.seed, uint64_t(0x70696c6f74), k);
        const Vector x = k == 0 ? parameters_.Start() : Parameters().SamplePrior(random);
        isExact_ &= !Subject(*this, x).colors->IsStochastic();
        if (isExact_) continue;
        const Vector values = Measure(x, random.Bits(), 1);
        const double floor = 1e-3 * values.head(m).maxCoeff();
        errors.col(k) = values.tail(m).array() / (values.head(m).array() + floor);
    }
    if (isExact_) {
        samples_.assign(directions_.size(), 1);
        isStochastic_ = false;
        return;
    }
    // Some parameters may have a closed form where others have none: one sample would do for them.
    isStochastic_ = true;
    for (size_t row = 0; row < directions_.size(); ++row) {
        std::vector<double> ofRow;
        for (const double e : errors.middleRows(Eigen::Index(row) * channels, channels).reshaped())
            if (std::isfinite(e)) ofRow.push_back(e);
        std::sort(ofRow.begin(), ofRow.end());
        const double typical = ofRow.empty() ? 1 : ofRow[ofRow.size() * 3 / 4];
        const double wanted =
            kPilotSamples * (typical / options.targetError) * (typical / options.targetError);
        int count = 2 * kParts;
        while (count < options.maxSamples && count < wanted) count *= 2;
        samples_[row] = count;
    }
}

Vector SceneReflectance::Measure(const Vector& x, uint64_t seed, int times) const {
    const Subject subject(*this, x);
    const Eigen::Index m = NumValues(), channels = m / Eigen::Index(directions_.size());
    Vector result = Vector::Zero(2 * m);
    const bool isRandom = !isExact_ && subject.colors->IsStochastic();
    const int parts = isRandom ? kParts : 1;
    for (size_t row = 0; row < directions_.size(); ++row) {
        const DirectionAngles& d = directions_[row];
        const Vec3 wi = measure::DirectionAt(d.thetaI, d.phiI), wo = measure::DirectionAt(d.thetaO, d.phiO);
        const int numSamples = isRandom ? samples_[row] * times / kParts : 1;
        glm::dvec3 sum(0), squares(0);
        for (int part = 0; part < parts; ++part) {
            const glm::dvec3 value = subject.Value(row, wo, wi, numSamples, Hash(seed, uint64_t(row), part));
            sum += value;
            squares += value * value;
        }
        for (Eigen::Index c = 0; c < channels; ++c) {
            const Eigen::Index i = Eigen::Index(row) * channels + c;
            const double mean = sum[int(c)] / parts;
            result[i] = std::max(mean, 0.);
            if (isRandom)
                result[m + i] = std::sqrt(std::max(0., squares[int(c)] / parts - mean * mean) / (parts - 1));
        }
    }
    return result;
}

SceneReflectance SceneReflectance::At(std::vector<DirectionAngles> directions) const {
    return SceneReflectance(parameters_, std::move(directions), {}, options_);
}

Measurement MeasureMaterial(const SceneDescription& scene, const std::string& material,
                            const std::vector<DirectionAngles>& directions, uint64_t seed) {
    constexpr int kMore = 4;
    const SceneParameters none(scene, material, {}, {});
    const SceneReflectance reflectance(none, directions, {}, {.targetError = 0.01, .seed = seed});
    const Vector values = reflectance.Measure(Vector(), seed, kMore);
    const Eigen::Index m = reflectance.NumValues(), rows = Eigen::Index(directions.size());
    Measurement measured{directions,
                         {},
                         values.head(m).reshaped(3, rows).transpose(),
                         values.tail(m).reshaped(3, rows).transpose()};
    return measured;
}

}  // namespace lacquer::estimate
