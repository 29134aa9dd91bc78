#include "estimate/fourier/fft.h"

#include <unsupported/Eigen/FFT>

#include <complex>

#include "pbrt/core/check.h"

namespace lacquer::estimate {
namespace {

constexpr int kLanes = 8;

/// Eight numbers that pass for one, as far as kissfft uses it.
struct Lanes {
    typedef double Vector __attribute__((vector_size(sizeof(double) * kLanes)));
    Vector v;

    Lanes() = default;
    Lanes(Vector values) : v(values) {}  // NOLINT: converts as numbers do
    Lanes(double value) : v{value, value, value, value, value, value, value, value} {}  // NOLINT
    Lanes& operator+=(const Lanes& b) { return v += b.v, *this; }
    Lanes& operator-=(const Lanes& b) { return v -= b.v, *this; }
    Lanes& operator*=(const Lanes& b) { return v *= b.v, *this; }
    Lanes operator-() const { return -v; }
    friend Lanes operator+(const Lanes& a, const Lanes& b) { return a.v + b.v; }
    friend Lanes operator-(const Lanes& a, const Lanes& b) { return a.v - b.v; }
    friend Lanes operator*(const Lanes& a, const Lanes& b) { return a.v * b.v; }
};

using Number = std::complex<Lanes>;

/// Transform of one length in one direction.
class Plan {
  public:
    Plan(int length, bool isInverse) {
        fft_.make_twiddles(length, isInverse);
        fft_.factorize(length);
    }
    void Run(std::vector<Number>* out, const std::vector<Number>& in) {
        fft_.work(0, out->data(), in.data(), 1, 1);
    }

  private:
    Eigen::internal::kiss_cpx_fft<Lanes> fft_;
};

struct LanePlans {
    Plan forward, inverse;
    std::vector<Number> in, out;

    explicit LanePlans(int length)
        : forward(length, false), inverse(length, true), in(size_t(length)), out(size_t(length)) {}
    void Run(bool isInverse) { (isInverse ? inverse : forward).Run(&out, in); }

