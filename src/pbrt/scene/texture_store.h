// The textures of one scene.
#pragma once

#include <map>
#include <set>
#include <vector>

#include "pbrt/base/texture.h"
#include "pbrt/image/image_cache.h"
#include "pbrt/scene/description.h"

namespace lacquer {

/// Makes textures when somebody asks for them: a spectrum texture once for each kind of use, so that, for
/// example, a value above 1 is an error only where it is used as a reflectance.
class TextureStore final : public TextureLibrary {
  public:
    TextureStore(const SceneDescription& description, const Transform& renderFromWorld,
                 const TextureMemory& memory = {}, bool meansOfImages = false, Observer* observer = nullptr);

    const FloatTexture* Float(const std::string& name, const FileLoc& loc) override;
    const SpectrumTexture* Spectrum(const std::string& name, SpectrumKind kind, const FileLoc& loc) override;
    const FloatTexture* Own(std::unique_ptr<FloatTexture> texture) override;
    const SpectrumTexture* Own(std::unique_ptr<SpectrumTexture> texture) override;
    ImageCache& Images() override { return images_; }
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
            if (!floats_.contains(named.first)) attempt([&] { Float(named.first, named.second->loc); });
        for (const auto& named : spectrumEntities_)
            if (!madeSpectra_.contains(named.first))
                attempt([&] { Spectrum(named.first, SpectrumKind::Unbounded, named.second->loc); });
    }

  private:
    /// Guards against textures that depend on themselves.
    class Making;
    Params ParamsOf(const TextureEntity& entity) const;
    [[noreturn]] static void Unknown(const char* what, const std::string& name, const FileLoc& loc,
                                     const std::map<std::string, const TextureEntity*>& known,
                                     const std::map<std::string, const TextureEntity*>& others);

    const SceneDescription& description_;
    Transform renderFromWorld_;
    bool meansOfImages_;
    std::map<std::string, const TextureEntity*> floatEntities_, spectrumEntities_;
    std::map<std::string, const FloatTexture*> floats_;
    std::map<std::pair<std::string, SpectrumKind>, const SpectrumTexture*> spectra_;
    std::set<std::string> madeSpectra_;
    std::set<std::string> making_;  // names under construction, "float " or "spectrum " before them
    ImageCache images_;             // outlives the textures, whose pyramids may be in its files
    std::vector<std::unique_ptr<FloatTexture>> ownedFloats_;
    std::vector<std::unique_ptr<SpectrumTexture>> ownedSpectra_;
};

}  // namespace lacquer
