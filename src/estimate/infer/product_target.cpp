#include "estimate/infer/product_target.h"

#include <limits>

namespace lacquer::estimate {

double ProductTarget::LogDensity(const Vector& t, Vector* gradient) const {
    Vector y;
    double logDeterminant = 0;
    if (!coordinates_.Logits(t, &y, &logDeterminant)) return -std::numeric_limits<double>::infinity();
    const double value = target_.LogDensity(y, gradient) + logDeterminant;
    if (gradient) *gradient = coordinates_.GradientByCoordinates(t, *gradient);
    return value;
}

}  // namespace lacquer::estimate
