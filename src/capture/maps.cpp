#include "capture/maps.h"

#include "pbrt/core/check.h"

namespace lacquer::capture {

Maps::Maps(int n) : size(n) {
    LACQUER_CHECK(n > 0);
    values.resize(kNumChannels * NumTexels());
}

}  // namespace lacquer::capture
