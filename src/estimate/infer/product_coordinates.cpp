#include "estimate/infer/product_coordinates.h"

#include <algorithm>
#include <cmath>

#include "pbrt/core/check.h"

namespace lacquer::estimate {

namespace {

double Sigmoid(double t) { return 1 / (1 + std::exp(-t)); }
double LogSigmoidSlope(double t) { return -std::abs(t) - 2 * std::log1p(std::exp(-std::abs(t))); }
/// From the nearer end, so that no digits are lost there.
double Between(double low, double high, double t) {
    return t < 0 ? low + (high - low) * Sigmoid(t) : high - (high - low) * Sigmoid(-t);
}
double Logit(double low, double high, double x) { return std::log((x - low) / (high - x)); }

// Products are exp(t) parts of the largest one, but for a smooth end there: exponents, whose differences are
// the logarithms of ratios, keep ridges of several factors straight.
constexpr double kSharpness = 4;
double ProductAt(double largest, double t) {
    return largest * std::pow(1 + std::exp(-kSharpness * t), -1 / kSharpness);
}
double CoordinateOf(double largest, double product) {
    const double part = product / largest;
    return std::log(part) - std::log1p(-std::pow(part, kSharpness)) / kSharpness;
}
/// Logarithm of d product / d t, and its derivative.
double LogProductSlope(double product, double t) {
    return std::log(product) - std::log1p(std::exp(kSharpness * t));
}
double LogProductSlopeByT(double t) {
    return Sigmoid(-kSharpness * t) - kSharpness * Sigmoid(kSharpness * t);
}

}  // namespace

ProductCoordinates::ProductCoordinates(const ParameterSpace& space) : space_(space) {
    for (size_t i = 0; i < space.Size(); ++i) {
        const auto scale = space.Find(space[i].productWith);
        if (!scale) continue;
        const Prior &own = space[i].prior, &ofScale = space[*scale].prior;
        LACQUER_CHECK(space[*scale].productWith.empty() && own.low >= 0 && ofScale.low >= 0);
        auto group = std::ranges::find(groups_, Eigen::Index(*scale), &Group::scale);
        if (group == groups_.end())
            group = groups_.insert(group, {Eigen::Index(*scale), ofScale.low, ofScale.high, {}});
        group->factors.push_back({Eigen::Index(i), own.low, own.high, own.high * ofScale.high});
    }
}

bool ProductCoordinates::Find(const Group& group, const Vector& t, Place* place) {
    *place = {{}, group.low, group.high, -1, -1, 0};
    for (size_t k = 0; k < group.factors.size(); ++k) {
        const Factor& f = group.factors[k];
        const double product = ProductAt(f.largest, t[f.index]);
        place->products.push_back(product);
        if (product > place->low * f.high) {
            place->low = product / f.high;
            place->lowest = int(k);
        }
        if (product < place->high * f.low) {
            place->high = product / f.low;
            place->highest = int(k);
        }
    }
    if (!(place->low < place->high)) return false;
    place->scale = Between(place->low, place->high, t[group.scale]);
    return true;
}

bool ProductCoordinates::Logits(const Vector& t, Vector* y, double* logDeterminant) const {
    *y = t;
    *logDeterminant = 0;
    Place place;
    for (const Group& group : groups_) {
        if (!Find(group, t, &place)) return false;
        const double s = place.scale;
        // Of (products, place between the ends) to (factors, scale), and of these to their logits, whose
        // slopes are (high - low) / ((x - low)(high - x)).
        (*y)[group.scale] = Logit(group.low, group.high, s);
        *logDeterminant += std::log(place.high - place.low) + LogSigmoidSlope(t[group.scale]) +
                           std::log((group.high - group.low) / ((s - group.low) * (group.high - s)));
        for (size_t k = 0; k < group.factors.size(); ++k) {
            const Factor& f = group.factors[k];
            const double v = place.products[k] / s;
            (*y)[f.index] = Logit(f.low, f.high, v);
            *logDeterminant += LogProductSlope(place.products[k], t[f.index]) +
                               std::log((f.high - f.low) / ((v - f.low) * (f.high - v) * s));
        }
    }
    return std::isfinite(*logDeterminant) && y->allFinite();
}

Vector ProductCoordinates::GradientByCoordinates(const Vector& t, const Vector& byLogits) const {
    Vector gradient = byLogits;
    Place place;
    for (const Group& group : groups_) {
        Find(group, t, &place);
        const double s = place.scale, u = Sigmoid(t[group.scale]), range = place.high - place.low;
        // d/dx of the whole for factors and scale: by the logit, and by the logarithm of its slope.
        const auto byValue = [&](Eigen::Index i, double low, double high, double x) {
            return byLogits[i] * (high - low) / ((x - low) * (high - x)) - 1 / (x - low) + 1 / (high - x);
        };
        double byScale = byValue(group.scale, group.low, group.high, s) - double(group.factors.size()) / s;
        std::vector<double> byFactors;
        for (size_t k = 0; k < group.factors.size(); ++k) {
            const Factor& f = group.factors[k];
            const double v = place.products[k] / s;
            byFactors.push_back(byValue(f.index, f.low, f.high, v));
            byScale -= byFactors[k] * v / s;  // dv/ds = -v / s at a fixed product
        }
        gradient[group.scale] = byScale * range * u * (1 - u) + 1 - 2 * u;
        for (size_t k = 0; k < group.factors.size(); ++k) {
            const Factor& f = group.factors[k];
            double byProduct = byFactors[k] / s;
            if (int(k) == place.lowest) byProduct += (byScale * (1 - u) - 1 / range) / f.high;
            if (int(k) == place.highest) byProduct += (byScale * u + 1 / range) / f.low;
            gradient[f.index] = byProduct * std::exp(LogProductSlope(place.products[k], t[f.index])) +
                                LogProductSlopeByT(t[f.index]);
        }
    }
    return gradient;
}

Matrix ProductCoordinates::FromLogits(const Matrix& y) const {
    Matrix t = y;
    Place place;
    for (Eigen::Index column = 0; column < y.cols(); ++column) {
        const Vector x = space_.ToNatural(y.col(column));
        for (const Group& group : groups_) {
            const double s = x[group.scale];
            for (const Factor& f : group.factors)
                t(f.index, column) = CoordinateOf(f.largest, x[f.index] * s);
            t(group.scale, column) = 0;
            if (Find(group, t.col(column), &place)) t(group.scale, column) = Logit(place.low, place.high, s);
        }
    }
    return t;
}

Matrix ProductCoordinates::ToLogits(const Matrix& t) const {
    Matrix y = t;
    Place place;
    const auto inside = [](double low, double high, double x) {
        const double margin = ParameterSpace::kMargin * (high - low);
        return Logit(low, high, std::clamp(x, low + margin, high - margin));
    };
    for (Eigen::Index column = 0; column < t.cols(); ++column)
        for (const Group& group : groups_) {
            if (!Find(group, t.col(column), &place)) place.scale = std::sqrt(place.low * place.high);
            y(group.scale, column) = inside(group.low, group.high, place.scale);
            for (size_t k = 0; k < group.factors.size(); ++k) {
                const Factor& f = group.factors[k];
                y(f.index, column) = inside(f.low, f.high, place.products[k] / place.scale);
            }
        }
    return y;
}

}  // namespace lacquer::estimate
