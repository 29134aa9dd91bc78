// The configurations by which product estimators are judged.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "layered/stack_cases.h"
#include "slope_samplers.h"

namespace lacquer::bench {

namespace test = layered::test;  // whose words stacks are written with

/// A component of the light of one stack.
struct Configuration {
    std::string name;
    /// The stack; Beckmann interfaces draw their facets by the sampler, others do not care.
    std::function<std::vector<layered::test::Layer>(SlopeSampler)> layers;
    Lobes side = Lobes::Reflection;  ///< where light leaves
    int maxVertices =
        layered::kMaxPathVertices;  ///< 3: f_010 in reflection by two interfaces, f_012 through three
};

/// Configurations whose geometric mean says something.
struct ConfigurationGroup {
    std::string name;   ///< on the command line
    std::string title;  ///< in words
    std::vector<Configuration> rows;
    bool hasBeckmann = true;  ///< the sampler makes a difference
};

/// All groups. `isCoarse`: the roughness grids have three values on a side in place of five.
std::vector<ConfigurationGroup> ProductConfigurations(bool isCoarse);

}  // namespace lacquer::bench
