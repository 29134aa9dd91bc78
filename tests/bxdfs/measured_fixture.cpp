#include "bxdfs/measured_fixture.h"

#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "pbrt/bxdfs/bilinear_warp.h"
#include "pbrt/scattering/fresnel.h"
#include "pbrt/scattering/trowbridge_reitz.h"

namespace lacquer::test {
namespace {

constexpr size_t kFacets = 48, kSpectra = 24;

/// The facet normal at a point of the square.
Vec3 FacetAt(Point2 u) {
    const float theta = u.x * u.x * (Pi / 2);
    return SphericalDirection(std::sin(theta), std::cos(theta), (2 * u.y - 1) * Pi);
}
Point2 GridPoint(size_t row, size_t column, size_t size) {
    return {float(column) / float(size - 1), float(row) / float(size - 1)};
}

template <class T>
void Append(std::string* bytes, T value) {
    bytes->append(reinterpret_cast<const char*>(&value), sizeof(T));
}

/// f 4 sigma(wo) cos(theta_i) / D: what the spectra of the file are, without the reflectance. It falls to 0
/// where wi comes to the surface.
float SmoothPart(const TrowbridgeReitz& facets, Vec3 wo, Vec3 wi) {
    if (!(wi.z > 0)) return 0;
    const float o = facets.ProjectedArea(wo) / wo.z, i = facets.ProjectedArea(wi) / wi.z;
    return o / (o + i - 1);
}

}  // namespace

std::string TensorFileBytes(const std::vector<TensorField>& fields) {
    size_t offset = 18;
    for (const TensorField& f : fields) offset += 2 + f.name.size() + 2 + 1 + 8 + 8 * f.shape.size();
    std::string head("tensor_file\0\1\0", 14), data;
    Append(&head, uint32_t(fields.size()));
    for (const TensorField& f : fields) {
        Append(&head, uint16_t(f.name.size()));
        head += f.name;
        Append(&head, uint16_t(f.shape.size()));
        Append(&head, uint8_t(f.bytes.empty() ? 10 : 1));
        Append(&head, uint64_t(offset + data.size()));
        for (const size_t n : f.shape) Append(&head, uint64_t(n));
        data += f.bytes;
        data.append(reinterpret_cast<const char*>(f.floats.data()), f.floats.size() * sizeof(float));
    }
    return head + data;
}

float FacetModel::Brdf(Vec3 wo, Vec3 wi, float lambda) const {
    const TrowbridgeReitz facets(alphaX, alphaY);
    return Reflectance(lambda) * SmoothPart(facets, wo, wi) * facets.D(Normalize(wo + wi)) /
           (4 * facets.ProjectedArea(wo) * wi.z);
}

std::vector<TensorField> FacetModel::Fields() const {
    const TrowbridgeReitz facets(alphaX, alphaY);
    std::vector<float> theta, phi;
    for (int i = 0; i < numTheta; ++i) theta.push_back(1.5f * float(i) / float(numTheta - 1));
    for (int i = 0; i < numPhi; ++i)
        phi.push_back(numPhi == 1 ? 0 : Pi * (2 * float(i) / float(numPhi - 1) - 1));
    const size_t numSlices = theta.size() * phi.size();

    std::vector<float> ndf, sigma, vndf, luminance, spectra;
    for (size_t row = 0; row < kFacets; ++row)
        for (size_t column = 0; column < kFacets; ++column) {
            const Vec3 w = FacetAt(GridPoint(row, column, kFacets));
            ndf.push_back(facets.D(w));
            sigma.push_back(facets.ProjectedArea(w));
        }
    // Azimuths of facets count from that of wo where there is one azimuth only: this one is 0.
    for (const float p : phi)
        for (const float t : theta) {
            const Vec3 wo = SphericalDirection(std::sin(t), std::cos(t), p);
            for (size_t row = 0; row < kFacets; ++row)
                for (size_t column = 0; column < kFacets; ++column) {
                    const Point2 u = GridPoint(row, column, kFacets);
                    const Vec3 wm = FacetAt(u);
                    vndf.push_back(facets.D(wm) * std::max(0.f, Dot(wo, wm)) * u.x *
                                   std::sin(u.x * u.x * (Pi / 2)));
                }
        }
    const BilinearWarp warp(vndf, kFacets, kFacets);
    for (size_t slice = 0; slice < numSlices; ++slice) {
        const float t = theta[slice % theta.size()], p = phi[slice / theta.size()];
        const Vec3 wo = SphericalDirection(std::sin(t), std::cos(t), p);
        SliceBlend blend;
        blend.slice[0] = slice;
        for (size_t row = 0; row < kSpectra; ++row)
            for (size_t column = 0; column < kSpectra; ++column) {
                const Point2 u = warp.Sample(GridPoint(row, column, kSpectra), blend).p;
                luminance.push_back(SmoothPart(facets, wo, Reflect(wo, FacetAt(u))));
            }
        // Linear in the wavelength: two of them are enough.
        const size_t size = kSpectra * kSpectra, start = luminance.size() - size;
        for (const float lambda : {360.f, 1000.f})
            for (size_t i = 0; i < size; ++i) spectra.push_back(luminance[start + i] * Reflectance(lambda));
    }
    return {{"theta_i", {theta.size()}, theta},
            {"phi_i", {phi.size()}, phi},
            {"ndf", {kFacets, kFacets}, ndf},
            {"sigma", {kFacets, kFacets}, sigma},
            {"vndf", {phi.size(), theta.size(), kFacets, kFacets}, vndf},
            {"luminance", {phi.size(), theta.size(), kSpectra, kSpectra}, luminance},
            {"spectra", {phi.size(), theta.size(), 2, kSpectra, kSpectra}, spectra},
            {"wavelengths", {2}, {360, 1000}},
            {"description", {4}, {}, "made"},
            {"jacobian", {1}, {}, "\1"}};
}

std::string WriteTestFile(const std::string& name, const std::string& bytes) {
    const std::string path =
        (std::filesystem::temp_directory_path() / ("lacquer-" + std::to_string(getpid()) + "-" + name))
            .string();
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
}

}  // namespace lacquer::test
