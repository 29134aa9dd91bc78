#include "compare/fingerprint.h"

#include <filesystem>

#include "pbrt/core/rng.h"

namespace lacquer::compare {

namespace {

namespace fs = std::filesystem;

class Fingerprint {
  public:
    explicit Fingerprint(const SceneDescription& scene) : scene_(scene) {}

    uint64_t Value() {
        for (const PluginEntity* entity :
             {&scene_.film, &scene_.sampler, &scene_.filter, &scene_.integrator, &scene_.accelerator})
            Add(*entity);
        Add(scene_.camera, scene_.camera.cameraFromWorld, scene_.camera.medium);
        Add(scene_.camera.startTime, scene_.camera.endTime, scene_.startTime, scene_.endTime);
        Add(scene_.options);
        for (const TextureEntity& t : scene_.textures) Add(t, t.worldFromTexture, t.name, t.isSpectrum);
        for (const MaterialEntity& m : scene_.materials) Add(m);
        for (const MaterialEntity& m : scene_.namedMaterials) Add(m, m.name);
        for (const MediumEntity& m : scene_.media) Add(m, m.worldFromMedium, m.name);
        for (const LightEntity& l : scene_.lights) Add(l, l.worldFromLight, l.medium);
        for (const PluginEntity& l : scene_.areaLights) Add(l);
        for (const ShapeEntity& s : scene_.shapes) AddShape(s);
        for (const ObjectDefinition& object : scene_.objects) {
            Add(object.name);
            for (const ShapeEntity& s : object.shapes) AddShape(s);
        }
        for (const InstanceEntity& i : scene_.instances) Add(i.name, i.worldFromInstance);
        return hash_;
    }

  private:
    /// All of several things, in turn.
    template <class First, class Second, class... More>
    void Add(const First& first, const Second& second, const More&... more) {
        Add(first);
        Add(second);
        (Add(more), ...);
    }
    void Add(float x) { hash_ = Hash(hash_, x); }
    void Add(int x) { hash_ = Hash(hash_, x); }
    void Add(bool x) { hash_ = Hash(hash_, int(x)); }
    void Add(const std::string& text) {
        hash_ = Hash(hash_, text.size());
        for (const char c : text) hash_ = Hash(hash_, c);
    }
    void Add(const Transform& t) {
        for (int column = 0; column < 4; ++column)
            for (int row = 0; row < 4; ++row) Add(float(t.Matrix()[column][row]));
    }
    void Add(const TransformPair& t) { Add(t.start, t.end); }

    void Add(const GivenOptions& given) {
        for (const SceneOption& option : OptionTable()) {
            if (!option.changesImage) continue;
            Add(given.IsGiven(option.field));
            std::visit([&](auto field) { Add(given.Values().*field); }, option.field);
        }
    }

    void Add(const PluginEntity& entity) {
        Add(entity.type);
        for (const Parameter& p : entity.parameters) AddParameter(p, entity);
        if (entity.attributes)
            for (const Parameter& p : *entity.attributes) AddParameter(p, entity);
    }

    void AddShape(const ShapeEntity& s) {
        Add(s, s.worldFromObject, s.reverseOrientation, s.material.index, s.material.name);
        Add(s.areaLight, s.insideMedium, s.outsideMedium);
    }

    void AddParameter(const Parameter& p, const PluginEntity& owner) {
        Add(p.type, p.name);
        if (p.colorSpace) Add(p.colorSpace->Name());
        for (const float x : p.floats) Add(x);
        for (const int x : p.integers) Add(x);
        for (const unsigned char x : p.bools) Add(int(x));
        for (const std::string& text : p.strings) {
            Add(text);
            AddFile(scene_.FilesOf(owner).Resolve(text));
        }
    }

    void AddFile(const std::string& path) {
        std::error_code error;
        if (!fs::is_regular_file(path, error)) return;
        hash_ = Hash(hash_, uint64_t(fs::file_size(path, error)),
                     int64_t(fs::last_write_time(path, error).time_since_epoch().count()));
    }

    const SceneDescription& scene_;
    uint64_t hash_ = 0;
};

}  // namespace

uint64_t FingerprintOf(const SceneDescription& scene) { return Fingerprint(scene).Value(); }

}  // namespace lacquer::compare
