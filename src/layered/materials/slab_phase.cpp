#include "layered/materials/slab_phase.h"

#include <fmt/format.h>

#include "layered/materials/slab.h"
#include "pbrt/image/image_cache.h"
#include "pbrt/media/microflakes.h"
#include "pbrt/media/phase_functions.h"

namespace lacquer::layered {
namespace {

/// Phase functions that one slab may have, mixtures of mixtures included: they are made anew at each hit.
constexpr int kMaxParts = 64;

/// A phase function of one texture, or of none.
template <class Phase>
class AngularSlabPhase final : public SlabPhase {
  public:
    explicit AngularSlabPhase(const FloatTexture* parameter) : parameter_(parameter) {}
    const PhaseFunction* Make(const TextureContext& context, const Frame&, Arena& arena) const override {
        return arena.New<Phase>(parameter_->Evaluate(context));
    }
    bool IsConstant() const override { return parameter_->Constant().has_value(); }

  private:
    const FloatTexture* parameter_;
};

class IsotropicSlabPhase final : public SlabPhase {
  public:
    const PhaseFunction* Make(const TextureContext&, const Frame&, Arena& arena) const override {
        return arena.New<IsotropicPhase>();
    }
};

class TableSlabPhase final : public SlabPhase {
  public:
    explicit TableSlabPhase(const std::vector<float>& samples) : table_(samples) {}
    const PhaseFunction* Make(const TextureContext&, const Frame&, Arena& arena) const override {
        return arena.New<TabulatedPhase>(table_);
    }

  private:
    PhaseTable table_;
};

class MixtureSlabPhase final : public SlabPhase {
  public:
    MixtureSlabPhase(std::vector<const SlabMaterial*> slabs, std::vector<float> weights)
        : slabs_(std::move(slabs)), weights_(std::move(weights)) {}

    const PhaseFunction* Make(const TextureContext& context, const Frame& frame,
                              Arena& arena) const override {
        const std::span<const PhaseFunction*> parts = arena.NewArray<const PhaseFunction*>(slabs_.size());
        for (size_t i = 0; i < slabs_.size(); ++i) parts[i] = slabs_[i]->MakePhase(context, frame, arena);
        return arena.New<MixturePhase>(parts, weights_);
    }
    bool IsOriented() const override {
        return std::any_of(slabs_.begin(), slabs_.end(), [](auto s) { return s->Phase().IsOriented(); });
    }
    bool IsConstant() const override {
        return std::all_of(slabs_.begin(), slabs_.end(), [](auto s) { return s->Phase().IsConstant(); });
    }
    int NumParts() const override {
        int sum = 1;
        for (const SlabMaterial* slab : slabs_) sum += slab->Phase().NumParts();
        return sum;
    }

  private:
    std::vector<const SlabMaterial*> slabs_;
    std::vector<float> weights_;
};

/// A direction in the tangent frame, the same everywhere or from an image.
class Orientation {
  public:
    static Orientation Read(const Params& params, TextureLibrary& textures) {
        Orientation o;
        const std::optional<std::string> file = params.GetOptionalString("orientationmap");
        if (file && params.Has("orientation"))
            params.Fail(
                "orientationmap",
                "an orientation is either \"orientation\" or \"orientationmap\"; expected only one of "
                "the two");
        o.constant_ = params.GetVector3("orientation", {0, 0, 1});
        if (!(MaxComponent(Abs(o.constant_)) > 0))
            params.Fail("orientation", "\"vector3 orientation\" has no length; expected a direction");
        // Long and short ones alike: squares must neither overflow nor vanish later.
        o.constant_ /= MaxComponent(Abs(o.constant_));
        if (!file) return o;
        const std::string path = params.Files().Resolve(*file);
        o.map_ = textures.Images().Get(path, ColorEncoding{}, params.LocOf("orientationmap"));
        if (!o.map_->HasRGB())
            params.Fail("orientationmap", path + ": an orientation map needs channels R, G and B");
        if (o.map_->HasNonFinite())
            params.Fail("orientationmap", path + ": the image has pixels that are not finite numbers");
        return o;
    }

    /// Any length but 0.
    Vec3 At(const TextureContext& context) const {
        if (!map_) return constant_;
        // Image rows go down where v goes up.
        const Point2 st(context.uv.x, 1 - context.uv.y);
        Vec3 v;
        for (int c = 0; c < 3; ++c) v[c] = 2 * map_->Bilinear(st, c, WrapMode::Repeat) - 1;
        return LengthSquared(v) > 0 ? v : constant_;
    }
    bool IsConstant() const { return !map_; }

