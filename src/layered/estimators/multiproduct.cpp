// Estimator "multiproduct": paths of few events from one density for all of their inner directions [Xia et
// al. 2020, sec. 4.4]; the other paths of one pass by pair products, all others by the walks of
// "bidirectional". Where a multiple product is impossible or known to be worse, it is "pairproduct".
//   productevents integer       3             events of the longest path, 3 (as in the paper) to 7
#include "layered/estimators/short_paths.h"
#include "layered/paths/interface_sequences.h"
#include "layered/paths/products/multiple_product.h"
#include "pbrt/core/params.h"

namespace lacquer::layered {
namespace {

/// The sum of the unscattered paths of at most `maxEvents` events, as far as multiple products can make them.
class MultipleProductPaths {
  public:
    MultipleProductPaths(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context, int maxVertices)
        : stack_(stack), wo_(wo), wi_(wi), context_(context), maxVertices_(maxVertices) {}

    /// Adds them to a value and says which they were.
    KnownPaths AddTo(SampledSpectrum* value, int maxEvents) {
        KnownPaths known{1, 1};
        const int shortest = SameHemisphere(wo_, wi_) ? 3 : stack_.Last() + 1;
        for (int n = shortest; stack_.Last() > 0 && n <= std::min(maxEvents, maxVertices_); n += 2) {
            const Sum direct = SumOf(n, [](int reflections) { return reflections <= 1; });
            if (!direct.isKnown) break;
            *value += direct.value;
            if (direct.count > 0) known.directVertices = n;
            // The shortest path reflects once at most; longer ones count only if all shorter ones do.
            if (n > shortest && known.vertices < n - 2) continue;
            const Sum others =
                n > shortest ? SumOf(n, [](int reflections) { return reflections > 1; }) : Sum{};
            if (!others.isKnown) continue;
            *value += others.value;
            known.vertices = n;
        }
        return known;
    }

  private:
    struct Sum {
        SampledSpectrum value{0};
        int count = 0;
        bool isKnown = true;
    };

    /// Over the sequences of n events whose number of reflections is accepted.
    template <class Accepts>
    Sum SumOf(int n, const Accepts& accepts) {
        Sum sum;
        sum.isKnown = ForEachInterfaceSequence(stack_, wo_, wi_, n, [&](std::span<const int> sequence) {
            if (!accepts(NumReflections(sequence))) return true;
            ++sum.count;
            return AddSequence(sequence, &sum.value);
        });
        return sum;
    }

    /// False where there is no product, which depends on nothing that is drawn.
    bool AddSequence(std::span<const int> sequence, SampledSpectrum* value) {
        InterfacePath path;
        if (!SetInterfacePath(stack_, wo_, wi_, sequence, &path) || !MultipleProductIsWorthwhile(path))
            return false;
        return HasMixtures(path) ? AddProduct<MultipleProductOfMixtures>(path, sequence, value)
                                 : AddProduct<MultipleProduct>(path, sequence, value);
    }
    template <class Product>
    bool AddProduct(const InterfacePath& path, std::span<const int> sequence, SampledSpectrum* value) {
        Product product;
        if (!product.Set(path)) return false;
        const float share = ShareOf(sequence);
        if (share == 1 || context_.rng->Uniform() < share)
            *value += product.Estimate(context_.mode, *context_.rng) / share;
        return true;
    }

    float ShareOf(std::span<const int> sequence) const {
        if (stack_.Last() == 1 && sequence.size() <= 3) return 1;  // there is no other
        return SequenceProbability(SmoothThroughput(stack_, sequence),
                                   LargestSmoothThroughput(stack_, wo_, wi_, maxVertices_));
    }

    const Stack& stack_;
    Vec3 wo_, wi_;
    const BxDFContext& context_;
    int maxVertices_;
};

class MultiProductEstimator final : public LayeredEstimator {
  public:
    explicit MultiProductEstimator(const Params& params)
        : maxEvents_(
              params.GetIntInRange("productevents", kMinEvents, kMinEvents, InterfacePath::kMaxEvents)) {}

    SampledSpectrum Evaluate(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                             int maxVertices) const override {
        SampledSpectrum value(0);
        // The pass down to the base and back is the strongest path, as a rule. Where it has too many events,
        // longer paths would only keep pairs from making it.
        const bool reachesBase = !SameHemisphere(wo, wi) || 2 * stack.Last() + 1 <= maxEvents_;
        const int maxEvents = reachesBase ? maxEvents_ : kMinEvents;
        KnownPaths known = MultipleProductPaths(stack, wo, wi, context, maxVertices).AddTo(&value, maxEvents);
        // Pairs make all paths of some lengths, or none.
        if (known.directVertices <= known.vertices)
            known.vertices = AddPairs(stack, wo, wi, context, known.vertices + 1,
                                      std::min(maxVertices, PairVerticesFor(stack, wo, wi)), &value);
        CountProductQuery(context, std::max(known.vertices, known.directVertices) >= 2);
        return value + EvaluateOthers(stack, wo, wi, context, maxVertices, known);
    }

  private:
    /// As many as in [Xia et al. 2020].
    static constexpr int kMinEvents = 3;

    int maxEvents_;
};

std::unique_ptr<const LayeredEstimator> CreateMultiProduct(const Params& params) {
    return std::make_unique<MultiProductEstimator>(params);
}

}  // namespace

LACQUER_REGISTER(LayeredEstimatorKind, "multiproduct", CreateMultiProduct);

}  // namespace lacquer::layered
