// Auxiliary outputs ("arbitrary output variables"): what the camera sees beside radiance. docs/aovs.md has
// their list.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "pbrt/base/scene_names.h"
#include "pbrt/film/aov_output.h"
#include "pbrt/film/cryptomatte.h"
#include "pbrt/film/exact_sums.h"
#include "pbrt/image/image.h"

namespace lacquer {

/// What outputs need to know of the scene and the image.
struct AovSetup {
    Bounds2i pixelBounds;
    AovSpaces spaces;
    const SceneNames* names = nullptr;  ///< for outputs with NeedsSceneNames(); outlives the buffer
    int cryptomatteRanks = 6;           ///< even
};

/// Sums of the outputs that were asked for; extra channels of the written image. Memory: 8 bytes a pixel,
/// 17 for each sum of each output (AovOutput::numSums), and IdCounts for objects and for materials.
class AovBuffer {
  public:
    /// The names that users may ask for.
    static std::vector<std::string> Names();
    /// Channels of the outputs with these names, but for those of ids and mattes; with Half.R, Half.G, Half.B
    /// of the film.
    static std::vector<std::string> ChannelsOf(const std::vector<std::string>& names);
    /// True if one of `names` needs FilmOverrides::keepsHalves.
    static bool NeedsHalves(const std::vector<std::string>& names);
    /// The image without the channels of halves: without their colours, or of others, they would mislead.
    static Image WithoutHalves(const Image& image);
    /// True if one of `names` is about objects or materials: then the scene has to keep theirs.
    static bool NeedsSceneNames(const std::vector<std::string>& names);
    /// @param names  as above (checked by the caller) or internal ones of AovKind; repeated ones count once
    AovBuffer(const std::vector<std::string>& names, const AovSetup& setup);

    FirstHitNeeds Needs() const;
    /// That of the film.
    void SetHalves(const Halves& halves) { halves_ = halves; }
    /// The names that it was made with, each once.
    const std::vector<std::string>& OutputNames() const { return names_; }
    /// Bytes of the sums, without IdCounts.
    size_t MemoryBytes() const { return (counts_.size() + halfCounts_.size()) * sizeof(int) + sums_.Bytes(); }
    /// Adds one camera sample; pixels belong to one thread at a time.
    /// @param response  of the film's sensor, where an output asks for it
    void Add(Int2 pixel, const FirstHit& hit, SampledSpectrum L, const SampledWavelengths& lambda,
             Vec3 response = Vec3(0), float weight = 1);
    /// Appends the channels and their metadata to an image of the same pixels. Channels that the image has
    /// already (of a film that keeps geometry) stay as they are.
    std::unique_ptr<Image> AppendTo(const Image& rgb) const;
    /// As that of films. @param prefix  of the names of the arrays
    void AppendState(const std::string& prefix, std::vector<StateArray>* arrays);

  private:
    /// Objects or materials.
    struct IdLayer {
        std::string idChannel, manifestKey, layerName;
        bool wantsId = false, wantsLayer = false;
        std::vector<std::string> names = {};
        std::unique_ptr<IdCounts> counts = {};
        std::unique_ptr<CryptomatteLayer> layer = {};
    };
    void PrepareIdLayer(IdLayer* idLayer, int ranks);
    void AddIds(size_t pixel, const FirstHit& hit);
    /// Channels to append, and the metadata that belong to them.
    std::vector<std::string> Channels() const;
    void AddMetadata(Metadata* metadata) const;
    /// The values of all channels of one pixel.
    void Develop(size_t pixel, float* out) const;

    std::vector<std::string> names_;
    std::vector<AovOutput> outputs_;
    AovSetup setup_;
    Transform worldFromRender_;
    IdLayer objects_, materials_;
    std::unordered_map<const Material*, int> materialIds_;
    /// Samples and hits of each pixel: of all samples; of the first half, if that is asked for.
    std::vector<int> counts_, halfCounts_;
    Halves halves_;
    size_t stride_ = 0;  ///< sums of a pixel
    ExactSums sums_;     ///< of all pixels, in the order of outputs_
};

}  // namespace lacquer
