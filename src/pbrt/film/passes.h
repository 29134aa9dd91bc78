// The passes that a user can ask for: names of light path expressions.
#pragma once

#include <string>
#include <vector>

namespace lacquer {

/// One layer of the image: the light of the paths that an expression matches.
struct Pass {
    std::string layer, expression;
};

/// "diffuse", "direct", ..., and "lightgroups", which stands for several; in alphabetical order.
std::vector<std::string> PassNames();
/// True for one of these, and for "lpe:NAME=EXPRESSION", right or wrong.
bool IsPass(const std::string& name);
/// What is wrong with "lpe:NAME=EXPRESSION", as far as that can be told without a scene; empty if nothing is.
std::string WhyNoPass(const std::string& name);
/// The passes among `names`; a name given twice counts once.
/// @param groups  of the scene's lights, [0] being "" (none)
/// Errors: LightPathError for what WhyNoPass() refuses, and for two passes of one name.
std::vector<Pass> PassesOf(const std::vector<std::string>& names, const std::vector<std::string>& groups);
/// What is wrong with a light group's or a pass's name; empty if nothing is.
std::string WhyNoLayerName(const std::string& name);

}  // namespace lacquer
