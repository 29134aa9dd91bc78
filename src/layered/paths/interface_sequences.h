// Sequences of interfaces that unscattered paths through a stack may meet, and how much of the light they
// carry.
#pragma once

#include <array>
#include <span>

#include "layered/paths/interface_path.h"

namespace lacquer::layered {

/// Calls visit(std::span<const int> interfaces) for each sequence of `numEvents` events, 2 to
/// InterfacePath::kMaxEvents, from wi to wo; none if the parity is wrong. Ends early, with false, where visit
/// gives false.
template <class Visitor>
bool ForEachInterfaceSequence(const Stack& stack, Vec3 wo, Vec3 wi, int numEvents, const Visitor& visit) {
    std::array<int, InterfacePath::kMaxEvents> sequence;
    const int exit = stack.OuterTowards(wo);
    const auto extend = [&](const auto& self, int count) -> bool {
        if (count == numEvents) return visit(std::span<const int>(sequence).first(size_t(count)));
        for (const int step : {1, -1}) {
            const int at = sequence[size_t(count - 1)] + step;
            if (at < 0 || at > stack.Last() || std::abs(at - exit) > numEvents - 1 - count) continue;
            sequence[size_t(count)] = at;
            if (!self(self, count + 1)) return false;
        }
        return true;
    };
    sequence[0] = stack.OuterTowards(wi);
    return extend(extend, 1);
}
/// Reflections in a sequence, between its first and its last event, which refract.
inline int NumReflections(std::span<const int> sequence) {
    int count = 0;
    for (size_t k = 1; k + 1 < sequence.size(); ++k) count += sequence[k - 1] == sequence[k + 1];
    return count;
}

/// Throughput of a sequence at normal incidence if all interfaces are smooth, its two ends left out; what
/// lets nothing through counts as a mirror.
float SmoothThroughput(const Stack& stack, std::span<const int> sequence);
/// That of the strongest sequence of at most so many vertices that reflects once, or, where light passes,
/// never.
float LargestSmoothThroughput(const Stack& stack, Vec3 wo, Vec3 wi, int maxVertices);
/// How often to estimate a sequence, at most 1: weak ones add little noise if that is seldom.
float SequenceProbability(float throughput, float largest);

}  // namespace lacquer::layered
