// Shapes for tests, made through the registry as a scene makes them.
#pragma once

#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "pbrt/base/shape.h"
#include "pbrt/core/progress.h"

namespace lacquer::test {

Parameter Floats(const std::string& type, const std::string& name, std::vector<float> values);
Parameter Integers(const std::string& name, std::vector<int> values);
Parameter Strings(const std::string& type, const std::string& name, std::vector<std::string> values);

struct ShapeSetup {
    std::string name;
    std::vector<Parameter> parameters;
    Transform renderFromObject{};
    bool reverseOrientation = false;
    Observer* observer = nullptr;
};
/// The shapes that the factory makes; checks that it looked at every parameter.
std::vector<std::unique_ptr<Shape>> MakeShapes(const ShapeSetup& setup);
/// The only shape that it makes.
std::unique_ptr<Shape> MakeShape(const ShapeSetup& setup);
/// The text of the SceneError (or FileError) that making the shape throws; empty if it throws none.
std::string ErrorOf(const ShapeSetup& setup);

/// Translate, rotate, scale differently along the axes, and mirror: each adds to the one before.
Transform SomeRigidTransform();
Transform SomeAffineTransform();
Transform SomeMirroringTransform();

/// Nearest hit over all primitives, with its primitive; primitive -1 if there is none.
struct NearestHit {
    ShapeHit hit;
    int primitive = -1;
};
NearestHit IntersectAll(const Shape& shape, const Ray& ray, float tMin = 0, float tMax = Infinity);

}  // namespace lacquer::test
