// Parts of the contact sheet that are no hemispheres, and what they share with those.
#pragma once

#include <vector>

#include "cmd/bsdf/plot.h"
#include "cmd/bsdf/result.h"

namespace lacquer::cmd {

/// One side of the surface, seen from above (transmission as if through the surface).
struct SheetSide {
    bool isTransmission = false;
    const char* name;

    const LobeImage& Of(const LobePair& p) const { return isTransmission ? p.transmission : p.reflection; }
    const std::vector<double>& Of(const DensityPair& p) const {
        return isTransmission ? p.transmission : p.reflection;
    }
    const Difference& DifferenceOf(const EstimatorResult& e) const {
        return isTransmission ? e.transmission : e.reflection;
    }
    const ColorMean& Of(const LobeEnergy& e) const { return isTransmission ? e.transmitted : e.reflected; }
    const ColorMean& SmoothOf(const SampledLobe& s) const {
        return isTransmission ? s.smoothTransmitted : s.smoothReflected;
    }
    const ColorMean& AllOf(const SampledLobe& s) const {
        return isTransmission ? s.transmitted : s.reflected;
    }
};
/// Reflection, and transmission where there is any.
std::vector<SheetSide> SidesOf(const BsdfResult& result);

/// Luminances that tell the range of a lobe; of a noisy one means over 3 x 3 pixels, so that single pixels
/// do not stretch it.
std::vector<double> RangeOf(const LobeImage& image, bool isNoisy);

/// The lobe along the line through wi and the normal, by all estimators and by samples.
CurvePlot SectionPlot(const BsdfResult& result, const SheetSide& side);
/// Albedo and furnace energy over the angle of incidence.
CurvePlot AlbedoPlot(const BsdfResult& result);
/// The albedo over the angle as strips of colour, from 0 to 90 degrees.
void DrawSwatches(Canvas& canvas, const BsdfResult& result, Vec2 at, float width);

/// Energies, agreement, furnace, cost and reciprocity in rows.
void DrawTable(Canvas& canvas, const BsdfResult& result, Vec2 at);
float TableHeight(const BsdfResult& result);

}  // namespace lacquer::cmd
