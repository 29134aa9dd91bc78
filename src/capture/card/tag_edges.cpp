#include "capture/card/tag_edges.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace lacquer::capture {

namespace {

using Eigen::Vector2d;

/// y = a + b t by least squares.
struct StraightLine {
    double a = 0, b = 0;
    double At(double t) const { return a + b * t; }
};

StraightLine FitLine(const std::vector<Vector2d>& points) {
    Vector2d mean = Vector2d::Zero();
    for (const Vector2d& p : points) mean += p / double(points.size());
    double tt = 0, ty = 0;
    for (const Vector2d& p : points) {
        tt += (p.x() - mean.x()) * (p.x() - mean.x());
        ty += (p.x() - mean.x()) * (p.y() - mean.y());
    }
    const double b = tt > 0 ? ty / tt : 0;
    return {mean.y() - b * mean.x(), b};
}

/// One edge of the square: a frame along it and across it, outwards.
struct Edge {
    Vector2d begin, along, out;
    double length = 0;

    Edge(const Vector2d& a, const Vector2d& b, const Vector2d& center)
        : begin(a), along((b - a).normalized()), length((b - a).norm()) {
        out = {along.y(), -along.x()};
        if (out.dot(center - a) > 0) out = -out;
    }
    Vector2d At(double t, double across) const { return begin + t * along + across * out; }
};

class EdgeFit {
  public:
    EdgeFit(const Image& grey, const Edge& edge, double cell)
        : grey_(grey),
          edge_(edge),
          // The inner cells begin one cell away, and blur reaches a pixel and a half from there.
          reach_(std::clamp(0.4 * cell, 1.25, 6.)),
          band_(0.25 + 0.1 * cell) {
        const double t0 = edge.length * (1 - kEdgeShare) / 2, t1 = edge.length - t0;
        const int count = std::max(8, int(std::ceil(t1 - t0)));
        for (int i = 0; i < count; ++i) ts_.push_back(t0 + (i + 0.5) * (t1 - t0) / count);
    }

    /// Mean of the white beside the edge, and its distance from the edge.
    double WhiteLevel() const {
        double sum = 0;
        for (const double t : ts_) sum += MeanAcross(t, reach_, reach_ + band_);
        return sum / double(ts_.size());
    }
    double WhiteDistance() const { return reach_ + band_ / 2; }
    /// @param gradient  of the light outwards, relative to it [1/pixel]: white is seen from the edge on, and
    /// known
    ///                  further away
    void SetGradient(double gradient) { levelChange_ = gradient * (reach_ + band_) / 2; }

    /// Offset of the edge outwards as a function of the distance along it.
    std::optional<StraightLine> Fit() {
        StraightLine line;
        for (int iteration = 0; iteration < 4; ++iteration) {
            const std::optional<StraightLine> next = Step(line);
            if (!next) return {};
            line = *next;
        }
        return line;
    }

  private:
    double Value(Vector2d p) const {
        const Int2 size = grey_.Resolution();
        const double x = std::clamp(p.x() - 0.5, 0., size.x - 1.),
                     y = std::clamp(p.y() - 0.5, 0., size.y - 1.);
        const int ix = std::min(int(x), size.x - 2), iy = std::min(int(y), size.y - 2);
        const double fx = x - ix, fy = y - iy;
        const auto at = [&](int i, int j) { return double(grey_.Get({ix + i, iy + j}, 0)); };
        return (1 - fy) * ((1 - fx) * at(0, 0) + fx * at(1, 0)) + fy * ((1 - fx) * at(0, 1) + fx * at(1, 1));
    }

    /// Mean across the edge over [from, to].
    double MeanAcross(double t, double from, double to) const {
        const int count = std::max(2, int(std::ceil((to - from) / 0.25)));
        double sum = 0;
        for (int i = 0; i < count; ++i) sum += Value(edge_.At(t, from + (i + 0.5) * (to - from) / count));
        return sum / count;
    }

