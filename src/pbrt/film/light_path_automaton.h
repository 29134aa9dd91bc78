// Which light paths belong to which pass: light path expressions, compiled to one automaton for all of them.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace lacquer {

/// What happens at a vertex of a path: reflection or transmission, diffuse, glossy or specular; or scattering
/// in a medium. What is below a surface with subsurface scattering is one diffuse transmission.
enum class PathEvent : uint8_t {
    DiffuseReflection,
    GlossyReflection,
    SpecularReflection,
    DiffuseTransmission,
    GlossyTransmission,
    SpecularTransmission,
    Volume
};
inline constexpr int kNumPathEvents = 7;
/// What a path ends at.
enum class PathSource : uint8_t {
    Light,       ///< of finite size or distance, and in one direction
    Background,  ///< an infinite light
    Medium       ///< one that glows
};
inline constexpr int kNumPathSources = 3;
/// Of one scene, those without name left out.
inline constexpr int kMaxLightGroups = 48;
inline constexpr int kMaxPasses = 64;

/// An expression is wrong; the text says where and what was expected.
class LightPathError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// A deterministic automaton: its state is a number that a path carries from the camera on. All functions
/// that a path calls are look-ups.
class LightPathAutomaton {
  public:
    using State = uint16_t;
    static constexpr State kStart = 0;

    /// @param expressions  at most kMaxPasses; docs/aovs.md has their syntax
    /// @param groups       names of light groups, [0] being "" (none)
    /// Errors: LightPathError, also for an expression that no path can match.
    LightPathAutomaton(const std::vector<std::string>& expressions, const std::vector<std::string>& groups);

    size_t NumPasses() const { return numPasses_; }
    size_t NumStates() const { return next_.size() / kNumPathEvents; }
    State Next(State state, PathEvent event) const {
        return next_[size_t(state) * kNumPathEvents + size_t(event)];
    }
    /// Bit i: the path belongs to expression i if it ends at such a source.
    uint64_t PassesOf(State state, PathSource source, int group) const {
        return passes_[(size_t(state) * numGroups_ + size_t(group)) * kNumPathSources + size_t(source)];
    }

  private:
    size_t numPasses_, numGroups_;
    std::vector<State> next_;       ///< [state][event]
    std::vector<uint64_t> passes_;  ///< [state][group][source]
};

/// Errors: LightPathError, where `expression` is wrong whatever the scene's light groups are.
void CheckLightPathExpression(const std::string& expression);

}  // namespace lacquer
