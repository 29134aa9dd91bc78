// What everyone who renders a scene does around Render(): options from the scene, the finished image with
// what it says about itself, statistics.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "pbrt/film/light_path_automaton.h"
#include "pbrt/image/image.h"
#include "pbrt/integrators/render.h"
#include "pbrt/scene/builder.h"

namespace lacquer {

/// What the scene says about its render: all samples, its seed, its jitter. No outputs, no limit of time.
RenderOptions RenderOptionsOf(const RenderSetup& setup);

/// Names of auxiliary outputs and of passes; "lpe:NAME=EXPRESSION" may be given as well.
std::vector<std::string> AovNames();

/// Errors: OverrideError for auxiliary outputs that the scene's camera ("motion") or integrator ("half") does
/// not have.
void CheckAovs(const std::vector<std::string>& names, const RenderSetup& setup);

/// Sums of auxiliary outputs for a scene's film; null where no names are given. Some of them need names that
/// the scene was built with: see AovBuffer. @param names  checked by the caller
std::unique_ptr<AovBuffer> MakeAovBuffer(const std::vector<std::string>& names, int cryptomatteRanks,
                                         const RenderSetup& setup);
/// The same for a part of the film.
std::unique_ptr<AovBuffer> MakeAovBuffer(const std::vector<std::string>& names, int cryptomatteRanks,
                                         const RenderSetup& setup, const Bounds2i& pixels);

/// The passes among these names, which the film then keeps; null where there are none. Errors:
/// LightPathError, for expressions and names that do not fit the scene, for an integrator that tells no
/// passes, and for a layered material that cannot be split.
std::unique_ptr<PassSet> MakePasses(const std::vector<std::string>& names, const RenderSetup& setup);

/// Where a finished image comes from.
struct ImageOrigin {
    int samplesPerPixel = 0;  ///< that it holds
    int firstSample = 0;
    double seconds = 0;              ///< of rendering
    bool showsSampleCounts = false;  ///< as a channel of their own: pixels got different numbers of samples
    std::string software, scene;     ///< names for the metadata
};
/// What images say about their scene: seed, transforms of the camera.
Metadata SceneMetadata(const RenderSetup& setup);
/// The film's image with its auxiliary outputs and metadata. @param aovs  may be null
/// @param hasPasses  the film keeps some
/// @param ofScene    SceneMetadata()
std::unique_ptr<Image> DevelopFilm(const Film& film, const AovBuffer* aovs, bool hasPasses,
                                   const Metadata& ofScene, const ImageOrigin& origin);
/// The same of a render. @param aovs, passes  may be null
std::unique_ptr<Image> DevelopRender(const RenderSetup& setup, const AovBuffer* aovs, const PassSet* passes,
                                     const ImageOrigin& origin);

/// True once a stop or a limit came within a pass.
inline bool PixelsDiffer(const RenderStats& stats) { return stats.maxSamples > stats.samplesPerPixel; }

/// An image without the channels of `names` that are none of `kept`: outputs that were needed for a while.
Image WithoutAovs(const Image& image, const std::vector<std::string>& names,
                  const std::vector<std::string>& kept);

/// What statistics hold beside the counters of the loop.
struct RenderCosts {
    double parseSeconds = 0, buildSeconds = 0, pilotSeconds = 0, writeSeconds = 0;
    int64_t peakBytes = 0;  ///< of memory, of the process
};
/// Statistics as JSON, indented by two blanks. @param image  its name
std::string StatisticsText(const RenderSetup& setup, const RenderStats& stats, const RenderCosts& costs,
                           const std::string& version, const std::string& image);

}  // namespace lacquer