    /// Light falls off along an edge: the levels beside it are straight lines, too.
    std::optional<StraightLine> Step(const StraightLine& line) const {
        std::vector<Vector2d> dark, light, edges;
        for (const double t : ts_) {
            const double e = line.At(t);
            dark.emplace_back(t, MeanAcross(t, e - reach_ - band_, e - reach_));
            light.emplace_back(t, MeanAcross(t, e + reach_, e + reach_ + band_));
        }
        const StraightLine black = FitLine(dark), white = FitLine(light);
        for (const double t : ts_) {
            const double e = line.At(t), low = black.At(t) * (1 + levelChange_),
                         contrast = white.At(t) * (1 - levelChange_) - low;
            if (!(contrast > 0)) return {};
            // Of the 2 reach_ across, so much is white.
            const double lit = 2 * reach_ * (MeanAcross(t, e - reach_, e + reach_) - low) / contrast;
            const double offset = reach_ - lit;
            if (std::abs(offset) < reach_) edges.emplace_back(t, e + offset);
        }
        if (edges.size() < ts_.size() / 2 || edges.size() < 4) return {};
        return FitWithoutOutliers(edges);
    }

    static StraightLine FitWithoutOutliers(std::vector<Vector2d> points) {
        const StraightLine all = FitLine(points);
        std::vector<double> distances;
        for (const Vector2d& p : points) distances.push_back(std::abs(p.y() - all.At(p.x())));
        auto middle = distances.begin() + std::ptrdiff_t(distances.size() / 2);
        std::nth_element(distances.begin(), middle, distances.end());
        // 1.48 times the median is a standard deviation; of normal errors none of thousands is cut.
        const double limit = 4 * 1.4826 * *middle + 1e-9;
        std::erase_if(points, [&](const Vector2d& p) { return std::abs(p.y() - all.At(p.x())) > limit; });
        return FitLine(points);
    }

    const Image& grey_;
    Edge edge_;
    double reach_, band_, levelChange_ = 0;
    std::vector<double> ts_;
};

}  // namespace

bool RefineCorners(const Image& grey, int numCells, std::array<Vector2d, 4>* corners) {
    const Vector2d center = ((*corners)[0] + (*corners)[1] + (*corners)[2] + (*corners)[3]) / 4;
    std::vector<Edge> edges;
    std::vector<EdgeFit> fits;
    double shortest = std::numeric_limits<double>::max();
    for (size_t i = 0; i < 4; ++i) {
        const Edge& edge = edges.emplace_back((*corners)[i], (*corners)[(i + 1) % 4], center);
        fits.emplace_back(grey, edge, edge.length / numCells);
        shortest = std::min(shortest, edge.length);
    }
    std::array<Eigen::Vector3d, 4> lines;
    for (size_t i = 0; i < 4; ++i) {
        const EdgeFit& opposite = fits[(i + 2) % 4];
        const double here = fits[i].WhiteLevel(), there = opposite.WhiteLevel(),
                     distance =
                         edges[(i + 1) % 4].length + fits[i].WhiteDistance() + opposite.WhiteDistance();
        fits[i].SetGradient(2 * (here - there) / ((here + there) * distance));
        const auto line = fits[i].Fit();
        if (!line) return false;
        const Edge& edge = edges[i];
        const Vector2d p = edge.At(0, line->At(0)), q = edge.At(edge.length, line->At(edge.length));
        lines[i] = p.homogeneous().cross(q.homogeneous());
    }
    std::array<Vector2d, 4> refined;
    for (size_t i = 0; i < 4; ++i) {
        refined[i] = lines[(i + 3) % 4].cross(lines[i]).hnormalized();
        // What moves by more than most of a cell has found something else.
        if (!((refined[i] - (*corners)[i]).norm() < std::max(1.5, 0.75 * shortest / numCells))) return false;
    }
    *corners = refined;
    return true;
}

}  // namespace lacquer::capture
