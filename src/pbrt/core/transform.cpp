#include "pbrt/core/transform.h"

#include <glm/gtc/matrix_transform.hpp>

namespace lacquer {

namespace {

bool AllFinite(const glm::mat4& m) {
    for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r)
            if (!std::isfinite(m[c][r])) return false;
    return true;
}

bool IsAffine(const glm::mat4& m) { return m[0][3] == 0 && m[1][3] == 0 && m[2][3] == 0 && m[3][3] == 1; }

/// In double: a float inverse loses half of the digits of scenes in millimetres.
glm::mat4 InverseOf(const glm::mat4& m) {
    if (!IsAffine(m)) return glm::mat4(glm::inverse(glm::dmat4(m)));
    // As nearly all are; moving objects take one for each ray that meets their bounds.
    const glm::dmat3 linear = glm::inverse(glm::dmat3(glm::mat3(m)));
    const glm::dvec3 translation = -(linear * glm::dvec3(glm::vec3(m[3])));
    return glm::mat4(glm::dmat4(glm::dvec4(linear[0], 0), glm::dvec4(linear[1], 0), glm::dvec4(linear[2], 0),
                                glm::dvec4(translation, 1)));
}

}  // namespace

Transform::Transform(const glm::mat4& m) : m_(m), inverse_(InverseOf(m)) {}

bool Transform::IsSingular() const {
    return !AllFinite(m_) || !AllFinite(inverse_) || glm::determinant(glm::dmat4(m_)) == 0;
}

bool Transform::HasScale() const {
    for (int axis = 0; axis < 3; ++axis)
        if (std::abs(LengthSquared(glm::vec3(m_[axis])) - 1) > 2e-3f) return true;
    return false;
}

Transform Transform::Translate(Vec3 d) {
    return {glm::translate(glm::mat4(1.f), d), glm::translate(glm::mat4(1.f), -d)};
}

Transform Transform::Scale(Vec3 s) { return Transform(glm::scale(glm::mat4(1.f), s)); }

Transform Transform::Rotate(float angleDeg, Vec3 axis) {
    const glm::mat4 m = glm::mat4(glm::rotate(glm::dmat4(1.0), double(angleDeg) * 0.017453292519943295,
                                              glm::normalize(glm::dvec3(axis))));
    return {m, glm::transpose(m)};
}

Transform Transform::LookAt(Point3 eye, Point3 look, Vec3 up, bool* valid) {
    const glm::dvec3 direction = glm::dvec3(look) - glm::dvec3(eye);
    *valid = glm::length(direction) > 0 && glm::length(glm::dvec3(up)) > 0;
    if (!*valid) return {};
    const glm::dvec3 forward = glm::normalize(direction);
    const glm::dvec3 side = glm::cross(glm::normalize(glm::dvec3(up)), forward);
    *valid = glm::length(side) > 1e-9;
    if (!*valid) return {};
    const glm::dvec3 right = glm::normalize(side), newUp = glm::cross(forward, right);
    const glm::dmat4 worldFromCamera{glm::dvec4(right, 0), glm::dvec4(newUp, 0), glm::dvec4(forward, 0),
                                     glm::dvec4(glm::dvec3(eye), 1)};
    return {glm::mat4(glm::inverse(worldFromCamera)), glm::mat4(worldFromCamera)};
}

Bounds3 Transform::Bounds(const Bounds3& b) const {
    Bounds3 result;
    for (int i = 0; i < 8; ++i) result = result.Union(Point(b.Corner(i)));
    return result;
}

AnimatedTransform::AnimatedTransform(const Transform& start, float startTime, const Transform& end,
                                     float endTime)
    : start_(start), end_(end), startTime_(startTime), endTime_(endTime), animated_(!(start == end)) {
    if (!animated_) return;
    parts_[0] = Decompose(start.Matrix());
    parts_[1] = Decompose(end.Matrix());
    // Of the two equal rotations q and -q, the one with the shorter arc.
    if (glm::dot(parts_[0].rotation, parts_[1].rotation) < 0) parts_[1].rotation = -parts_[1].rotation;
}

AnimatedTransform::Parts AnimatedTransform::Decompose(const glm::mat4& m) {
    Parts parts;
    parts.translation = glm::vec3(m[3]);
    // Polar decomposition M = R S by averaging with the inverse transpose until it no longer changes.
    const glm::dmat3 linear = glm::dmat3(glm::mat3(m));
    glm::dmat3 rotation = linear;
    for (int i = 0; i < 100; ++i) {
        const glm::dmat3 next = 0.5 * (rotation + glm::inverse(glm::transpose(rotation)));
        double change = 0;
        for (int c = 0; c < 3; ++c) change = std::max(change, glm::length(next[c] - rotation[c]));
        rotation = next;
        if (change < 1e-12) break;
    }
    // A mirroring belongs to S: quaternions hold proper rotations only.
    if (glm::determinant(rotation) < 0) rotation = -rotation;
    parts.rotation = glm::normalize(glm::quat(glm::quat_cast(rotation)));
    parts.scale = glm::mat3(glm::transpose(rotation) * linear);
    return parts;
}

Transform AnimatedTransform::Interpolate(float time) const {
    if (time <= startTime_) return start_;
    if (time >= endTime_) return end_;
    const float t = (time - startTime_) / (endTime_ - startTime_);
    const Vec3 translation = (1 - t) * parts_[0].translation + t * parts_[1].translation;
    const glm::quat rotation = glm::slerp(parts_[0].rotation, parts_[1].rotation, t);
    const glm::mat3 scale = parts_[0].scale * (1 - t) + parts_[1].scale * t;
    const glm::mat3 linear = glm::mat3_cast(rotation) * scale;
    return Transform(glm::mat4(glm::vec4(linear[0], 0), glm::vec4(linear[1], 0), glm::vec4(linear[2], 0),
                               glm::vec4(translation, 1)));
}

Bounds3 AnimatedTransform::MotionBounds(const Bounds3& b) const {
    if (!animated_) return start_.Bounds(b);
    // Between two samples a corner leaves their chord by at most (1 - cos(half step)) of its distance from
    // the axis; with 128 steps over at most pi that is below 1e-4 of the box's extent.
    constexpr int kSteps = 128;
    Bounds3 result;
    for (int i = 0; i <= kSteps; ++i)
        result = result.Union(At(Lerp(float(i) / kSteps, startTime_, endTime_)).Bounds(b));
    const float pad = 1e-3f * Length(result.Diagonal());
    result.min -= Vec3(pad);
    result.max += Vec3(pad);
    return result;
}

}  // namespace lacquer
