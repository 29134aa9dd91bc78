// Heights with a Gaussian spectrum: bumps, and scratches where the spectrum is long in one direction.
#pragma once

#include "estimate/fourier/fft.h"

namespace lacquer::estimate {

/// Heights over a periodic square [Guo et al. 2020],
///
///     h = Re sum over f of A(f) exp(i phi(f) + 2 pi i f x),  A(f) ~ exp(-((fx/sx)^2 + (fy/sy)^2) / 2),
///
/// with A scaled so that the mean square over seeds is rms^2 on this grid: relief does not depend on the
/// extent or the resolution. The mean height is 0. Frequencies above the Nyquist frequency do not exist.
class SpectralRelief {
  public:
    /// @param size, extent  points along a side, and its length [cm]
    SpectralRelief(int size, double extent);

    void SetPhases(uint64_t stream);
    /// @param rms  of heights [cm]  @param sx, sy  standard deviations of the amplitude [cycles/cm], > 0
    void Forward(double rms, double sx, double sy, std::span<double> height);

    struct Adjoint {
        double rms = 0, sx = 0, sy = 0;
    };
    /// Derivatives of a number, by those that it has by heights. For the arguments of the last Forward().
    Adjoint Backward(std::span<const double> heightAdjoint);

  private:
    /// exp(-(f/s)^2/2) of each frequency of one direction, and sums of squares over all that are not 0.
    struct Profile {
        std::vector<double> frequencies, values;
        double s = 1, sum = 0, sumOfDerivative = 0;  ///< the second: derivative of half the sum by s
        void Set(double newS);
    };

    Fft2 fft_;
    ComplexGrid phases_, half_;
    Profile x_, y_;
    double rms_ = 0, norm_ = 0;
};

}  // namespace lacquer::estimate
