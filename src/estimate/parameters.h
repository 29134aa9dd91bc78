// What is estimated: named parameters with priors, and the transform that lets samplers move without bounds.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "estimate/linear_algebra.h"
#include "estimate/normal_distribution.h"
#include "estimate/random.h"

namespace lacquer::estimate {

/// What is believed of a parameter before the data: normal, cut to [low, high].
using Prior = TruncatedNormal;

/// A continuous parameter.
struct Parameter {
    std::string name;
    std::string unit;  ///< "cm", "cycles/cm"; empty if it has none
    Prior prior;
    /// Summaries change smoothly with it. Where they do not (maps that are stretched or moved, say), samplers
    /// must not rely on gradients.
    bool smooth = true;
    /// Name of a parameter by which this one is multiplied in what is observed, so that the product is known
    /// better than either: light and albedo. Both are positive. Empty: there is none.
    std::string productWith = {};
};

/// A list of parameters. A point has natural units (x, inside of the bounds), or is the logit of its place
/// between the bounds (y, any real numbers): y = log((x - low) / (high - x)). Chains and emulators work in y,
/// where the prior has the Jacobian of the transform; the mode that users expect is that in x, without it.
class ParameterSpace {
  public:
    /// Errors: std::invalid_argument with the parameter's name, if a name is empty or there twice, sd is not
    /// positive, low is not below high, or a number is not finite.
    explicit ParameterSpace(std::vector<Parameter> parameters);

    size_t Size() const { return parameters_.size(); }
    const Parameter& operator[](size_t i) const { return parameters_[i]; }
    const std::vector<Parameter>& All() const { return parameters_; }
    std::vector<std::string> Names() const;
    /// Place of a name.
    std::optional<size_t> Find(const std::string& name) const;

    /// Nearer to a bound than this part of the range, starts are moved inside.
    static constexpr double kMargin = 1e-6;
    Vector ToNatural(const Vector& y) const;
    /// The inverse; points nearer to a bound than kMargin are moved.
    Vector ToLogit(const Vector& x) const;
    /// dx/dy for each parameter: gradients in x times this are gradients in y.
    Vector Slopes(const Vector& y) const;

    /// Logarithm of the prior's density with respect to x, up to a constant of the space.
    /// @param gradient  d/dx if not null
    double LogPrior(const Vector& x, Vector* gradient = nullptr) const;
    /// The same with respect to y: with the Jacobian dx/dy, up to a constant. Finite for all finite y.
    /// @param gradient  d/dy if not null
    double LogPriorOfLogit(const Vector& y, Vector* gradient = nullptr) const;

    /// An exact draw of the prior, in natural units, by the inverse of its distribution function.
    Vector SamplePrior(Random& random) const;

  private:
    std::vector<Parameter> parameters_;
};

}  // namespace lacquer::estimate
