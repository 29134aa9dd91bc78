// The numbers of stochastic BxDFs: dimensions of the pixel's sampler first, then the path's generator.
//
// Estimators branch, and how many numbers they take is known to nobody. So they do not share the sampler's
// sequence with the integrator, whose dimensions would shift. Each query has sets of points of its own
// (Sampler::GetPoint()), by the vertex of the path, by what is asked for, and by the part of the estimate:
// the first decisions of each part take the dimensions of a point in turn, those after them the generator.
// Sets are independent of each other and of the sampler's dimensions; so are value, density and sample at
// one vertex.
#pragma once

#include <array>

#include "pbrt/base/bxdf.h"
#include "pbrt/base/sampler.h"

namespace lacquer {

/// What a stochastic BxDF is asked for.
enum class BxDFQuery { Value, Density, Sample };

/// Where a path is, for the sets of points of its queries. One for each path that an integrator follows with
/// the samples of a pixel; integrators without such paths leave BxDFContext::dimensions null.
class BxDFDimensions {
  public:
    /// No points.
    BxDFDimensions() = default;
    /// @param sampler  positioned at the path's sample, as long as the path lasts
    explicit BxDFDimensions(const Sampler& sampler) : sampler_(&sampler) {}

    /// The path arrives at vertex `number`.
    void StartVertex(int number) {
        vertex_ = uint32_t(number);
        numCalls_ = {};
    }
    const Sampler* GetSampler() const { return sampler_; }
    /// The key of the next query of this kind at the vertex; its lowest byte is 0.
    uint64_t NextKey(BxDFQuery query) {
        const uint32_t call = numCalls_[size_t(query)]++;
        return uint64_t(vertex_) << 32 | uint64_t(call & 0xffff) << 16 | uint64_t(query) << 8;
    }

  private:
    const Sampler* sampler_ = nullptr;
    uint32_t vertex_ = 0;
    std::array<uint32_t, 3> numCalls_{};
};

/// The random numbers of one query. Those of queries within it (an interface of a stack) come out of them.
class BxDFNumbers final : private LeadingNumbers {
  public:
    /// @param context    the caller's
    /// @param numCopies  estimates that the query averages
    BxDFNumbers(const BxDFContext& context, BxDFQuery query, int numCopies = 1) : context_(context) {
        if (!context.dimensions || !context.dimensions->GetSampler()) return;
        sampler_ = context.dimensions->GetSampler();
        set_ = {context.dimensions->NextKey(query), 0, uint32_t(numCopies)};
        rng_ = Rng(context.rng->NextBits(), *this);
        start_ = rng_;
        context_.rng = &rng_;
        context_.dimensions = nullptr;
    }
    ~BxDFNumbers() {
        if (sampler_ && context_.counters)
            context_.counters->numbers += int64_t(rng_.CountSince(start_)) + numLeading_;
    }
    BxDFNumbers(const BxDFNumbers&) = delete;
    BxDFNumbers& operator=(const BxDFNumbers&) = delete;

    /// With the numbers in it.
    const BxDFContext& Context() const { return context_; }
    /// Begins estimate i of the query, with points that are stratified together with those of the others.
    void StartCopy(int i) {
        if (i == 0 || !sampler_) return;
        set_.copy = uint32_t(i);
        part_ = ~0u;
        rng_.StartPart();
    }

  private:
    bool Fill(Block* block) override;
    void DoStartPart() override {
        ++part_;
        blocks_ = 0;
    }

    BxDFContext context_;
    const Sampler* sampler_ = nullptr;
    PointSet set_;
    uint32_t part_ = 0, blocks_ = 0;  ///< the blocks that the part has had
    int64_t numLeading_ = 0;          ///< numbers in all blocks
    Rng rng_, start_;
};

}  // namespace lacquer
