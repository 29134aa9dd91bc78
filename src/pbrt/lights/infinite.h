// The lights behind the scene file's name "infinite": uniform, image, image through a portal, sky.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "pbrt/base/light.h"
#include "pbrt/core/color_space.h"
#include "pbrt/core/sampling.h"
#include "pbrt/image/image.h"

namespace lacquer {

/// Radiance from all directions as an image, in the equal-area octahedral parametrisation [Clarberg 2008]: +z
/// of the light's space at its centre, -z at the corners, +x to the right, +y down.
struct EnvironmentMap {
    std::shared_ptr<const Image> image;  ///< square, channels R, G, B first, finite
    float scale = 1;                     ///< factor for the illuminant spectrum of a texel

    int Size() const { return image->Resolution().x; }
    /// Negative components, which a filter may have left, count as black.
    RGB Texel(Int2 p) const {
        return glm::max(RGB(image->Get(p, 0), image->Get(p, 1), image->Get(p, 2)), 0.f);
    }
    const lacquer::ColorSpace& Space() const { return image->ColorSpaceOrSRGB(); }
    /// Luminance of a colour of the map, `scale` included; illuminants have the luminous integral
    /// kCieYIntegral. Kept below 1e30, so that sums of them are finite: they only steer where samples go.
    float Luminance(RGB rgb) const {
        return std::clamp(Space().Luminance(rgb) * (scale * kCieYIntegral), 0.f, 1e30f);
    }
};

/// A square of colours as emission spectra. The table look-up of each colour is done beforehand: during a
/// render it would miss the cache at every turn (for random colours in random order, SampleRGB takes three
/// times as long).
class SpectralMap {
  public:
    /// @param color  of each texel, not negative    @param scale  factor for the illuminant
    SpectralMap(const ColorSpace& space, int size, float scale, const std::function<RGB(Int2)>& color);

    int Size() const { return size_; }
    /// Radiance of the texel around a point of the unit square.
    SampledSpectrum Sample(Point2 st, const SampledWavelengths& lambda) const {
        const float size = float(size_), last = size - 1;
        // In this order, a coordinate that is not a number becomes 0.
        const size_t x = size_t(std::min(std::max(0.f, st.x * size), last));
        const size_t y = size_t(std::min(std::max(0.f, st.y * size), last));
        const Texel& texel = texels_[y * size_t(size_) + x];
        return texel.color.Sample(lambda) * texel.scale * illuminant_->Sample(lambda);
    }

  private:
    struct Texel {
        SigmoidPolynomial color;
        float scale = 0;
    };
    int size_;
    const DenselySampledSpectrum* illuminant_;
    std::vector<Texel> texels_;
};

/// The density by which directions are drawn, over n x n texels of the equal-area map. Scattered rays find
/// broad light well enough by themselves, and multiple importance sampling gains when the light's own samples
/// go only where the map exceeds its mean: max(0, Y - mean) [Karlik et al. 2019, MIS compensation]. A small
/// part of Y stays, so that the density is positive wherever the map is: an estimator that draws light
/// samples alone remains unbiased, and a constant map falls back to Y.
/// @param luminance  of each texel, rows from the top    @param mean  of them
PiecewiseConstant2D CompensatedDistribution(std::vector<float> luminance, int n, float mean);

/// A rectangle in rendering space.
struct Portal {
    std::array<Point3, 4> corners;  ///< in order
    Frame frame;  ///< x from corner 0 to corner 3, y from corner 0 to corner 1; the light comes from +z
    float area = 0;
};

std::unique_ptr<Light> MakeImageInfiniteLight(const Transform& renderFromLight, const EnvironmentMap& map);
std::unique_ptr<Light> MakePortalInfiniteLight(const Transform& renderFromLight, const EnvironmentMap& map,
                                               const Portal& portal);
/// `"string model" "sky"`; its parameters are in sky.cpp.
std::unique_ptr<Light> MakeSkyLight(const LightArgs& args);

}  // namespace lacquer
