// lacquer diff: how far an image is from a reference.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

namespace lacquer::cmd {

/// Everything that the command line of `diff` can say.
struct DiffArguments {
    std::string image, reference;
    std::string metric = "RMSE";
    std::vector<std::string> boxes;
    std::vector<std::string> channels;  ///< none: all
    std::optional<double> tolerance;
    std::string outfile;
    int threads = 0;
    bool quiet = false;
};

/// Exit statuses: those of OpenImageIO's idiff, which uses 1 for wrong usage, as Lacquer does, and for
/// warnings, of which this verb has none.
enum class DiffStatus : int {
    Match = 0,          ///< measured; within the tolerance if there is one
    Usage = 1,          ///< the command line makes no sense
    Failure = 2,        ///< above the tolerance, or NaN or infinite values
    DifferentSize = 3,  ///< sizes, channels or colour spaces that cannot be compared
    File = 4,           ///< a file cannot be read or written
};

/// Declares the options on `app`.
void AddDiffOptions(CLI::App& app, DiffArguments& arguments);
/// Prints the table to stdout. File errors become a message and a status; wrong options are
/// CLI::ValidationError.
DiffStatus RunDiff(const DiffArguments& arguments);

}  // namespace lacquer::cmd
