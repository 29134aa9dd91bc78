#pragma once

namespace lacquer {

/// From the build (project version in CMakeLists.txt).
inline constexpr const char* kVersion = LACQUER_VERSION;

}  // namespace lacquer
