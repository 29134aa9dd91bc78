#include "estimate/emulator/monomials.h"

namespace lacquer::estimate {

Monomials::Monomials(Eigen::Index numVariables, int degree) : numVariables_(numVariables) {
    terms_.push_back({0, {}});
    for (Eigen::Index i = 0; i < numVariables; ++i) terms_.push_back({1, {i}});
    for (Eigen::Index i = 0; degree >= 2 && i < numVariables; ++i)
        for (Eigen::Index j = i; j < numVariables; ++j) terms_.push_back({2, {i, j}});
    for (Eigen::Index i = 0; degree >= 3 && i < numVariables; ++i)
        for (Eigen::Index j = i; j < numVariables; ++j)
            for (Eigen::Index k = j; k < numVariables; ++k) terms_.push_back({3, {i, j, k}});
}

Vector Monomials::At(const Vector& t) const {
    Vector values(Size());
    for (size_t n = 0; n < terms_.size(); ++n) {
        double product = 1;
        for (int k = 0; k < terms_[n].degree; ++k) product *= t[terms_[n].variables[k]];
        values[Eigen::Index(n)] = product;
    }
    return values;
}

Vector Monomials::Gradient(const Vector& t, const Vector& weights) const {
    Vector gradient = Vector::Zero(numVariables_);
    for (size_t n = 0; n < terms_.size(); ++n) {
        const Term& term = terms_[n];
        for (int k = 0; k < term.degree; ++k) {
            double product = weights[Eigen::Index(n)];
            for (int other = 0; other < term.degree; ++other)
                if (other != k) product *= t[term.variables[other]];
            gradient[term.variables[k]] += product;
        }
    }
    return gradient;
}

}  // namespace lacquer::estimate
