// The numbers of `lacquer compare` as JSON and as text.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "compare/box.h"
#include "compare/experiment.h"

namespace lacquer::cmd {

/// What holds for the comparison as a whole.
struct CompareSetting {
    std::string command, scene;
    int threads = 0;
    Int2 resolution{0};
    compare::Budget budget;
    int runs = 0;
    compare::Subject subject = compare::Subject::Estimators;  ///< what they are
    std::string baseline;
    std::vector<std::string> estimators;  ///< the labels of what is compared
    std::vector<compare::Box> boxes;      ///< in the full image
};

/// One value of the varied parameter, or the scene as it is.
struct CompareVariant {
    std::string label;       ///< "coat.roughness = 0.1"; empty without variation
    std::string filePrefix;  ///< of its images
    compare::Reference reference;
    std::string referenceFile;
    bool isReferenceGiven = false;                  ///< by the user, not rendered
    std::vector<compare::CandidateResult> results;  ///< those that have runs
};

/// Paths inside the output folder.
std::string RunImageName(const CompareVariant& variant, const compare::Candidate& candidate, size_t run);
std::string ErrorImageName(const CompareVariant& variant, const compare::Candidate& candidate);

/// Everything but the variants; docs/compare.md has the schema.
nlohmann::ordered_json ToJson(const CompareSetting& setting, bool isComplete);
/// @param origin  of the images' pixels in the full image
nlohmann::ordered_json ToJson(const CompareVariant& variant, const std::vector<compare::Box>& boxes,
                              Int2 origin);

/// The main numbers for a terminal.
std::string ToText(const nlohmann::ordered_json& results);

}  // namespace lacquer::cmd
