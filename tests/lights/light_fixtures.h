// What the tests of lights share: parameters without a parser, shapes with closed forms, integrals over the
// sphere.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "pbrt/base/light.h"
#include "pbrt/base/shape.h"
#include "pbrt/core/rng.h"
#include "pbrt/core/spectrum.h"
#include "pbrt/image/image_cache.h"

namespace lacquer::test {

inline Parameter FloatParam(const std::string& name, std::vector<float> values,
                            const std::string& type = "float") {
    Parameter p;
    p.type = type;
    p.name = name;
    p.floats = std::move(values);
    p.colorSpace = &ColorSpace::SRGB();
    return p;
}
inline Parameter StringParam(const std::string& name, const std::string& value) {
    Parameter p;
    p.type = "string";
    p.name = name;
    p.kind = Parameter::Values::Strings;
    p.strings = {value};
    return p;
}
inline Parameter BoolParam(const std::string& name, bool value) {
    Parameter p;
    p.type = "bool";
    p.name = name;
    p.kind = Parameter::Values::Bools;
    p.bools = {value};
    return p;
}
inline Params MakeParams(std::vector<Parameter> parameters) {
    return Params("light", {"test.pbrt", 1, 1}, std::move(parameters), &ColorSpace::SRGB());
}

/// A library without textures that can read images.
class NoTextures final : public TextureLibrary {
  public:
    const FloatTexture* Float(const std::string& name, const FileLoc& loc) override {
        throw SceneError(loc, name);
    }
    const SpectrumTexture* Spectrum(const std::string& name, SpectrumKind, const FileLoc& loc) override {
        throw SceneError(loc, name);
    }
    const FloatTexture* Own(std::unique_ptr<FloatTexture> texture) override {
        owned_.push_back(std::move(texture));
        return owned_.back().get();
    }
    const SpectrumTexture* Own(std::unique_ptr<SpectrumTexture>) override { return nullptr; }
    ImageCache& Images() override { return images_; }

  private:
    std::vector<std::unique_ptr<FloatTexture>> owned_;
    ImageCache images_;
};

inline std::unique_ptr<Light> MakeLight(const std::string& type, std::vector<Parameter> parameters,
                                        const Transform& renderFromLight = {},
                                        const Transform& renderFromWorld = {}) {
    NoTextures textures;
    const Params params = MakeParams(std::move(parameters));
    auto light = Registry<LightKind>::Find(type)({params, renderFromLight, renderFromWorld, textures});
    params.CheckAllUsed();
    return light;
}
inline std::vector<std::unique_ptr<Light>> MakeAreaLights(const Shape& shape,
                                                          std::vector<Parameter> parameters,
                                                          const FloatTexture* alpha = nullptr) {
    NoTextures textures;
    const Params params = MakeParams(std::move(parameters));
    auto lights = Registry<AreaLightKind>::Find("diffuse")({params, Transform(), shape, alpha, textures});
    params.CheckAllUsed();
    return lights;
}

/// Sum over integer nm of y(lambda) times the spectrum: what the scene format calls luminance.
inline double LuminanceOf(const std::function<SampledSpectrum(const SampledWavelengths&)>& spectrum) {
    constexpr int kCount = 471;
    double sum = 0;
    for (int i = 0; i < kCount; ++i) {
        // The first wavelength of each set is 360 nm + i, but for rounding.
        const auto lambda = SampledWavelengths::SampleUniform((float(i) + 0.5f) / kCount, 359.5f, 830.5f);
        sum += double(CieY().Evaluate(float(360 + i))) * double(spectrum(lambda)[0]);
    }
    return sum;
}
/// The ratio between a luminance and the first lane of spectra at kGreen, for a white light.
inline SampledWavelengths Wavelengths() { return SampledWavelengths::SampleVisible(0.3f); }
/// First lane of the white of sRGB with luminance 1.
inline double WhiteAt(const SampledWavelengths& lambda) {
    return double(ColorSpace::SRGB().Illuminant().Sample(lambda)[0]) / double(kCieYIntegral);
}

/// Integral over the sphere by the midpoint rule on the equal-area map, n^2 cells.
inline double SphereIntegral(int n, const std::function<double(Vec3)>& f) {
    double sum = 0;
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x)
            sum += f(EqualAreaSquareToSphere((Point2(float(x), float(y)) + 0.5f) / float(n)));
    return sum * 4 * double(Pi) / (double(n) * n);
}

/// Shapes that are sampled by area only.
class FlatShape : public Shape {
  public:
    std::optional<ShapeHit> Intersect(const Ray&, float, float, int) const override { return std::nullopt; }
    void Interaction(const Ray&, const ShapeHit&, int, SurfaceInteraction*) const override {}
};

/// Parallelograms p + u a + v b, one for each offset.
class Parallelogram final : public FlatShape {
  public:
    Parallelogram(Point3 p, Vec3 a, Vec3 b, std::vector<Vec3> offsets = {Vec3(0)})
        : p_(p), a_(a), b_(b), offsets_(std::move(offsets)) {}
    int NumPrimitives() const override { return int(offsets_.size()); }
    Bounds3 Bounds(int i) const override {
        const Point3 o = p_ + offsets_[size_t(i)];
        return Bounds3(o, o + a_ + b_).Union(Bounds3(o + a_, o + b_));
    }
    float Area(int) const override { return Length(Cross(a_, b_)); }
    std::optional<ShapeSample> SampleArea(int i, Point2 u) const override {
        return ShapeSample{p_ + offsets_[size_t(i)] + u.x * a_ + u.y * b_, 0, Normalize(Cross(a_, b_)), u,
                           1 / Area(i)};
    }
    std::pair<Vec3, float> NormalCone(int) const override { return {Normalize(Cross(a_, b_)), 1.f}; }

  private:
    Point3 p_;
    Vec3 a_, b_;
    std::vector<Vec3> offsets_;
};

class Ball final : public FlatShape {
  public:
    Ball(Point3 center, float radius) : center_(center), radius_(radius) {}
    Bounds3 Bounds(int) const override { return {center_ - Vec3(radius_), center_ + Vec3(radius_)}; }
    float Area(int) const override { return 4 * Pi * Sqr(radius_); }
    std::optional<ShapeSample> SampleArea(int, Point2 u) const override {
        const Vec3 n = EqualAreaSquareToSphere(u);
        return ShapeSample{center_ + radius_ * n, 0, n, u, 1 / Area(0)};
    }

  private:
    Point3 center_;
    float radius_;
};

/// An image in a temporary file that goes away with it.
class TemporaryImage {
  public:
    TemporaryImage(const std::string& name, Int2 size, const std::function<RGB(Int2)>& color)
        : path_((std::filesystem::temp_directory_path() /
                 (std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + name))
                    .string()) {
        Image image(size, {"R", "G", "B"});
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                for (int c = 0; c < 3; ++c) image.Set({x, y}, c, color({x, y})[c]);
        image.SetColorSpace(&ColorSpace::SRGB());
        WriteImage(image, path_);
    }
    ~TemporaryImage() { std::filesystem::remove(path_); }
    const std::string& Path() const { return path_; }

  private:
    std::string path_;
};

}  // namespace lacquer::test
