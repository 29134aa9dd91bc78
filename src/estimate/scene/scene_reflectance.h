// What a goniometer would measure of a material of a scene.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "estimate/layered/measurement.h"
#include "estimate/scene/scene_parameters.h"
#include "estimate/simulator.h"
#include "pbrt/scene/builder.h"

namespace lacquer::estimate {

/// Reflectances of a material with free parameters at pairs of directions. The summaries are the values
/// [1/sr] in the order of Measurement::Flat(), then their standard errors (0 where the material has a closed
/// form). Each direction takes as many samples as its noise needs. The random numbers of a sample belong to
/// (seed, direction, wavelengths, sample): estimates at other parameters with one seed are common random
/// numbers.
class SceneReflectance final : public Simulator {
  public:
    struct Options {
        /// Relative error of a value that one simulation should have; what needs more than maxSamples samples
        /// at each set of wavelengths to come there has more.
        double targetError = 0.04;
        int maxSamples = 256;
        uint64_t seed = 1;  ///< of the pilot runs that the samples are chosen by
        BuildOptions build = {};
    };
    /// @param parameters   outlives the object
    /// @param wavelengths  one for each direction [nm]; empty: values are linear sRGB
    /// Errors: those of BuildMaterial() and BsdfSubject.
    SceneReflectance(const SceneParameters& parameters, std::vector<DirectionAngles> directions,
                     std::vector<double> wavelengths, const Options& options);

    const ParameterSpace& Parameters() const override { return parameters_.Space(); }
    const std::vector<std::string>& SummaryNames() const override { return names_; }
    Vector Simulate(const Vector& x, uint64_t seed) const override { return Measure(x, seed, 1); }
    /// With `times` as many samples.
    Vector Measure(const Vector& x, uint64_t seed, int times) const;
    Eigen::Index NumValues() const { return Eigen::Index(names_.size() / 2); }
    /// True if the material has a closed form: no noise.
    bool IsExact() const { return isExact_; }
    const std::vector<DirectionAngles>& Directions() const { return directions_; }
    /// Samples at each set of wavelengths, for each direction.
    const std::vector<int>& Samples() const { return samples_; }
    /// The same material at other directions.
    SceneReflectance At(std::vector<DirectionAngles> directions) const;

  private:
    struct Subject;
    void NameSummaries();
    void ChooseSamples(const Options& options);

    const SceneParameters& parameters_;
    std::vector<DirectionAngles> directions_;
    std::vector<double> wavelengths_;
    Options options_;
    std::vector<std::string> names_;
    std::vector<int> samples_;
    std::optional<bool> isStochastic_;  ///< before it is known: empty
    bool isExact_ = false;
};

/// Values of a material of any scene as a measurement: what is not random, or by many samples.
/// Errors: as of SceneReflectance.
Measurement MeasureMaterial(const SceneDescription& scene, const std::string& material,
                            const std::vector<DirectionAngles>& directions, uint64_t seed);

}  // namespace lacquer::estimate
