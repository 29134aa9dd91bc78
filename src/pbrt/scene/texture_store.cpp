#include "pbrt/scene/texture_store.h"

#include <algorithm>

#include "pbrt/scene/factory.h"

namespace lacquer {

class TextureStore::Making {
  public:
    Making(std::set<std::string>& making, std::string key, const std::string& name, const FileLoc& loc)
        : making_(making), key_(std::move(key)) {
        if (!making_.insert(key_).second)
            throw SceneError(loc, fmt::format("texture \"{}\" depends on itself", Excerpt(name)));
    }
    ~Making() { making_.erase(key_); }
    Making(const Making&) = delete;
    Making& operator=(const Making&) = delete;

  private:
    std::set<std::string>& making_;
    std::string key_;
};

TextureStore::TextureStore(const SceneDescription& description, const Transform& renderFromWorld,
                           const TextureMemory& memory, bool meansOfImages, Observer* observer)
    : description_(description),
      renderFromWorld_(renderFromWorld),
      meansOfImages_(meansOfImages),
      images_(memory, observer) {
    for (const TextureEntity& entity : description.textures)
        (entity.isSpectrum ? spectrumEntities_ : floatEntities_)[entity.name] = &entity;
}

Params TextureStore::ParamsOf(const TextureEntity& entity) const {
    return MakeParams(entity, "texture", description_.FilesOf(entity));
}

void TextureStore::Unknown(const char* what, const std::string& name, const FileLoc& loc,
                           const std::map<std::string, const TextureEntity*>& known,
                           const std::map<std::string, const TextureEntity*>& others) {
    if (others.contains(name))
        throw SceneError(loc, fmt::format("texture \"{}\" is not a {} texture; a {} texture is expected here",
                                          Excerpt(name), what, what));
    std::vector<std::string> names;
    for (const auto& [candidate, entity] : known) names.push_back(candidate);
    throw SceneError(
        loc, fmt::format("there is no {} texture \"{}\"{}", what, Excerpt(name), DidYouMean(name, names)));
}

const FloatTexture* TextureStore::Float(const std::string& name, const FileLoc& loc) {
    if (const auto made = floats_.find(name); made != floats_.end()) return made->second;
    const auto entity = floatEntities_.find(name);
    if (entity == floatEntities_.end()) Unknown("float", name, loc, floatEntities_, spectrumEntities_);
    const Making guard(making_, "float " + name, name, loc);
    const TextureEntity& e = *entity->second;
    const Params params = ParamsOf(e);
    auto texture = FactoryOf<FloatTextureKind>(e)({params, renderFromWorld_ * e.worldFromTexture, *this});
    params.CheckAllUsed();
    return floats_[name] = Own(std::move(texture));
}

const SpectrumTexture* TextureStore::Spectrum(const std::string& name, SpectrumKind kind,
                                              const FileLoc& loc) {
    const std::pair key(name, kind);
    if (const auto made = spectra_.find(key); made != spectra_.end()) return made->second;
    const auto entity = spectrumEntities_.find(name);
    if (entity == spectrumEntities_.end()) Unknown("spectrum", name, loc, spectrumEntities_, floatEntities_);
    const Making guard(making_, "spectrum " + name, name, loc);
    const TextureEntity& e = *entity->second;
    const Params params = ParamsOf(e);
    auto texture =
        FactoryOf<SpectrumTextureKind>(e)({params, renderFromWorld_ * e.worldFromTexture, *this, kind});
    params.CheckAllUsed();
    madeSpectra_.insert(name);
    return spectra_[key] = Own(std::move(texture));
}

const FloatTexture* TextureStore::Own(std::unique_ptr<FloatTexture> texture) {
    ownedFloats_.push_back(std::move(texture));
    return ownedFloats_.back().get();
}

const SpectrumTexture* TextureStore::Own(std::unique_ptr<SpectrumTexture> texture) {
    ownedSpectra_.push_back(std::move(texture));
    return ownedSpectra_.back().get();
}

const FloatTexture* TextureStore::MadeFloat(const std::string& name) const {
    const auto found = floats_.find(name);
    return found == floats_.end() ? nullptr : found->second;
}

const SpectrumTexture* TextureStore::MadeSpectrum(const std::string& name) const {
    const auto found = std::find_if(spectra_.begin(), spectra_.end(),
                                    [&](const auto& made) { return made.first.first == name; });
    return found == spectra_.end() ? nullptr : found->second;
}

}  // namespace lacquer
