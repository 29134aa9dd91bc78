// What directives change and shapes, lights and the like inherit.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "pbrt/scene/description.h"

namespace lacquer {

/// Kinds that Attribute directives address.
enum class AttributeTarget { Shape, Light, Material, Medium, Texture };
inline constexpr size_t kNumAttributeTargets = 5;
inline constexpr std::array<const char*, kNumAttributeTargets> kAttributeTargets = {
    "shape", "light", "material", "medium", "texture"};

/// Saved by AttributeBegin and ObjectBegin, restored by their ends; copied for Import.
struct GraphicsState {
    TransformPair ctm;
    std::optional<FileLoc>
        singularSince;  ///< the directive that took the CTM's inverse away, while it has none
    bool startActive = true, endActive = true;  ///< which of the two matrices transform directives change
    std::string insideMedium, outsideMedium;
    FileLoc mediumLoc;  ///< of the MediumInterface in force
    MaterialRef material;
    FileLoc materialLoc;  ///< of the NamedMaterial in force
    int areaLight = -1;
    bool reverseOrientation = false;
    const lacquer::ColorSpace* colorSpace = &lacquer::ColorSpace::SRGB();
    std::array<AttributeList, kNumAttributeTargets> attributes;

    const AttributeList& AttributesOf(AttributeTarget target) const { return attributes[size_t(target)]; }
};

}  // namespace lacquer
