// Phase function "bulk": a file of "lacquer bulk", which has the coefficients of its medium, too.
#pragma once

#include "pbrt/base/warnings.h"
#include "pbrt/core/spectrum.h"
#include "pbrt/phases/table.h"
#include "pbrt/scattering/bulk_table.h"

namespace lacquer {

/// A phase function from such a file, with the coefficients for those who have the phase function.
class BulkPhaseModel final : public PhaseModel, public HasWarnings {
  public:
    /// @param loc  what names the file, for Warnings(): of wavelengths that the file lacks
    BulkPhaseModel(const BulkTable& table, const std::string& path, const FileLoc& loc);

    const PhaseFunction* Make(const PhaseContext& context, Arena& arena) const override {
        return arena.New<SpectralTabulatedPhase>(phase_, context.lambda);
    }
    bool IsChromatic() const override { return phase_.IsChromatic(); }
    std::span<const Diagnostic> Warnings() const override { return warnings_; }

    // Coefficients [1/mm]: linear between the file's wavelengths, and constant beyond them.
    const DenselySampledSpectrum& SigmaA() const { return sigmaA_; }
    const DenselySampledSpectrum& SigmaS() const { return sigmaS_; }
    DenselySampledSpectrum SigmaT() const;
    /// 0 where nothing is met.
    DenselySampledSpectrum Albedo() const;
    double HostIndex() const { return hostIndex_; }

    /// `model` if it is one, else null.
    static const BulkPhaseModel* Of(const PhaseModel& model) {
        return dynamic_cast<const BulkPhaseModel*>(&model);
    }

  private:
    SpectralPhaseTable phase_;
    DenselySampledSpectrum sigmaA_, sigmaS_;
    double hostIndex_;
    std::vector<Diagnostic> warnings_;
};

/// Errors: SceneError at a parameter that says what the file of `"string bulk"` says, if that is given.
void RefuseBesideBulk(const Params& params);

}  // namespace lacquer
