// Writes the flakes of a material "flakes" as discs, directives of a scene: what its image is held against.
// usage: flake_geometry DENSITY SIZE ALPHA SEED
// For uscale = vscale = 1, "distribution" "beckmann", and u, v in [0,1], which are x and y. The discs lie at
// heights up to a tenth of their size, in random order, for flakes that overlap.
#include <fmt/format.h>

#include <cstdlib>

#include "pbrt/materials/flake_layout.h"

namespace lacquer {
namespace {

/// A disc at a point, with its normal along z of a frame.
void WriteDisc(double x, double y, double height, Vec3 normal, double radius) {
    const Frame frame = Frame::FromZ(normal);
    fmt::print(
        "AttributeBegin Transform [ {:.6g} {:.6g} {:.6g} 0 {:.6g} {:.6g} {:.6g} 0 {:.6g} {:.6g} {:.6g} 0 "
        "{:.8g} {:.8g} {:.8g} 1 ] Shape \"disk\" \"float radius\" {:.6g} AttributeEnd\n",
        frame.x.x, frame.x.y, frame.x.z, frame.y.x, frame.y.y, frame.y.z, normal.x, normal.y, normal.z, x, y,
        height, radius);
}

void WriteFlakes(const FlakeLayout& layout, float alpha) {
    const Beckmann normals(alpha, alpha);
    const FlakeField field(layout.seed);
    const double tiles = layout.TilesPerUnit();
    // Windows of a disc around each tile; of its flakes those within the tile.
    for (double ty = 0; ty < tiles; ++ty)
        for (double tx = 0; tx < tiles; ++tx)
            field.ForEach(FlakeWindow(tx + 0.5, ty + 0.5, {0.75f, 0}, {0, 0.75f}), FlakeNormals(),
                          [&](const Flake& flake) {
                              const double x = double(flake.offset.x) + 0.5, y = double(flake.offset.y) + 0.5;
                              if (!(x >= 0 && x < 1 && y >= 0 && y < 1)) return;
                              const double height =
                                  0.2 * double(layout.radius) * double(UnitFloat(flake.bits));
                              WriteDisc((tx + x) / tiles, (ty + y) / tiles, height,
                                        DirectionOf(SlopeOfFlake(flake, normals)), double(layout.radius));
                          });
}

}  // namespace
}  // namespace lacquer

int main(int argc, char** argv) {
    if (argc != 5) {
        fmt::print(stderr, "usage: flake_geometry DENSITY SIZE ALPHA SEED\n");
        return 2;
    }
    lacquer::FlakeLayout layout;
    layout.density = float(std::atof(argv[1]));
    layout.radius = 0.5f * float(std::atof(argv[2]));
    layout.seed = lacquer::Hash(std::atoi(argv[4]));
    lacquer::WriteFlakes(layout, float(std::atof(argv[3])));
    return 0;
}
