// Names from files and from other people's scenes, made fit for a terminal.
#pragma once

#include <string>

namespace lacquer::cmd {

/// A text that may quote anything: UTF-8, and without control characters other than tabs and ends of lines,
/// each of which becomes '?'.
std::string Printable(const std::string& text);
/// The same for a name in a line or a table: tabs and ends of lines become '?' as well.
std::string PrintableName(const std::string& name);

}  // namespace lacquer::cmd
