// A small texture library and parameter lists written by hand.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "pbrt/base/texture.h"
#include "pbrt/image/image_cache.h"

namespace lacquer::testing_support {

class TestLibrary final : public TextureLibrary {
  public:
    const FloatTexture* Float(const std::string& name, const FileLoc& loc) override {
        if (!floats.contains(name)) throw SceneError(loc, "no texture " + name);
        return floats[name];
    }
    const SpectrumTexture* Spectrum(const std::string& name, SpectrumKind, const FileLoc& loc) override {
        if (!spectra.contains(name)) throw SceneError(loc, "no texture " + name);
        return spectra[name];
    }
    const FloatTexture* Own(std::unique_ptr<FloatTexture> texture) override {
        return ownedFloats_.emplace_back(std::move(texture)).get();
    }
    const SpectrumTexture* Own(std::unique_ptr<SpectrumTexture> texture) override {
        return ownedSpectra_.emplace_back(std::move(texture)).get();
    }
    ImageCache& Images() override { return images_; }

    std::map<std::string, const FloatTexture*> floats;
    std::map<std::string, const SpectrumTexture*> spectra;

  private:
    std::vector<std::unique_ptr<FloatTexture>> ownedFloats_;
    std::vector<std::unique_ptr<SpectrumTexture>> ownedSpectra_;
    ImageCache images_;
};

inline Parameter Numbers(const std::string& type, const std::string& name, std::vector<float> values) {
    Parameter p;
    p.type = type;
    p.name = name;
    p.loc = {"scene.pbrt", 3, 5};
    p.floats = std::move(values);
    return p;
}
inline Parameter Integer(const std::string& name, int value) {
    Parameter p = Numbers("integer", name, {});
    p.kind = Parameter::Values::Integers;
    p.integers = {value};
    return p;
}
inline Parameter Text(const std::string& type, const std::string& name, const std::string& value) {
    Parameter p = Numbers(type, name, {});
    p.kind = Parameter::Values::Strings;
    p.strings = {value};
    return p;
}
inline Parameter Flag(const std::string& name, bool value) {
    Parameter p = Numbers("bool", name, {});
    p.kind = Parameter::Values::Bools;
    p.bools = {value};
    return p;
}
inline Params MakeParams(std::vector<Parameter> parameters) {
    return Params("texture \"test\"", {"scene.pbrt", 3, 1}, std::move(parameters), &ColorSpace::SRGB());
}

/// Makes textures through the registry, and checks that all parameters were used.
class Textures : public ::testing::Test {
  protected:
    const FloatTexture* MakeFloat(const std::string& name, std::vector<Parameter> parameters,
                                  Transform transform = {}) {
        const auto factory = Registry<FloatTextureKind>::Find(name);
        EXPECT_NE(factory, nullptr) << name;
        const Params params = MakeParams(std::move(parameters));
        const FloatTexture* texture = library.Own(factory({params, transform, library}));
        params.CheckAllUsed();
        return texture;
    }
    const SpectrumTexture* MakeSpectrum(const std::string& name, std::vector<Parameter> parameters,
                                        SpectrumKind kind = SpectrumKind::Albedo, Transform transform = {}) {
        const auto factory = Registry<SpectrumTextureKind>::Find(name);
        EXPECT_NE(factory, nullptr) << name;
        const Params params = MakeParams(std::move(parameters));
        const SpectrumTexture* texture = library.Own(factory({params, transform, library, kind}));
        params.CheckAllUsed();
        return texture;
    }
    static TextureContext At(float u, float v) {
        TextureContext context;
        context.uv = {u, v};
        return context;
    }
    static TextureContext At(Point3 p) {
        TextureContext context;
        context.p = p;
        return context;
    }

    TestLibrary library;
    SampledWavelengths lambda = SampledWavelengths::SampleVisible(0.3f);
};

}  // namespace lacquer::testing_support
