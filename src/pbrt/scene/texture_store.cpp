#include "pbrt/scene/texture_store.h"

#include <algorithm>

#include "pbrt/scene/factory.h"

namespace lacquer {

TextureStore::TextureStore(const SceneDescription& description, const Transform& renderFromWorld,
                           std::shared_ptr<ImageCache> images, bool meansOfImages)
    : description_(description),
      renderFromWorld_(renderFromWorld),
      meansOfImages_(meansOfImages),
      images_(std::move(images)) {
    for (const TextureEntity& entity : description.textures)
        (entity.isSpectrum ? spectrumEntities_ : floatEntities_)[entity.name] = &entity;
}

void TextureStore::ReadImagesAhead() {
    std::vector<TextureImage> images;
    for (const TextureEntity& entity : description_.textures) {
        const auto image = entity.isSpectrum ? Registry<SpectrumTextureKind>::TraitsOf(entity.type).image
                                             : Registry<FloatTextureKind>::TraitsOf(entity.type).image;
        if (!image) continue;
        FileResolver files = description_.FilesOf(entity);
        files.RecordIn(nullptr);  // that a texture has read it is recorded when that is made
        try {
            images.push_back(image(MakeParams(entity, "texture", files)));
        } catch (const SceneError&) {  // NOLINT(bugprone-empty-catch): told when the texture is made
        }
    }
    images_->ReadAhead(std::move(images));
}

const TextureEntity& TextureStore::EntityOf(const Use& use, const FileLoc& loc) const {
    const Entities& known = use.isSpectrum ? spectrumEntities_ : floatEntities_;
    const Entities& others = use.isSpectrum ? floatEntities_ : spectrumEntities_;
    if (const auto entity = known.find(use.name); entity != known.end()) return *entity->second;
    const char* const what = use.isSpectrum ? "spectrum" : "float";
    if (others.contains(use.name))
        throw SceneError(loc, fmt::format("texture \"{}\" is not a {} texture; a {} texture is expected here",
                                          Excerpt(use.name), what, what));
    std::vector<std::string> names;
    for (const auto& [candidate, entity] : known) names.push_back(candidate);
    throw SceneError(loc, fmt::format("there is no {} texture \"{}\"{}", what, Excerpt(use.name),
                                      DidYouMean(use.name, names)));
}

const FloatTexture* TextureStore::Float(const std::string& name, const FileLoc& loc) {
    return Get({.isSpectrum = false, .name = name}, loc).asFloat;
}

const SpectrumTexture* TextureStore::Spectrum(const std::string& name, SpectrumKind kind,
                                              const FileLoc& loc) {
    return Get({.isSpectrum = true, .name = name, .kind = kind}, loc).asSpectrum;
}

const TextureStore::Made& TextureStore::Get(const Use& use, const FileLoc& loc) {
    if (!made_.contains(use)) {
        EntityOf(use, loc);
        if (beingMade_) throw NotYetMade{use, loc};
        MakeWithParts(use);
    }
    const Made& made = made_.at(use);
    if (made.error) std::rethrow_exception(made.error);
    if (beingMade_) {
        beingMade_->depth = std::max(beingMade_->depth, made.depth + 1);
        beingMade_->evaluations += made.evaluations;
    }
    return made;
}

namespace {

struct CircleMember {
    const TextureEntity* entity;
    FileLoc loc;  ///< where the one before asks for it
};

/// @param circle  textures of which each asks for the next one, and the last for the first
SceneError CircleError(std::vector<CircleMember> circle) {
    // Whoever was asked for first, it is the same message.
    std::rotate(circle.begin(),
                std::min_element(circle.begin(), circle.end(),
                                 [](const auto& a, const auto& b) { return a.entity < b.entity; }),
                circle.end());
    constexpr size_t kMaxNames = 4;
    std::string message = fmt::format("texture \"{}\" depends on itself", Excerpt(circle[0].entity->name));
    for (size_t i = 1; i < std::min(circle.size(), kMaxNames); ++i)
        message += fmt::format("{} \"{}\"", i == 1 ? ", by way of" : ",", Excerpt(circle[i].entity->name));
    if (circle.size() > kMaxNames) message += fmt::format(" and {} more", circle.size() - kMaxNames);
    return {circle[0].loc, message};
}

}  // namespace

// Factories ask for the textures that they need. Were those made on the spot, a deep chain of textures would
// overflow the stack. So a factory that asks for one which is not there is given up, and run again when that
// one is made.
void TextureStore::MakeWithParts(const Use& asked) {
    std::vector<NotYetMade> waiting{{asked, {}}};  // each for the next one
    std::set<Use> isWaiting{asked};
    while (!waiting.empty()) {
        const Use use = waiting.back().use;
        Made made;
        try {
            made = Make(use);
        } catch (const NotYetMade& part) {
            if (isWaiting.insert(part.use).second) {
                waiting.push_back(part);
                continue;
            }
            auto member = std::find_if(waiting.begin(), waiting.end(),
                                       [&](const NotYetMade& w) { return w.use == part.use; });
            member->loc = part.loc;  // where the circle asks for it, not who came from outside
            std::vector<CircleMember> circle;
            for (; member != waiting.end(); ++member)
                circle.push_back({&EntityOf(member->use, {}), member->loc});
            made.error = std::make_exception_ptr(CircleError(std::move(circle)));
        } catch (...) {
            made.error = std::current_exception();
        }
        made_.emplace(use, std::move(made));
        isWaiting.erase(use);
        waiting.pop_back();
    }
}

/// The run of a factory. If it is not completed, the constants are dropped that it has left behind.
class TextureStore::Factory {
  public:
    Factory(TextureStore& store, Made& made)
        : store_(store), numFloats_(store.ownedFloats_.size()), numSpectra_(store.ownedSpectra_.size()) {
        store.beingMade_ = &made;
    }
    ~Factory() {
        store_.beingMade_ = nullptr;
        if (isDone_) return;
        store_.ownedFloats_.resize(numFloats_);
        store_.ownedSpectra_.resize(numSpectra_);
    }
    Factory(const Factory&) = delete;
    Factory& operator=(const Factory&) = delete;

