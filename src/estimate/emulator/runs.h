// Forward runs of a simulator, many at once, and their record on disk.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "estimate/simulator.h"
#include "pbrt/core/progress.h"

namespace lacquer::estimate {

/// Runs with their results.
struct Runs {
    Matrix parameters;  ///< logits, a column for each run
    Matrix summaries;   ///< a row for each run
    Eigen::Index Count() const { return parameters.cols(); }
    /// Those of `other` behind these.
    void Append(const Runs& other);
    /// The runs with these indices.
    Runs Select(const std::vector<Eigen::Index>& indices) const;
};

/// A file to which runs are appended as they are made. Since runs are made in a fixed order, a resumed
/// computation finds its first runs in the file and does not make them again: resuming gives the same bits.
class RunLog {
  public:
    /// Opens or makes the file. A last record that is torn is dropped, and so is what follows a record that
    /// is damaged. Errors: FileError if it cannot be read or written, or is of another kind or other sizes.
    RunLog(std::string path, Eigen::Index numParameters, Eigen::Index numSummaries);
    /// The summaries of the next run, if the file has them for these parameters and this seed. Where it has
    /// another run, that one and all after it are dropped.
    bool Recall(const Vector& parameters, uint64_t seed, Vector* summaries);
    /// Adds a run. Errors: FileError.
    void Append(const Vector& parameters, uint64_t seed, const Vector& summaries);
    size_t NumRecalled() const { return next_; }

  private:
    std::string path_;
    Eigen::Index numParameters_, numSummaries_;
    std::vector<std::vector<double>> records_;  ///< seed as the bits of its first number
    size_t next_ = 0;
    void ReadRecords();
    void Rewrite();
};

/// The observer has asked to stop.
struct Interrupted {};

/// Runs `simulator` at the columns of `parameters` (logits), in parallel, run i with the seed
/// Hash(seed, i): the same bits for any number of threads.
/// @param log       null: runs are not kept
/// @param observer  told of each run; if it asks to stop, an Interrupted is thrown
Runs RunSimulator(const Simulator& simulator, const Matrix& parameters, uint64_t seed, RunLog* log = nullptr,
                  Observer* observer = nullptr);

}  // namespace lacquer::estimate
