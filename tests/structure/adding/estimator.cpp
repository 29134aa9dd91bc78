// Estimator "example", with a parameter of its own: so many times nothing.
//   numexample    integer    1
// Stands in src/layered/estimators. Scene: Material "coateddiffuse" "string estimator" "example" "integer
// numexample" 2
#include "layered/estimator.h"
#include "pbrt/core/params.h"
#include "pbrt/core/registry.h"

namespace lacquer::layered {
namespace {

class Example final : public LayeredEstimator {
  public:
    explicit Example(int times) : times_(times) {}
    SampledSpectrum Evaluate(const Stack&, Vec3, Vec3, const BxDFContext&, int) const override {
        return SampledSpectrum(0 * float(times_));
    }

  private:
    int times_;
};

std::unique_ptr<const LayeredEstimator> Create(const Params& params) {
    return std::make_unique<Example>(params.GetIntInRange("numexample", 1, 1, 8));
}

}  // namespace

LACQUER_REGISTER(LayeredEstimatorKind, "example", Create);

}  // namespace lacquer::layered
