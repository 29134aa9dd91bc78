#include "pbrt/cameras/realistic_aperture.h"

#include <functional>
#include <stdexcept>

namespace lacquer {

namespace {

/// Pixels along a side of the named shapes, as in pbrt: their edges show it.
constexpr int kShapeSize = 256;

/// The image of a function of the point in [-1,1]^2, +y up.
Image Rasterize(const std::function<float(Point2)>& f) {
    Image image({kShapeSize, kShapeSize}, {"Y"});
    const auto coordinate = [](int i) { return 2 * (float(i) + 0.5f) / kShapeSize - 1; };
    for (int y = 0; y < kShapeSize; ++y)
        for (int x = 0; x < kShapeSize; ++x) image.Set({x, y}, 0, f({coordinate(x), -coordinate(y)}));
    return image;
}

/// True if p lies in the polygon, by the parity of the edges to its right.
bool IsInside(Point2 p, const std::vector<Point2>& corners) {
    bool inside = false;
    for (size_t i = 0; i < corners.size(); ++i) {
        const Point2 a = corners[i], b = corners[(i + 1) % corners.size()];
        if ((a.y > p.y) == (b.y > p.y)) continue;
        if (p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)) inside = !inside;
    }
    return inside;
}

/// Points at equal angles, at the given distances in turn. @param firstDeg  angle of the first one from +x
std::vector<Point2> CornersAround(int count, float firstDeg, float even, float odd) {
    std::vector<Point2> corners;
    for (int i = 0; i < count; ++i) {
        const float angle = Radians(firstDeg + 360 * float(i) / float(count));
        corners.push_back((i % 2 == 0 ? even : odd) * Point2(std::cos(angle), std::sin(angle)));
    }
    return corners;
}

Image Polygon(const std::vector<Point2>& corners) {
    return Rasterize([&](Point2 p) { return IsInside(p, corners) ? 1.f : 0.f; });
}

Image Shape(const std::string& name) {
    if (name == "gaussian")
        return Rasterize([](Point2 p) { return std::max(0.f, std::exp(-glm::dot(p, p)) - std::exp(-1.f)); });
    if (name == "square")
        return Rasterize([](Point2 p) { return std::max(std::abs(p.x), std::abs(p.y)) < 0.5f ? 1.f : 0.f; });
    // One corner below; the star has one to the left, and edges that go on in those of the next but one
    // point.
    if (name == "pentagon") return Polygon(CornersAround(5, -90, 0.8f, 0.8f));
    const float innerRadius = std::cos(Radians(72.f)) / std::cos(Radians(36.f));
    return Polygon(CornersAround(10, 180, 1, innerRadius));
}

}  // namespace

const std::vector<std::string>& ApertureMask::Names() {
    static const std::vector<std::string> names = {"gaussian", "square", "pentagon", "star"};
    return names;
}

std::optional<ApertureMask> ApertureMask::Named(const std::string& name) {
    if (std::find(Names().begin(), Names().end(), name) == Names().end()) return std::nullopt;
    return ApertureMask(Shape(name));
}

ApertureMask::ApertureMask(const Image& image) : values_(image.Resolution(), {"Y"}) {
    // The mean of the colours, whatever else there is.
    const int channels = image.HasRGB() ? 3 : 1;
    const Int2 size = image.Resolution();
    double sum = 0;
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            float value = 0;
            for (int c = 0; c < channels; ++c) value += image.Get({x, y}, c) / float(channels);
            if (!(value >= 0) || !std::isfinite(value))
                throw std::invalid_argument("has a value that is negative or not finite");
            values_.Set({x, y}, 0, value);
            sum += double(value);
        }
    if (!(sum > 0)) throw std::invalid_argument("is black: no light would get through");

    // The mean over the square becomes the share of a disk in it. Pixels reach one half beyond their centres.
    const auto scale = float(double(PiOver4) * size.x * size.y / sum);
    for (float& value : values_.Pixels()) value *= scale;
    const auto edge = [](int i, int count) {
        const float centre = 2 * (float(i) + 0.5f) / float(count) - 1;
        return std::min(1.f, std::abs(centre) + 2 / float(count));
    };
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x)
            if (values_.Get({x, y}, 0) > 0)
                extent_ = std::max(extent_, std::hypot(edge(x, size.x), edge(y, size.y)));
}

}  // namespace lacquer
