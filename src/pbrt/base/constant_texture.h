// Textures that are the same everywhere.
#pragma once

#include <memory>

#include "pbrt/base/texture.h"

namespace lacquer {

class FloatConstantTexture final : public FloatTexture {
  public:
    explicit FloatConstantTexture(float value) : value_(value) {}
    float Evaluate(const TextureContext&) const override { return value_; }
    std::optional<float> Constant() const override { return value_; }

  private:
    float value_;
};

class SpectrumConstantTexture final : public SpectrumTexture {
  public:
    /// @param spectrum  not null
    explicit SpectrumConstantTexture(std::unique_ptr<Spectrum> spectrum) : spectrum_(std::move(spectrum)) {}
    SampledSpectrum Evaluate(const TextureContext&, const SampledWavelengths& lambda) const override {
        return spectrum_->Sample(lambda);
    }
    bool IsConstant() const override { return true; }

  private:
    std::unique_ptr<Spectrum> spectrum_;
};

}  // namespace lacquer
