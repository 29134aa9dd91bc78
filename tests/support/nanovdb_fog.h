// A NanoVDB file for tests of what any medium can do.
#pragma once

#include <string>

namespace lacquer::test {

/// The path of a file, there until the tests end, with a ball of fog: density 1 up to 0.85 from (0.3, -0.2,
/// 0.5), and falling to 0 at 1.
const std::string& FogFile();

}  // namespace lacquer::test