    /// Transforms all columns in place, eight at a time; rows are padded to whole vectors.
    void Columns(bool isInverse, ComplexGrid* grid) {
        const int rows = grid->rows;
        for (int first = 0; first < grid->columns; first += kLanes) {
            for (int row = 0; row < rows; ++row) {
                Lanes re, im;
                __builtin_memcpy(&re, &grid->re[grid->Index(row, first)], sizeof re);
                __builtin_memcpy(&im, &grid->im[grid->Index(row, first)], sizeof im);
                in[size_t(row)] = {re, im};
            }
            Run(isInverse);
            for (int row = 0; row < rows; ++row) {
                const Lanes re = out[size_t(row)].real(), im = out[size_t(row)].imag();
                __builtin_memcpy(&grid->re[grid->Index(row, first)], &re, sizeof re);
                __builtin_memcpy(&grid->im[grid->Index(row, first)], &im, sizeof im);
            }
        }
    }
};

}  // namespace

ComplexGrid::ComplexGrid(int numRows, int numColumns)
    : rows(numRows),
      columns(numColumns),
      stride((numColumns + kLanes - 1) / kLanes * kLanes),
      re(size_t(rows) * size_t(stride)),
      im(re.size()) {}

struct Fft2::Plans : LanePlans {
    using LanePlans::LanePlans;
};

Fft2::Fft2(int size) : size_(size), plans_(std::make_unique<Plans>(size)) { LACQUER_CHECK(size >= 2); }
Fft2::~Fft2() = default;
Fft2::Fft2(Fft2&&) noexcept = default;
Fft2& Fft2::operator=(Fft2&&) noexcept = default;

void Fft2::Columns(bool isInverse, ComplexGrid* grid) { plans_->Columns(isInverse, grid); }

void Fft2::Rows(bool isInverse, ComplexGrid* grid) {
    for (int first = 0; first < size_; first += kLanes) {
        const int count = std::min(kLanes, size_ - first);
        for (int lane = 0; lane < count; ++lane) {
            const double* re = &grid->re[grid->Index(first + lane, 0)];
            const double* im = &grid->im[grid->Index(first + lane, 0)];
            auto* in = reinterpret_cast<double*>(plans_->in.data()) + lane;
            for (int k = 0; k < size_; ++k) {
                in[2 * kLanes * k] = re[k];
                in[2 * kLanes * k + kLanes] = im[k];
            }
        }
        plans_->Run(isInverse);
        for (int lane = 0; lane < count; ++lane) {
            double* re = &grid->re[grid->Index(first + lane, 0)];
            double* im = &grid->im[grid->Index(first + lane, 0)];
            const auto* out = reinterpret_cast<const double*>(plans_->out.data()) + lane;
            for (int k = 0; k < size_; ++k) {
                re[k] = out[2 * kLanes * k];
                im[k] = out[2 * kLanes * k + kLanes];
            }
        }
    }
}

// Two real rows are one complex row, sixteen of them eight: their spectra come apart by symmetry.
void Fft2::Forward(std::span<const double> image, ComplexGrid* half) {
    const int n = size_, pairs = (n + 1) / 2;
    auto* in = reinterpret_cast<double*>(plans_->in.data());
    const auto* out = reinterpret_cast<const double*>(plans_->out.data());
    for (int first = 0; first < pairs; first += kLanes) {
        const int count = std::min(kLanes, pairs - first);
        for (int lane = 0; lane < count; ++lane) {
            const int row = 2 * (first + lane);
            const double* a = &image[size_t(row) * size_t(n)];
            const double* b = row + 1 < n ? a + n : nullptr;
            for (int x = 0; x < n; ++x) {
                in[2 * kLanes * x + lane] = a[x];
                in[2 * kLanes * x + kLanes + lane] = b ? b[x] : 0;
            }
        }
        plans_->Run(false);
        for (int lane = 0; lane < count; ++lane) {
            const int row = 2 * (first + lane);
            for (int k = 0; k < HalfColumns(); ++k) {
                const int mirror = k == 0 ? 0 : n - k;
                const double zr = out[2 * kLanes * k + lane], zi = out[2 * kLanes * k + kLanes + lane];
                const double mr = out[2 * kLanes * mirror + lane],
                             mi = out[2 * kLanes * mirror + kLanes + lane];
                half->re[half->Index(row, k)] = 0.5 * (zr + mr);
                half->im[half->Index(row, k)] = 0.5 * (zi - mi);
                if (row + 1 == n) continue;
                half->re[half->Index(row + 1, k)] = 0.5 * (zi + mi);
                half->im[half->Index(row + 1, k)] = 0.5 * (mr - zr);
            }
        }
    }
    Columns(false, half);
}

void Fft2::Inverse(ComplexGrid* half, std::span<double> image) {
    Columns(true, half);
    const int n = size_, pairs = (n + 1) / 2;
    auto* in = reinterpret_cast<double*>(plans_->in.data());
    const auto* out = reinterpret_cast<const double*>(plans_->out.data());
    for (int first = 0; first < pairs; first += kLanes) {
        const int count = std::min(kLanes, pairs - first);
        for (int lane = 0; lane < count; ++lane) {
            const int row = 2 * (first + lane);
            const bool hasSecond = row + 1 < n;
            for (int k = 0; k < HalfColumns(); ++k) {
                const size_t i = half->Index(row, k), j = half->Index(hasSecond ? row + 1 : row, k);
                const int mirror = k == 0 ? 0 : n - k;
                // Where a column is its own mirror image, only the real part counts.
                const bool isOwnMirror = mirror == k || k == 0;
                const double ar = half->re[i], ai = isOwnMirror ? 0 : half->im[i];
                const double br = hasSecond ? half->re[j] : 0;
                const double bi = hasSecond && !isOwnMirror ? half->im[j] : 0;
                in[2 * kLanes * k + lane] = ar - bi;
                in[2 * kLanes * k + kLanes + lane] = ai + br;
                in[2 * kLanes * mirror + lane] = ar + bi;
                in[2 * kLanes * mirror + kLanes + lane] = br - ai;
            }
        }
        plans_->Run(true);
        for (int lane = 0; lane < count; ++lane) {
            double* a = &image[size_t(2 * (first + lane)) * size_t(n)];
            const bool hasSecond = 2 * (first + lane) + 1 < n;
            for (int x = 0; x < n; ++x) a[x] = out[2 * kLanes * x + lane];
            if (!hasSecond) continue;
            for (int x = 0; x < n; ++x) a[n + x] = out[2 * kLanes * x + kLanes + lane];
        }
    }
}

void Fft2::ForwardAdjoint(ComplexGrid* half, std::span<double> image) {
    // Each entry counts once here and twice in Inverse(), but for columns that are their own mirror image.
    for (int row = 0; row < size_; ++row)
        for (int k = 1; 2 * k < size_; ++k) {
            half->re[half->Index(row, k)] *= 0.5;
            half->im[half->Index(row, k)] *= 0.5;
        }
    Inverse(half, image);
}

void Fft2::InverseAdjoint(std::span<const double> image, ComplexGrid* half) {
    Forward(image, half);
    for (int row = 0; row < size_; ++row)
        for (int k = 1; 2 * k < size_; ++k) {
            half->re[half->Index(row, k)] *= 2;
            half->im[half->Index(row, k)] *= 2;
        }
}

void Fft2::ForwardComplex(ComplexGrid* full) {
    Rows(false, full);
    Columns(false, full);
}
void Fft2::InverseComplex(ComplexGrid* full) {
    Columns(true, full);
    Rows(true, full);
}

struct FftColumns::Plans : LanePlans {
    using LanePlans::LanePlans;
};

FftColumns::FftColumns(int length) : plans_(std::make_unique<Plans>(length)) {}
FftColumns::~FftColumns() = default;
FftColumns::FftColumns(FftColumns&&) noexcept = default;
FftColumns& FftColumns::operator=(FftColumns&&) noexcept = default;
void FftColumns::Forward(ComplexGrid* grid) { plans_->Columns(false, grid); }
void FftColumns::Inverse(ComplexGrid* grid) { plans_->Columns(true, grid); }

}  // namespace lacquer::estimate
