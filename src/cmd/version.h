#pragma once

namespace lacquer::cmd {

/// From the build (project version in CMakeLists.txt).
inline constexpr const char* kVersion = LACQUER_VERSION;

}  // namespace lacquer::cmd
