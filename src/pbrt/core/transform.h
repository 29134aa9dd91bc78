// Affine and projective transforms with their inverses, and transforms that move with time.
#pragma once

#include <glm/gtc/quaternion.hpp>

#include "pbrt/core/vec.h"

namespace lacquer {

/// A 4x4 matrix and its inverse. Column vectors: (A * B)(p) applies B first.
class Transform {
  public:
    Transform() : m_(1.f), inverse_(1.f) {}
    /// Computes the inverse; see IsSingular().
    explicit Transform(const glm::mat4& m);
    Transform(const glm::mat4& m, const glm::mat4& inverse) : m_(m), inverse_(inverse) {}

    static Transform Translate(Vec3 d);
    static Transform Scale(Vec3 s);
    /// Right-hand-rule rotation formula; the axis need not be unit but not zero.
    static Transform Rotate(float angleDeg, Vec3 axis);
    /// World to camera, camera axes +x right, +y up, +z forward (left-handed, as pbrt). `valid` is false, and
    /// the result the identity, where eye = look or up is parallel to the view direction.
    static Transform LookAt(Point3 eye, Point3 look, Vec3 up, bool* valid);

    const glm::mat4& Matrix() const { return m_; }
    const glm::mat4& InverseMatrix() const { return inverse_; }
    Transform Inverse() const { return {inverse_, m_}; }
    /// True where the matrix has no usable inverse or an element that is not finite.
    bool IsSingular() const;
    bool IsIdentity() const { return m_ == glm::mat4(1.f); }
    /// True where the determinant of the linear part is negative (a mirroring).
    bool SwapsHandedness() const { return glm::determinant(glm::mat3(m_)) < 0; }
    /// True where lengths change by more than a relative 1e-3 in some axis direction.
    bool HasScale() const;

    /// Projective point transform; the division is skipped where w is 1.
    Point3 Point(Point3 p) const { return ApplyPoint(m_, p); }
    Vec3 Vector(Vec3 v) const { return ApplyVector(m_, v); }
    /// Normals by the inverse transpose; not renormalised.
    Normal3 Normal(Normal3 n) const { return ApplyTransposed(inverse_, n); }
    Point3 InversePoint(Point3 p) const { return ApplyPoint(inverse_, p); }
    Vec3 InverseVector(Vec3 v) const { return ApplyVector(inverse_, v); }
    Normal3 InverseNormal(Normal3 n) const { return ApplyTransposed(m_, n); }
    lacquer::Ray Ray(const lacquer::Ray& r) const { return {Point(r.o), Vector(r.d), r.time}; }
    lacquer::Ray InverseRay(const lacquer::Ray& r) const {
        return {InversePoint(r.o), InverseVector(r.d), r.time};
    }
    Bounds3 Bounds(const Bounds3& b) const;

    Transform operator*(const Transform& b) const { return {m_ * b.m_, b.inverse_ * inverse_}; }
    bool operator==(const Transform& b) const { return m_ == b.m_; }

  private:
    static Point3 ApplyPoint(const glm::mat4& m, Point3 p) {
        const glm::vec3 q =
            glm::vec3(m[0]) * p.x + glm::vec3(m[1]) * p.y + glm::vec3(m[2]) * p.z + glm::vec3(m[3]);
        const float w = m[0][3] * p.x + m[1][3] * p.y + m[2][3] * p.z + m[3][3];
        return w == 1 ? q : q / w;
    }
    static Vec3 ApplyVector(const glm::mat4& m, Vec3 v) {
        return glm::vec3(m[0]) * v.x + glm::vec3(m[1]) * v.y + glm::vec3(m[2]) * v.z;
    }
    static Vec3 ApplyTransposed(const glm::mat4& m, Vec3 n) {
        return {glm::dot(glm::vec3(m[0]), n), glm::dot(glm::vec3(m[1]), n), glm::dot(glm::vec3(m[2]), n)};
    }
    glm::mat4 m_, inverse_;
};

/// A transform that moves between two key transforms: translation linearly, rotation by spherical
/// interpolation, and the remaining scale component-wise [Shoemake and Duff 1992, polar decomposition].
class AnimatedTransform {
  public:
    AnimatedTransform() = default;
    explicit AnimatedTransform(const Transform& still) : start_(still), end_(still) {}
    AnimatedTransform(const Transform& start, float startTime, const Transform& end, float endTime);

    bool IsAnimated() const { return animated_; }
    const Transform& Start() const { return start_; }
    const Transform& End() const { return end_; }
    /// The transform at `time`, clamped to the key times.
    Transform At(float time) const { return animated_ ? Interpolate(time) : start_; }
    /// Bounds of a moving box: the union over dense time samples, padded by the chord error between them.
    Bounds3 MotionBounds(const Bounds3& b) const;

  private:
    struct Parts {
        Vec3 translation{0};
        glm::quat rotation{1, 0, 0, 0};
        glm::mat3 scale{1.f};
    };
    static Parts Decompose(const glm::mat4& m);
    Transform Interpolate(float time) const;

    Transform start_, end_;
    float startTime_ = 0, endTime_ = 1;
    bool animated_ = false;
    Parts parts_[2];
};

}  // namespace lacquer
