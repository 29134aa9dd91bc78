// Posterior densities of the parameters of layers.
#pragma once

#include <memory>

#include "estimate/infer/target.h"
#include "estimate/layered/lobe_coordinates.h"
#include "estimate/layered/lobe_data.h"
#include "estimate/layered/lobe_emulator.h"
#include "estimate/layered/lobe_likelihood.h"
#include "estimate/simulator.h"

namespace lacquer::estimate {

/// Name of the parameter that is added to those of a model: relative noise of the measurement, with a
/// half-normal prior of deviation 0.1.
inline constexpr const char* kNoiseName = "noise";
inline constexpr Prior kNoisePrior = {0, 0.1, 1e-3, 1};
/// A model's parameters and the noise, which is the last one.
ParameterSpace WithNoise(const ParameterSpace& ofModel, const Prior& ofNoise = kNoisePrior);

/// Where simulations lie, in an emulator's coordinates. Beyond them an emulator says nothing.
class SimulatedRegion {
  public:
    SimulatedRegion() = default;
    /// @param points  a column for each simulation; more of them than rows
    explicit SimulatedRegion(const Matrix& points);
    /// Logarithm of a density that is 1 among the simulations and falls off outside, with its gradient.
    double Log(const Vector& point, Vector* gradient) const;
    double SquaredDistance(const Vector& point) const {
        return (whitening_ * (point - center_)).squaredNorm();
    }
    double SquaredRadius() const { return squaredRadius_; }

  private:
    Vector center_;
    Matrix whitening_;
    double squaredRadius_ = 0;
};

/// Posterior density of logits by an emulator.
class LobeTarget final : public Target {
  public:
    /// @param space  WithNoise(); outlives the object, as do the coordinates
    /// @param errorScale  of the emulator's error: 1, unless a test wants it wrong
    LobeTarget(const ParameterSpace& space, const LobeCoordinates& coordinates,
               std::shared_ptr<const LobeEmulator> emulator, const Vector& variances,
               const ObservedLobes& observed, SimulatedRegion region, bool isRobust, double errorScale = 1);
    Eigen::Index Size() const override { return Eigen::Index(space_.Size()); }
    double LogDensity(const Vector& y, Vector* gradient) const override;
    /// Logarithms of the predicted values. @param x  natural units
    Vector Predict(const Vector& x) const { return emulator_->Predict(coordinates_.FromNatural(x)); }
    double Misfit(const Vector& x) const { return likelihood_.Misfit(Predict(x), x[x.size() - 1]); }
    const LobeEmulator& Emulator() const { return *emulator_; }

  private:
    const ParameterSpace& space_;
    const LobeCoordinates& coordinates_;
    std::shared_ptr<const LobeEmulator> emulator_;
    LobeLikelihood likelihood_;
    SimulatedRegion region_;
};

/// The same by a model that has no noise. Its derivatives are differences, or those of an emulator, which HMC
/// takes as well: chains keep the density that they accept by, whatever they are led by.
class ExactLobeTarget final : public Target {
  public:
    /// @param simulator  whose errors are all zero; outlives the object, as does the space, WithNoise()
    ExactLobeTarget(const Simulator& simulator, const ParameterSpace& space, const ObservedLobes& observed,
                    bool isRobust, const Target* guide = nullptr);
    Eigen::Index Size() const override { return Eigen::Index(space_.Size()); }
    double LogDensity(const Vector& y, Vector* gradient) const override;
    Vector Predict(const Vector& x) const;
    double Misfit(const Vector& x) const { return likelihood_.Misfit(Predict(x), x[x.size() - 1]); }

  private:
    const Simulator& simulator_;
    const ParameterSpace& space_;
    LobeLikelihood likelihood_;
    double floor_;
    const Target* guide_;
};

}  // namespace lacquer::estimate
