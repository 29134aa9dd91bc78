// --explain: which summaries tell which parameters.
#pragma once

#include <string>

#include "cmd/estimate/estimate_arguments.h"

namespace lacquer::cmd {

/// A table: for each family of summaries and for all of them, the deviation over the prior's that they alone
/// would leave of each parameter at `natural`, and the first line above. Families that were not used are
/// there as well. Cost: some 300 simulations and 32 for each parameter.
std::string FamilyTable(const EstimateArguments& arguments, const estimate::PhotoSimulator& simulator,
                        const estimate::Vector& natural);

}  // namespace lacquer::cmd
