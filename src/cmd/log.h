// The log file that --log-file asks for.
#pragma once

#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <string>

#include <fmt/format.h>

#include "pbrt/core/error.h"

namespace lacquer::cmd {

/// Lines with seconds since the start; nothing without a file name.
class Log {
  public:
    /// Errors: FileError if the file cannot be written.
    Log(const std::string& path, const std::string& level) : verbose_(level == "verbose"), path_(path) {
        if (path.empty()) return;
        out_.open(path);
        if (!out_) throw FileError(path, "cannot be written");
    }
    /// Shown at level "verbose".
    void Info(const std::string& message) {
        if (verbose_) Write(message);
    }
    void Error(const std::string& message) { Write("error: " + message); }

    /// Errors: FileError if a line could not be written.
    void CheckWritten() const {
        if (out_.is_open() && !out_)
            throw FileError(path_, fmt::format("cannot be written: {}; the log is incomplete",
                                               std::strerror(errorNumber_)));
    }

  private:
    void Write(const std::string& message) {
        if (!out_.is_open()) return;
        const double seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
        errno = 0;
        if (out_ << fmt::format("{:10.3f} {}\n", seconds, message) << std::flush) return;
        if (errorNumber_ == 0) errorNumber_ = errno;
    }
    bool verbose_;
    std::string path_;
    int errorNumber_ = 0;  ///< of the first line that could not be written
    std::ofstream out_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace lacquer::cmd
