#include "pbrt/base/shape.h"

namespace lacquer {

float AreaToSolidAngle(float pdfArea, Point3 from, Point3 p, Normal3 n) {
    const Vec3 d = p - from;
    const float distance2 = LengthSquared(d);
    const float projected = AbsDot(n, d);
    // |cos theta| = projected / distance: one square root and no normalised direction is needed.
    const float pdf = pdfArea * distance2 * std::sqrt(distance2) / projected;
    return std::isfinite(pdf) ? pdf : 0.f;
}

std::optional<ShapeSample> Shape::SampleSolidAngle(int primitive, const LightReference& ref, Point2 u,
                                                   bool /*wantsUv*/) const {
    std::optional<ShapeSample> sample = SampleArea(primitive, u);
    if (!sample) return std::nullopt;
    sample->pdf = AreaToSolidAngle(sample->pdf, ref.p, sample->p, sample->n);
    if (!(sample->pdf > 0)) return std::nullopt;
    return sample;
}

float Shape::PdfSolidAngle(int primitive, const LightReference& ref, Point3 p, Normal3 n) const {
    const float area = Area(primitive);
    return area > 0 ? AreaToSolidAngle(1 / area, ref.p, p, n) : 0.f;
}

}  // namespace lacquer
