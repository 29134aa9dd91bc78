#include "pbrt/scene/parse_log.h"

#include <fmt/format.h>

namespace lacquer {

void ParseLog::Error(const FileLoc& loc, const std::string& message) {
    errors_.push_back({Diagnostic::Severity::Error, loc, message});
    if (errors_.size() < kMaxErrors) return;
    errors_.push_back({Diagnostic::Severity::Error, {}, fmt::format("stopped after {} errors", kMaxErrors)});
    throw ParsingStops();
}

void ParseLog::Fatal(const FileLoc& loc, const std::string& message) {
    errors_.push_back({Diagnostic::Severity::Error, loc, message});
    throw ParsingStops();
}

void ParseLog::Error(const FileError& error) {
    fileErrors_.push_back(error);
    isIncomplete_ = true;
    Error(error.Loc(), error.Message());
}

void ParseLog::Warn(const FileLoc& loc, const std::string& message) {
    if (warnings_.size() >= kMaxWarnings) return;
    if (!warnings_.empty() && warnings_.back().message == message) return;
    warnings_.push_back({Diagnostic::Severity::Warning, loc, message});
    if (observer_) observer_->Warn(warnings_.back().ToString());
}

void ParseLog::V3(const FileLoc& loc, const std::string& offender, const std::string& advice) {
    const char* introduction = isV3_ ? ""
                                     : "this is a pbrt-v3 scene, and Lacquer reads pbrt-v4 (lacquer convert "
                                       "--upgrade makes one of it): ";
    isV3_ = true;
    Error(loc, fmt::format("{}{} is pbrt-v3; in pbrt-v4 {}", introduction, offender, advice));
}

void ParseLog::ThrowIfErrors() const {
    if (errors_.empty()) return;
    if (errors_.size() == 1 && fileErrors_.size() == 1) throw fileErrors_.front();
    throw SceneErrors(errors_);
}

}  // namespace lacquer
