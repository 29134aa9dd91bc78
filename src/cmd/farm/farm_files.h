// lacquer farm: the files by which any engine that runs commands renders an image in parts.
#pragma once

#include <string>
#include <vector>

namespace lacquer::cmd {

/// An image, and how its parts are rendered.
struct FarmPlan {
    std::string program, scene, outfile, folder;  ///< absolute paths
    std::string options;                          ///< of `render` for all parts, as a shell reads them
    std::vector<std::string> parts;               ///< options of each: "--sample-range 0:8"
};

/// A word that a shell reads as this text.
std::string ShellWord(const std::string& text);
/// Writes into the plan's folder, which is there,
///   task.sh    `sh task.sh N` renders part N, from 1 on, and goes on from its state if there is one
///   tasks.txt  a line for each task
///   merge.sh   makes the image of all states
///   tasks.sbatch, merge.sbatch, submit.sh  the same for Slurm
/// Errors: FileError, also for a folder that has such files or states of parts.
/// @param slurm  further options of sbatch
void WriteFarmFiles(const FarmPlan& plan, const std::vector<std::string>& slurm);

}  // namespace lacquer::cmd
