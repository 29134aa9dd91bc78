#include "pbrt/cameras/realistic_lens.h"

#include <fmt/format.h>

#include <array>
#include <bit>

#include "pbrt/core/error.h"
#include "pbrt/core/file_bytes.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/words.h"

namespace lacquer {

namespace {

constexpr size_t kMaxLensFile = size_t(1) << 20;
constexpr size_t kMaxSurfaces = 1000;
/// [mm]: what no lens has, so that no square overflows.
constexpr float kMaxLength = 1e6f;
constexpr float kMaxIndex = 10;
const char* const kColumns = "radius of curvature, thickness, index of refraction, diameter";

struct NumberInFile {
    float value = 0;
    FileLoc loc;
};

/// The numbers of whole surfaces.
/// Errors: SceneError at the first line that holds a part of a surface, if the total is not one of whole
/// ones.
std::vector<NumberInFile> ReadNumbers(std::string_view text, const std::string& path) {
    Words words(text, path);
    std::vector<NumberInFile> numbers;
    for (std::string_view word = words.Next(); !word.empty(); word = words.Next()) {
        numbers.push_back({ParseNumber(word, words.Loc()), words.Loc()});
        if (numbers.size() > 4 * kMaxSurfaces)
            throw SceneError(words.Loc(), fmt::format("a lens of more than {} surfaces", kMaxSurfaces));
    }
    if (numbers.empty())
        throw SceneError({path, 0, 0}, fmt::format("the lens file has no surfaces: no rows of {}", kColumns));
    if (numbers.size() % 4 == 0) return numbers;
    for (size_t i = 0; i < numbers.size();) {
        size_t end = i + 1;
        while (end < numbers.size() && numbers[end].loc.line == numbers[i].loc.line) ++end;
        if ((end - i) % 4 != 0)
            throw SceneError(numbers[i].loc, fmt::format("a surface has {} of its four numbers here ({})",
                                                         (end - i) % 4, kColumns));
        i = end;
    }
    return numbers;
}

void CheckSurface(const LensSurface& surface, const NumberInFile numbers[4]) {
    const auto check = [&](bool isGood, int column, const char* problem) {
        if (!isGood)
            throw SceneError(numbers[column].loc, fmt::format(fmt::runtime(problem), numbers[column].value));
    };
    check(std::abs(surface.radius) <= kMaxLength, 0,
          "a radius of curvature of {} mm; at most 1e6 mm is expected, or 0 for a stop");
    check(surface.thickness >= 0 && surface.thickness <= kMaxLength, 1,
          "a thickness of {} mm; it must lie between 0 and 1e6 mm");
    check(surface.eta >= 1 && surface.eta <= kMaxIndex, 2,
          "an index of refraction of {}; it must lie between 1 and 10, or be 0 for air");
    check(surface.diameter > 0 && surface.diameter <= kMaxLength, 3,
          "a diameter of {} mm; it must be positive, and at most 1e6 mm");
}

}  // namespace

std::vector<LensSurface> ReadLensFile(const std::string& path, const FileLoc& loc) {
    const FileBytes file = ReadFileBytes(path, loc, {kMaxLensFile});
    const std::vector<NumberInFile> numbers = ReadNumbers(file.View(), path);
    std::vector<LensSurface> surfaces;
    for (size_t i = 0; i < numbers.size(); i += 4) {
        LensSurface surface{numbers[i].value, numbers[i + 1].value, numbers[i + 2].value,
                            numbers[i + 3].value, numbers[i].loc.line};
        if (surface.eta == 0) surface.eta = 1;
        CheckSurface(surface, &numbers[i]);
        surfaces.push_back(surface);
    }
    return surfaces;
}

LensSystem::LensSystem(const std::vector<LensSurface>& surfaces, float stopDiameter) {
    float z = 0;
    for (size_t i = surfaces.size(); i-- > 0;) {
        const LensSurface& s = surfaces[i];
        const bool isStop = s.radius == 0;
        z += s.thickness;
        // No surface is wider than its sphere.
        const float diameter =
            isStop ? std::min(s.diameter, stopDiameter) : std::min(s.diameter, 2 * std::abs(s.radius));
        const float etaAhead = i > 0 ? surfaces[i - 1].eta : 1;
        surfaces_.push_back({isStop ? 0.f : -1 / s.radius, z, Sqr(diameter / 2), 2 / diameter,
                             isStop ? 1.f : s.eta / etaAhead});
    }
}

CardinalPoints LensSystem::Cardinals() const {
    // Height and slope of a ray behind the lens are linear in those on the film's side: columns of the system
    // matrix. Heights are measured at the vertices.
    double height[2] = {1, 0}, slope[2] = {0, 1};
    for (size_t i = 0; i < surfaces_.size(); ++i) {
        const Surface& s = surfaces_[i];
        const double gap = i > 0 ? double(s.z) - double(surfaces_[i - 1].z) : 0;
        const double ratio = double(s.etaRatio), curvature = double(s.curvature);
        for (int k = 0; k < 2; ++k) {
            height[k] += gap * slope[k];
            // n' u' = n u - (n' - n) c h, where c > 0 has its centre ahead.
            slope[k] = ratio * slope[k] - (1 - ratio) * curvature * height[k];
        }
    }
    // A ray parallel to the axis from the film (1, 0) leaves with slope -1/f and, followed back to height 1,
    // meets the principal plane of the scene's side; the other one follows from the same for reversed rays,
    // with the determinant of the matrix, 1 between air and air.
    CardinalPoints points;
    points.focalLength = float(-1 / slope[0]);
    points.frontPrincipal = float(double(FrontZ()) + (1 - height[0]) / slope[0]);
    points.rearPrincipal = float(double(RearZ()) - (1 - slope[1]) / slope[0]);
    return points;
}

float LensSystem::NearestFocus() const {
    const CardinalPoints c = Cardinals();
    return 4 * c.focalLength + c.frontPrincipal - c.rearPrincipal;
}

bool LensSystem::Focus(float distance) {
    const CardinalPoints c = Cardinals();
    const double f = double(c.focalLength);
    if (!(f > 0) || !std::isfinite(f)) return false;
    // Object and image distances s + s' = d, between principal planes, and 1/s + 1/s' = 1/f. Of the two
    // solutions the one with the lens near the film; written such that distant objects keep their digits.
    const double d = double(distance) - double(c.frontPrincipal) + double(c.rearPrincipal);
    if (!(d >= 4 * f)) return false;
    const double imageDistance = 2 * f / (1 + std::sqrt(1 - 4 * f / d));
    const auto shift = float(imageDistance - double(c.rearPrincipal));
    if (!(RearZ() + shift > 0)) return false;
    for (Surface& s : surfaces_) s.z += shift;
    return true;
}

float LensSystem::RearSag() const {
    const Surface& s = surfaces_.front();
    if (s.curvature == 0) return 0;
    const float radius = 1 / s.curvature;
    return radius - std::copysign(SafeSqrt(Sqr(radius) - s.radius2), radius);
}

namespace {

using Lanes = LensRays::Lanes;
using Mask = LensRays::Mask;

/// Square roots, of 0 for negative numbers. An array, for which the compiler finds the vector instruction.
Lanes SafeSqrt(Lanes x) {
    auto values = std::bit_cast<std::array<float, LensRays::kCount>>(x > 0.f ? x : Lanes{});
    for (float& value : values) value = std::sqrt(value);
    return std::bit_cast<Lanes>(values);
}
/// True if one of the first `count` lanes is set.
bool AnyOf(Mask mask, int count) {
    int any = 0;
    for (int i = 0; i < count; ++i) any |= mask[i];
    return any != 0;
}
Mask FirstLanes(int count) { return Mask{0, 1, 2, 3} < count; }

}  // namespace

LensRays::Mask LensSystem::Trace(LensRays* rays, int blocked, Stops stops) const {
    Lanes x = rays->ox, y = rays->oy, z = rays->oz, dx = rays->dx, dy = rays->dy, dz = rays->dz;
    Lanes stopRadius2{};
    const Mask canBeBlocked = FirstLanes(blocked);
    Mask alive = {-1, -1, -1, -1};
    for (const Surface& s : surfaces_) {
        // To the plane of the vertex, from there on to the sphere.
        const Lanes toPlane = (s.z - z) / dz;
        x += toPlane * dx;
        y += toPlane * dy;
        z = Lanes{} + s.z;
        if (s.curvature == 0) {
            rays->stopX = x * s.invRadius;
            rays->stopY = y * s.invRadius;
            const Lanes r2 = rays->stopX * rays->stopX + rays->stopY * rays->stopY;
            stopRadius2 = r2 > stopRadius2 ? r2 : stopRadius2;
            if (stops == Stops::Block) alive &= (r2 <= 1.f) | ~canBeBlocked;
            if (!AnyOf(alive, blocked)) break;
            continue;
        }
        const Lanes f = s.curvature * (x * x + y * y), g = dz - s.curvature * (x * dx + y * dy);
        const Lanes cos2 = g * g - s.curvature * f;
        const Lanes cosI = SafeSqrt(cos2);
        const Lanes t = f / (g + cosI);
        x += t * dx;
        y += t * dy;
        z += t * dz;
        const Lanes nz = 1 - s.curvature * (z - s.z);
        alive &= (cos2 >= 0.f) & (nz > 0.f) & ((x * x + y * y <= s.radius2) | ~canBeBlocked);

        // Snell's law.
        const Lanes cosT2 = 1 - s.etaRatio * s.etaRatio * (1 - cosI * cosI);
        alive &= cosT2 > 0.f;
        if (!AnyOf(alive, blocked)) break;
        const Lanes along = SafeSqrt(cosT2) - s.etaRatio * cosI;
        dx = s.etaRatio * dx - along * s.curvature * x;
        dy = s.etaRatio * dy - along * s.curvature * y;
        dz = s.etaRatio * dz + along * nz;
    }
    rays->ox = x, rays->oy = y, rays->oz = z, rays->dx = dx, rays->dy = dy, rays->dz = dz;
    rays->stopRadius2 = stopRadius2;
    return alive;
}

namespace {

/// Searches the box of the exit pupil for one point of the film.
class PupilSearch {
  public:
    using Box = ExitPupils::Box;
    PupilSearch(const LensSystem& lens, float filmX, float stopScale)
        : lens_(lens), filmX_(filmX), stopScale2_(Sqr(stopScale)) {}

