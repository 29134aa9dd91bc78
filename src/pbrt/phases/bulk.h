// Phase function "bulk": a file of "lacquer bulk", which has the coefficients of its medium, too.
#pragma once

#include "pbrt/base/warnings.h"
#include "pbrt/core/spectrum.h"
#include "pbrt/phases/orientation.h"
#include "pbrt/phases/oriented.h"
#include "pbrt/phases/table.h"
#include "pbrt/scattering/bulk_table.h"

namespace lacquer {

/// A phase function from such a file, with the coefficients for those who have the phase function.
class BulkPhaseModel : public PhaseModel, public HasWarnings {
  public:
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

  protected:
    /// @param loc  what names the file, for Warnings(): of wavelengths that the file lacks
    BulkPhaseModel(const BulkHead& head, const std::string& path, const FileLoc& loc,
                   DenselySampledSpectrum sigmaA, DenselySampledSpectrum sigmaS);

  private:
    DenselySampledSpectrum sigmaA_, sigmaS_;
    double hostIndex_;
    std::vector<Diagnostic> warnings_;
};

/// Of the file of an isotropic medium.
class IsotropicBulkModel final : public BulkPhaseModel {
  public:
    IsotropicBulkModel(const BulkTable& table, const std::string& path, const FileLoc& loc);

    const PhaseFunction* Make(const PhaseContext& context, Arena& arena) const override {
        return arena.New<SpectralTabulatedPhase>(phase_, context.lambda);
    }
    bool IsChromatic() const override { return phase_.IsChromatic(); }

  private:
    SpectralPhaseTable phase_;
};

/// Of the file of an oriented ensemble. SigmaT() is the mean over all directions, Albedo() the largest of all
/// directions and wavelengths: the phase function has the factors.
class OrientedBulkModel final : public BulkPhaseModel {
  public:
    /// @param table  with its phase functions
    OrientedBulkModel(const OrientedBulkTable& table, const std::string& path, const FileLoc& loc,
                      Orientation orientation)
        : OrientedBulkModel(table, path, loc, std::move(orientation), OrientedPhaseTable(table)) {}

    const PhaseFunction* Make(const PhaseContext& context, Arena& arena) const override {
        return arena.New<OrientedPhase>(phase_, orientation_.At(context), context.lambda);
    }
    bool IsOriented() const override { return true; }
    bool IsChromatic() const override { return phase_.IsChromatic(); }
    bool HasChromaticExtinction() const override { return phase_.IsChromatic(); }
    bool IsConstant() const override { return orientation_.IsConstant(); }

  private:
    OrientedBulkModel(const OrientedBulkTable& table, const std::string& path, const FileLoc& loc,
                      Orientation orientation, OrientedPhaseTable phase);

    OrientedPhaseTable phase_;
    Orientation orientation_;
};

/// Errors: SceneError at a parameter that says what the file of `"string bulk"` says, if that is given.
void RefuseBesideBulk(const Params& params);

}  // namespace lacquer
