// What a run of `lacquer estimate` is, whatever it estimates: preparations, inference, files, a verdict.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "cmd/console.h"
#include "cmd/estimate/estimate_arguments.h"
#include "cmd/estimate/posterior_summary.h"
#include "cmd/exit_status.h"
#include "cmd/timed_console.h"

namespace lacquer::cmd {

class EstimateRun {
  public:
    EstimateRun(const EstimateArguments& arguments, Console* console)
        : a_(arguments), console_(console), observer_(console, arguments.timeLimit) {}
    virtual ~EstimateRun() = default;
    ExitStatus Run();

  protected:
    /// Reads all that is asked for. Errors: usage, SceneError, FileError.
    virtual void Prepare() = 0;
    /// Everything that the results depend on.
    virtual nlohmann::ordered_json MakeConfig() const = 0;
    /// Errors: Interrupted, by a signal or at the end of the time.
    virtual void Infer() = 0;
    virtual void Write() = 0;
    /// Tells what was found.
    virtual ExitStatus Finish() = 0;

    /// All simulations so far.
    std::string RunLogName() const { return a_.out + "/runs.bin"; }
    /// The settings by which an interrupted run is known again, as text: its file is known by its hash, and
    /// may have moved.
    std::string Settings() const;
    /// Says why the results are not to be relied on. @param hasSettled  the waves have
    ExitStatus NotConverged(bool hasSettled, const PosteriorSummary& summary, double shift,
                            double allowedShift) const;

    const EstimateArguments& a_;
    Console* console_;
    TimedConsole observer_;

  private:
    /// A folder with another run in it is not written over; --resume goes on with the same one.
    void PrepareFolder();
    ExitStatus Stopped() const;

    nlohmann::ordered_json config_;
};

}  // namespace lacquer::cmd
