#include "cmd/capture/map_fitter.h"

#include <fmt/format.h>

namespace lacquer::cmd {
namespace {

class TexelFitter final : public MapFitter {
  public:
    FittedMaps Fit(const capture::ViewSet& views, std::span<const capture::RectifiedImage> images,
                   const capture::FitSettings& settings, Observer* observer) override {
        return {capture::FitFromConstant(views, images, {}, settings, observer),
                {{"Fit", fmt::format("{} steps, total variation {:.3g}", settings.iterations,
                                     settings.totalVariation)}},
                {},
                {}};
    }
};

}  // namespace

std::unique_ptr<MapFitter> MakeTexelFitter() { return std::make_unique<TexelFitter>(); }

}  // namespace lacquer::cmd
