// What `lacquer bulk` makes of an input: the computations that it takes, and what is written and said of
// them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bulk/input/particles_input.h"
#include "bulk/table/ensemble_computation.h"
#include "cmd/console.h"

namespace lacquer::cmd {

/// Where results go.
struct BulkFiles {
    std::string table;
    std::string report;   ///< folder of the page; empty: none
    std::string command;  ///< the command line, for the page
};

/// Of one input; the order of calls is that of the functions.
class BulkOutput {
  public:
    virtual ~BulkOutput() = default;

    /// Whether the table can be written where it should. Errors: usage, FileError.
    virtual void CheckFiles() const {}
    /// What must be solved, in the order of sizes. None for methods without clusters.
    virtual std::vector<bulk::EnsembleComputation*> Computations() = 0;
    /// The table. Errors: SceneError without a place for too few realisations; FileError.
    virtual void WriteTable() = 0;
    /// The table's numbers for a person.
    virtual void Tell(Console* console) const = 0;
    /// report.html, into its folder. Errors: FileError.
    virtual void WritePage() const = 0;
};

/// @param input  must outlive it
std::unique_ptr<BulkOutput> MakeIsotropicOutput(const bulk::ParticlesInput& input, const BulkFiles& files);
/// @param input  with `oriented`
std::unique_ptr<BulkOutput> MakeOrientedOutput(const bulk::ParticlesInput& input, const BulkFiles& files);

}  // namespace lacquer::cmd
