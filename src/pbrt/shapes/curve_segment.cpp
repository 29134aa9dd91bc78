#include "pbrt/shapes/curve_segment.h"

#include <bit>

namespace lacquer {

namespace {

/// The column of weights that control point j has in each control point of the part [a, b] of a cubic: its
/// polar form at (a, a, a), (a, a, b), (a, b, b), (b, b, b).
constexpr ControlValues PolarWeights(int j, float a, float b) {
    ControlValues column{};
    for (int i = 0; i < 4; ++i) {
        const float arguments[3] = {i > 2 ? b : a, i > 1 ? b : a, i > 0 ? b : a};
        // Sum over the choices of j of the three arguments.
        float sum = 0;
        for (int choice = 0; choice < 8; ++choice) {
            if (std::popcount(unsigned(choice)) != j) continue;
            float product = 1;
            for (int k = 0; k < 3; ++k) product *= choice >> k & 1 ? arguments[k] : 1 - arguments[k];
            sum += product;
        }
        column[i] = sum;
    }
    return column;
}

using Weights = std::array<ControlValues, 4>;

/// The weights of all parts: those of 2^n parts stand from 2^n on.
const std::array<Weights, 2 << kMaxLog2CurveParts> kPartWeights = [] {
    std::array<Weights, 2 << kMaxLog2CurveParts> table;
    for (int count = 1; count <= 1 << kMaxLog2CurveParts; count *= 2)
        for (int part = 0; part < count; ++part)
            for (int j = 0; j < 4; ++j)
                table[size_t(count + part)][size_t(j)] =
                    PolarWeights(j, float(part) / float(count), float(part + 1) / float(count));
    return table;
}();

ControlValues Apply(const Weights& w, ControlValues v) {
    return w[0] * v[0] + w[1] * v[1] + w[2] * v[2] + w[3] * v[3];
}
BezierPoints Apply(const Weights& w, const BezierPoints& p) {
    return {Apply(w, p.x), Apply(w, p.y), Apply(w, p.z)};
}

bool All(decltype(ControlValues{} > ControlValues{}) mask) {
    const auto halves = std::bit_cast<std::array<uint64_t, 2>>(mask);
    return (halves[0] & halves[1]) == ~uint64_t(0);
}
/// True if all values lie on one side of zero, further away than the root of `distance2`.
bool AreBeyond(ControlValues v, float distance2) {
    const ControlValues zero{};
    if (!All(v * v > zero + distance2)) return false;
    return All(v > zero) || All(v < zero);
}

/// What all steps of one intersection share.
struct Query {
    const CurveStrip& strip;
    Vec3 w;            ///< unit direction of the ray
    float inverseDd;   ///< 1 / |d|^2
    float tMin, tMax;  ///< shrinks to the nearest hit
    std::optional<CurveHit> hit;
};

/// A piece of the curve in the frame of the ray: x across and y along the curve, both at right angles to the
/// ray, z along it in units of t |d|^2.
struct Piece {
    BezierPoints p;
    float u0, u1;
};

float BoxRadius(const Query& q, const Piece& piece) {
    return 0.5f * std::max(q.strip.WidthAt(piece.u0), q.strip.WidthAt(piece.u1));
}

bool MayMeet(const Query& q, const Piece& piece) {
    const float radius2 = Sqr(BoxRadius(q, piece));
    if (AreBeyond(piece.p.x, radius2) || AreBeyond(piece.p.y, radius2)) return false;
    const ControlValues zero{}, t = piece.p.z * q.inverseDd;
    return !All(t < zero + q.tMin) && !All(t > zero + q.tMax);
}

/// Halvings after which the chord is nearer to the curve than a twentieth of the width. The second
/// differences bound the distance [Wang's formula]; each halving divides it by four.
int NumHalvings(const Query& q, const Piece& piece) {
    constexpr int kMax = 10;
    float bend = 0;
    for (const ControlValues& v : {piece.p.x, piece.p.y})
        bend = std::max({bend, std::abs(v[0] - 2 * v[1] + v[2]), std::abs(v[1] - 2 * v[2] + v[3])});
    // sqrt(2): the two coordinates together; 6 / 8: degree times degree - 1, over 8.
    float distance = 1.41421356f * 6 / 8 * bend;
    const float tolerance = 0.05f * 2 * BoxRadius(q, piece);
    int halvings = 0;
    for (; halvings < kMax && distance > tolerance; ++halvings) distance *= 0.25f;
    return halvings;
}

/// Finds where an almost straight piece passes the ray, which is the origin here.
void IntersectLeaf(Query& q, const Piece& piece) {
    const BezierPoints& p = piece.p;
    const auto at = [&](int i) { return Vec2(p.x[i], p.y[i]); };
    // The tangent at an end; where control points coincide, the direction to the next one that does not.
    const auto tangent = [&](int end, int step) {
        for (int i = 1; i < 4; ++i) {
            const Vec2 d = float(step) * (at(end + step * i) - at(end));
            if (glm::dot(d, d) > 0) return d;
        }
        return Vec2(0);
    };
    // The foot of the perpendicular lies in the piece: behind its start, before its end, up to rounding.
    const float slack = 1e-3f * BoxRadius(q, piece);
    const Vec2 start = tangent(0, 1), end = tangent(3, -1);
    if (glm::dot(at(0), start) > slack * glm::length(start)) return;
    if (glm::dot(at(3), end) < -slack * glm::length(end)) return;

    const Vec2 chord = at(3) - at(0);
    const float length2 = glm::dot(chord, chord);
    if (!(length2 > 0)) return;  // the ray runs along the fibre
    float s = std::clamp(-glm::dot(at(0), chord) / length2, 0.f, 1.f);
    Vec3 c, dc;
    for (int step = 0;; ++step) {
        c = p.At(s);
        dc = p.DerivativeAt(s);
        const float dd = dc.x * dc.x + dc.y * dc.y;
        if (step == 2 || !(dd > 0)) break;
        s = std::clamp(s - (c.x * dc.x + c.y * dc.y) / dd, 0.f, 1.f);
    }

    const float u = Lerp(s, piece.u0, piece.u1), width = q.strip.WidthSeen(u, q.w);
    const float distance2 = c.x * c.x + c.y * c.y;
    if (!(distance2 <= 0.25f * width * width)) return;
    const float t = c.z * q.inverseDd;
    if (!(t > q.tMin && t < q.tMax)) return;
    q.tMax = t;
    // In this frame d x (0, 1, .) is (1, 0, .): the side on which the curve lies left of the ray.
    const float side = c.y * dc.x - c.x * dc.y, offset = width > 0 ? std::sqrt(distance2) / width : 0.f;
    q.hit = CurveHit{t, u, std::clamp(0.5f + std::copysign(offset, side), 0.f, 1.f)};
}

/// Halves the pieces that the ray may meet until they are straight.
void Search(Query& q, const Piece& whole) {
    struct Task {
        Piece piece;
        int halvings;
    };
    std::array<Task, 12> tasks;
    int count = 0;
    tasks[size_t(count++)] = {whole, NumHalvings(q, whole)};
    while (count > 0) {
        const Task task = tasks[size_t(--count)];
        if (task.halvings == 0) {
            IntersectLeaf(q, task.piece);
            continue;
        }
        const float middle = 0.5f * (task.piece.u0 + task.piece.u1);
        const Piece halves[2] = {{Apply(kPartWeights[2], task.piece.p), task.piece.u0, middle},
                                 {Apply(kPartWeights[3], task.piece.p), middle, task.piece.u1}};
        for (const Piece& half : halves)
            if (MayMeet(q, half)) tasks[size_t(count++)] = {half, task.halvings - 1};
    }
}

ControlValues Dot(const BezierPoints& p, Vec3 v) { return p.x * v.x + p.y * v.y + p.z * v.z; }

}  // namespace

Point3 BezierPoints::At(float u) const {
    const float v = 1 - u;
    const ControlValues weights{v * v * v, 3 * u * v * v, 3 * u * u * v, u * u * u};
    const ControlValues a = weights * x, b = weights * y, c = weights * z;
    return {(a[0] + a[1]) + (a[2] + a[3]), (b[0] + b[1]) + (b[2] + b[3]), (c[0] + c[1]) + (c[2] + c[3])};
}

Vec3 BezierPoints::DerivativeAt(float u) const {
    const float v = 1 - u;
    const auto derivative = [&](ControlValues p) {
        return 3 * (v * v * (p[1] - p[0]) + 2 * u * v * (p[2] - p[1]) + u * u * (p[3] - p[2]));
    };
    return {derivative(x), derivative(y), derivative(z)};
}

BezierPoints PartOf(const BezierPoints& segment, int log2Parts, int part) {
    return log2Parts == 0 ? segment : Apply(kPartWeights[size_t((1 << log2Parts) + part)], segment);
}

Normal3 CurveStrip::NormalAt(float u) const {
    const float angle = AngleBetween(normals[0], normals[1]), sine = std::sin(angle);
    // Opposite normals leave the way open: the first one holds for all.
    if (!(sine > 1e-6f)) return normals[0];
    return (std::sin((1 - u) * angle) * normals[0] + std::sin(u * angle) * normals[1]) / sine;
}

std::optional<CurveHit> IntersectCurve(const Ray& ray, float tMin, float tMax, const CurveStrip& strip) {
    const ControlValues zero{};
    const BezierPoints p{strip.p.x - (zero + ray.o.x), strip.p.y - (zero + ray.o.y),
                         strip.p.z - (zero + ray.o.z)};
    const float dd = Dot(ray.d, ray.d), radius2 = Sqr(0.5f * std::max(strip.width0, strip.width1));
    Query q{strip, Vec3(0), 1 / dd, tMin, tMax, std::nullopt};

    // The axes are at first as long as they come out: most rays miss, and need no roots.
    Vec3 across = glm::cross(ray.d, p[3] - p[0]);
    float across2 = Dot(across, across);
    if (!(across2 > 0)) {
        Vec3 other;
        CoordinateSystem(Normalize(ray.d), &across, &other);
        across2 = 1;
    }
    const ControlValues x = Dot(p, across);
    if (AreBeyond(x, radius2 * across2)) return std::nullopt;
    const Vec3 along = glm::cross(across, ray.d);
    const ControlValues y = Dot(p, along);
    if (AreBeyond(y, radius2 * across2 * dd)) return std::nullopt;
    const ControlValues z = Dot(p, ray.d), t = z * q.inverseDd;
    if (All(t < zero + tMin) || All(t > zero + tMax)) return std::nullopt;

    const float scaleX = 1 / std::sqrt(across2), scaleD = std::sqrt(q.inverseDd);
    q.w = ray.d * scaleD;
    Search(q, {{x * scaleX, y * (scaleX * scaleD), z}, strip.u0, strip.u1});
    return q.hit;
}

std::vector<Point3> ToCubicBezier(std::span<const Point3> p, int degree, bool isBSpline) {
    std::vector<Point3> result;
    const size_t n = isBSpline ? p.size() - size_t(degree) : (p.size() - 1) / size_t(degree);
    result.reserve(3 * n + 1);
    // A quadratic is a cubic with inner points two thirds of the way to its own.
    const auto addQuadratic = [&](Point3 a, Point3 b, Point3 c) {
        if (result.empty()) result.push_back(a);
        result.insert(result.end(), {(a + 2.f * b) / 3.f, (2.f * b + c) / 3.f, c});
    };
    const auto addCubic = [&](Point3 a, Point3 b, Point3 c, Point3 d) {
        if (result.empty()) result.push_back(a);
        result.insert(result.end(), {b, c, d});
    };
    for (size_t i = 0; i < n; ++i) {
        const Point3* q = p.data() + i * (isBSpline ? 1 : size_t(degree));
        if (!isBSpline && degree == 2)
            addQuadratic(q[0], q[1], q[2]);
        else if (!isBSpline)
            addCubic(q[0], q[1], q[2], q[3]);
        else if (degree == 2)
            // Between uniform knots a B-spline starts and ends half way between its control points.
            addQuadratic(0.5f * (q[0] + q[1]), q[1], 0.5f * (q[1] + q[2]));
        else
            addCubic((q[0] + 4.f * q[1] + q[2]) / 6.f, (2.f * q[1] + q[2]) / 3.f, (q[1] + 2.f * q[2]) / 3.f,
                     (q[1] + 4.f * q[2] + q[3]) / 6.f);
    }
    return result;
}

}  // namespace lacquer
