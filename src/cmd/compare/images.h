// The images that `lacquer compare` writes beside its report.
#pragma once

#include <string>
#include <vector>

#include "cmd/compare/results.h"

namespace lacquer::cmd {

/// One channel, "Y": the root of the mean squared error over the runs in each pixel.
Image ErrorMapOf(const compare::CandidateResult& result, const compare::Reference& reference);

/// A name as part of a file's name: what is neither a plain letter or digit nor one of "-_." becomes "-".
std::string FileWord(std::string name);

/// R, G and B without the channels behind them.
Image ColoursOnly(const Image& image);

/// PNG crops ready for a paper, all of one box at one scale: BOX-reference.png and BOX-ESTIMATOR.png (first
/// run), and BOX-ESTIMATOR-error.png (magma, from 0 to the 99th percentile of the box's errors over all
/// estimators). Boxes that are small are enlarged by a whole factor, each pixel a square. @return  the
/// names inside the folder. Errors: FileError.
std::vector<std::string> WriteCrops(const CompareVariant& variant, const std::vector<compare::Box>& boxes,
                                    Int2 origin, const std::string& folder);

}  // namespace lacquer::cmd
