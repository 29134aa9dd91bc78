// How the parameters of phase functions are read, for slabs and media alike.
#pragma once

#include <optional>

#include "pbrt/base/phase_function.h"
#include "pbrt/base/texture.h"

namespace lacquer {

/// `"string phase"` with the parameters that belong to it. Errors: SceneError for an unknown name, values out
/// of their range, parameters of another phase function, and what its factory throws.
/// @param fallback  its name where neither "phase" nor "bulk" is given
std::unique_ptr<PhaseModel> ReadPhaseModel(const PhaseArgs& args, std::string_view fallback);

/// A number among the parameters: the same everywhere, or (of slabs) that of a texture.
class PhaseNumber {
  public:
    explicit PhaseNumber(float value) : value_(value) {}
    /// @param texture  not null
    explicit PhaseNumber(const FloatTexture* texture)
        : value_(texture->Constant().value_or(0.f)), texture_(texture->Constant() ? nullptr : texture) {}

    float At(const PhaseContext& context) const {
        return texture_ ? texture_->Evaluate(*context.textures) : value_;
    }
    /// The value where it is the same everywhere.
    std::optional<float> Constant() const { return texture_ ? std::nullopt : std::optional(value_); }

  private:
    float value_;
    const FloatTexture* texture_ = nullptr;
};

/// `"float name"`, or a texture where the owner has some; what is constant must lie in [low, high].
/// Errors: SceneError.
PhaseNumber ReadPhaseNumber(const PhaseArgs& args, std::string_view name, float fallback, float low,
                            float high);

/// Errors: SceneError at a texture under `name`, which the owner (a medium) cannot have.
void RefuseTexture(const PhaseArgs& args, std::string_view name);

}  // namespace lacquer
