// The ways that light may take between the interfaces of a stack where no slab scatters it, and how much of
// it they carry.
#pragma once

#include <array>
#include <span>

#include "layered/chains/chain.h"

namespace lacquer::layered {

/// Calls visit(std::span<const int> interfaces) for each way of `numEvents` events, 2 to Chain::kMaxEvents,
/// from wi to wo; none if the parity is wrong. Ends early, with false, where visit gives false.
template <class Visitor>
bool ForEachWay(const Stack& stack, Vec3 wo, Vec3 wi, int numEvents, const Visitor& visit) {
    std::array<int, Chain::kMaxEvents> way;
    const int exit = stack.OuterTowards(wo);
    const auto extend = [&](const auto& self, int count) -> bool {
        if (count == numEvents) return visit(std::span<const int>(way).first(size_t(count)));
        for (const int step : {1, -1}) {
            const int at = way[size_t(count - 1)] + step;
            if (at < 0 || at > stack.Last() || std::abs(at - exit) > numEvents - 1 - count) continue;
            way[size_t(count)] = at;
            if (!self(self, count + 1)) return false;
        }
        return true;
    };
    way[0] = stack.OuterTowards(wi);
    return extend(extend, 1);
}
/// Reflections on a way, between its first and its last event, which refract.
inline int NumTurns(std::span<const int> way) {
    int count = 0;
    for (size_t k = 1; k + 1 < way.size(); ++k) count += way[k - 1] == way[k + 1];
    return count;
}

/// What light keeps on a way at normal incidence if all interfaces are smooth, its two ends left out; what
/// lets nothing through counts as a mirror.
float StrengthOf(const Stack& stack, std::span<const int> way);
/// That of the strongest way of at most so many vertices that turns once, or, where light passes, never.
float LargestStrength(const Stack& stack, Vec3 wo, Vec3 wi, int maxVertices);
/// How often to estimate a way, at most 1: weak ones add little noise if that is seldom.
float ShareOfWay(float strength, float largest);

}  // namespace lacquer::layered
