// Everything that a survey finds out about a material.
#pragma once

#include <string>
#include <vector>

#include "measure/lobe_images.h"
#include "measure/lobe_survey.h"

namespace lacquer::measure {

/// What one way to evaluate the material gives. Energies are those of light that is not in specular peaks.
struct EstimatorResult {
    std::string name;
    LobePair lobe;
    Difference reflection, transmission;  ///< lobe against the histogram of samples
    LobeEnergy energy;                    ///< of light from the asked direction
    LobeEnergy furnace;                   ///< of a white environment, seen from there
    std::vector<LobeEnergy> energyByAngle, furnaceByAngle;
    Reciprocity reciprocity;
    EvaluationCost cost;
};

/// What one interface of a stack does to light by itself: 1 - (reflected + transmitted), luminance.
struct InterfaceLoss {
    int index = 0;                             ///< from the outside in
    std::vector<double> fromAbove, fromBelow;  ///< at BsdfResult::lossAnglesDeg
};

struct BsdfResult {
    /// What was looked at, for titles and tables: the survey leaves these to whoever asked for it.
    std::string material, type, scene, pdfName;
    Point2 uv{0};
    double thetaDeg = 0, phiDeg = 0;  ///< where the light comes from
    Vec3 w{0, 0, 1};                  ///< that direction
    int resolution = 0, samplesPerPixel = 0, seed = 0;
    int64_t histogramSamples = 0;
    bool transmits = false, isStochastic = false;

    std::vector<EstimatorResult> estimators;  ///< at least one
    SampledLobe sampled;                      ///< light from w
    SampledLobe sampledFurnace;               ///< white environment seen from w
    LobePair histogram;
    DensityPair density, pdf;
    std::vector<double> anglesDeg;
    std::vector<SampledLobe> sampledByAngle, sampledFurnaceByAngle;
    std::vector<double> lossAnglesDeg;
    std::vector<InterfaceLoss> interfaces;  ///< empty for what is no stack
};

/// A confidence interval of a difference of two independent means, one of several: with a probability of 95 %
/// all of them hold their differences.
struct Interval {
    double difference = 0, halfWidth = 0;
    bool HoldsZero() const { return std::abs(difference) <= halfWidth; }
};
/// Of luminances, by Welch's t. @param numComparisons  the intervals that are read together
Interval Agreement(const ColorMean& a, const ColorMean& b, size_t numComparisons);

/// Whether the energies of an estimator are those of the samples.
struct EnergyAgreement {
    Interval reflected, transmitted;
};
/// Of each estimator, over all estimators and sides together.
std::vector<EnergyAgreement> AgreementsWithSamples(const BsdfResult& result);
/// How many comparisons that are.
size_t NumAgreements(const BsdfResult& result);

}  // namespace lacquer::measure
