// Participating media. The format's media come with volumetric transport; a surface only has to know that
// they exist.
#pragma once

namespace lacquer {

class Medium {
  public:
    virtual ~Medium() = default;
};

}  // namespace lacquer
