// The simulator of flash photographs: a procedural model, a photograph of it, and summaries.
#pragma once

#include <map>
#include <mutex>

#include "estimate/models/material_model.h"
#include "estimate/photo/tone.h"
#include "estimate/simulator.h"
#include "estimate/summary/summary.h"

namespace lacquer::estimate {

/// How the photograph was taken, and what is made of it.
struct PhotoSettings {
    int resolution = 256;  ///< pixels along a side: a multiple of 16, at least 64
    /// Each pixel is the mean, in linear light, of so many times so many that are simulated: what a camera
    /// makes of finer relief, and a reader of a photograph with more pixels.
    int averaging = 1;
    double extent = 25;    ///< side of what it shows [cm]
    double distance = 25;  ///< of the camera, whose light is at the same place [cm]
    ToneCurve tone = ToneCurve::SRGB;
    Brdf brdf = Brdf::Smith;
    ModelKinds kinds;
    /// Values are rounded to 8 bits before summaries are made of them, as those of a file are. What rounding
    /// hides can then not be known from the summaries. Derivatives are those without.
    bool isRounded = false;
    std::shared_ptr<const VggWeights> vgg;  ///< for summaries "vgg" (summary/vgg.h)

    MapGrid Grid() const { return {resolution, extent, false}; }
    /// Of what is simulated.
    MapGrid FineGrid() const { return {resolution * averaging, extent, false}; }
};

enum class PriorSet { Test, Demo };
/// Distance that the models' priors are for [cm].
inline constexpr double kPriorDistance = 25;
/// The prior of a model's parameter for a camera at a distance [cm]. At twice the distance, exposures like
/// those at 25 cm take four times as much light, and the same vignette is twice as wide on the sample.
Prior PriorAt(const ModelParameter& parameter, PriorSet priors, double distance);

/// Which parameters are free, and with what priors.
struct FreeParameters {
    PriorSet priors = PriorSet::Test;
    std::map<std::string, double> fixed;          ///< by name [natural units]
    std::map<std::string, Prior> replacedPriors;  ///< by name
    std::vector<std::string> alsoFree;            ///< optional ones that are to be free
};

/// Families of summaries that a model is estimated with unless others are asked for.
std::vector<std::string> DefaultSummaries(const MaterialModel& model);

/// Runs of one thread at a time share their buffers through this; the simulator has one for each thread that
/// is in it.
class PhotoWorkspace {
  public:
    PhotoWorkspace(const MaterialModel& model, const PhotoSettings& settings,
                   const std::vector<std::string>& families);

    /// All parameters of the model, in natural units. Values are the summaries; LastSurface() and
    /// Image() then are of this run.
    void Forward(std::span<const double> parameters, uint64_t seed, std::span<double> values);
    /// Derivatives of a number by all parameters, from those by the summaries of the last Forward().
    std::vector<double> Backward(std::span<const double> parameters, std::span<const double> by);

    const Surface& LastSurface() const { return surface_; }
    const PlanarImage& Image() const { return summaries_.Image(); }
    const std::vector<std::string>& Names() const { return summaries_.Names(); }

  private:
    FlashSettings SettingsOf(std::span<const double> parameters) const;

    PhotoSettings settings_;
    size_t vignette_, axisX_, axisY_;  ///< places in the table
    std::unique_ptr<ModelRun> run_;
    bool hasSeed_ = false;
    uint64_t seed_ = 0;
    Surface surface_;
    FlashPhoto photo_;
    PlanarImage fine_;    ///< linear, as simulated
    PlanarImage linear_;  ///< of the pixels
    SummarySet summaries_;
};

/// Free parameters and a seed give the summaries of a photograph.
class PhotoSimulator final : public Simulator {
  public:
    /// @param families  of summaries; empty: the default ones
    /// Errors: std::invalid_argument that names an unknown parameter or family, a value outside of its
    /// bounds, or a bad setting.
    PhotoSimulator(const MaterialModel& model, const PhotoSettings& settings, const FreeParameters& free,
                   const std::vector<std::string>& families = {});
    ~PhotoSimulator() override;

    const ParameterSpace& Parameters() const override { return space_; }
    const std::vector<std::string>& SummaryNames() const override { return names_; }
    Vector Simulate(const Vector& x, uint64_t seed) const override;
    std::unique_ptr<DifferentiableRun> SimulateForGradient(const Vector& x, uint64_t seed) const override;

    const MaterialModel& Model() const { return model_; }
    const PhotoSettings& Settings() const { return settings_; }
    const std::vector<std::string>& Families() const { return families_; }
    /// In the order of the summaries.
    std::vector<FamilyRange> FamilyRanges() const;
    /// All parameters of the model: free ones from x, the others as they are fixed.
    std::vector<double> AllParameters(const Vector& x) const;
    /// Summaries of an image with the resolution of the settings.
    Vector SummariesOf(const PlanarImage& image) const;
    /// The photograph itself, after the tone curve, and the surface that it shows if that is not null.
    PlanarImage Photograph(const Vector& x, uint64_t seed, Surface* surface = nullptr) const;
    /// What one should know of these settings: priors beyond the Nyquist frequency.
    const std::vector<std::string>& Warnings() const { return warnings_; }
    /// And what is good to know: priors that follow the distance.
    const std::vector<std::string>& Notes() const { return notes_; }

  private:
    class Run;
    class Lease;
    ParameterSpace MakeSpace(const FreeParameters& free);

    const MaterialModel& model_;
    PhotoSettings settings_;
    std::vector<std::string> families_, names_, warnings_, notes_;
    std::vector<size_t> freeIndices_;      ///< places of free parameters in the model's table
    std::vector<double> fixedParameters_;  ///< of all; free ones have no meaning
    ParameterSpace space_;
    mutable std::mutex mutex_;
    mutable std::vector<std::unique_ptr<PhotoWorkspace>> idle_;
};

}  // namespace lacquer::estimate
