#include "bulk/waves/axial_translation.h"

#include <cmath>

#include "pbrt/core/check.h"

namespace lacquer::bulk {
namespace {

// The factors of (d/dx + i d/dy) between harmonics.
double RaisingUp(int n, int m) {
    return std::sqrt((n + m + 1.) * (n + m + 2.) / ((2. * n + 1) * (2. * n + 3)));
}
double RaisingDown(int n, int m) {
    return std::sqrt(double(n - m) * (n - m - 1.) / ((2. * n - 1) * (2. * n + 1)));
}

}  // namespace

AxialTranslation::AxialTranslation(int fromDegree, int toDegree)
    : fromDegree_(fromDegree), toDegree_(toDegree) {
    LACQUER_CHECK(fromDegree >= 1 && toDegree >= 1);
    const size_t size = AlphaIndex(MaxOrder() + 1, 0, 0), numBessel = size_t(NumBessel());
    real_.resize(size);
    imaginary_.resize(size);
    sectorial_.resize(numBessel);
    nextSectorial_.resize(numBessel);
    for (std::vector<Lanes>& column : columns_) column.resize(numBessel);
    for (int n = 0; n <= std::max(fromDegree, toDegree); ++n)
        degreeFactors_.push_back(n == 0 ? 0 : 1 / std::sqrt(n * (n + 1.)));
    cosineFactors_.resize((numBessel + 1) * size_t(fromDegree + 1));
    for (int m = 0; m <= fromDegree; ++m)
        for (int n = m; n < NumBessel(); ++n) {
            const double up = n + 1;
            cosineFactors_[size_t(n + 1) * size_t(fromDegree + 1) + size_t(m)] =
                std::sqrt((up * up - double(m * m)) / ((2. * n + 1) * (2. * n + 3)));
        }
}

void AxialTranslation::Compute(const Lanes& kd, const Lanes* besselJ, const Lanes* besselY) {
    kd_ = kd;
    ComputeScalar(besselJ, &real_);
    ComputeScalar(besselY, &imaginary_);
}

void AxialTranslation::ComputeScalar(const Lanes* bessel, std::vector<Lanes>* alpha) {
    const int top = NumBessel() - 1;
    for (int nu = 0; nu <= top; ++nu)
        sectorial_[size_t(nu)] = ParitySign(nu) * std::sqrt(2. * nu + 1) * bessel[nu];
    for (int m = 0; m <= MaxOrder(); ++m) {
        // Columns n = m, m+1, ...: each knows one nu less than the one before it.
        for (int nu = m; nu <= top - m; ++nu) columns_[0][size_t(nu)] = sectorial_[size_t(nu)];
        for (int n = m; n <= fromDegree_; ++n) {
            std::vector<Lanes>& now = columns_[size_t(n - m) % 3];
            const std::vector<Lanes>& before = columns_[size_t(n - m + 2) % 3];
            std::vector<Lanes>& next = columns_[size_t(n - m + 1) % 3];
            for (int nu = m; nu <= toDegree_ + 1; ++nu) (*alpha)[AlphaIndex(m, nu, n)] = now[size_t(nu)];
            if (n == fromDegree_) break;
            const double scale = 1 / CosineFactor(n, m), left = CosineFactor(n - 1, m);
            for (int nu = m; nu < top - n; ++nu) {
                Lanes sum = -CosineFactor(nu, m) * now[size_t(nu + 1)];
                if (nu > m) sum += CosineFactor(nu - 1, m) * now[size_t(nu - 1)];
                if (n > m) sum += left * before[size_t(nu)];
                next[size_t(nu)] = scale * sum;
            }
        }
        const double scale = 1 / RaisingUp(m, m);
        for (int nu = m + 1; nu < top - m; ++nu)
            nextSectorial_[size_t(nu)] = scale * (RaisingUp(nu - 1, m) * sectorial_[size_t(nu - 1)] +
                                                  RaisingDown(nu + 1, m) * sectorial_[size_t(nu + 1)]);
        std::swap(sectorial_, nextSectorial_);
    }
}

void AxialTranslation::Get(int m, int nu, int n, Entry* entry) const {
    const double v = nu, degrees = degreeFactors_[size_t(n)] * degreeFactors_[size_t(nu)];
    const double up = v * CosineFactor(nu, m), down = (v + 1) * CosineFactor(nu - 1, m);
    const size_t here = AlphaIndex(m, nu, n), step = size_t(fromDegree_ + 1);
    const auto set = [&](const std::vector<Lanes>& alpha, Lanes* a, Lanes* b) {
        Lanes sum = up * alpha[here + step];
        if (nu > m) sum += down * alpha[here - step];
        *a = degrees * (v * (v + 1) * alpha[here] + kd_ * sum);
        *b = degrees * double(m) * (kd_ * alpha[here]);
    };
    set(real_, &entry->aReal, &entry->bReal);
    set(imaginary_, &entry->aImag, &entry->bImag);
}

}  // namespace lacquer::bulk
