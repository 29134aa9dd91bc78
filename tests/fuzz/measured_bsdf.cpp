// Measured BRDFs of the RGL database, and what a path asks of them.
#include "fuzz/fuzz_target.h"
#include "pbrt/bxdfs/measured.h"

namespace lacquer::fuzz {
namespace {

void MeasuredBsdf(std::string_view bytes) {
    const auto brdf = MeasuredBrdf::Read(InputFile(bytes).Path(), {});
    const Vec3 wo = Normalize(Vec3(0.3f, -0.2f, 0.8f));
    for (const float u : {0.f, 0.4f, 0.9999f}) {
        const Vec3 wi = brdf->Sample(wo, {u, 1 - u});
        if (!(wi.z > 0)) continue;
        brdf->Evaluate(wo, wi, SampledSpectrum(550));
        brdf->Pdf(wo, wi);
    }
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "measured_bsdf", MeasuredBsdf);

}  // namespace lacquer::fuzz
