// What the inference knows of a model: parameters go in, summaries of a photograph or a measurement come out.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "estimate/linear_algebra.h"
#include "estimate/parameters.h"

namespace lacquer::estimate {

/// A run of a simulator that has kept what its gradient needs.
class DifferentiableRun {
  public:
    virtual ~DifferentiableRun() = default;
    virtual const Vector& Summaries() const = 0;
    /// Gradient with respect to the parameters, in natural units, of any function U of the summaries.
    /// @param adjoint  dU/dS at Summaries()
    virtual Vector Gradient(const Vector& adjoint) const = 0;
};

/// Summaries of one family, by their places among all of a simulator's.
struct FamilyRange {
    std::string name;
    Eigen::Index first, count;
};

/// A model with a photograph (or a measurement) and summaries of it. All functions are const, may be called
/// from several threads at once, and give the same bits for the same arguments.
class Simulator {
  public:
    virtual ~Simulator() = default;
    /// The free parameters.
    virtual const ParameterSpace& Parameters() const = 0;
    /// Names of the summaries, in the order of their values: "spectrum 8.0 cycles/cm".
    virtual const std::vector<std::string>& SummaryNames() const = 0;
    /// Summaries of one random realisation of the model.
    /// @param x     parameters in natural units
    /// @param seed  all of the randomness
    /// Always as many numbers as there are names; finite for all x inside of the bounds.
    virtual Vector Simulate(const Vector& x, uint64_t seed) const = 0;
    /// The same with what the reverse mode needs; null if the model has none. It has one for all arguments or
    /// for none.
    virtual std::unique_ptr<DifferentiableRun> SimulateForGradient(const Vector& /*x*/,
                                                                   uint64_t /*seed*/) const {
        return nullptr;
    }
};

}  // namespace lacquer::estimate
