// Which lobes are fitted: the one table that a new model of a boundary needs a row in.
#pragma once

#include <span>
#include <string_view>

#include "gaussfit/lobe/lobe.h"

namespace lacquer::gaussfit {

/// A family of slices f(w, .), one for each alpha, eta and angle of incidence, and how it is fitted.
struct LobeModel {
    /// f(w, v) [1/sr] without the cosine, up to a factor that does not depend on v.
    /// @param eta   index on the far side over index on the side of w; not looked at for reflections
    /// @param w, v  unit, away from the surface; w.z > 0, v on the side where the event sends it
    using Function = float (*)(float alpha, float eta, Vec3 w, Vec3 v);

    const char* name;  ///< also of the file: data/lobes/NAME.txt
    MicrofacetModel distribution;
    LobeEvent event;
    int numComponents;  ///< of the mixture, 1 or 2
    int cosinePower;    ///< c of f |cos|^c, which is what a lobe resembles
    Function f;

    bool Transmits() const { return event != LobeEvent::Reflection; }
};

/// All models, in the order in which they are fitted.
std::span<const LobeModel> LobeModels();
/// Null if there is none of that name.
const LobeModel* FindLobeModel(std::string_view name);

}  // namespace lacquer::gaussfit
