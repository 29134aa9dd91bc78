// Tables in one, two and three dimensions, periodic and linear between their entries.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace lacquer::estimate {

/// The two entries around a coordinate, and how far it is from the first.
struct TablePlace {
    int first, second;
    double t;
};
inline TablePlace PlaceIn(int size, double u) {
    const double floorU = std::floor(u);
    int first = int(floorU - size * std::floor(floorU / size));
    if (first >= size) first = 0;  // rounding
    return {first, first + 1 == size ? 0 : first + 1, u - floorU};
}

struct PeriodicTable1 {
    std::vector<double> values;
    struct Sample {
        double value, byU;
    };
    explicit PeriodicTable1(int size) : values(size_t(size)) {}
    /// Entry i is at u = i.
    Sample At(double u) const {
        const TablePlace p = PlaceIn(int(values.size()), u);
        const double a = values[size_t(p.first)], b = values[size_t(p.second)];
        return {a + p.t * (b - a), b - a};
    }
};

struct PeriodicTable2 {
    int size;
    std::vector<double> values;  ///< rows along v
    struct Sample {
        double value, byU, byV;
    };
    explicit PeriodicTable2(int n) : size(n), values(size_t(n) * size_t(n)) {}
    Sample At(double u, double v) const {
        const TablePlace p = PlaceIn(size, u), q = PlaceIn(size, v);
        const double* top = &values[size_t(q.first) * size_t(size)];
        const double* bottom = &values[size_t(q.second) * size_t(size)];
        const double v00 = top[p.first], v01 = top[p.second], v10 = bottom[p.first], v11 = bottom[p.second];
        const double upper = v00 + p.t * (v01 - v00), lower = v10 + p.t * (v11 - v10);
        return {upper + q.t * (lower - upper), (1 - q.t) * (v01 - v00) + q.t * (v11 - v10), lower - upper};
    }
};

/// Two components, of which each point of a cube of n^3 has its own.
struct PeriodicTable3 {
    int size;
    std::vector<std::array<double, 2>> values;
    struct Sample {
        std::array<double, 2> value;
        std::array<std::array<double, 3>, 2> by;  ///< of each component, by u, v, w
    };
    explicit PeriodicTable3(int n) : size(n), values(size_t(n) * size_t(n) * size_t(n)) {}
    /// Rows along w, then along v.
    Sample At(double u, double v, double w) const {
        const TablePlace p = PlaceIn(size, u), q = PlaceIn(size, v), r = PlaceIn(size, w);
        const auto row = [this](int k, int j) {
            return &values[(size_t(k) * size_t(size) + size_t(j)) * size_t(size)];
        };
        const auto *a = row(r.first, q.first), *b = row(r.first, q.second);
        const auto *c = row(r.second, q.first), *d = row(r.second, q.second);
        Sample sample{};
        for (size_t i = 0; i < 2; ++i) {
            const double au = a[p.second][i] - a[p.first][i], bu = b[p.second][i] - b[p.first][i];
            const double cu = c[p.second][i] - c[p.first][i], du = d[p.second][i] - d[p.first][i];
            const double a0 = a[p.first][i] + p.t * au, b0 = b[p.first][i] + p.t * bu;
            const double c0 = c[p.first][i] + p.t * cu, d0 = d[p.first][i] + p.t * du;
            const double front = a0 + q.t * (b0 - a0), back = c0 + q.t * (d0 - c0);
            sample.value[i] = front + r.t * (back - front);
            sample.by[i] = {(1 - r.t) * (au + q.t * (bu - au)) + r.t * (cu + q.t * (du - cu)),
                            (1 - r.t) * (b0 - a0) + r.t * (d0 - c0), back - front};
        }
        return sample;
    }
};

}  // namespace lacquer::estimate
