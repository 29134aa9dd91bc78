#include "pbrt/core/parallel.h"
#include "pbrt/lights/infinite.h"

namespace lacquer {

SpectralMap::SpectralMap(const ColorSpace& space, int size, float scale,
                         const std::function<RGB(Int2)>& color)
    : size_(size), illuminant_(&space.Illuminant()), texels_(size_t(size) * size_t(size)) {
    ParallelFor(size, [&](int64_t row) {
        for (int x = 0; x < size; ++x) {
            // The largest component goes to one half, where the polynomials are smoothest (as SampleRGB
            // does).
            const RGB rgb = color({x, int(row)});
            const float m = 2 * MaxComponent(rgb);
            if (!(m > 0)) continue;
            texels_[size_t(row) * size_t(size) + size_t(x)] = {space.ToPolynomial(rgb / m), m * scale};
        }
    });
}

}  // namespace lacquer
