#include "capture/card/card_photographs.h"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "capture/card/card.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/rng.h"

namespace lacquer::capture::test_cards {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kCellsPerUnit = 4;

/// The inverse of the distortion by Newton's method along the radius.
Vector2d Undistort(const Intrinsics& in, Vector2d pixel) {
    const Vector2d d((pixel.x() - in.cx) / in.f, (pixel.y() - in.cy) / in.f);
    const double rd = d.norm();
    double r = rd;
    for (int i = 0; i < (in.k1 == 0 && in.k2 == 0 ? 0 : 6); ++i)
        r -= (r * (1 + r * r * (in.k1 + r * r * in.k2)) - rd) / (1 + r * r * (3 * in.k1 + 5 * r * r * in.k2));
    return rd > 0 ? Vector2d(d * (r / rd)) : d;
}

class Projector {
  public:
    Projector(const PhotographedCard& card, const CameraPose& pose) : card_(card), pose_(pose) {}

    /// What the ray through x, y of the plane at z = 1 of the camera sees.
    double Value(Vector2d p) const {
        const Vector3d d = pose_.rotation.transpose() * Vector3d(p.x(), p.y(), 1);
        if (!(d.z() < 0)) return 0.1;
        const Vector3d hit = Hit(d);
        const double half = 0.5 * kSampleShare * card_.size;
        const Vector3d sample = pose_.position - d * ((pose_.position.z() + card_.depth) / d.z());
        if (std::abs(sample.x()) <= half && std::abs(sample.y()) <= half)
            return card_.sample(sample.x(), sample.y());
        const double scale = kUnitsPerSize / card_.size * kCellsPerUnit;
        const int side = card_.cells.Resolution().x;
        const int x = int(std::floor(hit.x() * scale + 0.5 * side)),
                  y = int(std::floor(0.5 * side - hit.y() / card_.aspect * scale));
        if (x < 0 || y < 0 || x >= side || y >= side) return 0.15;  // the table
        return 0.04 + 0.86 * double(card_.cells.Get({x, y}, 0));
    }

  private:
    Vector3d Hit(const Vector3d& d) const {
        Vector3d hit = pose_.position - d * (pose_.position.z() / d.z());
        for (int i = 0; i < 4 && card_.bend != 0; ++i) {
            const double t = 2 * hit.x() / card_.size, z = card_.bend * (1 - t * t);
            hit = pose_.position - d * ((pose_.position.z() - z) / d.z());
        }
        return hit;
    }

    const PhotographedCard& card_;
    const CameraPose& pose_;
};

/// Corners of a row of pixels: rays, and what they see.
struct RowOfCorners {
    std::vector<Vector2d> rays;
    std::vector<double> values;

    RowOfCorners(const Projector& projector, const Photographer& photographer, int y) {
        for (int x = 0; x <= photographer.resolution.x; ++x) {
            rays.push_back(Undistort(photographer.intrinsics, {x, y}));
            values.push_back(projector.Value(rays.back()));
        }
    }
};

/// The mean over pixel x between two rows: one value where its corners and its middle agree. The distortion
/// is straight over a pixel.
double MeanOver(const Projector& projector, const RowOfCorners& above, const RowOfCorners& below, size_t x,
                int n) {
    const Vector2d a = above.rays[x], dx = above.rays[x + 1] - a, dy = below.rays[x] - a;
    const double middle = projector.Value(a + 0.5 * (dx + dy));
    if (middle == above.values[x] && middle == above.values[x + 1] && middle == below.values[x] &&
        middle == below.values[x + 1])
        return middle;
    double sum = 0;
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            // Shifted from row to row, lest many samples pass an edge at once.
            const double u = (i + (j + 0.5) / n) / n, v = (j + (i + 0.5) / n) / n;
            sum += projector.Value(a + u * dx + v * dy);
        }
    return sum / (n * n);
}

}  // namespace

CameraPose LookAtCard(const Vector3d& position, const Vector2d& target, double rollDeg) {
    const Vector3d z = (Vector3d(target.x(), target.y(), 0) - position).normalized();
    const double roll = rollDeg * std::numbers::pi / 180;
    const Vector3d down = Vector3d(-std::sin(roll), -std::cos(roll), 0);
    const Vector3d x = down.cross(z).normalized();
    CameraPose pose;
    pose.position = position;
    pose.rotation.row(0) = x;
    pose.rotation.row(1) = z.cross(x);
    pose.rotation.row(2) = z;
    return pose;
}

std::vector<CameraPose> NinePoses() {
    std::vector<CameraPose> poses;
    for (int i = 0; i < 9; ++i) {
        const double x = 8. * (i % 3 - 1) + 0.4 * i, y = 7. * (i / 3 - 1) - 0.3 * i;
        poses.push_back(LookAtCard({x, y, 25 - 0.5 * (i % 4)}, {0.1 * x, 0.05 * y}, 4. * (i % 5) - 8));
    }
    return poses;
}