    /// Where the plane must be crossed by rays that meet the surface next to the film.
    Box WholeSurface() const {
        // The rim's depth moves what is seen of it: extremes of the projections of a box around the cap.
        const float rear = lens_.RearZ(), radius = lens_.RearRadius();
        Box box{Point2(Infinity), Point2(-Infinity)};
        for (const float z : {rear, rear + lens_.RearSag()}) {
            const float scale = rear / std::max(z, 1e-3f * rear);
            for (const float sign : {-1.f, 1.f}) {
                const Point2 p(filmX_ + (sign * radius - filmX_) * scale, sign * radius * scale);
                box.min = glm::min(box.min, p);
                box.max = glm::max(box.max, p);
            }
        }
        return box;
    }

    /// The box of the points that let light through, a little larger; the whole surface where none is found.
    Box Find() const {
        const Box whole = WholeSurface();
        Box box = whole;
        Grid grid = Scan(box, kCoarse);
        if (!grid.hasBest) grid = Scan(box, kFine);
        // The stop may be much finer than the grid: look at ever smaller parts around the ray that passes
        // nearest to its middle, until some ray gets through.
        for (int zoom = 0; zoom < 8 && grid.hasBest && grid.numThrough == 0; ++zoom) {
            const Vec2 half = (box.max - box.min) / 16.f;
            box = {grid.best - half, grid.best + half};
            grid = Scan(box, kCoarse);
        }
        // Close in on what was found; where it goes on beyond the part, open that again.
        for (int round = 0; round < 12 && grid.numThrough > 0; ++round) {
            const bool isCut = ReachesEdge(grid.through, box) && Holds(whole, Grown(box, Cell(box, kCoarse)));
            if (!isCut && round >= 2) break;
            const Vec2 margin = isCut ? box.max - box.min : Cell(box, kCoarse);
            box = Clipped(Grown(grid.through, margin), whole);
            grid = Scan(box, kCoarse);
        }
        if (grid.numThrough > 0) grid = Scan(box, kFine);
        if (grid.numThrough == 0) return whole;
        // Two cells, for corners that are too sharp for the grid.
        return Clipped(Grown(grid.through, 2.f * Cell(box, kFine)), whole);
    }

