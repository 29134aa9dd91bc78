// What a camera would see of a scene with free parameters.
#pragma once

#include <string>
#include <vector>

#include "estimate/scene/scene_parameters.h"
#include "estimate/simulator.h"
#include "pbrt/image/image.h"

namespace lacquer::estimate {

/// An image as means over blocks: at most `blocks` along its longer side.
struct ImageBlocks {
    Int2 count{0};
    /// r, g, b of each block, row by row. @param image  with channels R, G, B
    Vector MeansOf(const Image& image) const;
};
ImageBlocks BlocksOf(Int2 resolution, int blocks);

/// A photograph of a scene, linear and in the scene's own units: camera, light and shape are the scene's,
/// and so is the exposure unless it is a free parameter (kExposureName). The summaries are means of blocks
/// that are bright enough, then their standard errors, from four renders with seeds of their own.
class ScenePhotograph final : public Simulator {
  public:
    struct Options {
        int blocks = 12;        ///< along the longer side
        int pixelsOfBlock = 3;  ///< along its side, of what is rendered
        int samples = 16;       ///< of each pixel, in all
    };
    /// @param parameters  outlives the object
    /// @param photograph  with channels R, G, B, in the ratio of the scene's film
    /// Errors: those of BuildScene(); SceneError for a photograph of another ratio, without colours, with
    /// values that are not finite, or too dark.
    ScenePhotograph(const SceneParameters& parameters, const Image& photograph, const std::string& path,
                    const Options& options);
    const ParameterSpace& Parameters() const override { return parameters_.Space(); }
    const std::vector<std::string>& SummaryNames() const override { return names_; }
    Vector Simulate(const Vector& x, uint64_t seed) const override;
    /// Values of the photograph, in the order of the summaries.
    const Vector& Observed() const { return observed_; }

  private:
    Vector Render(const SceneDescription& scene, uint64_t seed) const;

    const SceneParameters& parameters_;
    Options options_;
    Int2 resolution_{0};  ///< of what is rendered
    ImageBlocks blocks_;
    std::vector<Eigen::Index> used_;  ///< of the blocks' values
    Vector observed_;
    std::vector<std::string> names_;
};

}  // namespace lacquer::estimate
