// Errors that a user can make, each with its place; thrown by the library, printed only by the commands.
#pragma once

#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "pbrt/core/file_name.h"

namespace lacquer {

/// A place in a text file; line and column count from 1, line 0 means the file as a whole.
struct FileLoc {
    FileName file;
    int line = 0, column = 0;
    /// "file:line:column", as much of it as is known; empty if nothing is.
    std::string ToString() const;
};

/// A problem without an exception, so that several can be reported together.
struct Diagnostic {
    enum class Severity { Warning, Error };
    enum class Cause { Scene, File };  ///< a wrong scene, or a file that cannot be read
    Severity severity = Severity::Error;
    FileLoc loc;
    std::string message;
    Cause cause = Cause::Scene;
    /// "file:line:column: error: message".
    std::string ToString() const;
};

/// The scene, or an asset that it names, says something impossible: exit status 2.
class SceneError : public std::runtime_error {
  public:
    SceneError(FileLoc loc, const std::string& message);
    const FileLoc& Loc() const { return loc_; }
    /// The message without the place.
    const std::string& Message() const { return message_; }

  private:
    FileLoc loc_;
    std::string message_;
};

/// Several problems found together; what() joins them line by line.
class SceneErrors : public std::runtime_error {
  public:
    explicit SceneErrors(std::vector<Diagnostic> diagnostics);
    const std::vector<Diagnostic>& Diagnostics() const { return diagnostics_; }

  private:
    std::vector<Diagnostic> diagnostics_;
};

/// A file cannot be opened, read or written at all: exit status 3.
class FileError : public std::runtime_error {
  public:
    /// `loc` is the place in the scene that names the file, where there is one.
    FileError(const std::string& path, const std::string& problem, FileLoc loc = {});
    const std::string& Path() const { return path_; }
    const std::string& Problem() const { return problem_; }
    /// "path: problem", without the place.
    const std::string& Message() const { return message_; }
    const FileLoc& Loc() const { return loc_; }

  private:
    std::string path_, problem_, message_;
    FileLoc loc_;
};

/// Text fit for a message: at most 40 bytes and whole characters of it, control characters as '?'.
std::string Excerpt(std::string_view text);

/// The candidate with the smallest edit distance to `name` (case ignored; at most a third of its length,
/// at least one edit), or an empty string. Ties go to the first candidate.
std::string NearestName(std::string_view name, std::span<const std::string> candidates);
/// "; did you mean \"x\"?" for the nearest candidate, empty if none is near.
std::string DidYouMean(std::string_view name, std::span<const std::string> candidates);

}  // namespace lacquer
