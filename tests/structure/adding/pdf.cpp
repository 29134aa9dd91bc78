// Pdf "example": the same density in all directions, good for nothing but its shortness.
// Stands in src/layered/pdfs. Scene: Material "coateddiffuse" "string pdf" "example"
#include "layered/estimator.h"
#include "pbrt/core/registry.h"

namespace lacquer::layered {
namespace {

class Example final : public LayeredPdf {
  public:
    float Evaluate(const Stack&, Vec3, Vec3, const BxDFContext&, int) const override { return 0.25f * InvPi; }
};

}  // namespace

LACQUER_REGISTER(LayeredPdfKind, "example", MakePdf<Example>);

}  // namespace lacquer::layered
