// Summaries of a photograph: numbers that say what a material looks like, and not where its features lie.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "estimate/photo/flash_photo.h"

namespace lacquer::estimate {

/// What summaries read, and derivatives by it.
struct SummaryInput {
    PlanarImage image;              ///< values after the tone curve
    std::vector<double> luminance;  ///< of each pixel, from the same values
};

/// Weights of red, green and blue in luminance (Rec. 709).
constexpr double kLuminanceWeights[3] = {0.2126, 0.7152, 0.0722};

/// Variance of what rounding to 8 bits adds to a value. Energies begin at what this noise has of them: below
/// it, an image from a file says nothing, and the logarithm of an energy would follow what no photograph
/// shows.
constexpr double kRoundingVariance = 1 / (12 * 255. * 255.);

/// A family of summaries, for images of one size. Keeps what its way back needs, and belongs to one thread.
class Summary {
  public:
    virtual ~Summary() = default;
    /// One for each number.
    const std::vector<std::string>& Names() const { return names_; }
    size_t Size() const { return names_.size(); }
    virtual void Forward(const SummaryInput& input, std::span<double> values) = 0;
    /// Adds the derivatives of a number by the input of the last Forward(), of which `by` has those by the
    /// values.
    virtual void Backward(const SummaryInput& input, std::span<const double> by, SummaryInput* byInput) = 0;

  protected:
    std::vector<std::string> names_;
};

/// Families by the names that a command line has; null if there is none of that name.
/// @param grid  of the photograph; the size is a multiple of 16 and at least 64
std::unique_ptr<Summary> MakeSummary(std::string_view name, const MapGrid& grid);
/// Names that MakeSummary() knows.
std::span<const std::string_view> SummaryFamilies();

struct VggWeights;

/// Several families one behind the other.
class SummarySet {
  public:
    /// @param vgg  for the family "vgg", which is there with these weights only (summary/vgg.h)
    /// Error: std::invalid_argument that names a family that does not exist.
    SummarySet(const std::vector<std::string>& families, const MapGrid& grid,
               const std::shared_ptr<const VggWeights>& vgg = nullptr);

    const std::vector<std::string>& Names() const { return names_; }
    size_t Size() const { return names_.size(); }
    /// The image is taken over and kept for Backward().
    void Forward(PlanarImage image, std::span<double> values);
    const PlanarImage& Image() const { return input_.image; }
    /// The image of the last Forward(), to be filled again: saves its allocation.
    PlanarImage TakeImage() { return std::move(input_.image); }
    /// Derivatives by the image.
    const PlanarImage& Backward(std::span<const double> by);

  private:
    std::vector<std::unique_ptr<Summary>> families_;
    std::vector<std::string> names_;
    SummaryInput input_, byInput_;
};

// The families, each in its file.

/// "colour": means of red, green and blue; their covariances; means in the centre less means at the rim. 12
/// numbers.
std::unique_ptr<Summary> MakeColorSummary(const MapGrid& grid);
/// "rings": in 12 rings about the middle, or columns side by side, mean luminance and half the log of the
/// energy of what a binomial blur takes away.
std::unique_ptr<Summary> MakeRingSummary(const MapGrid& grid);
/// "columns": 64 of them, 32 for images below 256.
std::unique_ptr<Summary> MakeColumnSummary(const MapGrid& grid);
/// "spectrum": half the log of the mean power under a Hann window, in 8 bands of frequency and 2 sectors of
/// orientation.
std::unique_ptr<Summary> MakeSpectrumSummary(const MapGrid& grid);
/// "columnspectrum": the same of one-dimensional spectra along columns and along rows, in 4 groups of them.
std::unique_ptr<Summary> MakeColumnSpectrumSummary(const MapGrid& grid);
/// "pyramid": 4 octaves of 4 orientations: half the log of energies, log kurtosis of magnitudes, correlations
/// of magnitudes between orientations and between octaves [Portilla and Simoncelli 2000]. 68 numbers.
std::unique_ptr<Summary> MakePyramidSummary(const MapGrid& grid);
/// "histogram": means of each sixteenth of the sorted values, of luminance and of two bands of it.
std::unique_ptr<Summary> MakeHistogramSummary(const MapGrid& grid);
/// "gram": square roots of the Gram matrices of four layers of fixed random filters [Ustyuzhaninov et al.
/// 2016].
std::unique_ptr<Summary> MakeGramSummary(const MapGrid& grid);

/// Blur by the binomial weights (1 4 6 4 1) / 16 along rows and columns, of taps `step` apart; beyond the
/// border values are those at the border.
void BinomialBlur(int size, int step, std::span<const double> in, std::vector<double>* out);
/// Adjoint: derivatives by `in` from those by `out`.
void BinomialBlurAdjoint(int size, int step, std::span<const double> by, std::vector<double>* out);

}  // namespace lacquer::estimate
