// The inputs of MaterialX's surfaces, and what they are called as parameters of "openpbr".
#pragma once

#include <span>
#include <string_view>

namespace lacquer::materialx {

enum class InputKind {
    Float,
    Color,
    Bool,
    Normal,      ///< a node `normalmap`
    Opacity,     ///< a colour whose mean is a number
    FilmInNano,  ///< thickness of a film [nm], which is there where it is above 0
    Ignored,     ///< has no counterpart
};

struct SurfaceInput {
    std::string_view name;       ///< of the input
    std::string_view parameter;  ///< of the material
    InputKind kind = InputKind::Float;
    float factor = 1;  ///< of numbers, from the input to the parameter
    /// Where the surface has another default than the parameter: that, as it would stand in the document.
    std::string_view fallback = {};
};

struct SurfaceKind {
    std::string_view category;  ///< of the node
    std::span<const SurfaceInput> inputs;
};
/// All kinds that are understood.
std::span<const SurfaceKind> SurfaceKinds();

}  // namespace lacquer::materialx
