// The passes that a user can ask for: names of light path expressions.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "pbrt/film/light_path_automaton.h"

namespace lacquer {

/// What light did within the stack (a layered material) that the camera sees first, by the vertices of its
/// path there.
enum class LayeredPart {
    Surface,  ///< one: reflected by the outer interface, or let through by a stack of one
    Single,   ///< two or three: at most one event between going in and coming out
    Rest      ///< more
};
inline constexpr int kNumLayeredParts = 3;
constexpr LayeredPart LayeredPartOf(int numVertices) {
    return numVertices <= 1   ? LayeredPart::Surface
           : numVertices <= 3 ? LayeredPart::Single
                              : LayeredPart::Rest;
}

/// One layer of the image: the light of the paths that an expression matches, or of those that are a part of
/// what stacks scatter.
struct Pass {
    std::string layer, expression;
    std::optional<LayeredPart> part = {};
};

/// "diffuse", "direct", ..., and "lightgroups", which stands for several; in alphabetical order.
std::vector<std::string> PassNames();
/// True for one of these, and for "lpe:NAME=EXPRESSION", right or wrong.
bool IsPass(const std::string& name);
/// What is wrong with "lpe:NAME=EXPRESSION", as far as that can be told without a scene; empty if nothing is.
std::string WhyNoPass(const std::string& name);
/// The passes among `names`; a name given twice counts once. Those of expressions come first.
/// @param groups  of the scene's lights, [0] being "" (none)
/// Errors: LightPathError for what WhyNoPass() refuses, and for two passes of one name.
std::vector<Pass> PassesOf(const std::vector<std::string>& names, const std::vector<std::string>& groups);
/// All passes of a render.
class PassSet {
  public:
    /// @param passes  as PassesOf() has them
    /// Errors: those of LightPathAutomaton.
    PassSet(const std::vector<Pass>& passes, const std::vector<std::string>& groups);

    const LightPathAutomaton& Automaton() const { return automaton_; }
    const std::vector<std::string>& Layers() const { return layers_; }
    /// Index of a part's layer; -1: nobody asks.
    int LayerOf(LayeredPart part) const { return layerOfPart_[size_t(part)]; }
    bool HasLayeredParts() const { return layers_.size() > automaton_.NumPasses(); }

  private:
    LightPathAutomaton automaton_;
    std::vector<std::string> layers_;
    std::array<int, kNumLayeredParts> layerOfPart_;
};

/// What is wrong with a light group's or a pass's name; empty if nothing is.
std::string WhyNoLayerName(const std::string& name);

}  // namespace lacquer
