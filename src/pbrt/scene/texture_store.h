// The textures of one scene.
#pragma once

#include <exception>
#include <map>
#include <set>
#include <vector>

#include "pbrt/base/texture.h"
#include "pbrt/image/image_cache.h"
#include "pbrt/scene/description.h"

namespace lacquer {

/// Textures inside of one another. Evaluation recurses: a level takes some 60 bytes of a thread's stack, of
/// which workers have 4 MiB; under sanitizers, and in textures with more variables, many times as much.
inline constexpr int kMaxTextureDepth = 1000;
/// Textures that one look-up evaluates. A texture is evaluated anew at each of its uses, so that n textures
/// can take 2^n evaluations; with this limit a look-up ends within a millisecond or so.
inline constexpr int64_t kMaxTextureEvaluations = 1 << 16;

/// Makes textures when somebody asks for them: a spectrum texture once for each kind of use, so that, for
/// example, a value above 1 is an error only where it is used as a reflectance.
///
/// Any texture may refer to any other one. Errors, beside those of the textures themselves: SceneError for
/// one that depends on itself, with some of those between, and for one beyond the limits above. What could
/// not be made is an error with the same message for everyone who asks.
class TextureStore final : public TextureLibrary {
  public:
    TextureStore(const SceneDescription& description, const Transform& renderFromWorld,
                 std::shared_ptr<ImageCache> images, bool meansOfImages = false);

    const FloatTexture* Float(const std::string& name, const FileLoc& loc) override;
    const SpectrumTexture* Spectrum(const std::string& name, SpectrumKind kind, const FileLoc& loc) override;
    const FloatTexture* Own(std::unique_ptr<FloatTexture> texture) override;
    const SpectrumTexture* Own(std::unique_ptr<SpectrumTexture> texture) override;
    ImageCache& Images() override { return *images_; }
    /// Reads the images of all textures by all threads. What is wrong with them is told by the functions
    /// above.
    void ReadImagesAhead();
    bool WantsMeansOfImages() const override { return meansOfImages_; }
    /// A texture that has been made already, a spectrum texture for whichever use; null if there is none.
    /// Also once the description is gone, when the functions above can make no texture any more.
    const FloatTexture* MadeFloat(const std::string& name) const;
    const SpectrumTexture* MadeSpectrum(const std::string& name) const;

    /// Makes the textures that nobody asked for, so that their mistakes are found; one at a time through
    /// `attempt`.
    template <class Attempt>
    void MakeUnused(const Attempt& attempt) {
        for (const auto& named : floatEntities_)
            if (!MadeFloat(named.first)) attempt([&] { Float(named.first, named.second->loc); });
        for (const auto& named : spectrumEntities_)
            if (!MadeSpectrum(named.first))
                attempt([&] { Spectrum(named.first, SpectrumKind::Unbounded, named.second->loc); });
    }

  private:
    using Entities = std::map<std::string, const TextureEntity*>;
    /// A texture for one use.
    struct Use {
        bool isSpectrum;
        std::string name;
        SpectrumKind kind = SpectrumKind::Albedo;      ///< float textures: always this one
        auto operator<=>(const Use&) const = default;  // NOLINT(modernize-use-nullptr): its own zero
    };
    /// What a use of a texture became.
    struct Made {
        const FloatTexture* asFloat = nullptr;        ///< null unless it is a float texture
        const SpectrumTexture* asSpectrum = nullptr;  ///< null unless it is a spectrum texture
        int depth = 1;                                ///< textures inside of one another, itself included
        int64_t evaluations = 1;                      ///< of textures, at most, for one of itself
        std::exception_ptr error;                     ///< why there is none
    };
    /// What a factory runs into that asks for a texture which is not there yet.
    struct NotYetMade {
        Use use;
        FileLoc loc;
    };
    class Factory;

    const Made& Get(const Use& use, const FileLoc& loc);
    void MakeWithParts(const Use& asked);
    Made Make(const Use& use);
    const TextureEntity& EntityOf(const Use& use, const FileLoc& loc) const;

    const SceneDescription& description_;
    Transform renderFromWorld_;
    bool meansOfImages_;
    Entities floatEntities_, spectrumEntities_;
    std::map<Use, Made> made_;
    Made* beingMade_ = nullptr;           ///< by the factory that is running; null if none is
    std::shared_ptr<ImageCache> images_;  ///< outlives the textures, whose pyramids may be in its files
    std::vector<std::unique_ptr<FloatTexture>> ownedFloats_;
    std::vector<std::unique_ptr<SpectrumTexture>> ownedSpectra_;
};

}  // namespace lacquer
