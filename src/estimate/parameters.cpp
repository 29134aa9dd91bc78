#include "estimate/parameters.h"

#include <cmath>
#include <set>
#include <stdexcept>

namespace lacquer::estimate {

namespace {

void Check(const Parameter& p) {
    const auto fail = [&](const std::string& problem) {
        throw std::invalid_argument(fmt::format("parameter \"{}\": {}", p.name, problem));
    };
    const Prior& d = p.prior;
    if (p.name.empty()) fail("has no name");
    for (const double number : {d.mean, d.sd, d.low, d.high})
        if (!std::isfinite(number)) fail("the prior's mean, deviation and bounds must be finite");
    if (d.sd <= 0) fail(fmt::format("the prior's deviation is {}, must be positive", d.sd));
    if (d.low >= d.high) fail(fmt::format("the lower bound {} is not below the upper one {}", d.low, d.high));
    if (d.Mass() <= 0) fail(fmt::format("the prior has no mass between {} and {}", d.low, d.high));
}

double Sigmoid(double y) {
    const double e = std::exp(-std::abs(y));
    return y >= 0 ? 1 / (1 + e) : e / (1 + e);
}

/// log(s(y) (1 - s(y))), without overflow.
double LogSigmoidSlope(double y) { return -std::abs(y) - 2 * std::log1p(std::exp(-std::abs(y))); }

}  // namespace

ParameterSpace::ParameterSpace(std::vector<Parameter> parameters) : parameters_(std::move(parameters)) {
    std::set<std::string> names;
    for (const Parameter& p : parameters_) {
        Check(p);
        if (!names.insert(p.name).second)
            throw std::invalid_argument(fmt::format("parameter \"{}\" is there twice", p.name));
    }
}

std::vector<std::string> ParameterSpace::Names() const {
    std::vector<std::string> names;
    for (const Parameter& p : parameters_) names.push_back(p.name);
    return names;
}

std::optional<size_t> ParameterSpace::Find(const std::string& name) const {
    for (size_t i = 0; i < Size(); ++i)
        if (parameters_[i].name == name) return i;
    return std::nullopt;
}

Vector ParameterSpace::ToNatural(const Vector& y) const {
    Vector x(y.size());
    for (Eigen::Index i = 0; i < y.size(); ++i) {
        const Prior& d = parameters_[size_t(i)].prior;
        // From the nearer end, so that no digits are lost there.
        x[i] =
            y[i] < 0 ? d.low + (d.high - d.low) * Sigmoid(y[i]) : d.high - (d.high - d.low) * Sigmoid(-y[i]);
    }
    return x;
}

Vector ParameterSpace::ToLogit(const Vector& x) const {
    Vector y(x.size());
    for (Eigen::Index i = 0; i < x.size(); ++i) {
        const Prior& d = parameters_[size_t(i)].prior;
        const double u = std::clamp((x[i] - d.low) / (d.high - d.low), kMargin, 1 - kMargin);
        y[i] = std::log(u / (1 - u));
    }
    return y;
}

Vector ParameterSpace::Slopes(const Vector& y) const {
    Vector slopes(y.size());
    for (Eigen::Index i = 0; i < y.size(); ++i) {
        const Prior& d = parameters_[size_t(i)].prior;
        slopes[i] = (d.high - d.low) * Sigmoid(y[i]) * Sigmoid(-y[i]);
    }
    return slopes;
}

double ParameterSpace::LogPrior(const Vector& x, Vector* gradient) const {
    double sum = 0;
    if (gradient) gradient->resize(x.size());
    for (Eigen::Index i = 0; i < x.size(); ++i) {
        const Prior& d = parameters_[size_t(i)].prior;
        const double z = (x[i] - d.mean) / d.sd;
        sum -= 0.5 * z * z;
        if (gradient) (*gradient)[i] = -z / d.sd;
    }
    return sum;
}

double ParameterSpace::LogPriorOfLogit(const Vector& y, Vector* gradient) const {
    double sum = LogPrior(ToNatural(y), gradient);
    if (gradient) *gradient = gradient->cwiseProduct(Slopes(y));
    for (Eigen::Index i = 0; i < y.size(); ++i) {
        sum += LogSigmoidSlope(y[i]);
        // d/dy log(s (1 - s)) = 1 - 2 s
        if (gradient) (*gradient)[i] += Sigmoid(-y[i]) - Sigmoid(y[i]);
    }
    return sum;
}

Vector ParameterSpace::SamplePrior(Random& random) const {
    Vector x{Eigen::Index(Size())};
    for (size_t i = 0; i < Size(); ++i) x[Eigen::Index(i)] = parameters_[i].prior.Quantile(random.Uniform());
    return x;
}

}  // namespace lacquer::estimate
