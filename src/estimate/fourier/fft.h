// Two-dimensional Fourier transforms of square images, real and complex.
#pragma once

#include <memory>
#include <span>
#include <vector>

namespace lacquer::estimate {

/// Complex numbers over a grid, real and imaginary parts apart. Row r starts at r * stride.
struct ComplexGrid {
    int rows = 0, columns = 0, stride = 0;
    std::vector<double> re, im;

    ComplexGrid() = default;
    /// All zero. The stride is the number of columns, rounded up to whole vectors.
    ComplexGrid(int numRows, int numColumns);
    size_t Index(int row, int column) const { return size_t(row) * size_t(stride) + size_t(column); }
};

/// Transforms of size x size numbers, unscaled in both directions:
///
///     F(ky, kx) = sum over y, x of f(y, x) exp(-2 pi i (kx x + ky y) / size),
///
/// and the inverse with the other sign. A real image has the half spectrum: rows ky = 0 ... size - 1 (ky
/// above size / 2 are negative frequencies), columns kx = 0 ... size / 2. Any size; powers of two are
/// fastest.
///
/// The transform itself is kissfft as Eigen carries it, which is a template over its numbers: here these are
/// vectors of eight, so that eight rows or columns are transformed at once. FFTW is not used: it is under the
/// GPL. An object has buffers of its own and belongs to one thread; results depend on the arguments alone.
class Fft2 {
  public:
    explicit Fft2(int size);
    ~Fft2();
    Fft2(Fft2&&) noexcept;
    Fft2& operator=(Fft2&&) noexcept;

    int Size() const { return size_; }
    int HalfColumns() const { return size_ / 2 + 1; }
    ComplexGrid MakeHalf() const { return {size_, HalfColumns()}; }
    ComplexGrid MakeFull() const { return {size_, size_}; }

    void Forward(std::span<const double> image, ComplexGrid* half);
    /// Real part of the sum of half(ky, kx) w exp(+...), w = 2 for 0 < kx < size / 2 and 1 else: the image of
    /// which `half` is the half spectrum, times size^2.
    /// @param half  is overwritten
    void Inverse(ComplexGrid* half, std::span<double> image);
    /// Adjoint of Forward: `half` has the derivatives of a number by real and imaginary parts, `image` gets
    /// those by the image. @param half  is overwritten
    void ForwardAdjoint(ComplexGrid* half, std::span<double> image);
    /// Adjoint of Inverse, of the same kind.
    void InverseAdjoint(std::span<const double> image, ComplexGrid* half);
    /// Transforms of complex images, in place. Each is the adjoint of the other.
    void ForwardComplex(ComplexGrid* full);
    void InverseComplex(ComplexGrid* full);

  private:
    struct Plans;
    void Columns(bool isInverse, ComplexGrid* grid);
    void Rows(bool isInverse, ComplexGrid* grid);

    int size_;
    std::unique_ptr<Plans> plans_;
};

/// Transforms of `count` real sequences of `length` numbers at once, one in each column: powers of the half
/// spectrum, and their adjoint. For spectra of columns.
class FftColumns {
  public:
    explicit FftColumns(int length);
    ~FftColumns();
    FftColumns(FftColumns&&) noexcept;
    FftColumns& operator=(FftColumns&&) noexcept;

    /// @param grid  re: the sequences, one a column, `length` rows; im zero. Becomes the full spectrum in
    /// place
    void Forward(ComplexGrid* grid);
    /// sum over k of grid(k) exp(+2 pi i k y / length), in place.
    void Inverse(ComplexGrid* grid);

  private:
    struct Plans;
    std::unique_ptr<Plans> plans_;
};

}  // namespace lacquer::estimate
