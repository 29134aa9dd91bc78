// What a model makes of parameters and a seed: a surface over a square grid.
#pragma once

#include <array>
#include <span>
#include <vector>

namespace lacquer::estimate {

/// Points of a square: row i from the top, column j, at x = ((j + 1/2) / size - 1/2) extent, y upward.
struct MapGrid {
    int size = 256;
    double extent = 25;  ///< side of the square [cm]
    /// The surface goes on on the other side: maps that tile. Else it goes on beyond the square.
    bool isPeriodic = false;

    double Spacing() const { return extent / size; }
    double X(int column) const { return ((column + 0.5) / size - 0.5) * extent; }
    double Y(int row) const { return -((row + 0.5) / size - 0.5) * extent; }
    size_t NumPoints() const { return size_t(size) * size_t(size); }
};

/// One number for each point, or a single one for all.
using Field = std::vector<double>;

enum class Reflectance {
    Dielectric,  ///< Lambertian under a rough interface with F0 = 0.04
    Metal,       ///< anisotropic microfacets
    Flakes       ///< Lambertian and a smooth lobe, flat; tilted flakes; if asked for, a glow
};

/// Fields and numbers that the photograph reads. The same type holds derivatives by them.
struct Surface {
    Reflectance reflectance = Reflectance::Dielectric;
    /// [cm], rows of points; empty for flakes, which are flat.
    Field height;
    /// dh/dx and dh/dy of the surface or of its flakes, for each point.
    Field slopeX, slopeY;
    /// Diffuse albedo; of metals the reflectance at normal incidence.
    std::array<Field, 3> albedo;
    /// r, with alpha = r^2: of dielectrics.
    Field roughness;
    /// r along x and y: of metals.
    double roughnessX = 0, roughnessY = 0;
    /// Of flakes: reflectance and r of the top, of the flakes, and of the glow with its weight.
    double topF0 = 0, topRoughness = 0, flakeRoughness = 0, glowWeight = 0, glowF0 = 0, glowRoughness = 0;
    std::array<double, 3> flakeF0{};

    /// Zero derivatives in the layout of this surface.
    Surface ZeroAdjoint() const;
};

/// Slopes of heights by forward differences: dh/dx from the point to the right, dh/dy from the one below. At
/// the last column and row: of a periodic surface from the other side, else as at the points before.
void SlopesOf(const MapGrid& grid, std::span<const double> height, Field* slopeX, Field* slopeY);
/// Adjoint: adds to the derivatives by heights what follows from those by slopes.
void SlopesAdjoint(const MapGrid& grid, std::span<const double> byX, std::span<const double> byY,
                   std::span<double> byHeight);

}  // namespace lacquer::estimate
