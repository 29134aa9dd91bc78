// A pair has 8 lanes of real and 8 of imaginary parts: helicities u, v of the waves from the second centre,
// then v, u of those from the first one, two columns each. The way back is the way of the parity-inverted
// wave: (-1)^n, and helicities change places. So one matrix serves both ways.
#include "bulk/cluster/pair_product.h"

namespace lacquer::bulk {
namespace {

/// Helicity groups of a, b, a, b.
Lanes Interleave(const Lanes& a, const Lanes& b) {
    return __builtin_shufflevector(a, b, 0, 1, 10, 11, 4, 5, 14, 15);
}

constexpr double kRootTwo = 1.4142135623730951;

/// Place of the sums of degree n among pairs of real and imaginary parts; the differences follow n + 1 later.
size_t PartIndex(int n) { return size_t(n) * size_t(n) - 1; }

/// out_r = sum_c matrix[r * rowStride + c * columnStride] in_c for `Rows` rows, real matrix.
template <int Rows>
void RealRows(const double* matrix, size_t rowStride, size_t columnStride, int numColumns, const Lanes* in,
              Lanes* out) {
    Lanes real[Rows] = {}, imaginary[Rows] = {};
    for (int c = 0; c < numColumns; ++c) {
        const Lanes a = in[2 * c], b = in[2 * c + 1];
        for (int r = 0; r < Rows; ++r) {
            const double entry = matrix[size_t(r) * rowStride + size_t(c) * columnStride];
            real[r] += entry * a;
            imaginary[r] += entry * b;
        }
    }
    for (int r = 0; r < Rows; ++r) {
        out[2 * r] = real[r];
        out[2 * r + 1] = imaginary[r];
    }
}

void MultiplyReal(const double* matrix, size_t rowStride, size_t columnStride, int size, const Lanes* in,
                  Lanes* out) {
    int r = 0;
    for (; r + 6 <= size; r += 6)
        RealRows<6>(matrix + size_t(r) * rowStride, rowStride, columnStride, size, in, out + 2 * r);
    const double* rest = matrix + size_t(r) * rowStride;
    switch (size - r) {
        case 1:
            return RealRows<1>(rest, rowStride, columnStride, size, in, out + 2 * r);
        case 2:
            return RealRows<2>(rest, rowStride, columnStride, size, in, out + 2 * r);
        case 3:
            return RealRows<3>(rest, rowStride, columnStride, size, in, out + 2 * r);
        case 4:
            return RealRows<4>(rest, rowStride, columnStride, size, in, out + 2 * r);
        case 5:
            return RealRows<5>(rest, rowStride, columnStride, size, in, out + 2 * r);
        default:
            return;
    }
}

/// The same for complex entries, `stride` doubles from each to the next in a row, rows one after the other.
template <int Rows>
void ComplexRows(const double* matrix, size_t stride, int numColumns, const Lanes* in, Lanes* out) {
    Lanes real[Rows] = {}, imaginary[Rows] = {};
    for (int c = 0; c < numColumns; ++c) {
        const Lanes a = in[2 * c], b = in[2 * c + 1];
        for (int r = 0; r < Rows; ++r) {
            const double* entry = matrix + (size_t(r) * size_t(numColumns) + size_t(c)) * stride;
            real[r] += entry[0] * a - entry[1] * b;
            imaginary[r] += entry[0] * b + entry[1] * a;
        }
    }
    for (int r = 0; r < Rows; ++r) {
        out[2 * r] = real[r];
        out[2 * r + 1] = imaginary[r];
    }
}

void MultiplyComplex(const double* matrix, size_t stride, int size, const Lanes* in, Lanes* out) {
    int r = 0;
    for (; r + 4 <= size; r += 4)
        ComplexRows<4>(matrix + size_t(r) * size_t(size) * stride, stride, size, in, out + 2 * r);
    const double* rest = matrix + size_t(r) * size_t(size) * stride;
    switch (size - r) {
        case 1:
            return ComplexRows<1>(rest, stride, size, in, out + 2 * r);
        case 2:
            return ComplexRows<2>(rest, stride, size, in, out + 2 * r);
        case 3:
            return ComplexRows<3>(rest, stride, size, in, out + 2 * r);
        default:
            return;
    }
}

}  // namespace

PairProduct::PairProduct(const PairTableLayout& layout) : layout_(layout) {
    const size_t degree = size_t(layout.Degree());
    parts_.resize(2 * degree * (degree + 2));
    turned_.resize(parts_.size());
    order_.resize(4 * degree);
    shifted_.resize(4 * degree);
}

void PairProduct::Apply(const double* table, const Lanes* fromSecond, const Lanes* fromFirst, Lanes* toFirst,
                        Lanes* toSecond) {
    Load(table + layout_.Phases(), fromSecond, fromFirst);
    RotateIntoFrame(table);
    Shift(table);
    RotateOutOfFrame(table);
    AddTo(table + layout_.Phases(), toFirst, toSecond);
}

void PairProduct::Load(const double* phases, const Lanes* fromSecond, const Lanes* fromFirst) {
    for (int n = 1; n <= layout_.Degree(); ++n) {
        const double parity = ParitySign(n);
        const auto load = [&](int m, Lanes* real, Lanes* imaginary) {
            const Lanes &second = fromSecond[HarmonicIndex(n, m)], &first = fromFirst[HarmonicIndex(n, m)];
            *real = Join(Low(second), parity * SwapPairs(Low(first)));
            *imaginary = Join(High(second), parity * SwapPairs(High(first)));
        };
        Lanes* sums = &parts_[2 * PartIndex(n)];
        Lanes* differences = sums + 2 * (n + 1);
        Lanes real, imaginary, oppositeReal, oppositeImaginary;
        load(0, &real, &imaginary);
        sums[0] = kRootTwo * real;
        sums[1] = kRootTwo * imaginary;
        for (int m = 1; m <= n; ++m) {
            // e^{im phi} c_m and (-1)^m e^{-im phi} c_{-m}.
            load(m, &real, &imaginary);
            load(-m, &oppositeReal, &oppositeImaginary);
            const double cosine = phases[2 * m], sine = phases[2 * m + 1], sign = ParitySign(m);
            const Lanes aReal = cosine * real - sine * imaginary;
            const Lanes aImaginary = cosine * imaginary + sine * real;
            const Lanes bReal = sign * (cosine * oppositeReal + sine * oppositeImaginary);
            const Lanes bImaginary = sign * (cosine * oppositeImaginary - sine * oppositeReal);
            sums[2 * m] = aReal + bReal;
            sums[2 * m + 1] = aImaginary + bImaginary;
            differences[2 * (m - 1)] = aReal - bReal;
            differences[2 * (m - 1) + 1] = aImaginary - bImaginary;
        }
    }
}

void PairProduct::RotateIntoFrame(const double* table) {
    for (int n = 1; n <= layout_.Degree(); ++n) {
        const size_t place = 2 * PartIndex(n), next = place + 2 * size_t(n + 1);
        MultiplyReal(table + layout_.Sums(n), 1, size_t(n + 1), n + 1, &parts_[place], &turned_[place]);
        MultiplyReal(table + layout_.Differences(n), 1, size_t(n), n, &parts_[next], &turned_[next]);
    }
}

void PairProduct::RotateOutOfFrame(const double* table) {
    for (int n = 1; n <= layout_.Degree(); ++n) {
        const size_t place = 2 * PartIndex(n), next = place + 2 * size_t(n + 1);
        MultiplyReal(table + layout_.Sums(n), size_t(n + 1), 1, n + 1, &turned_[place], &parts_[place]);
        MultiplyReal(table + layout_.Differences(n), size_t(n), 1, n, &turned_[next], &parts_[next]);
    }
}

void PairProduct::Shift(const double* table) {
    const int degree = layout_.Degree();
    // m = 0: A alone, on what the rotation left.
    for (int n = 1; n <= degree; ++n) {
        const Lanes* sums = &turned_[2 * PartIndex(n)];
        order_[2 * size_t(n - 1)] = sums[0];
        order_[2 * size_t(n - 1) + 1] = sums[1];
    }
    MultiplyComplex(table + layout_.Shifts(0), 2, degree, order_.data(), shifted_.data());
    for (int n = 1; n <= degree; ++n) {
        Lanes* sums = &turned_[2 * PartIndex(n)];
        sums[0] = shifted_[2 * size_t(n - 1)];
        sums[1] = shifted_[2 * size_t(n - 1) + 1];
    }
    for (int m = 1; m <= degree; ++m) {
        const int count = degree - m + 1;
        Lanes *plus = order_.data(), *minus = order_.data() + 2 * count;
        // c_m and c_{-m}: A + B acts on u of order m and v of order -m, A - B on the others.
        for (int n = m; n <= degree; ++n) {
            const Lanes* sums = &turned_[2 * PartIndex(n)] + 2 * m;
            const Lanes* differences = &turned_[2 * PartIndex(n)] + 2 * (n + m);
            for (int part = 0; part < 2; ++part) {
                const Lanes up = sums[part] + differences[part];
                const Lanes down = ParitySign(m) * (sums[part] - differences[part]);
                plus[2 * (n - m) + part] = Interleave(up, down);
                minus[2 * (n - m) + part] = Interleave(down, up);
            }
        }
        Lanes *shiftedPlus = shifted_.data(), *shiftedMinus = shifted_.data() + 2 * count;
        MultiplyComplex(table + layout_.Shifts(m), 4, count, plus, shiftedPlus);
        MultiplyComplex(table + layout_.Shifts(m) + 2, 4, count, minus, shiftedMinus);
        for (int n = m; n <= degree; ++n) {
            Lanes* sums = &turned_[2 * PartIndex(n)] + 2 * m;
            Lanes* differences = &turned_[2 * PartIndex(n)] + 2 * (n + m);
            for (int part = 0; part < 2; ++part) {
                const Lanes &first = shiftedPlus[2 * (n - m) + part],
                            &second = shiftedMinus[2 * (n - m) + part];
                const Lanes up = Interleave(first, second);
                const Lanes down = ParitySign(m) * Interleave(second, first);
                sums[part] = up + down;
                differences[part] = up - down;
            }
        }
    }
}

void PairProduct::AddTo(const double* phases, Lanes* toFirst, Lanes* toSecond) const {
    for (int n = 1; n <= layout_.Degree(); ++n) {
        const double parity = ParitySign(n);
        const auto add = [&](int m, const Lanes& real, const Lanes& imaginary) {
            toFirst[HarmonicIndex(n, m)] += Join(Low(real), Low(imaginary));
            toSecond[HarmonicIndex(n, m)] += parity * Join(SwapPairs(High(real)), SwapPairs(High(imaginary)));
        };
        const Lanes* sums = &parts_[2 * PartIndex(n)];
        const Lanes* differences = sums + 2 * (n + 1);
        add(0, (1 / kRootTwo) * sums[0], (1 / kRootTwo) * sums[1]);
        for (int m = 1; m <= n; ++m) {
            const double cosine = 0.5 * phases[2 * m], sine = 0.5 * phases[2 * m + 1];
            const Lanes aReal = sums[2 * m] + differences[2 * (m - 1)];
            const Lanes aImaginary = sums[2 * m + 1] + differences[2 * (m - 1) + 1];
            const Lanes bReal = ParitySign(m) * (sums[2 * m] - differences[2 * (m - 1)]);
            const Lanes bImaginary = ParitySign(m) * (sums[2 * m + 1] - differences[2 * (m - 1) + 1]);
            add(m, cosine * aReal + sine * aImaginary, cosine * aImaginary - sine * aReal);
            add(-m, cosine * bReal - sine * bImaginary, cosine * bImaginary + sine * bReal);
        }
    }
}

}  // namespace lacquer::bulk
