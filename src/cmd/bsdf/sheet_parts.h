// Parts of the contact sheet that are no hemispheres, and what they share with those.
#pragma once

#include <vector>

#include "measure/bsdf_result.h"
#include "plot/plot.h"

namespace lacquer::cmd {

/// One side of the surface, seen from above (transmission as if through the surface).
struct SheetSide {
    bool isTransmission = false;
    const char* name;

    const measure::LobeImage& Of(const measure::LobePair& p) const {
        return isTransmission ? p.transmission : p.reflection;
    }
    const std::vector<double>& Of(const measure::DensityPair& p) const {
        return isTransmission ? p.transmission : p.reflection;
    }
    const measure::Difference& DifferenceOf(const measure::EstimatorResult& e) const {
        return isTransmission ? e.transmission : e.reflection;
    }
    const measure::ColorMean& Of(const measure::LobeEnergy& e) const {
        return isTransmission ? e.transmitted : e.reflected;
    }
    const measure::ColorMean& SmoothOf(const measure::SampledLobe& s) const {
        return isTransmission ? s.smoothTransmitted : s.smoothReflected;
    }
    const measure::ColorMean& AllOf(const measure::SampledLobe& s) const {
        return isTransmission ? s.transmitted : s.reflected;
    }
};
/// Reflection, and transmission where there is any.
std::vector<SheetSide> SidesOf(const measure::BsdfResult& result);

/// Luminances that tell the range of a lobe; of a noisy one means over 3 x 3 pixels, so that single pixels
/// do not stretch it.
std::vector<double> RangeOf(const measure::LobeImage& image, bool isNoisy);

/// The lobe along the line through wi and the normal, by all estimators and by samples.
plot::CurvePlot SectionPlot(const measure::BsdfResult& result, const SheetSide& side);
/// Albedo and furnace energy over the angle of incidence.
plot::CurvePlot AlbedoPlot(const measure::BsdfResult& result);
/// The albedo over the angle as strips of colour, from 0 to 90 degrees.
void DrawSwatches(plot::Canvas& canvas, const measure::BsdfResult& result, Vec2 at, float width);

/// Energies, agreement, furnace, cost and reciprocity in rows.
void DrawTable(plot::Canvas& canvas, const measure::BsdfResult& result, Vec2 at);
float TableHeight(const measure::BsdfResult& result);

}  // namespace lacquer::cmd
