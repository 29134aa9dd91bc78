#include "pbrt/integrators/pixel_stats.h"

namespace lacquer {

std::unique_ptr<Image> PixelStats::Develop(Int2 fullResolution) const {
    auto image = std::make_unique<Image>(Int2(bounds_.Width(), bounds_.Height()),
                                         std::vector<std::string>{"time", "rays", "shadowrays", "vertices"});
    image->dataWindow = bounds_;
    image->fullResolution = fullResolution;
    float* out = image->Pixels().data();
    for (const Costs& costs : pixels_) {
        *out++ = float(costs.seconds);
        *out++ = float(costs.rays);
        *out++ = float(costs.shadowRays);
        *out++ = float(costs.vertices);
    }
    return image;
}

}  // namespace lacquer
