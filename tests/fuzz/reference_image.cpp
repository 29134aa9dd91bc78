// Images that `lacquer compare` takes for a reference.
#include "compare/reference.h"
#include "fuzz/fuzz_target.h"

namespace lacquer::fuzz {
namespace {

void ReferenceImage(std::string_view bytes) {
    const Image like({6, 5}, {"R", "G", "B"});
    const compare::Reference reference = compare::ReadReference(InputFile(bytes).Path(), like);
    Require(reference.image.Resolution() == like.Resolution(),
            "a reference has the pixels of the scene's image");
    reference.NoiseIsKnown();
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "reference_image", ReferenceImage);

}  // namespace lacquer::fuzz
