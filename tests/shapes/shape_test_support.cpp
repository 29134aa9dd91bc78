#include "shapes/shape_test_support.h"

#include <gtest/gtest.h>

namespace lacquer::test {

namespace {

// Shapes of these tests have no textures.
class NoTextures final : public TextureLibrary {
  public:
    const FloatTexture* Float(const std::string& name, const FileLoc& loc) override {
        throw SceneError(loc, name);
    }
    const SpectrumTexture* Spectrum(const std::string& name, SpectrumKind, const FileLoc& loc) override {
        throw SceneError(loc, name);
    }
    const FloatTexture* Own(std::unique_ptr<FloatTexture>) override {
        throw std::logic_error("no textures here");
    }
    const SpectrumTexture* Own(std::unique_ptr<SpectrumTexture>) override {
        throw std::logic_error("no textures here");
    }
    ImageCache& Images() override { throw std::logic_error("no images here"); }
};

Parameter Named(const std::string& type, const std::string& name, Parameter::Values kind) {
    Parameter parameter;
    parameter.type = type;
    parameter.name = name;
    parameter.loc = {"test.pbrt", 7, 3};
    parameter.kind = kind;
    return parameter;
}

}  // namespace

Parameter Floats(const std::string& type, const std::string& name, std::vector<float> values) {
    Parameter parameter = Named(type, name, Parameter::Values::Floats);
    parameter.floats = std::move(values);
    return parameter;
}

Parameter Integers(const std::string& name, std::vector<int> values) {
    Parameter parameter = Named("integer", name, Parameter::Values::Integers);
    parameter.integers = std::move(values);
    return parameter;
}

Parameter Strings(const std::string& type, const std::string& name, std::vector<std::string> values) {
    Parameter parameter = Named(type, name, Parameter::Values::Strings);
    parameter.strings = std::move(values);
    return parameter;
}

std::vector<std::unique_ptr<Shape>> MakeShapes(const ShapeSetup& setup) {
    NoTextures textures;
    const Params params("shape \"" + setup.name + "\"", {"test.pbrt", 7, 1}, setup.parameters, nullptr);
    const ShapeKind::Factory factory = Registry<ShapeKind>::Find(setup.name);
    if (!factory) throw std::logic_error("no shape " + setup.name);
    auto shapes =
        factory({params, setup.renderFromObject, setup.reverseOrientation, textures, setup.observer});
    params.CheckAllUsed();
    return shapes;
}

std::unique_ptr<Shape> MakeShape(const ShapeSetup& setup) {
    auto shapes = MakeShapes(setup);
    if (shapes.size() != 1) throw std::logic_error("one shape is expected");
    return std::move(shapes[0]);
}

std::string ErrorOf(const ShapeSetup& setup) {
    try {
        MakeShapes(setup);
    } catch (const SceneError& error) {
        return error.what();
    } catch (const FileError& error) {
        return error.what();
    }
    return "";
}

Transform SomeRigidTransform() {
    return Transform::Translate({2, -3, 1}) * Transform::Rotate(50, {1, 2, -1});
}
Transform SomeAffineTransform() {
    return SomeRigidTransform() * Transform::Scale({0.7f, 1.3f, 2}) * Transform::Rotate(30, {0, 1, 1});
}
Transform SomeMirroringTransform() { return SomeAffineTransform() * Transform::Scale({1, -1, 1}); }

NearestHit IntersectAll(const Shape& shape, const Ray& ray, float tMin, float tMax) {
    NearestHit nearest;
    for (int i = 0; i < shape.NumPrimitives(); ++i)
        if (const auto hit = shape.Intersect(ray, tMin, tMax, i)) {
            nearest = {*hit, i};
            tMax = hit->t;
        }
    return nearest;
}

}  // namespace lacquer::test
