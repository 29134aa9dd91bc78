// Numbers that carry their derivatives by the nine stored values of a texel.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace lacquer::capture {

/// A value and its derivatives by N unknowns. At the ends of what is clamped the derivative is that of the
/// inside or 0, as comparisons of the values choose.
template <size_t N>
struct Dual {
    double value = 0;
    std::array<double, N> by{};

    Dual() = default;
    Dual(double x) : value(x) {}  // NOLINT: numbers are constants
    /// The unknown with this index.
    static Dual Unknown(double x, size_t index) {
        Dual d(x);
        d.by[index] = 1;
        return d;
    }
    /// f of this, by its value and derivative.
    Dual Through(double f, double slope) const {
        Dual d(f);
        for (size_t i = 0; i < N; ++i) d.by[i] = slope * by[i];
        return d;
    }

    friend Dual operator+(const Dual& a, const Dual& b) {
        Dual d(a.value + b.value);
        for (size_t i = 0; i < N; ++i) d.by[i] = a.by[i] + b.by[i];
        return d;
    }
    friend Dual operator-(const Dual& a, const Dual& b) {
        Dual d(a.value - b.value);
        for (size_t i = 0; i < N; ++i) d.by[i] = a.by[i] - b.by[i];
        return d;
    }
    friend Dual operator*(const Dual& a, const Dual& b) {
        Dual d(a.value * b.value);
        for (size_t i = 0; i < N; ++i) d.by[i] = a.by[i] * b.value + a.value * b.by[i];
        return d;
    }
    friend Dual operator/(const Dual& a, const Dual& b) {
        const double inverse = 1 / b.value;
        Dual d(a.value * inverse);
        for (size_t i = 0; i < N; ++i) d.by[i] = (a.by[i] - d.value * b.by[i]) * inverse;
        return d;
    }
    friend Dual operator*(const Dual& a, double b) { return a.Through(a.value * b, b); }
    friend Dual operator*(double a, const Dual& b) { return b * a; }
    friend bool operator<(const Dual& a, const Dual& b) { return a.value < b.value; }
    friend bool operator>(const Dual& a, const Dual& b) { return a.value > b.value; }

    friend Dual sqrt(const Dual& x) {
        const double root = std::sqrt(x.value);
        return x.Through(root, 0.5 / root);
    }
    /// @param p  above 1, or x is above 0
    friend Dual pow(const Dual& x, double p) {
        return x.Through(std::pow(x.value, p), p * std::pow(x.value, p - 1));
    }
};

}  // namespace lacquer::capture
