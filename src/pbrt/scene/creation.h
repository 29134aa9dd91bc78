// Plugins that are made by all threads at once: what is said of them, and what becomes of them, is as if they
// were made one after another.
#pragma once

#include <algorithm>
#include <exception>
#include <iterator>
#include <mutex>
#include <string>
#include <vector>

#include "pbrt/base/texture.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/progress.h"
#include "pbrt/scene/factory.h"

namespace lacquer {

/// Keeps the warnings of one plugin until its turn has come. Factories of shapes and lights tell nothing
/// else.
class KeptWarnings final : public Observer {
  public:
    explicit KeptWarnings(Observer* observer) : observer_(observer) {}
    void Warn(const std::string& message) override { warnings_.push_back(message); }
    void PassOn() {
        if (observer_)
            for (const std::string& warning : warnings_) observer_->Warn(warning);
        warnings_.clear();
    }

  private:
    Observer* observer_;
    std::vector<std::string> warnings_;
};

/// The textures of a scene for several threads: one at a time asks for them.
class SharedTextures final : public TextureLibrary {
  public:
    explicit SharedTextures(TextureLibrary& textures) : textures_(textures) {}
    const FloatTexture* Float(const std::string& name, const FileLoc& loc) override {
        const std::lock_guard lock(mutex_);
        return textures_.Float(name, loc);
    }
    const SpectrumTexture* Spectrum(const std::string& name, SpectrumKind kind, const FileLoc& loc) override {
        const std::lock_guard lock(mutex_);
        return textures_.Spectrum(name, kind, loc);
    }
    const FloatTexture* Own(std::unique_ptr<FloatTexture> texture) override {
        const std::lock_guard lock(mutex_);
        return textures_.Own(std::move(texture));
    }
    const SpectrumTexture* Own(std::unique_ptr<SpectrumTexture> texture) override {
        const std::lock_guard lock(mutex_);
        return textures_.Own(std::move(texture));
    }
    ImageCache& Images() override { return textures_.Images(); }
    bool WantsMeansOfImages() const override { return textures_.WantsMeansOfImages(); }

  private:
    TextureLibrary& textures_;
    std::mutex mutex_;
};

/// One plugin of `Kind`, from its entity's parameters to what its factory makes of them. Stays where it is.
template <class Kind, class Product>
class Creation {
  public:
    /// @param entity  its parameters go
    Creation(PluginEntity& entity, const FileResolver& files, Observer* observer)
        : entity_(entity), files_(files), observer_(observer) {
        files_.RecordIn(&filesRead_);
    }
    Creation(const Creation&) = delete;
    Creation& operator=(const Creation&) = delete;

    /// The factory's work; perhaps at the same time as that of others.
    /// @param make  (factory, parameters, observer) -> Product
    template <class Make>
    void Run(const Make& make) {
        try {
            const auto factory = FactoryOf<Kind>(entity_);
            params_ = MakeParams(std::move(entity_), Kind::kKind, files_);
            product_ = make(factory, params_, &observer_);
        } catch (...) {
            error_ = std::current_exception();
        }
    }

    /// The product, when its turn has come: tells what there is to tell before. Errors: those of the factory.
    Product Finish(std::vector<FileUse>* filesRead) {
        observer_.PassOn();
        std::move(filesRead_.begin(), filesRead_.end(), std::back_inserter(*filesRead));
        if (error_) std::rethrow_exception(error_);
        return std::move(product_);
    }
    const Params& Parameters() const { return params_; }

  private:
    PluginEntity& entity_;
    FileResolver files_;
    KeptWarnings observer_;
    Params params_;
    std::vector<FileUse> filesRead_;
    Product product_;
    std::exception_ptr error_;
};

/// How many of the entities that begin at `begin` are made together: what their parameters hold is in memory
/// until all of them are done.
/// @param entity  (index) -> PluginEntity&
template <class EntityAt>
size_t BatchSize(size_t begin, size_t end, const EntityAt& entity) {
    constexpr size_t kMaxEntities = 4096, kMaxValues = size_t(1) << 24;
    size_t values = 0, i = begin;
    for (; i < std::min(end, begin + kMaxEntities) && values < kMaxValues; ++i)
        for (const Parameter& p : entity(i).parameters) values += p.NumValues();
    return i - begin;
}

}  // namespace lacquer
