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

#include "pbrt/core/clock.h"

namespace lacquer::cmd {

namespace {

volatile sig_atomic_t receivedSignal = 0;

void OnSignal(int signal) {
    receivedSignal = signal;
    // The next one ends the process in the usual way.
    ::signal(signal, SIG_DFL);
}

/// Bytes of the UTF-8 character that begins at `at`; 0 if there is none, or a control character other than a
/// tab.
size_t PrintableLength(const std::string& text, size_t at) {
    const auto byte = [&](size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
    const unsigned first = byte(at);
    if (first < 0x80) return first == '\t' || (first >= 0x20 && first != 0x7f) ? 1 : 0;
    if (first < 0xc2 || first > 0xf4) return 0;
    const size_t length = first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
    for (size_t i = 1; i < length; ++i)
        if ((byte(at + i) & 0xc0) != 0x80) return 0;
    // U+0080 to U+009F steer terminals as well.
    return first == 0xc2 && byte(at + 1) < 0xa0 ? 0 : length;
}

/// A text that may quote anything, made fit for a terminal: of bounded length, UTF-8, and without control
/// characters.
std::string Printable(const std::string& text) {
    constexpr size_t kLongest = 4000;
    std::string result;
    for (size_t at = 0; at < std::min(text.size(), kLongest);) {
        const size_t length = PrintableLength(text, at);
        if (length == 0)
            result += text[at] == '\n' ? '\n' : '?';
        else
            result.append(text, at, length);
        at += std::max<size_t>(1, length);
    }
    return text.size() > kLongest ? result + "..." : result;
}

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
    struct sigaction action = {};
    action.sa_handler = OnSignal;
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    // A reader that went away is told by the failing write, not by the death of the process.
    ::signal(SIGPIPE, SIG_IGN);
}

int Console::Signal() { return receivedSignal; }

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
        fmt::print(stderr, "{} {}\n", name_, numbers);
        return;
    }
    constexpr int kWidth = 28;
    const int filled = int(std::lround(fraction * kWidth));
    fmt::print(stderr, "\r\033[K{} [{}{}] {}", name_, std::string(size_t(filled), '#'),
               std::string(size_t(kWidth - filled), '.'), numbers);
    std::fflush(stderr);
    barShown_ = true;
}

void Console::ClearBar() {
    if (!barShown_) return;
    fmt::print(stderr, "\r\033[K");
    std::fflush(stderr);
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
    fmt::print(stderr, "{}\n", Highlight(Printable(complete ? message : "warning: " + message)));
}

void Console::Info(const std::string& message) {
    const std::lock_guard lock(mutex_);
    if (style_.quiet) return;
    ClearBar();
    fmt::print(stderr, "{}\n", message);
}

void Console::Error(const Diagnostic& d) {
    const std::lock_guard lock(mutex_);
    ClearBar();
    fmt::print(stderr, "{}\n", Highlight(Printable(d.ToString())));
    if (d.loc.line <= 0) return;
    const std::string line = LineOf(d.loc.file, d.loc.line);
    if (line.empty() || d.loc.column < 1 || size_t(d.loc.column) > line.size() + 1) return;
    fmt::print(stderr, "  {}\n  {}{}\n", line, Indent(line, d.loc.column), Bold("^", 32));
}

void Console::Error(const std::string& message) {
    const std::lock_guard lock(mutex_);
    ClearBar();
    fmt::print(stderr, "{}\n", Highlight(Printable("error: " + message)));
}

}  // namespace lacquer::cmd
