#include "capture/card/homography.h"

#include <Eigen/Dense>
#include <cmath>

#include "capture/card/card.h"
#include "pbrt/core/check.h"

namespace lacquer::capture {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// Moves the mean to the origin and the root mean square of the distances from it to sqrt(2).
Matrix3d NormalizingTransform(std::span<const Vector2d> points) {
    Vector2d mean = Vector2d::Zero();
    for (const Vector2d& p : points) mean += p / double(points.size());
    double square = 0;
    for (const Vector2d& p : points) square += (p - mean).squaredNorm() / double(points.size());
    const double scale = square > 0 ? std::sqrt(2 / square) : 1;
    Matrix3d transform = Matrix3d::Identity();
    transform(0, 0) = transform(1, 1) = scale;
    transform.topRightCorner<2, 1>() = -scale * mean;
    return transform;
}

/// Corners of some tags on the card and in the photograph.
struct CornerPairs {
    std::vector<Vector2d> card, image;
};

CornerPairs CornersOf(std::span<const DetectedTag> tags, const std::vector<size_t>& indices, double size) {
    CornerPairs pairs;
    for (const size_t i : indices) {
        const auto corners = TagCorners(tags[i].id, size);
        pairs.card.insert(pairs.card.end(), corners.begin(), corners.end());
        pairs.image.insert(pairs.image.end(), tags[i].corners.begin(), tags[i].corners.end());
    }
    return pairs;
}

bool IsWhereCardHasIt(const DetectedTag& tag, const Matrix3d& homography, double size) {
    const auto corners = TagCorners(tag.id, size);
    for (size_t c = 0; c < 4; ++c) {
        const double edge = (tag.corners[(c + 1) % 4] - tag.corners[c]).norm();
        const Vector2d expected = (homography * corners[c].homogeneous()).hnormalized();
        if (!((expected - tag.corners[c]).norm() < 0.5 * edge)) return false;
    }
    return true;
}

}  // namespace

Matrix3d FitHomography(std::span<const Vector2d> from, std::span<const Vector2d> to) {
    LACQUER_CHECK(from.size() == to.size() && from.size() >= 4);
    const Matrix3d normalizeFrom = NormalizingTransform(from), normalizeTo = NormalizingTransform(to);
    // Rows of the equations to x H = 0, summed up as a normal matrix: normalised, it keeps enough digits.
    Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
    for (size_t i = 0; i < from.size(); ++i) {
        const Vector3d p = normalizeFrom * from[i].homogeneous(), q = normalizeTo * to[i].homogeneous();
        Eigen::Matrix<double, 2, 9> rows;
        rows << Eigen::RowVector3d::Zero(), -p.transpose(), q.y() * p.transpose(), p.transpose(),
            Eigen::RowVector3d::Zero(), -q.x() * p.transpose();
        normal += rows.transpose() * rows;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(normal);
    const Eigen::Matrix<double, 9, 1> h = solver.eigenvectors().col(0);
    const Matrix3d result = normalizeTo.inverse() *
                            Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(h.data()) *
                            normalizeFrom;
    return result / result(2, 2);
}

CardHomography FindCard(std::span<const DetectedTag> tags, double size) {
    CardHomography best;
    const auto consider = [&](const std::vector<size_t>& indices) {
        const CornerPairs pairs = CornersOf(tags, indices, size);
        CardHomography found{FitHomography(pairs.card, pairs.image), {}};
        for (size_t i = 0; i < tags.size(); ++i)
            if (IsWhereCardHasIt(tags[i], found.matrix, size)) found.consistent.push_back(i);
        if (found.consistent.size() > best.consistent.size()) best = std::move(found);
    };
    for (size_t i = 0; i < tags.size(); ++i)
        for (size_t j = i + 1; j < tags.size(); ++j) consider({i, j});
    if (best.consistent.size() < 2) return best;
    const CornerPairs pairs = CornersOf(tags, best.consistent, size);
    best.matrix = FitHomography(pairs.card, pairs.image);
    return best;
}

std::optional<double> FocalLengthOf(std::span<const Matrix3d> homographies, const Vector2d& center,
                                    double scale) {
    Matrix3d normalize = Matrix3d::Identity();
    normalize.topRightCorner<2, 1>() = -center / scale;
    normalize(0, 0) = normalize(1, 1) = 1 / scale;
    // With w = (scale / f)^2: the first two columns are at right angles, and have one length.
    double numerator = 0, denominator = 0;
    const auto addEquation = [&](double factor, double constant) {
        numerator -= factor * constant;
        denominator += factor * factor;
    };
    for (const Matrix3d& homography : homographies) {
        const Matrix3d h = normalize * homography;
        const Vector3d a = h.col(0) / h.col(0).norm(), b = h.col(1) / h.col(0).norm();
        addEquation(a.x() * b.x() + a.y() * b.y(), a.z() * b.z());
        addEquation(a.head<2>().squaredNorm() - b.head<2>().squaredNorm(), a.z() * a.z() - b.z() * b.z());
    }
    const double w = numerator / denominator;
    if (!(w > 0) || !std::isfinite(w)) return {};
    return scale / std::sqrt(w);
}

CameraPose PoseOf(const Matrix3d& homography, const Intrinsics& intrinsics) {
    Matrix3d camera = Matrix3d::Identity();
    camera.diagonal() << intrinsics.f, intrinsics.f, 1;
    camera(0, 2) = intrinsics.cx;
    camera(1, 2) = intrinsics.cy;
    Matrix3d h = camera.inverse() * homography;
    h *= 2 / (h.col(0).norm() + h.col(1).norm());
    if (h(2, 2) < 0) h = -h;  // the card lies in front of the camera
    Matrix3d columns;
    columns << h.col(0), h.col(1), h.col(0).cross(h.col(1));
    const Eigen::JacobiSVD<Matrix3d> svd(columns, Eigen::ComputeFullU | Eigen::ComputeFullV);
    CameraPose pose;
    pose.rotation = svd.matrixU() * svd.matrixV().transpose();
    pose.position = -pose.rotation.transpose() * h.col(2);
    return pose;
}

}  // namespace lacquer::capture
