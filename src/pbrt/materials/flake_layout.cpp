#include "pbrt/materials/flake_layout.h"

#include <algorithm>
#include <cmath>

namespace lacquer {
namespace {

/// Half axes of an ellipse, the longer one first.
struct Axes {
    Vec2 a, b;
};
/// The axes of the ellipse with two conjugate half diameters.
Axes AxesOfEllipse(Vec2 p, Vec2 q) {
    // The ellipse is the image of the unit circle under (p q); its axes are those of (p q)(p q)^T.
    const float xx = p.x * p.x + q.x * q.x, xy = p.x * p.y + q.x * q.y, yy = p.y * p.y + q.y * q.y;
    const float mean = 0.5f * (xx + yy), difference = 0.5f * (xx - yy);
    const float root = std::sqrt(difference * difference + xy * xy);
    const float angle = 0.5f * std::atan2(xy, difference), c = std::cos(angle), s = std::sin(angle);
    const float longer = std::sqrt(mean + root);
    const float shorter = longer > 0 ? std::abs(p.x * q.y - p.y * q.x) / longer : 0.f;  // of equal area
    return {Vec2(c, s) * longer, Vec2(-s, c) * shorter};
}

}  // namespace

float FlakeLayout::Coverage() const { return -std::expm1(-density * AreaOfFlake()); }

double FlakeLayout::TilesPerUnit() const { return std::sqrt(double(density) / FlakeField::kMeanPerTile); }

FlakesInWindow FlakeLayout::WindowAt(const TextureContext& context, float mostFlakes) const {
    constexpr float kMaxElongation = 4;  // windows along the rows of a bounding box, not across
    constexpr float kHuge = 1e9f;        // footprints beyond it are cut anyway, and their squares are numbers
    const auto half = [&](float du, float dv) {
        const Vec2 v = 0.5f * scale * Vec2(du, dv);
        return std::isfinite(v.x) && std::isfinite(v.y)
                   ? Vec2(std::clamp(v.x, -kHuge, kHuge), std::clamp(v.y, -kHuge, kHuge))
                   : Vec2(0);
    };
    const Axes axes = AxesOfEllipse(half(context.dudx, context.dvdx), half(context.dudy, context.dvdy));
    const float lengthA = std::sqrt(Dot(axes.a, axes.a));
    const Vec2 along = lengthA > 0 ? axes.a / lengthA : Vec2(1, 0);
    float shorter = std::sqrt(Dot(axes.b, axes.b)) + radius;
    float longer = std::min(lengthA + radius, kMaxElongation * shorter);
    // Samples of a pixel lie all over it: parts of a footprint are as good on average.
    const float flakes = density * Pi * longer * shorter;
    const float shrink = flakes > mostFlakes ? std::sqrt(mostFlakes / flakes) : 1;
    longer = std::max(longer * shrink, radius);
    shorter = std::max(shorter * shrink, radius);

    const double tiles = TilesPerUnit();
    const auto coordinate = [&](float scaled) {
        const double x = double(scaled) * tiles;
        return std::abs(x) < 0x1p50 ? x : 0;  // tiles beyond have no numbers of their own
    };
    const FlakeWindow window(coordinate(scale.x * context.uv.x), coordinate(scale.y * context.uv.y),
                             along * float(double(longer) * tiles),
                             Vec2(-along.y, along.x) * float(double(shorter) * tiles));
    return {FlakeField(seed), window, AreaOfFlake() / (Pi * longer * shorter)};
}

}  // namespace lacquer
