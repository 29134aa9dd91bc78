// The log file that --log-file asks for.
#pragma once

#include <chrono>
#include <fstream>
#include <string>

#include <fmt/format.h>

#include "pbrt/core/error.h"

namespace lacquer::cmd {

/// Lines with seconds since the start; nothing without a file name.
class Log {
  public:
    /// Errors: FileError if the file cannot be written.
    Log(const std::string& path, const std::string& level) : verbose_(level == "verbose") {
        if (path.empty()) return;
        out_.open(path);
        if (!out_) throw FileError(path, "cannot be written");
    }
    /// Shown at level "verbose".
    void Info(const std::string& message) {
        if (verbose_) Write(message);
    }
    void Error(const std::string& message) { Write("error: " + message); }

  private:
    void Write(const std::string& message) {
        if (!out_.is_open()) return;
        const double seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
        out_ << fmt::format("{:10.3f} {}\n", seconds, message) << std::flush;
    }
    bool verbose_;
    std::ofstream out_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace lacquer::cmd