PhotographedCard::PhotographedCard() : cells(CardImage(size, kCellsPerUnit)) {}

void PhotographedCard::PutTag(int place, int id) {
    const TagCells isBlack = CellsOfTag(id);
    const Vector2d corner = TagCorner(place, 3);
    const int x0 = int(std::lround((corner.x() + kPageUnits / 2) * kCellsPerUnit)),
              y0 = int(std::lround((kPageUnits / 2 - corner.y()) * kCellsPerUnit));
    for (int y = 0; y < kTagCells; ++y)
        for (int x = 0; x < kTagCells; ++x)
            cells.Set({x0 + x, y0 + y}, 0, isBlack[size_t(y * kTagCells + x)] ? 0.F : 1.F);
}

void PhotographedCard::Cover(int place) {
    const Vector2d corner = TagCorner(place, 3);
    const int x0 = int(std::lround((corner.x() + kPageUnits / 2) * kCellsPerUnit)),
              y0 = int(std::lround((kPageUnits / 2 - corner.y()) * kCellsPerUnit));
    for (int y = -1; y < kTagCells + 2; ++y)
        for (int x = 2; x < kTagCells + 2; ++x) cells.Set({x0 + x, y0 + y}, 0, 0.5F);
}

void PhotographedCard::Mirror() {
    const Image before = cells;
    const int side = cells.Resolution().x;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) cells.Set({x, y}, 0, before.Get({side - 1 - x, y}, 0));
}

Image TakePhotograph(const PhotographedCard& card, const Photographer& photographer, const CameraPose& pose) {
    const Int2 size = photographer.resolution;
    Image image(size, {"Y"});
    const Projector projector(card, pose);
    const double corner = 0.25 * double(size.x * size.x + size.y * size.y);
    constexpr int kBand = 32;  // rows
    ParallelFor((size.y + kBand - 1) / kBand, [&](int64_t band) {
        RowOfCorners above(projector, photographer, int(band) * kBand);
        for (int y = int(band) * kBand; y < std::min(size.y, int(band + 1) * kBand); ++y) {
            RowOfCorners below(projector, photographer, y + 1);
            for (int x = 0; x < size.x; ++x) {
                const double value =
                    MeanOver(projector, above, below, size_t(x), photographer.samplesPerEdge);
                const double fromCenter = std::pow(x - 0.5 * size.x, 2) + std::pow(y - 0.5 * size.y, 2);
                const double light =
                    photographer.exposure * (1 - photographer.vignetting * fromCenter / corner);
                image.Set({x, y}, 0, float(light * value));
            }
            above = std::move(below);
        }
    });
    return image;
}

Image Distorted(const Image& image, const Intrinsics& straight, const Intrinsics& bent) {
    const Int2 size = image.Resolution();
    Image result(size, image.Channels());
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const Vector2d p = Undistort(bent, {x + 0.5, y + 0.5});
            const Point2 st(float((straight.f * p.x() + straight.cx) / size.x),
                            float((straight.f * p.y() + straight.cy) / size.y));
            for (int c = 0; c < image.NumChannels(); ++c)
                result.Set({x, y}, c, image.Bilinear(st, c, WrapMode::Clamp));
        }
    return result;
}

Image WithNoise(Image image, double deviation, uint64_t seed) {
    std::vector<float>& pixels = image.Pixels();
    for (size_t i = 0; i < pixels.size(); ++i) {
        // The sum of four uniform numbers is normal enough for means of many, and its deviation 1/sqrt(3).
        const uint64_t bits = Hash(seed, i);
        const uint64_t sum = (bits & 0xffff) + (bits >> 16 & 0xffff) + (bits >> 32 & 0xffff) + (bits >> 48);
        const double normal = (double(sum) / 65536 - 2 + 2. / 65536) * std::sqrt(3.);
        pixels[i] = std::max(0.F, pixels[i] + float(deviation * normal));
    }
    return image;
}

std::vector<CardPhotograph> Detect(const std::vector<Image>& photographs) {
    std::vector<CardPhotograph> result(photographs.size());
    ParallelFor(int64_t(photographs.size()), [&](int64_t i) {
        result[size_t(i)] = {"p" + std::to_string(i), DetectTags(photographs[size_t(i)])};
    });
    return result;
}

std::vector<CardPhotograph> TakeAndDetect(const PhotographedCard& card, const Photographer& photographer,
                                          const std::vector<CameraPose>& poses, uint64_t seed) {
    std::vector<Image> images;
    for (const CameraPose& pose : poses) {
        images.push_back(TakePhotograph(card, photographer, pose));
        if (photographer.noise > 0)
            images.back() =
                WithNoise(std::move(images.back()), photographer.noise, Hash(seed, images.size()));
    }
    return Detect(images);
}

}  // namespace lacquer::capture::test_cards
