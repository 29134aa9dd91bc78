#include "cmd/capture/map_fitter.h"

#include <fmt/format.h>

namespace lacquer::cmd {
namespace {

class TexelFitter final : public MapFitter {
  public:
    FittedMaps Fit(const capture::ViewSet& views, std::span<const capture::RectifiedImage> images,
                   const capture::FitSettings& settings, Observer* observer) override {
        capture::FitResult fit = capture::FitTexels(views, images, {}, settings, observer);
        std::string row =
            fmt::format("{} steps, {}, total variation {:.3g}", settings.iterations,
                        fit.isCoarseToFine ? "coarse to fine" : "at one size", settings.totalVariation);
        return {std::move(fit), {{"Fit", std::move(row)}}, {}, {}};
    }
};

}  // namespace

std::unique_ptr<MapFitter> MakeTexelFitter() { return std::make_unique<TexelFitter>(); }

}  // namespace lacquer::cmd
