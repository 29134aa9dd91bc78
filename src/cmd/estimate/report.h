// The report of `lacquer estimate`.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cmd/report_page.h"
#include "estimate/normal_distribution.h"

namespace lacquer::cmd {

/// A number that is not known: the page shows a dash, and no sentence is made of it.
inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

using EstimatePrior = estimate::TruncatedNormal;

/// A parameter, or a product of parameters, with what is known of it. All numbers in its natural unit.
struct EstimateParameter {
    std::string name;     ///< as the command line has it: "rough"
    std::string meaning;  ///< for people, without an article: "roughness"; empty: the name alone
    std::string unit;     ///< "cm"; empty: none
    /// Not empty: a product (or quotient) of the parameters with these names, which the data tell better than
    /// the factors. It stands in the table and has its distributions, but is not among the correlations.
    std::vector<std::string> factors;

    double map = kUnknown;                                           ///< most probable values of all together
    double mean = kUnknown, sd = kUnknown;                           ///< of the posterior
    double q5 = kUnknown, q50 = kUnknown, q95 = kUnknown;            ///< its quantiles
    double rhat = kUnknown, essBulk = kUnknown, essTail = kUnknown;  ///< BulkEss() and so on
    double priorSd = kUnknown;           ///< of the prior as it is cut, or of its draws
    std::optional<EstimatePrior> prior;  ///< what the prior's curve is drawn from, ...
    std::vector<double> priorDraws;      ///< ... or, without it, from these (products); may be empty
    /// Shares of the posterior that lie within 1 % of the range of a bound.
    double shareAtLow = 0, shareAtHigh = 0;
    std::optional<double> truth;  ///< if it is known: a synthetic photograph
    /// The draws, chain by chain, all chains of the same length and in the order of sampling. The page keeps
    /// a few hundred of each chain's for traces; distributions and correlations are made from all.
    std::vector<std::vector<double>> chains;
};

/// A family of summaries beside what the posterior predicts.
struct EstimateCheck {
    std::string family;      ///< "spectrum"
    bool isHeldOut = false;  ///< was not used for the estimate
    /// For each summary its name in words, and the share of predicted values that lie above the photograph's
    /// (half of those that are equal): .5 is the middle, 0 and 1 are outside of all.
    std::vector<std::string> names;
    std::vector<double> shares;
};

/// A summary's difference from the model's, for people.
struct EstimateResidual {
    std::string name;  ///< "energy at 8 cycles/cm"
    double deviation;  ///< photograph less model, in standard deviations of their difference
};

/// A wave of simulations (estimate::WaveReport).
struct EstimateWave {
    double runs;        ///< that its emulator was made from
    double shift;       ///< of the means since the wave before, in posterior deviations; NaN for the first
    double misfit;      ///< chi^2 at the mean over the number of summaries
    double acceptance;  ///< of the walks
    double maxRhat;
};

/// Measured reflectances of one direction of the light, or of one spectrum, and what the posterior predicts.
struct EstimateLobe {
    std::string title;           ///< "light from 30°"
    std::string unit;            ///< of the places: "angle of view [degrees]"
    std::vector<double> places;  ///< ascending
    struct Channel {
        std::string name;                                 ///< "r"
        std::vector<double> measured, low, median, high;  ///< the middle 90 %, without the noise
    };
    std::vector<Channel> channels;
};

/// A direction that could be measured next [degrees].
struct EstimateNext {
    double thetaI, phiI, thetaO, phiO;
    double deviation;  ///< of what is predicted there, relative
    double ratio;      ///< of its variance to that of the noise
};

/// A map of the material.
struct EstimateMap {
    std::string name;  ///< "albedo"
    std::string unit;  ///< of one channel: "cm"; empty: none
    bool isColor;      ///< three channels of linear colour; others are shown as they are (normals)
    Image image;       ///< three channels R, G, B, or one
};

/// All that the page shows. What is empty or not known has no place on it.
struct EstimateReport {
    std::string title;    ///< "leather from photo.png"
    std::string model;    ///< "leather"
    std::string command;  ///< as it was typed; empty: not known
    /// What the page lists as it is: {"Method", "emulated"}, {"Image", "256 x 256, 10 cm wide"}.
    std::vector<std::pair<std::string, std::string>> settings;

    std::string subject = "photograph";  ///< what was observed, as sentences call it
    std::string fit;  ///< how well the model does, as a clause that begins a sentence; empty: by the misfit

    std::vector<EstimateParameter> parameters;  ///< products behind their factors
    size_t numSummaries = 0;                    ///< p
    double misfit = kUnknown;                   ///< chi^2/p at the best parameters, before any widening
    /// By which factor standard deviations were widened because of it; 1: not.
    double tau = 1;
    bool isCalibrated = true;  ///< the error is from simulations; false: set by hand
    double handError = 0;      ///< if set by hand
    bool isMapOnly = false;    ///< there is a best point and no distribution: chains are empty

    // What went less than well.
    bool hasMeanSettled = true;     ///< the last wave moved the means by less than its tolerance
    bool wasStopped = false;        ///< by the limit of time, before the planned end
    int numDivergent = 0;           ///< transitions of HMC
    double lowestEbfmi = kUnknown;  ///< of HMC's chains
    double paretoK = kUnknown;      ///< of importance weights
    /// Further warnings, each a sentence with its full stop.
    std::vector<std::string> warnings;

    std::vector<EstimateCheck> checks;
    int numPredicted = 0;                     ///< posterior draws that the checks' shares are of
    std::vector<EstimateResidual> residuals;  ///< any number, in any order: the page has the five largest
    std::vector<EstimateWave> waves;
    std::vector<EstimateLobe> lobes;
    std::vector<EstimateNext> next;  ///< the best one first
    std::string nextText;            ///< the sentence about it

    /// Pixels as the photograph has them after its tone curve, in [0,1]. True for the linear one, whose
    /// images pass through the sRGB curve on the page.
    bool isLinear = false;
    Image photo;  ///< cropped and at the resolution of the estimate; without pixels: none
    Image best;   ///< of the most probable parameters, with a fresh seed
    std::vector<Image> draws;
    std::vector<EstimateMap> maps;
};

/// All numbers and sentences of the page (schema lacquer-estimate-report-1). Images have their names there:
/// "photo", "best", "draw 1" ..., "map albedo" .... Cost: sorts the draws of each parameter once.
nlohmann::ordered_json EstimateReportResults(const EstimateReport& report);

/// The page's text (UTF-8). Cost and errors: as MakeReportPage()
std::string MakeEstimateReport(const EstimateReport& report);

/// Writes report.html into a folder that exists. Errors: FileError.
void WriteEstimateReport(const std::string& folder, const EstimateReport& report);

}  // namespace lacquer::cmd
