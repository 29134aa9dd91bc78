// OpenPBR surfaces as stacks of layers.
#pragma once

#include "layered/layered_bxdf.h"
#include "layered/openpbr/openpbr_parameters.h"

namespace lacquer::layered {

/// One of the surfaces that the specification mixes by its weights.
struct OpenPBRVariant {
    bool isMetal = false, transmits = false, hasSubsurface = false;
    bool hasCoat = false, hasFuzz = false, hasFilm = false;
    bool isThere = true;  ///< false: a hole, by geometry_opacity
    bool isThinWalled = false;

    static constexpr int kCount = 1 << 8;
    int Index() const {
        return isMetal | transmits << 1 | hasSubsurface << 2 | hasCoat << 3 | hasFuzz << 4 | hasFilm << 5 |
               isThere << 6 | isThinWalled << 7;
    }
    static OpenPBRVariant At(int index) {
        const auto bit = [index](int i) { return ((index >> i) & 1) != 0; };
        return {bit(0), bit(1), bit(2), bit(3), bit(4), bit(5), bit(6), bit(7)};
    }
};

/// Frames in that of the shading, where the coat has one of its own. Fuzz stays in that of the shading.
struct OpenPBRFrames {
    bool differ = false;
    Frame coat, base;
};

/// The variant at a point, in `arena`: a stack where there is more than one layer. `lambda` loses its
/// secondary wavelengths where the index disperses.
/// @param rescatters  light may meet several facets of a rough interface, where neither a film nor a tint of
///                    a dielectric is on it
BxDF* MakeOpenPBR(const OpenPBRVariant& variant, const OpenPBRPoint& point, const OpenPBRFrames& frames,
                  const LayeredOptions& options, bool rescatters, SampledWavelengths& lambda, Arena& arena);

}  // namespace lacquer::layered
