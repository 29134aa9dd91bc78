#include "cmd/console.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "cmd/printable.h"
#include "pbrt/core/clock.h"

namespace lacquer::cmd {

namespace {

volatile sig_atomic_t receivedSignal = 0;

void OnSignal(int signal) {
    receivedSignal = signal;
    // The next one ends the process in the usual way.
    ::signal(signal, SIG_DFL);
}

/// A message as a terminal gets it, of bounded length.
std::string Shown(const std::string& message) {
    constexpr size_t kLongest = 4000;
    return message.size() > kLongest ? Printable(message.substr(0, kLongest)) + "..." : Printable(message);
}

/// To standard error. That it takes no more, as where the terminal was closed, must cost nothing else.
void Put(const std::string& text) {
    std::fwrite(text.data(), 1, text.size(), stderr);
    std::fflush(stderr);
}
void PutLine(const std::string& line) { Put(line + "\n"); }

/// Line `number` of a text file, empty if there is none, it is unreasonably long, or it is no text.
std::string LineOf(const std::string& file, int number) {
    constexpr size_t kLongest = 400;
    // What stands in a compressed file is not what was read from it; a pipe cannot be read again.
    std::error_code ignored;
    if (file.ends_with(".gz") || !std::filesystem::is_regular_file(file, ignored)) return {};
    std::ifstream in(file);
    std::string line;
    for (int i = 0; i < number; ++i)
        if (!std::getline(in, line)) return {};
    if (!line.empty() && line.back() == '\r') line.pop_back();
    return line.size() > kLongest || Printable(line) != line ? std::string() : line;
}

/// Blanks that reach to below the character at `column`, counted from 1 in bytes: a tab stays one, and the
/// bytes that continue a UTF-8 character take no room.
std::string Indent(const std::string& line, int column) {
    std::string indent;
    for (size_t i = 0; i + 1 < size_t(column); ++i) {
        const bool continues = (static_cast<unsigned char>(line[i]) & 0xc0) == 0x80;
        if (!continues) indent += line[i] == '\t' ? '\t' : ' ';
    }
    return indent;
}

}  // namespace

ConsoleStyle ConsoleStyle::Detect(bool quiet) {
    const char* term = std::getenv("TERM");
    ConsoleStyle style;
    style.quiet = quiet;
    style.terminal = isatty(STDERR_FILENO) && term && std::strcmp(term, "dumb") != 0;
    const char* noColor = std::getenv("NO_COLOR");
    style.color = style.terminal && !(noColor && *noColor);
    return style;
}

void Console::CatchSignals() {
    struct sigaction action = {}, before = {};
    action.sa_handler = OnSignal;
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    // Unless it is ignored already, as by nohup.
    if (sigaction(SIGHUP, nullptr, &before) == 0 && before.sa_handler != SIG_IGN)
        sigaction(SIGHUP, &action, nullptr);
}

void Console::CatchUserSignal() {
    struct sigaction action = {};
    action.sa_handler = OnSignal;
    sigaction(SIGUSR1, &action, nullptr);
}

int Console::Signal() { return receivedSignal; }

ExitStatus Console::StatusOfSignal() {
    if (receivedSignal == SIGHUP) return ExitStatus::HungUp;
    const bool isTermination = receivedSignal == SIGTERM || receivedSignal == SIGUSR1;
    return isTermination ? ExitStatus::Terminated : ExitStatus::Interrupted;
}

std::string FormatSeconds(double seconds) {
    if (seconds < 60) return fmt::format("{:.1f} s", seconds);
    const auto whole = int64_t(seconds);
    if (whole < 3600) return fmt::format("{}:{:02}", whole / 60, whole % 60);
    return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

std::string FormatCount(double count) {
    if (count >= 1e9) return fmt::format("{:.1f} G", count / 1e9);
    if (count >= 1e6) return fmt::format("{:.1f} M", count / 1e6);
    if (count >= 1e3) return fmt::format("{:.0f} k", count / 1e3);
    return fmt::format("{:.0f} ", count);
}

void Console::Begin(const std::string& name, int64_t total, const std::string& unit) {
    const std::lock_guard lock(mutex_);
    name_ = name;
    unit_ = unit;
    total_ = std::max<int64_t>(total, 1);
    done_ = 0;
    described_ = 0;
    note_.clear();
    start_ = lastDraw_ = Clock::now();
    active_ = true;
}

void Console::Describe(double fraction, const std::string& note) {
    const std::lock_guard lock(mutex_);
    described_ = fraction;
    note_ = note;
}

void Console::Advance(int64_t units) {
    done_ += units;
    if (style_.quiet) return;
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock || !active_) return;
    const double interval = style_.terminal ? 0.2 : 10;
    if (SecondsSince(lastDraw_) < interval) return;
    lastDraw_ = Clock::now();
    Draw();
}

void Console::End() {
    const std::lock_guard lock(mutex_);
    if (!active_) return;
    active_ = false;
    if (!style_.quiet && style_.terminal) ClearBar();
}

void Console::Draw() {
    const double elapsed = SecondsSince(start_);
    const double fraction = std::clamp(double(done_) / double(total_), described_, 1.0);
    const double remaining = fraction > 0 ? elapsed * (1 - fraction) / fraction : 0;
    std::string numbers = fmt::format("{:3.0f} %  {} elapsed, {} left", 100 * fraction,
                                      FormatSeconds(elapsed), FormatSeconds(remaining));
    if (!unit_.empty())
        numbers += fmt::format(", {}{}/s", FormatCount(double(done_) / std::max(elapsed, 1e-9)), unit_);
    if (!note_.empty()) numbers += ", " + note_;
    if (!style_.terminal) {
        PutLine(fmt::format("{} {}", PrintableName(name_), numbers));
        return;
    }
    constexpr int kWidth = 28;
    const int filled = int(std::lround(fraction * kWidth));
    Put(fmt::format("\r\033[K{} [{}{}] {}", PrintableName(name_), std::string(size_t(filled), '#'),
                    std::string(size_t(kWidth - filled), '.'), numbers));
    barShown_ = true;
}

void Console::ClearBar() {
    if (!barShown_) return;
    Put("\r\033[K");
    barShown_ = false;
}

std::string Console::Bold(const std::string& text, int colorCode) const {
    return style_.color ? fmt::format("\033[1;{}m{}\033[0m", colorCode, text) : text;
}

std::string Console::Highlight(const std::string& message) const {
    for (const auto& [word, code] : {std::pair("error:", 31), std::pair("warning:", 33)}) {
        const size_t at = message.find(word);
        if (at != std::string::npos)
            return std::string(message).replace(at, std::strlen(word), Bold(word, code));
    }
    return message;
}

void Console::Warn(const std::string& message) {
    const std::lock_guard lock(mutex_);
    if (style_.quiet || !warned_.insert(message).second) return;
    ClearBar();
    const bool complete = message.find("warning:") != std::string::npos;
    PutLine(Highlight(Shown(complete ? message : "warning: " + message)));
}

void Console::Info(const std::string& message) {
    const std::lock_guard lock(mutex_);
    if (style_.quiet) return;
    ClearBar();
    PutLine(Shown(message));
}

void Console::Print(const std::string& text) {
    const std::lock_guard lock(mutex_);
    ClearBar();
    PutLine(Printable(text));
}

void Console::Error(const Diagnostic& d) {
    const std::lock_guard lock(mutex_);
    ClearBar();
    PutLine(Highlight(Shown(d.ToString())));
    if (d.loc.line <= 0) return;
    const std::string line = LineOf(d.loc.file, d.loc.line);
    if (line.empty() || d.loc.column < 1 || size_t(d.loc.column) > line.size() + 1) return;
    PutLine(fmt::format("  {}\n  {}{}", line, Indent(line, d.loc.column), Bold("^", 32)));
}

void Console::Error(const std::string& message) {
    const std::lock_guard lock(mutex_);
    ClearBar();
    PutLine(Highlight(Shown("error: " + message)));
}

}  // namespace lacquer::cmd