  private:
    Vec3 constant_{0, 0, 1};
    std::shared_ptr<const Image> map_;
};

class SggxSlabPhase final : public SlabPhase {
  public:
    SggxSlabPhase(Orientation orientation, const FloatTexture* roughness, bool isSurface)
        : orientation_(std::move(orientation)), roughness_(roughness), isSurface_(isSurface) {}
    const PhaseFunction* Make(const TextureContext& context, const Frame& frame,
                              Arena& arena) const override {
        return arena.New<SggxPhase>(frame.FromLocal(orientation_.At(context)), roughness_->Evaluate(context),
                                    isSurface_);
    }
    bool IsOriented() const override { return true; }
    bool IsConstant() const override { return orientation_.IsConstant() && roughness_->Constant(); }

  private:
    Orientation orientation_;
    const FloatTexture* roughness_;
    bool isSurface_;
};

class FibreSlabPhase final : public SlabPhase {
  public:
    FibreSlabPhase(Orientation orientation, const FloatTexture* stddev)
        : orientation_(std::move(orientation)), stddev_(stddev) {}
    const PhaseFunction* Make(const TextureContext& context, const Frame& frame,
                              Arena& arena) const override {
        return arena.New<FibrePhase>(frame.FromLocal(orientation_.At(context)), stddev_->Evaluate(context));
    }
    bool IsOriented() const override { return true; }
    bool IsConstant() const override { return orientation_.IsConstant() && stddev_->Constant(); }

