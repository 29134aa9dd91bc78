// The work of `lacquer bulk`: realisations up to a number, an error or a time, with checkpoints.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "bulk/input/particles_input.h"
#include "bulk/table/ensemble_computation.h"
#include "cmd/console.h"

namespace lacquer::cmd {

/// When a computation has averaged enough. Whichever comes first.
struct BulkLimits {
    int maxRealizations = 50;
    double error = 0;    ///< largest standard error of C_ext and C_sca, relative, and of g; 0: any
    double seconds = 0;  ///< of the whole run; 0: any time
};

/// Solves all computations that a table comes from: one, or one for each size of the ball.
class BulkRun {
  public:
    enum class End {
        Reached,  ///< the number of realisations, or the error
        Time,     ///< after at least as many realisations as an average needs
        Signal
    };

    /// @param computations  of `input`, in the order of sizes    @param partPath  file for checkpoints;
    /// empty: none are written    @param version  of the program, which checkpoints keep
    BulkRun(std::vector<bulk::EnsembleComputation*> computations, const bulk::ParticlesInput& input,
            const BulkLimits& limits, std::string partPath, const std::string& version, Console* console);

    /// Goes on from the checkpoint. False if there is none. Errors: FileError if it cannot be used.
    bool Resume();
    /// Solves; every 30 s and at a signal a checkpoint is written. Errors: SceneError if there is no room for
    /// the particles, or if their waves have no solution.
    End Solve();
    /// After the table is written.
    void RemoveCheckpoint() const;

    /// Of all computations.
    int NumRealizations() const;

  private:
    class Progress;

    End SolveOne(bulk::EnsembleComputation* computation, double deadline);
    void RequireSolutions(const bulk::EnsembleComputation& computation) const;
    void Save();
    void SaveOrWarn();
    double Seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }

    const bulk::ParticlesInput& input_;
    BulkLimits limits_;
    std::string partPath_, problem_;
    Console* console_;
    std::vector<bulk::EnsembleComputation*> computations_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    double lastSave_ = 0;
    bool hasCheckpoint_ = false;  ///< of this run
};

/// The largest standard errors over the wavelengths.
struct BulkErrors {
    double extinction = 0, scattering = 0;  ///< relative
    double g = 0;                           ///< absolute
    double Largest() const { return std::max({extinction, scattering, g}); }
};
BulkErrors ErrorsOf(const bulk::EnsembleComputation& computation);

}  // namespace lacquer::cmd
