// Texture "bilerp": bilinear between four values v_st; the first index belongs to s, the second to t. Their
// type is that of the texture.
//
//   "v00", "v01", "v10", "v11"  0, 1, 0, 1  the values at the corners
//   "mapping", "uscale", "vscale", "udelta", "vdelta", "v1", "v2": see texture_mapping.h
#include "pbrt/textures/finite_params.h"
#include "pbrt/textures/texture_mapping.h"

namespace lacquer {

namespace {

/// The mapped point, so bounded that the extrapolation outside of the unit square stays finite.
Point2 BoundedPoint(const TextureMapping2D& mapping, const TextureContext& context) {
    constexpr float kFar = 1e15f;
    return glm::clamp(mapping.Map(context).st, Point2(-kFar), Point2(kFar));
}

class FloatBilerp final : public FloatTexture {
  public:
    FloatBilerp(std::unique_ptr<TextureMapping2D> mapping, float v00, float v01, float v10, float v11)
        : mapping_(std::move(mapping)), v00_(v00), v01_(v01), v10_(v10), v11_(v11) {}
    float Evaluate(const TextureContext& context) const override {
        const Point2 st = BoundedPoint(*mapping_, context);
        return Lerp(st.x, Lerp(st.y, v00_, v01_), Lerp(st.y, v10_, v11_));
    }

  private:
    std::unique_ptr<TextureMapping2D> mapping_;
    float v00_, v01_, v10_, v11_;
};

using SpectrumPtr = std::unique_ptr<Spectrum>;

class SpectrumBilerp final : public SpectrumTexture {
  public:
    SpectrumBilerp(std::unique_ptr<TextureMapping2D> mapping, SpectrumPtr v00, SpectrumPtr v01,
                   SpectrumPtr v10, SpectrumPtr v11)
        : mapping_(std::move(mapping)),
          v00_(std::move(v00)),
          v01_(std::move(v01)),
          v10_(std::move(v10)),
          v11_(std::move(v11)) {}
    SampledSpectrum Evaluate(const TextureContext& context, const SampledWavelengths& lambda) const override {
        const Point2 st = BoundedPoint(*mapping_, context);
        return Lerp(st.x, Lerp(st.y, v00_->Sample(lambda), v01_->Sample(lambda)),
                    Lerp(st.y, v10_->Sample(lambda), v11_->Sample(lambda)));
    }

  private:
    std::unique_ptr<TextureMapping2D> mapping_;
    SpectrumPtr v00_, v01_, v10_, v11_;
};

std::unique_ptr<FloatTexture> CreateFloat(const TextureArgs& args) {
    const Params& params = args.params;
    return std::make_unique<FloatBilerp>(MakeTextureMapping2D(args), FiniteFloat(params, "v00", 0),
                                         FiniteFloat(params, "v01", 1), FiniteFloat(params, "v10", 0),
                                         FiniteFloat(params, "v11", 1));
}

std::unique_ptr<SpectrumTexture> CreateSpectrum(const TextureArgs& args) {
    const auto corner = [&](const char* name, float fallback) {
        SpectrumPtr spectrum = args.params.GetSpectrum(name, args.kind);
        return spectrum ? std::move(spectrum) : std::make_unique<ConstantSpectrum>(fallback);
    };
    return std::make_unique<SpectrumBilerp>(MakeTextureMapping2D(args), corner("v00", 0), corner("v01", 1),
                                            corner("v10", 0), corner("v11", 1));
}

}  // namespace

LACQUER_REGISTER(FloatTextureKind, "bilerp", CreateFloat);
LACQUER_REGISTER(SpectrumTextureKind, "bilerp", CreateSpectrum);

}  // namespace lacquer