  private:
    Orientation orientation_;
    const FloatTexture* stddev_;
};

// ---- Reading ----------------------------------------------------------------------------------------------

/// A float texture; where it is constant, its value must lie in [low, high].
const FloatTexture* TextureInRange(const MaterialArgs& args, const char* name, float fallback, float low,
                                   float high) {
    const FloatTexture* texture = FloatTextureParam(args.params, name, fallback, args.textures);
    const float value = texture->Constant().value_or(fallback);
    if (value >= low && value <= high) return texture;
    if (std::isinf(high))
        args.params.Fail(name,
                         fmt::format("\"{}\" is {}; expected a value of at least {}", name, value, low));
    args.params.Fail(name, fmt::format("\"{}\" is {}; expected a value in [{}, {}]", name, value, low, high));
}

std::unique_ptr<SlabPhase> ReadIsotropic(const MaterialArgs&) {
    return std::make_unique<IsotropicSlabPhase>();
}

std::unique_ptr<SlabPhase> ReadHenyeyGreenstein(const MaterialArgs& args) {
    return MakeHenyeyGreensteinSlabPhase(TextureInRange(args, "g", 0, -1, 1));
}

std::unique_ptr<SlabPhase> ReadVonMisesFisher(const MaterialArgs& args) {
    return std::make_unique<AngularSlabPhase<VonMisesFisherPhase>>(
        TextureInRange(args, "kappa", 1, 0, Infinity));
}

std::unique_ptr<SlabPhase> ReadTable(const MaterialArgs& args) {
    const std::vector<float> samples = args.params.GetFloats("table");
    if (samples.size() < 2)
        args.params.Fail("table", fmt::format("\"float table\" has {} values; expected two or more, from the "
                                              "cosine -1 (straight back) to 1 (straight on)",
                                              samples.size()));
    for (const float value : samples)
        if (value < 0) args.params.Fail("table", fmt::format("\"float table\": {} is negative", value));
    if (*std::max_element(samples.begin(), samples.end()) == 0)
        args.params.Fail("table", "\"float table\" is 0 everywhere; light must go somewhere");
    return std::make_unique<TableSlabPhase>(samples);
}

/// The slab called `name`, null for one that could not be made.
const SlabMaterial* FindSlab(const MaterialArgs& args, const std::string& name) {
    const auto it = args.named.find(name);
    if (it == args.named.end()) {
        std::vector<std::string> slabs;
        for (const auto& [known, material] : args.named)
            if (dynamic_cast<const SlabMaterial*>(material)) slabs.push_back(known);
        args.params.Fail("phases", fmt::format("no slab named \"{}\" stands before this one{}", Excerpt(name),
                                               DidYouMean(name, slabs)));
    }
    const auto* slab = dynamic_cast<const SlabMaterial*>(it->second);
    if (!slab && !it->second->IsStandIn())
        args.params.Fail(
            "phases",
            fmt::format("\"{}\" is no slab; expected one, whose phase function is mixed", Excerpt(name)));
    return slab;
}

std::vector<float> ReadWeights(const Params& params, size_t count) {
    std::vector<float> weights = params.GetFloats("weights");
    if (weights.empty() && !params.Has("weights")) return std::vector<float>(count, 1);
    if (weights.size() != count)
        params.Fail("weights", fmt::format("\"float weights\" has {} values for {} phase functions; expected "
                                           "one for each",
                                           weights.size(), count));
    float largest = 0;
    for (const float weight : weights) {
        if (weight < 0) params.Fail("weights", fmt::format("\"float weights\": {} is negative", weight));
        largest = std::max(largest, weight);
    }
    if (largest == 0) params.Fail("weights", "\"float weights\" are all 0; expected a positive one");
    return weights;
}

std::unique_ptr<SlabPhase> ReadMixture(const MaterialArgs& args) {
    const std::vector<std::string> names = args.params.GetStrings("phases");
    if (names.empty())
        args.params.Fail("phases", "a mixture needs \"string phases\": the names of earlier slabs");
    std::vector<const SlabMaterial*> slabs;
    int numParts = 1;
    for (const std::string& name : names) {
        const SlabMaterial* slab = FindSlab(args, name);
        slabs.push_back(slab);
        numParts += slab ? slab->Phase().NumParts() : 1;
        if (numParts > kMaxParts)
            args.params.Fail("phases", fmt::format("the mixture has more than {} phase functions, counting "
                                                   "those of mixtures in it",
                                                   kMaxParts));
    }
    std::vector<float> weights = ReadWeights(args.params, names.size());
    if (std::find(slabs.begin(), slabs.end(), nullptr) != slabs.end())
        return std::make_unique<IsotropicSlabPhase>();  // the scene is not rendered
    return std::make_unique<MixtureSlabPhase>(std::move(slabs), std::move(weights));
}

std::unique_ptr<SlabPhase> ReadSggx(const MaterialArgs& args) {
    return std::make_unique<SggxSlabPhase>(
        Orientation::Read(args.params, args.textures), TextureInRange(args, "roughness", 0.1f, 0, 1),
        args.params.GetChoice("flakes", "fibre", {"fibre", "surface"}) == "surface");
}

std::unique_ptr<SlabPhase> ReadFibre(const MaterialArgs& args) {
    const FloatTexture* stddev = TextureInRange(args, "stddev", 0.1f, 0, Infinity);
    if (stddev->Constant() == 0.f)
        args.params.Fail("stddev", "\"stddev\" is 0; expected a positive standard deviation");
    return std::make_unique<FibreSlabPhase>(Orientation::Read(args.params, args.textures), stddev);
}

struct PhaseEntry {
    const char* name;
    std::unique_ptr<SlabPhase> (*read)(const MaterialArgs&);
    std::vector<std::string> parameters;
};

const std::vector<PhaseEntry>& PhaseEntries() {
    static const std::vector<PhaseEntry> entries{
        {"isotropic", ReadIsotropic, {}},
        {"hg", ReadHenyeyGreenstein, {"g"}},
        {"vmf", ReadVonMisesFisher, {"kappa"}},
        {"table", ReadTable, {"table"}},
        {"mixture", ReadMixture, {"phases", "weights"}},
        {"sggx", ReadSggx, {"orientation", "orientationmap", "roughness", "flakes"}},
        {"fibre", ReadFibre, {"orientation", "orientationmap", "stddev"}},
    };
    return entries;
}

/// A parameter of another phase function is no misspelling: the message says where it belongs.
void RefuseOthersParameters(const Params& params, const PhaseEntry& chosen) {
    for (const Parameter& p : params.All()) {
        const auto has = [&](const PhaseEntry& entry) {
            return std::find(entry.parameters.begin(), entry.parameters.end(), p.name) !=
                   entry.parameters.end();
        };
        if (p.fromAttribute || has(chosen)) continue;
        for (const PhaseEntry& entry : PhaseEntries())
            if (has(entry))
                throw SceneError(p.loc, fmt::format("\"{}\" has no effect on the phase function \"{}\"; it "
                                                    "belongs to \"string phase\" \"{}\"",
                                                    p.name, chosen.name, entry.name));
    }
}

}  // namespace

std::unique_ptr<SlabPhase> MakeHenyeyGreensteinSlabPhase(const FloatTexture* g) {
    return std::make_unique<AngularSlabPhase<HenyeyGreensteinPhase>>(g);
}

std::unique_ptr<SlabPhase> ReadSlabPhase(const MaterialArgs& args) {
    std::vector<std::string> names;
    for (const PhaseEntry& entry : PhaseEntries()) names.push_back(entry.name);
    const std::string name = args.params.GetChoice("phase", "isotropic", names);
    const auto chosen = std::find_if(PhaseEntries().begin(), PhaseEntries().end(),
                                     [&](const PhaseEntry& entry) { return entry.name == name; });
    RefuseOthersParameters(args.params, *chosen);
    return chosen->read(args);
}

}  // namespace lacquer::layered