  private:
    static constexpr int kCoarse = 32, kFine = 96;

    struct Grid {
        Box through{Point2(Infinity), Point2(-Infinity)};  ///< of the points that let light through
        int numThrough = 0;
        bool hasBest = false;
        Point2 best{0};  ///< nearest to the middle of the stop among those that only the stop may block
        float bestRadius2 = Infinity;
    };

    static Vec2 Cell(const Box& box, int count) { return (box.max - box.min) / float(count - 1); }
    static Box Grown(const Box& box, Vec2 margin) { return {box.min - margin, box.max + margin}; }
    static Box Clipped(const Box& box, const Box& to) {
        return {glm::max(box.min, to.min), glm::min(box.max, to.max)};
    }
    static bool Holds(const Box& box, const Box& other) {
        return other.min.x >= box.min.x && other.min.y >= box.min.y && other.max.x <= box.max.x &&
               other.max.y <= box.max.y;
    }
    static bool ReachesEdge(const Box& part, const Box& box) {
        const Vec2 cell = Cell(box, kCoarse);
        return !Holds({box.min + cell / 2.f, box.max - cell / 2.f}, part);
    }

    /// Traces through count x count points of the box, its edges included.
    Grid Scan(const Box& box, int count) const {
        Grid grid;
        const Vec2 cell = Cell(box, count);
        for (int row = 0; row < count; ++row)
            for (int column = 0; column < count; column += LensRays::kCount) {
                std::array<Point2, LensRays::kCount> points;
                for (int i = 0; i < LensRays::kCount; ++i)
                    points[size_t(i)] = box.min + cell * Vec2(float(column + i), float(row));
                Count(points, &grid);
            }
        return grid;
    }

