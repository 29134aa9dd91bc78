// Texture "marble": layers along y, perturbed by noise, coloured by a spline.
//
//   "integer octaves", "float roughness"  8, 0.5  number of octaves, and the amplitude of one relative to the
//                                                 one before: see noise.h
//   "float scale"                         1       of the coordinates
//   "float variation"                     0.2     strength of the perturbation
#include "pbrt/textures/finite_params.h"
#include "pbrt/textures/noise.h"
#include "pbrt/textures/texture_mapping.h"

namespace lacquer {

namespace {

// Control colours in sRGB; each cubic piece uses four of them, starting one further on.
constexpr int kNumColors = 9, kNumPieces = kNumColors - 3;
constexpr float kColors[kNumColors][3] = {{.58f, .58f, .6f}, {.58f, .58f, .6f}, {.58f, .58f, .6f},
                                          {.5f, .5f, .5f},   {.6f, .59f, .58f}, {.58f, .58f, .6f},
                                          {.58f, .58f, .6f}, {.2f, .2f, .33f},  {.58f, .58f, .6f}};

/// Colour at t in [0,1]. The pieces are Bezier curves over overlapping windows, so they do not join smoothly:
/// pbrt's.
RGB MarbleColor(float t) {
    const int first = std::clamp(int(t * kNumPieces), 0, kNumPieces - 1);
    const float x = t * kNumPieces - float(first), y = 1 - x;
    const float weights[4] = {y * y * y, 3 * x * y * y, 3 * x * x * y, x * x * x};
    RGB color(0);
    for (int i = 0; i < 4; ++i) {
        const float* c = kColors[first + i];
        color += weights[i] * RGB(c[0], c[1], c[2]);
    }
    return 1.5f * color;
}

class Marble final : public SpectrumTexture {
  public:
    explicit Marble(const TextureArgs& args)
        : mapping_(args),
          octaves_(OctaveParams::Read(args.params)),
          scale_(FiniteFloat(args.params, "scale", 1)),
          variation_(FiniteFloat(args.params, "variation", 0.2f)) {}
    SampledSpectrum Evaluate(const TextureContext& context, const SampledWavelengths& lambda) const override {
        const TexturePoint c = mapping_.Map(context);
        const Point3 p = scale_ * c.p;
        const float layer =
            p.y + variation_ * FractionalBrownianMotion(p, scale_ * c.dpdx, scale_ * c.dpdy, octaves_);
        const float t = std::isfinite(layer) ? 0.5f + 0.5f * std::sin(layer) : 0.5f;
        // Always an sRGB reflectance, whatever it is used for, as in pbrt.
        return SampleRGB(ColorSpace::SRGB(), MarbleColor(t), SpectrumKind::Albedo, lambda);
    }

  private:
    TextureMapping3D mapping_;
    OctaveParams octaves_;
    float scale_, variation_;
};

std::unique_ptr<SpectrumTexture> Create(const TextureArgs& args) { return std::make_unique<Marble>(args); }

}  // namespace

LACQUER_REGISTER(SpectrumTextureKind, "marble", Create);

}  // namespace lacquer