    /// The texture, owned by the store.
    template <class Kind>
    auto Run(const TextureEntity& entity, SpectrumKind kind) {
        const Params params = MakeParams(entity, "texture", store_.description_.FilesOf(entity));
        auto texture = FactoryOf<Kind>(entity)(
            {params, store_.renderFromWorld_ * entity.worldFromTexture, store_, kind});
        params.CheckAllUsed();
        isDone_ = true;
        return store_.Own(std::move(texture));
    }

  private:
    TextureStore& store_;
    size_t numFloats_, numSpectra_;
    bool isDone_ = false;
};

TextureStore::Made TextureStore::Make(const Use& use) {
    const TextureEntity& entity = EntityOf(use, {});
    Made made;
    Factory factory(*this, made);
    if (use.isSpectrum)
        made.asSpectrum = factory.Run<SpectrumTextureKind>(entity, use.kind);
    else
        made.asFloat = factory.Run<FloatTextureKind>(entity, use.kind);
    if (made.depth > kMaxTextureDepth)
        throw SceneError(entity.loc,
                         fmt::format("texture \"{}\" and those that it needs are {} inside of one another; "
                                     "expected at most {}",
                                     Excerpt(use.name), made.depth, kMaxTextureDepth));
    if (made.evaluations > kMaxTextureEvaluations)
        throw SceneError(entity.loc,
                         fmt::format("a look-up of texture \"{}\" takes up to {} evaluations of textures, "
                                     "each anew at each of its uses; expected at most {}",
                                     Excerpt(use.name), made.evaluations, kMaxTextureEvaluations));
    return made;
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
    const auto found = made_.find({.isSpectrum = false, .name = name});
    return found == made_.end() ? nullptr : found->second.asFloat;
}

const SpectrumTexture* TextureStore::MadeSpectrum(const std::string& name) const {
    for (auto it = made_.lower_bound({.isSpectrum = true, .name = name, .kind = SpectrumKind{}});
         it != made_.end() && it->first.isSpectrum && it->first.name == name; ++it)
        if (it->second.asSpectrum) return it->second.asSpectrum;
    return nullptr;
}

}  // namespace lacquer
