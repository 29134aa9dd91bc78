// BxDFs that live in the file of their material: made as a scene makes them.
#pragma once

#include <memory>
#include <string>

#include "pbrt/scene/builder.h"
#include "pbrt/scene/parser.h"

namespace lacquer::test {

/// A material of scene text, such as `"thindielectric" "float eta" 1.5`. Copies share it; BxDFs that it makes
/// may refer to it.
class MaterialFromText {
  public:
    explicit MaterialFromText(const std::string& text)
        : setup_(std::make_shared<const MaterialSetup>(BuildMaterial(
              ParseText("WorldBegin Material " + text, "scene.pbrt", "", nullptr), "@1", {}, nullptr))) {}
    /// The BxDF at the origin, in `arena`. A dispersive index leaves `lambda` as it is.
    BxDF* MakeBxDF(SampledWavelengths lambda, Arena& arena) const {
        return setup_->material->MakeBxDF(TextureContext(), lambda, arena);
    }

  private:
    std::shared_ptr<const MaterialSetup> setup_;
};

}  // namespace lacquer::test
