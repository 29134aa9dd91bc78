#include "bulk/waves/wigner.h"

#include <cmath>
#include <utility>

namespace lacquer::bulk {
namespace {

/// sqrt((2 lo)! / (a! b!)) sin^a(beta/2) cos^b(beta/2), by logarithms where the parts would overflow.
double StartValue(int lo, int a, int b, double sine, double cosine, const std::vector<double>& logFactorial) {
    const double logFactor =
        0.5 * (logFactorial[size_t(2 * lo)] - logFactorial[size_t(a)] - logFactorial[size_t(b)]);
    if (lo < 80) return std::exp(logFactor) * std::pow(sine, a) * std::pow(cosine, b);
    if ((sine == 0 && a > 0) || (cosine == 0 && b > 0)) return 0;
    return std::exp(logFactor + (a > 0 ? a * std::log(sine) : 0) + (b > 0 ? b * std::log(cosine) : 0));
}

}  // namespace

std::vector<double> LogFactorials(int n) {
    std::vector<double> values;
    long double sum = 0;
    for (int i = 0; i <= n; ++i) {
        if (i > 1) sum += std::log((long double)i);
        values.push_back(double(sum));
    }
    return values;
}

WignerD::WignerD(int degree, double beta, int maxOrder) : maxOrder_(std::min(maxOrder, degree)) {
    for (int n = 0; n <= degree; ++n)
        matrices_.emplace_back(Eigen::MatrixXd::Zero(2 * n + 1, 2 * MaxOrder(n) + 1));
    const std::vector<double> logFactorial = LogFactorials(2 * degree);
    const double x = std::cos(beta), sine = std::sin(beta / 2), cosine = std::cos(beta / 2);
    for (int k = -maxOrder_; k <= maxOrder_; ++k)
        for (int m = -degree; m <= degree; ++m) {
            const int lo = std::max(std::abs(m), std::abs(k));
            const double sign = k >= m ? 1 : ParitySign(m - k);
            double before = 0,
                   now = sign * StartValue(lo, std::abs(m - k), std::abs(m + k), sine, cosine, logFactorial);
            // Upwards in n [Varshalovich et al. 1988, sec. 4.8].
            for (int n = lo; n <= degree; ++n) {
                matrices_[size_t(n)](m + n, k + MaxOrder(n)) = now;
                const double nn = n, up = nn + 1;
                const double mk = double(m) * k;
                const double below = std::sqrt((nn * nn - double(m * m)) * (nn * nn - double(k * k)));
                const double above = std::sqrt((up * up - double(m * m)) * (up * up - double(k * k)));
                const double next =
                    n == 0 ? x * now
                           : ((2 * nn + 1) * (nn * up * x - mk) * now - up * below * before) / (nn * above);
                before = std::exchange(now, next);
            }
        }
}

}  // namespace lacquer::bulk
