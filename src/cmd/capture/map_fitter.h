// How a capture finds the maps of its photographs at first: texel by texel, or, in a program with libtorch,
// among those that a generator can make.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "capture/svbrdf/pixel_fit.h"

namespace lacquer::cmd {

/// What a generator's fit leaves beside the maps.
inline constexpr const char* kLatentName = "latent.safetensors";

struct FittedMaps {
    capture::FitResult fit;
    /// Rows and sentences of the report, each with its name.
    std::vector<std::pair<std::string, std::string>> settings, findings;
    /// Not empty: why the maps are not to be trusted, as a sentence without its full stop. A fit of texels
    /// then takes their place.
    std::string doubt;
};

class MapFitter {
  public:
    virtual ~MapFitter() = default;
    /// Texels along an edge that it makes; 0: as many as wanted.
    virtual int Size() const { return 0; }
    /// What its result depends on besides photographs and settings.
    virtual capture::FitCheckpoint::Problem Problem() const { return {}; }
    /// @param images    one for each view, of one size
    /// @param settings  of fits of texels; its callbacks and checkpoint are for all that it does
    virtual FittedMaps Fit(const capture::ViewSet& views, std::span<const capture::RectifiedImage> images,
                           const capture::FitSettings& settings, Observer* observer) = 0;
    /// Beside the maps. Errors: FileError.
    virtual void WriteExtras(const std::string& /*folder*/) const {}
};

/// capture::FitTexels().
std::unique_ptr<MapFitter> MakeTexelFitter();

}  // namespace lacquer::cmd
