// What a command shows to a person: everything goes to stderr.
#pragma once

#include <atomic>
#include <chrono>
#include <mutex>
#include <set>
#include <string>

#include "cmd/exit_status.h"
#include "pbrt/core/error.h"
#include "pbrt/core/progress.h"

namespace lacquer::cmd {

/// Colours and redrawing are used on terminals only, and not with NO_COLOR or TERM=dumb.
struct ConsoleStyle {
    bool terminal = false;
    bool color = false;
    bool quiet = false;
    static ConsoleStyle Detect(bool quiet);
};

/// Progress and warnings on stderr: a bar on a terminal, a line now and then elsewhere, nothing when quiet.
class Console final : public Observer {
  public:
    explicit Console(ConsoleStyle style) : style_(style) {}
    ~Console() override { End(); }

    void Begin(const std::string& name, int64_t total, const std::string& unit) override;
    void Advance(int64_t units) override;
    void End() override;
    void Warn(const std::string& message) override;
    /// True once a signal has arrived (see CatchSignals).
    bool ShouldStop() override { return Signal() != 0; }

    /// Of the work that has begun: how much of it is done, where that is no number of units, and a note that
    /// stands behind the bar.
    void Describe(double fraction, const std::string& note);

    /// A line of information; nothing when quiet.
    void Info(const std::string& message);
    /// Results that belong on stderr, always shown.
    void Print(const std::string& text);
    /// An error, always shown, with the offending line of the file under it where it can be read.
    void Error(const Diagnostic& diagnostic);
    void Error(const std::string& message);

    /// Takes SIGINT, SIGTERM and SIGHUP from now on: the first one asks to stop, a second one ends the
    /// process.
    static void CatchSignals();
    /// SIGUSR1 as well, which then means what SIGTERM does.
    static void CatchUserSignal();
    /// The signal that arrived, 0 if none.
    static int Signal();
    /// What a command ends with that it has stopped.
    static ExitStatus StatusOfSignal();

  private:
    void Draw();
    void ClearBar();
    std::string Bold(const std::string& text, int colorCode) const;
    /// Rewrites "warning:" and "error:" of a diagnostic in colour.
    std::string Highlight(const std::string& message) const;

    ConsoleStyle style_;
    std::mutex mutex_;
    std::string name_, unit_, note_;
    int64_t total_ = 0;
    std::atomic<int64_t> done_ = 0;
    double described_ = 0;  ///< part that is done, at least
    std::chrono::steady_clock::time_point start_, lastDraw_;
    bool active_ = false, barShown_ = false;
    std::set<std::string> warned_;
};

/// "1:02:03", "2:03" or "3.4 s".
std::string FormatSeconds(double seconds);
/// "12.3 M", "45 k".
std::string FormatCount(double count);

}  // namespace lacquer::cmd
