// Medium "cloud": a procedural cloud [Kniss and Hart 2002], denser below than above.
//
//   "float density"                         1                 of the noise, >= 0
//   "float wispiness"                       1                 strength of the domain warping, >= 0
//   "float frequency"                       5                 of the noise [1 / unit of length in medium
//                                                             space]
//   "spectrum sigma_a", "spectrum sigma_s"  1, 1              absorption and scattering coefficient of
//                                                             density 1 [1 / unit of length in the world]
//   "string bulk"                           -                 a file of "lacquer bulk" instead, in 1/mm, with
//                                                             its phase function; and only then
//   "float scale"                           1                 multiplies both coefficients
//   "string phase"                          hg                and its parameters: see phases/
//   "point3 p0", "point3 p1"                (0 0 0), (1 1 1)  the box in medium space; heights y of the cloud
//                                                             count in medium space, too
#include "pbrt/core/noise.h"
#include "pbrt/media/grid_params.h"
#include "pbrt/media/medium_params.h"

namespace lacquer {
namespace {

constexpr int kOctaves = 5;
constexpr float kLacunarity = 1.99f;

/// The density in [0, 1] as a function of the place in medium space.
class CloudDensity {
  public:
    explicit CloudDensity(const Params& params)
        : density_(ReadNonNegative(params, "density", 1)),
          wispiness_(ReadNonNegative(params, "wispiness", 1)),
          frequency_(ReadNonNegative(params, "frequency", 5)) {}

    float At(Point3 p) const {
        // Below 0 the second term alone reaches the limit.
        if (p.y <= 0) return 1;
        const float billows =
            std::clamp((1 - p.y) * 4.5f * density_ * Octaves(Swirl(frequency_ * p)), 0.f, 1.f);
        return std::min(1.f, billows + Ground(p.y));
    }
    /// Largest density between two heights.
    ///
    /// The sum of octaves is bounded by that of their amplitudes, and the swirls move points by more than the
    /// features of most octaves: bounds of the noise in a cell that held for sure would, but for cells of
    /// some thousandths of the cloud, hardly be below that sum. So only the height tells anything.
    float Maximum(float yLow, float yHigh) const {
        const float slope = std::max(std::abs(1 - yLow), std::abs(1 - yHigh));
        return std::min(1.f, std::min(1.f, slope * 4.5f * density_ * kMaxOctaveSum) + Ground(yLow));
    }

  private:
    /// Noise is a weighted mean over the corners of a cell, each with a sum of two coordinates from there: at
    /// most 1.0364, whatever the gradients. The octaves' amplitudes add up to 31/32.
    static constexpr float kMaxOctaveSum = 1.04f * 31 / 32;

    static float Ground(float y) { return 2 * std::max(0.f, 0.5f - y); }
    /// The point after two steps along the noise's gradient.
    Point3 Swirl(Point3 q) const {
        if (wispiness_ == 0) return q;
        float amplitude = 0.05f * wispiness_, lambda = 10;
        for (int i = 0; i < 2; ++i) {
            q += amplitude * NoiseGradient(lambda * q);
            amplitude *= 0.5f;
            lambda *= kLacunarity;
        }
        return q;
    }
    static float Octaves(Point3 q) {
        float sum = 0, amplitude = 0.5f, lambda = 1;
        for (int i = 0; i < kOctaves; ++i) {
            sum += amplitude * Noise(lambda * q);
            amplitude *= 0.5f;
            lambda *= kLacunarity;
        }
        return sum;
    }

    float density_, wispiness_, frequency_;
};

class Cloud final : public Medium {
  public:
    explicit Cloud(const MediumArgs& args)
        : Medium(ReadMediumPhase(args)),
          mediumFromRender_(args.renderFromMedium.Inverse()),
          unitFromRender_(ReadUnitFromRender(args)),
          density_(args.params),
          coefficients_(ReadUnscaledCoefficients(args.params, GetPhaseModel())),
          majorants_(Bounds()) {}

    MediumProperties At(Point3 p, const SampledWavelengths& lambda) const override {
        if (!InUnitCube(unitFromRender_.Point(p))) return {};
        const float density = density_.At(mediumFromRender_.Point(p));
        if (density == 0) return {};
        return {density * coefficients_.sigma_a.Sample(lambda),
                density * coefficients_.sigma_s.Sample(lambda), SampledSpectrum(0)};
    }
    MajorantWalk Majorants(const Ray& ray, float tMax, const SampledWavelengths& lambda) const override {
        return {majorants_, unitFromRender_.Ray(ray), tMax,
                coefficients_.sigma_a.Sample(lambda) + coefficients_.sigma_s.Sample(lambda)};
    }
    bool IsEmissive() const override { return false; }

  private:
    MajorantGrid Bounds() const {
        constexpr int kLayers = 32;
        const auto height = [&](float u) {
            return mediumFromRender_.Point(unitFromRender_.InversePoint({0, u, 0})).y;
        };
        return BoundUnitCube({1, kLayers, 1}, [&](const Bounds3& box) {
            return density_.Maximum(height(box.min.y), height(box.max.y));
        });
    }

    Transform mediumFromRender_, unitFromRender_;
    CloudDensity density_;
    Coefficients coefficients_;
    MajorantGrid majorants_;
};

std::unique_ptr<Medium> Create(const MediumArgs& args) { return std::make_unique<Cloud>(args); }

}  // namespace

LACQUER_REGISTER(MediumKind, "cloud", Create);

}  // namespace lacquer
