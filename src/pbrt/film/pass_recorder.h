// The passes of one camera sample; one for each thread.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <span>

#include "pbrt/base/bxdf.h"
#include "pbrt/film/passes.h"

namespace lacquer {

/// Values of each LayeredPart.
using LayeredParts = std::array<SampledSpectrum, kNumLayeredParts>;

/// Sums the light that paths of a camera sample find, by the expressions of an automaton and by what it did
/// in the stack that the camera sees.
class PassRecorder {
  public:
    explicit PassRecorder(const PassSet& passes)
        : passes_(&passes), automaton_(&passes.Automaton()), sums_(passes.Layers().size()) {}

    /// A new camera sample. @param seed  of random numbers that nothing but passes depends on
    void Start(uint64_t seed) {
        std::fill(sums_.begin(), sums_.end(), SampledSpectrum(0));
        rng_ = Rng(seed);
        followed_.reset();
    }
    /// All that was added counts for so much.
    void Scale(float factor) {
        if (factor == 1) return;
        for (SampledSpectrum& sum : sums_) sum *= factor;
    }
    std::span<const SampledSpectrum> Sums() const { return sums_; }
    Rng& Random() { return rng_; }

    bool WantsLayeredParts() const { return passes_->HasLayeredParts(); }
    /// Adds light that a stack sends to the camera.
    void AddLayered(const LayeredParts& light) {
        for (int i = 0; i < kNumLayeredParts; ++i)
            if (const int layer = passes_->LayerOf(LayeredPart(i)); layer >= 0)
                sums_[size_t(layer)] += light[size_t(i)];
    }
    /// The path was scattered by a stack first: so much of all light that it finds from now on belongs to
    /// each part.
    void FollowLayered(const LayeredParts& shares) { followed_ = shares; }

  private:
    friend class PathPasses;
    const PassSet* passes_;
    const LightPathAutomaton* automaton_;
    std::vector<SampledSpectrum> sums_;
    std::optional<LayeredParts> followed_;  ///< shares of the parts in what the path finds
    Rng rng_;
};

/// Of one path: what it has met, as states of the automaton. Integrators tell it of every event, and of all
/// light that they add to their result, in the same unit. Costs a comparison each where nobody asks.
class PathPasses {
  public:
    PathPasses() = default;
    /// @param recorder  null: nobody asks
    explicit PathPasses(PassRecorder* recorder) : recorder_(recorder) {}
    explicit operator bool() const { return recorder_; }
    Rng& Random() const { return recorder_->rng_; }
    PassRecorder& Recorder() const { return *recorder_; }

    void Meet(PathEvent event) {
        if (!recorder_) return;
        for (State& state : states_) state = recorder_->automaton_->Next(state, event);
    }
    /// One event or another one, drawn for each wavelength: `first` with the probability `share`. One path
    /// then belongs to different passes at different wavelengths, and each pass gets its share in the mean.
    void MeetEither(PathEvent first, PathEvent second, SampledSpectrum share) {
        const float u = recorder_->rng_.Uniform();
        for (int i = 0; i < kNumWavelengths; ++i) {
            State& state = states_[size_t(i)];
            state = recorder_->automaton_->Next(state, u < share[i] ? first : second);
        }
        isSplit_ = true;
    }
    void Add(PathSource source, int group, SampledSpectrum light) const {
        if (!recorder_) return;
        if (recorder_->followed_) AddLayered(*recorder_->followed_, light);
        if (!isSplit_)
            AddTo(states_[0], source, group, light);
        else
            for (int i = 0; i < kNumWavelengths; ++i) {
                SampledSpectrum::Lanes lane{};
                lane[i] = light[i];
                AddTo(states_[size_t(i)], source, group, lane);
            }
    }
    /// The same after one event more.
    void AddAfter(PathEvent event, PathSource source, int group, SampledSpectrum light) const {
        if (!recorder_) return;
        PathPasses next = *this;
        next.Meet(event);
        next.Add(source, group, light);
    }

  private:
    using State = LightPathAutomaton::State;
    void AddLayered(LayeredParts shares, SampledSpectrum light) const {
        for (SampledSpectrum& share : shares) share *= light;
        recorder_->AddLayered(shares);
    }
    void AddTo(State state, PathSource source, int group, SampledSpectrum light) const {
        for (uint64_t left = recorder_->automaton_->PassesOf(state, source, group); left; left &= left - 1)
            recorder_->sums_[size_t(std::countr_zero(left))] += light;
    }

    PassRecorder* recorder_ = nullptr;
    std::array<State, kNumWavelengths> states_{};  ///< kStart
    bool isSplit_ = false;                         ///< the states may differ
};

/// True for a BxDF whose rough scattering is of two kinds: a stack with a rough surface and diffuse light
/// from below. Evaluate() with Lobes::Glossy among the sides then gives the glossy part alone.
inline bool HasBothKinds(Lobes flags) { return Any(flags, Lobes::Diffuse) && Any(flags, Lobes::Glossy); }
/// Scattering at a surface that is neither specular nor of two kinds. It belongs to the BxDF and not to the
/// lobe that a sample drew, so that samples of lights and of BxDFs tell the same of a pair of directions.
inline PathEvent EventOf(Lobes kind, bool isTransmission) {
    if (Any(kind, Lobes::Diffuse))
        return isTransmission ? PathEvent::DiffuseTransmission : PathEvent::DiffuseReflection;
    return isTransmission ? PathEvent::GlossyTransmission : PathEvent::GlossyReflection;
}
/// That of a draw from a BxDF with these flags; of two kinds, what the draw says.
inline PathEvent EventOf(Lobes flags, const BxDFSample& sample) {
    if (sample.IsSpecular())
        return sample.IsTransmission() ? PathEvent::SpecularTransmission : PathEvent::SpecularReflection;
    return EventOf(HasBothKinds(flags) ? sample.lobe : flags, sample.IsTransmission());
}

}  // namespace lacquer
