// Materials as files of the RGL database, which the material "measured" reads.
#pragma once

#include <string>
#include <vector>

#include "measure/bsdf_tables.h"
#include "measure/scene_material.h"

namespace lacquer::measure {

/// True if turning both directions of a pair about the normal changes f in a quarter of 64 pairs, by 2 per
/// cent and by more than the noise: for stochastic materials, about 8 per cent and more are found.
bool IsAnisotropic(const BsdfSubject& subject, uint64_t seed);

/// Reflection from above in the adaptive parametrisation [Dupuy and Jakob 2018]: a distribution of facets,
/// its visible normals by wo, and what is left of f over the uniform numbers that draw them, so that fine
/// tables lie where the light goes. The distribution serves as the coordinates only: f does not depend on how
/// well it describes the surface, its interpolation does. Specular peaks have no place here.
struct TensorTable {
    std::vector<float> theta, phi;  ///< of wo [radians]; one azimuth for isotropic materials
    std::vector<float> wavelengths;
    size_t ndfRows = 0;                      ///< of ndf and sigma; their columns are those of vndf
    size_t facetRows = 0, facetColumns = 0;  ///< azimuths and polar angles of facets
    size_t resolution = 0;                   ///< rows and columns of luminance and spectra
    std::vector<float> ndf, sigma;           ///< [row][column]
    std::vector<float> vndf;                 ///< [phi][theta][row][column]
    std::vector<float> luminance;            ///< [phi][theta][row][column]
    std::vector<float> spectra;              ///< [phi][theta][wavelength][row][column]
    bool IsIsotropic() const { return phi.size() == 1; }
    /// A file in the form that TensorFile describes.
    std::string Bytes(const std::string& description) const;
};

/// Anisotropic where the material is.
/// @param uv        where its textures are looked up
/// @param observer  may be null
TensorTable TabulateTensor(const SceneMaterial& material, Point2 uv, const TableOptions& options,
                           Observer* observer);

}  // namespace lacquer::measure
