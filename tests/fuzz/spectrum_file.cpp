// Files of spectra.
#include "fuzz/fuzz_target.h"
#include "pbrt/core/spectrum.h"

namespace lacquer::fuzz {
namespace {

void SpectrumFile(std::string_view bytes) {
    const auto spectrum = ReadSpectrumFile(InputFile(bytes).Path());
    Require(spectrum->Evaluate(550) <= spectrum->MaxValue(), "no value is above the largest one");
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "spectrum_file", SpectrumFile);

}  // namespace lacquer::fuzz
