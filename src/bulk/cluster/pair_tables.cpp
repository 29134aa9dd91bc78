#include "bulk/cluster/pair_tables.h"

#include <cmath>

#include "bulk/waves/harmonics.h"
#include "bulk/waves/wigner.h"

namespace lacquer::bulk {

PairTableLayout::PairTableLayout(int degree) : degree_(degree) {
    size_t place = 0;
    sums_.push_back(0);
    for (int n = 1; n <= degree; ++n) {
        sums_.push_back(place);
        place += size_t((n + 1) * (n + 1) + n * n);
    }
    for (int m = 0; m <= degree; ++m) {
        const int count = degree - std::max(1, m) + 1;
        shifts_.push_back(place);
        place += size_t(count * count * (m == 0 ? 2 : 4));
    }
    phases_ = place;
    place += 2 * size_t(degree + 1);
    size_ = (place + kNumLanes - 1) / kNumLanes * kNumLanes;
}

PairTableMaker::PairTableMaker(const PairTableLayout& layout)
    : layout_(layout), axial_(layout.Degree(), layout.Degree()) {
    besselJ_.resize(size_t(axial_.NumBessel()));
    besselY_.resize(size_t(axial_.NumBessel()));
    sinePowers_.resize(2 * size_t(layout.Degree()) + 1);
    cosinePowers_.resize(2 * size_t(layout.Degree()) + 1);
    const std::vector<double> logFactorial = LogFactorials(2 * layout.Degree());
    for (int m = 0; m <= layout.Degree(); ++m)
        for (int k = 0; k <= m; ++k)
            startFactors_.push_back(
                std::exp(0.5 * (logFactorial[size_t(2 * m)] - logFactorial[size_t(m - k)] -
                                logFactorial[size_t(m + k)])));
}

namespace {

/// Beyond it are degrees of one sphere at another one that is so small that they are none of its own: their
/// entries of T are zero, but infinity times zero is not.
constexpr double kLargestBessel = 1e120;

}  // namespace

void PairTableMaker::Make(const Point* displacements, double* tables) {
    Lanes cosine, halfSine, halfCosine, kd;
    for (int lane = 0; lane < kNumLanes; ++lane) {
        const Point& d = displacements[lane];
        const double beta = std::atan2(std::hypot(d.x(), d.y()), d.z()), phi = std::atan2(d.y(), d.x());
        cosine[lane] = std::cos(beta);
        halfSine[lane] = std::sin(beta / 2);
        halfCosine[lane] = std::cos(beta / 2);
        kd[lane] = d.norm();
        const Eigen::VectorXd j = SphericalBesselJ(axial_.NumBessel() - 1, kd[lane]);
        const Eigen::VectorXd y = SphericalBesselY(axial_.NumBessel() - 1, kd[lane]);
        for (int nu = 0; nu < axial_.NumBessel(); ++nu) {
            besselJ_[size_t(nu)][lane] = j[nu];
            besselY_[size_t(nu)][lane] = std::abs(y[nu]) < kLargestBessel ? y[nu] : 0;
        }
        double* phases = tables + size_t(lane) * layout_.Size() + layout_.Phases();
        for (int m = 0; m <= layout_.Degree(); ++m) {
            phases[2 * m] = std::cos(m * phi);
            phases[2 * m + 1] = std::sin(m * phi);
        }
    }
    MakeRotations(cosine, halfSine, halfCosine, tables);
    axial_.Compute(kd, besselJ_.data(), besselY_.data());
    MakeShifts(tables);
}

void PairTableMaker::MakeRotations(const Lanes& cosine, const Lanes& halfSine, const Lanes& halfCosine,
                                   double* tables) {
    sinePowers_[0] = cosinePowers_[0] = Lanes{} + 1;
    for (size_t i = 1; i < sinePowers_.size(); ++i) {
        sinePowers_[i] = sinePowers_[i - 1] * halfSine;
        cosinePowers_[i] = cosinePowers_[i - 1] * halfCosine;
    }
    const double* next = startFactors_.data();
    for (int m = 0; m <= layout_.Degree(); ++m)
        for (int k = 0; k <= m; ++k) {
            const double factor = *next++;
            const size_t a = size_t(m - k), b = size_t(m + k);
            // zeta of Varshalovich is (-1)^(m-k) for k < m, and (-1)^(m+k) for -k < m.
            const Lanes plus = ParitySign(m - k) * factor * sinePowers_[a] * cosinePowers_[b];
            const Lanes minus = ParitySign(m + k) * factor * sinePowers_[b] * cosinePowers_[a];
            MakeRotationsOf(m, k, cosine, &plus, &minus, tables);
        }
}

void PairTableMaker::MakeRotationsOf(int m, int k, const Lanes& cosine, const Lanes* plusStart,
                                     const Lanes* minusStart, double* tables) {
    Lanes plus = *plusStart, minus = *minusStart, plusBefore{}, minusBefore{};
    const double transposed = ParitySign(m - k);
    for (int n = m; n <= layout_.Degree(); ++n) {
        if (n > 0) {
            // With zero orders, which have no partner, by sqrt 2: rotations stay orthogonal.
            const Lanes sum = k > 0 ? plus + ParitySign(k) * minus : m > 0 ? std::sqrt(2.) * plus : plus;
            const size_t row = size_t(n + 1);
            Store(tables, layout_.Sums(n) + size_t(m) * row + size_t(k), sum);
            if (k != m) Store(tables, layout_.Sums(n) + size_t(k) * row + size_t(m), transposed * sum);
            if (k > 0) {
                const Lanes difference = plus - ParitySign(k) * minus;
                const size_t i = size_t(m - 1), j = size_t(k - 1);
                Store(tables, layout_.Differences(n) + i * size_t(n) + j, difference);
                if (k != m)
                    Store(tables, layout_.Differences(n) + j * size_t(n) + i, transposed * difference);
            }
        }
        const double nn = n, up = nn + 1, mk = double(m) * k;
        const double below = std::sqrt((nn * nn - double(m * m)) * (nn * nn - double(k * k)));
        const double above = 1 / std::sqrt((up * up - double(m * m)) * (up * up - double(k * k)));
        Lanes nextPlus, nextMinus;
        if (n == 0) {
            nextPlus = cosine * plus;
            nextMinus = cosine * minus;
        } else {
            const double scale = above / nn;
            nextPlus = scale * ((2 * nn + 1) * (nn * up * cosine - mk) * plus - up * below * plusBefore);
            nextMinus = scale * ((2 * nn + 1) * (nn * up * cosine + mk) * minus - up * below * minusBefore);
        }
        plusBefore = plus;
        minusBefore = minus;
        plus = nextPlus;
        minus = nextMinus;
    }
}

void PairTableMaker::MakeShifts(double* tables) {
    const int degree = layout_.Degree();
    for (int m = 0; m <= degree; ++m) {
        const int lo = std::max(1, m);
        size_t place = layout_.Shifts(m);
        for (int nu = lo; nu <= degree; ++nu)
            for (int n = lo; n <= degree; ++n) {
                AxialTranslation::Entry e;
                axial_.Get(m, nu, n, &e);
                if (m == 0) {
                    Store(tables, place, e.aReal);
                    Store(tables, place + 1, e.aImag);
                    place += 2;
                } else {
                    // B = i b; half of the sums and differences of orders m and -m.
                    Store(tables, place, 0.5 * (e.aReal - e.bImag));
                    Store(tables, place + 1, 0.5 * (e.aImag + e.bReal));
                    Store(tables, place + 2, 0.5 * (e.aReal + e.bImag));
                    Store(tables, place + 3, 0.5 * (e.aImag - e.bReal));
                    place += 4;
                }
            }
    }
}

}  // namespace lacquer::bulk
