// The log file that --log-file asks for.
#pragma once

#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <fmt/format.h>

#include "cmd/printable.h"
#include "pbrt/core/error.h"

namespace lacquer::cmd {

/// Lines with seconds since the start; nothing without a file name.
class Log {
  public:
    /// Errors: FileError if the file cannot be written, or holds anything but an earlier log.
    Log(const std::string& path, const std::string& level) : verbose_(level == "verbose"), path_(path) {
        if (path.empty()) return;
        if (!MayBeReplaced(path)) throw FileError(path, "is there already and is no log; it stays as it is");
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
    /// A log is written from before the scene is read, whose files are not known then.
    static bool MayBeReplaced(const std::string& path) {
        std::error_code error;
        if (!std::filesystem::is_regular_file(path, error)) return true;
        std::string line;
        std::ifstream file(path);
        if (!std::getline(file, line)) return true;  // empty
        double seconds = 0;
        std::istringstream words(line);
        const size_t point = line.find('.');
        return words >> seconds && point == kSecondsWidth - kSecondsDigits - 1 &&
               line.size() > kSecondsWidth && line[kSecondsWidth] == ' ';
    }
    void Write(const std::string& message) {
        if (!out_.is_open()) return;
        const double seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
        errno = 0;
        if (out_ << fmt::format("{:{}.{}f} {}\n", seconds, kSecondsWidth, kSecondsDigits, Printable(message))
                 << std::flush)
            return;
        if (errorNumber_ == 0) errorNumber_ = errno;
    }
    static constexpr size_t kSecondsWidth = 10, kSecondsDigits = 3;
    bool verbose_;
    std::string path_;
    int errorNumber_ = 0;  ///< of the first line that could not be written
    std::ofstream out_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace lacquer::cmd
