// Files of measured BRDFs, made from a microfacet model: no measured one is needed here.
#pragma once

#include <string>
#include <vector>

#include "pbrt/core/vec.h"

namespace lacquer::test {

/// A field of a tensor file; bytes if `bytes` is not empty, else floats.
struct TensorField {
    std::string name;
    std::vector<size_t> shape;
    std::vector<float> floats;
    std::string bytes{};
};
/// The bytes of a tensor file of these fields.
std::string TensorFileBytes(const std::vector<TensorField>& fields);

/// A rough white mirror whose reflectance falls with the wavelength.
struct FacetModel {
    float alphaX = 0.3f, alphaY = 0.3f;
    int numTheta = 24, numPhi = 1;  ///< directions of wo that are tabulated; one azimuth: isotropic
    /// What the facets reflect.
    static float Reflectance(float lambda) { return 1 - (lambda - 360) / 1000; }
    /// The value that the file stands for; both directions above the surface.
    float Brdf(Vec3 wo, Vec3 wi, float lambda) const;
    /// The fields of a file in the adaptive parametrisation [Dupuy and Jakob 2018].
    std::vector<TensorField> Fields() const;
};

/// Writes a file below the folder for temporary files, under a name that the running test has for itself.
std::string WriteTestFile(const std::string& name, const std::string& bytes);

}  // namespace lacquer::test
