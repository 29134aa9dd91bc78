// Primary sample space [Kelemen et al. 2002]: the uniform numbers of a path, as the state of a Markov chain.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "pbrt/base/sampler.h"

namespace lacquer {

/// The numbers of one path, which the next mutation changes a little, all of them (a small step), or draws
/// anew (a large step). Each is made when a path asks for it first, and catches up then with the steps that
/// it has missed.
///
/// Numbers are asked for in streams. What one stream takes shifts nothing in the others: a path from the
/// camera with one vertex more leaves that from the light as it was.
class PrimarySamples final : public Sampler {
  public:
    static constexpr int kNumStreams = 3;
    struct Steps {
        float largeProbability = 0.3f;
        float sigma = 0.01f;  ///< standard deviation of a small step
    };

    explicit PrimarySamples(const Steps& steps) : steps_(steps) {}
    /// The numbers of a path that no other came before, as those of a new object. Keeps its memory.
    void StartChain(uint64_t seed);
    /// What is drawn from now on comes from another seed; the path stays.
    void Reseed(uint64_t seed) { rng_ = Rng(seed); }

    /// Proposes the next path, which asks for its numbers after that. Accept() or Reject() ends the step.
    void StartStep();
    bool IsLargeStep() const { return isLarge_; }
    /// The proposed path is that of the chain.
    void Accept();
    /// The chain stays where it was before StartStep().
    void Reject();
    /// What decides between them.
    float AcceptanceNumber() { return rng_.Uniform(); }

    /// The next numbers are the first ones of a stream.
    void StartStream(int stream) {
        stream_ = size_t(stream);
        next_ = 0;
    }
    float Get1D() override { return Next(); }
    Point2 Get2D() override {
        const float x = Next();
        return {x, Next()};
    }
    /// Of the generator of stochastic BxDFs. Large steps alone draw another one: with the same numbers in
    /// every small step, what a chain follows is as smooth as the BxDFs are.
    uint64_t PathSeed() const { return pathSeed_; }

    int SamplesPerPixel() const override { return 1; }
    void StartPixelSample(Int2, int) override {}
    std::unique_ptr<Sampler> Clone() const override { return std::make_unique<PrimarySamples>(*this); }

  private:
    /// A number, and what it was before the current step.
    struct Number {
        float value = 0, before = 0;
        int64_t step = -1, stepBefore = -1;  ///< up to which it has followed
    };

    float Next() {
        std::vector<Number>& numbers = streams_[stream_];
        if (next_ == numbers.size()) numbers.emplace_back();
        Number& number = numbers[next_++];
        if (number.step != step_) Follow(&number);
        return number.value;
    }
    /// Takes the steps that a number has missed, and the current one.
    void Follow(Number* number);
    /// By so many small steps.
    void Move(Number* number, int64_t count);

    Steps steps_;
    Rng rng_;
    std::array<std::vector<Number>, kNumStreams> streams_;
    size_t stream_ = 0, next_ = 0;
    int64_t step_ = 0, largeStep_ = 0;  ///< accepted ones and the current one; the last large one accepted
    bool isLarge_ = true;
    uint64_t pathSeed_ = 0, pathSeedBefore_ = 0;
};

/// A Markov chain over primary samples that visits paths in proportion to their `contribution`, a field of
/// Path that is finite and not negative.
template <class Path>
class PrimarySampleChain {
  public:
    /// @param start  the path of the samples; its contribution is positive
    PrimarySampleChain(PrimarySamples samples, const Path& start)
        : samples_(std::move(samples)), path_(start) {}
    const Path& Current() const { return path_; }

    /// One mutation [Kelemen et al. 2002]. Both paths are recorded, with the probability that the
    /// chain goes on with each, over its contribution: the expectation of recording the one that is drawn,
    /// with less noise [Veach 1997, ch. 11].
    /// @param evaluate  path of given samples    @param record  (path, weight)
    template <class Evaluate, class Record>
    void Mutate(const Evaluate& evaluate, const Record& record) {
        samples_.StartStep();
        const Path proposed = evaluate(samples_);
        // Small and large steps are as likely in both directions.
        const float acceptance = std::min(1.f, proposed.contribution / path_.contribution);
        if (acceptance > 0) record(proposed, acceptance / proposed.contribution);
        if (acceptance < 1) record(path_, (1 - acceptance) / path_.contribution);
        if (samples_.AcceptanceNumber() < acceptance) {
            path_ = proposed;
            samples_.Accept();
        } else {
            samples_.Reject();
        }
    }

  private:
    PrimarySamples samples_;
    Path path_;
};

}  // namespace lacquer
