// What people who know pbrt type: names of its options and tools that are elsewhere here, or nowhere.
#pragma once

#include <string>

namespace lacquer::cmd {

/// Where an option of pbrt lives that `render` does not have, or why there is none; empty for all others.
/// @param argument  as typed: "--toply"
std::string AnswerToPbrtOption(const std::string& argument);
/// The same for commands of imgtool and for the programs that come with pbrt. @param word  "plytool"
std::string AnswerToPbrtCommand(const std::string& word);

}  // namespace lacquer::cmd