    void Count(const std::array<Point2, LensRays::kCount>& points, Grid* grid) const {
        LensRays rays{};
        for (int i = 0; i < LensRays::kCount; ++i) {
            const Point2 p = points[size_t(i)];
            const Vec3 d = Normalize(Vec3(p.x - filmX_, p.y, lens_.RearZ()));
            rays.ox[i] = filmX_;
            rays.dx[i] = d.x, rays.dy[i] = d.y, rays.dz[i] = d.z;
        }
        const Mask alive = lens_.Trace(&rays, LensRays::kCount, LensSystem::Stops::Ignore);
        for (int i = 0; i < LensRays::kCount; ++i) {
            if (!alive[i]) continue;
            const Point2 p = points[size_t(i)];
            if (rays.stopRadius2[i] <= stopScale2_) {
                grid->through.min = glm::min(grid->through.min, p);
                grid->through.max = glm::max(grid->through.max, p);
                ++grid->numThrough;
            }
            if (rays.stopRadius2[i] >= grid->bestRadius2) continue;
            grid->hasBest = true;
            grid->bestRadius2 = rays.stopRadius2[i];
            grid->best = p;
        }
    }

    const LensSystem& lens_;
    float filmX_, stopScale2_;
};

}  // namespace

ExitPupils::ExitPupils(const LensSystem& lens, float filmRadius, float stopScale) : boxes_(kRings) {
    // Filters take points from a little beyond the film's corners.
    constexpr float kMargin = 1.02f;
    perRadius_ = kRings / (kMargin * filmRadius);
    ParallelFor(kRings, [&](int64_t ring) {
        Box& box = boxes_[size_t(ring)];
        box = {Point2(Infinity), Point2(-Infinity)};
        for (const float part : {0.f, 0.5f, 1.f}) {
            const Box found = PupilSearch(lens, (float(ring) + part) / perRadius_, stopScale).Find();
            box.min = glm::min(box.min, found.min);
            box.max = glm::max(box.max, found.max);
        }
    });
}

}  // namespace lacquer
