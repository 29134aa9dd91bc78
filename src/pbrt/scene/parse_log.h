// Problems that parsing finds, collected so that many can be reported together.
#pragma once

#include <string>
#include <vector>

#include "pbrt/core/error.h"
#include "pbrt/core/progress.h"

namespace lacquer {

/// Thrown when there is no point in reading on; ends the parse, whose result is what the log holds.
struct ParsingStops {};

class ParseLog {
  public:
    static constexpr size_t kMaxErrors = 20, kMaxWarnings = 100;

    explicit ParseLog(Observer* observer) : observer_(observer) {}
    void Error(const FileLoc& loc, const std::string& message);
    /// An error after which all others would be its consequences.
    [[noreturn]] void Fatal(const FileLoc& loc, const std::string& message);
    /// A file that the scene includes and that cannot be read.
    void Error(const FileError& error);
    /// Consecutive equal warnings count as one; those beyond kMaxWarnings are dropped.
    void Warn(const FileLoc& loc, const std::string& message);
    /// An error for a name of pbrt-v3; the first one says at length what it means.
    /// @param offender  what stands in the file    @param advice  what stands there in pbrt-v4
    void V3(const FileLoc& loc, const std::string& offender, const std::string& advice);

    /// Something that may define names was not read: unresolved names need not be errors of their own.
    void MarkIncomplete() { isIncomplete_ = true; }
    bool IsIncomplete() const { return isIncomplete_; }
    const std::vector<Diagnostic>& Errors() const { return errors_; }
    const std::vector<Diagnostic>& Warnings() const { return warnings_; }
    /// Throws what was found: FileError where an unreadable file is the only problem, else SceneErrors.
    void ThrowIfErrors() const;

  private:
    Observer* observer_;
    std::vector<Diagnostic> errors_, warnings_;
    std::vector<FileError> fileErrors_;
    bool isIncomplete_ = false, isV3_ = false;
};

}  // namespace lacquer
