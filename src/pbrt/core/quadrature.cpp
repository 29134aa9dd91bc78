#include "pbrt/core/quadrature.h"

#include <cmath>
#include <numbers>

namespace lacquer {

std::vector<QuadratureNode> GaussLegendre(int n) {
    std::vector<QuadratureNode> nodes;
    for (int i = 0; i < n; ++i) {
        // Newton's method on the Legendre polynomial.
        double x = std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5)), slope = 1;
        for (int step = 0; step < 100; ++step) {
            double p = 1, previous = 0;
            for (int k = 0; k < n; ++k) {
                const double next = ((2 * k + 1) * x * p - k * previous) / (k + 1);
                previous = p;
                p = next;
            }
            slope = n * (x * p - previous) / (x * x - 1);
            const double dx = p / slope;
            x -= dx;
            if (std::abs(dx) < 1e-15) break;
        }
        nodes.push_back({x, 2 / ((1 - x * x) * slope * slope)});
    }
    return nodes;
}

}  // namespace lacquer
