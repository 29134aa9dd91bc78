// A flash photograph of a surface: camera and light at one point, straight above it.
#pragma once

#include "estimate/models/surface.h"
#include "estimate/photo/microfacets.h"

namespace lacquer::estimate {

/// An image with the values of each channel together: red, green, blue; rows from the top.
struct PlanarImage {
    int size = 0;
    std::vector<double> values;

    PlanarImage() = default;
    explicit PlanarImage(int n) : size(n), values(3 * size_t(n) * size_t(n)) {}
    size_t NumPixels() const { return size_t(size) * size_t(size); }
    std::span<double> Channel(size_t k) { return std::span(values).subspan(k * NumPixels(), NumPixels()); }
    std::span<const double> Channel(size_t k) const {
        return std::span(values).subspan(k * NumPixels(), NumPixels());
    }
};

/// What belongs to the photograph rather than to the surface. The same type holds derivatives.
struct FlashSettings {
    double light = 1000;          ///< intensity [cm^2]: a value of 1 is a white pixel
    double vignette = 10;         ///< standard deviation of the falloff over the sample [cm]
    double axisX = 0, axisY = 0;  ///< where the axis meets the sample [cm]
};

/// Linear values of the photograph,
///
///     light cos f(h, h) / d^2 exp(-(x^2 + y^2) / (2 vignette^2)),
///
/// with x, y from the axis, d the distance to the camera, h the direction to it, which is that to the light
/// and the half vector, and f as the surface says: a Lambertian and a GGX lobe with F0 = 0.04, of which
/// Schlick's Fresnel factor is F0 as light meets its facets straight on; or metal; or flakes. The image has
/// the surface's grid.
class FlashPhoto {
  public:
    /// @param distance  of the camera from the sample [cm]
    FlashPhoto(const MapGrid& grid, double distance, Brdf brdf);

    const MapGrid& Grid() const { return grid_; }
    void Forward(const Surface& surface, const FlashSettings& settings, PlanarImage* linear) const;
    /// Adds to derivatives by surface and settings what follows from those by the image.
    /// @param bySurface  in the layout of the surface
    void Backward(const Surface& surface, const FlashSettings& settings, const PlanarImage& byLinear,
                  Surface* bySurface, FlashSettings* bySettings) const;

  private:
    MapGrid grid_;
    double distance_;
    Brdf brdf_;
};

}  // namespace lacquer::estimate
