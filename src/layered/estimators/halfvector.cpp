// Estimator "halfvector": the shortest path through the facets that it meets, all other light by walks from
// both sides.
#include "layered/connection_walk.h"
#include "layered/estimator.h"
#include "layered/paths/half_vectors/shortest_path.h"

namespace lacquer::layered {
namespace {

class HalfVectorEstimator final : public LayeredEstimator {
  public:
    SampledSpectrum Evaluate(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                             int maxVertices) const override {
        InterfacePath path;
        SampledSpectrum shortest(0);
        KnownPaths known;
        if (FindShortestPath(stack, wo, wi, maxVertices, &path)) {
            if (const ShortestPathMethod method = ShortestPathMethodFor(path);
                method != ShortestPathMethod::None) {
                shortest = EstimateShortestPath(method, path, context);
                known.vertices = path.numEvents;
            }
        }
        CountProductQuery(context, known.vertices > 0);
        return shortest + ConnectionWalk<WalkPolicy>(stack, context, maxVertices, known).Estimate(wo, wi);
    }
};

}  // namespace

LACQUER_REGISTER(LayeredEstimatorKind, "halfvector", MakeEstimator<HalfVectorEstimator>);

}  // namespace lacquer::layered
