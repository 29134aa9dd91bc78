#include "pbrt/film/aov.h"

#include <algorithm>
#include <array>
#include <set>

#include "pbrt/film/manifest.h"
#include "pbrt/film/render_state.h"

namespace lacquer {

namespace {

/// Features of the first half of the samples, and their number: with the film's own Half.R, Half.G and
/// Half.B.
constexpr const char* kHalf = "half";
constexpr std::array kFeatures = {"albedo", "normal", "depth", "samples"};
AovOutput OfHalf(AovOutput output) {
    for (std::string& channel : output.channels) channel = "Half." + channel;
    output.isOfHalf = true;
    return output;
}

constexpr std::array kIdOutputs = {"object", "material", "cryptoobject", "cryptomaterial"};

template <class List, class Value>
bool Contains(const List& list, const Value& value) {
    return std::find(list.begin(), list.end(), value) != list.end();
}

// Counts are samples and hits, pixel by pixel.
void Count(size_t pixel, bool isHit, std::vector<int>* counts) {
    (*counts)[2 * pixel] += 1;
    (*counts)[2 * pixel + 1] += isHit ? 1 : 0;
}
AovCounts CountsOf(const std::vector<int>& counts, size_t pixel) {
    return {double(counts[2 * pixel]), double(counts[2 * pixel + 1])};
}

}  // namespace

std::vector<std::string> AovBuffer::Names() {
    std::vector<std::string> names;
    for (const std::string& name : Registry<AovKind>::Names())
        if (!Registry<AovKind>::Find(name)().isInternal) names.push_back(name);
    names.insert(names.end(), kIdOutputs.begin(), kIdOutputs.end());
    names.emplace_back(kHalf);
    return names;
}

std::vector<std::string> AovBuffer::ChannelsOf(const std::vector<std::string>& names) {
    std::vector<std::string> channels;
    const auto add = [&](const AovOutput& output) {
        channels.insert(channels.end(), output.channels.begin(), output.channels.end());
    };
    for (const std::string& name : names)
        if (const auto factory = Registry<AovKind>::Find(name)) add(factory());
    if (!NeedsHalves(names)) return channels;
    channels.insert(channels.end(), {"Half.R", "Half.G", "Half.B"});
    for (const char* feature : kFeatures) add(OfHalf(Registry<AovKind>::Find(feature)()));
    return channels;
}

bool AovBuffer::NeedsHalves(const std::vector<std::string>& names) { return Contains(names, kHalf); }

Image AovBuffer::WithoutHalves(const Image& image) {
    return image.OnlyChannels([](const std::string& channel) { return !channel.starts_with("Half."); });
}

bool AovBuffer::NeedsSceneNames(const std::vector<std::string>& names) {
    return std::any_of(names.begin(), names.end(),
                       [](const std::string& name) { return Contains(kIdOutputs, name); });
}

AovBuffer::AovBuffer(const std::vector<std::string>& names, const AovSetup& setup)
    : setup_(setup),
      worldFromRender_(setup.spaces.renderFromWorld.Inverse()),
      objects_{"object.id", "objectManifest", "CryptoObject"},
      materials_{"material.id", "materialManifest", "CryptoMaterial"} {
    std::set<std::string> known;
    for (const std::string& name : names) {
        if (!known.insert(name).second) continue;
        names_.push_back(name);
        if (const auto factory = Registry<AovKind>::Find(name)) outputs_.push_back(factory());
        objects_.wantsId |= name == "object";
        objects_.wantsLayer |= name == "cryptoobject";
        materials_.wantsId |= name == "material";
        materials_.wantsLayer |= name == "cryptomaterial";
    }
    const size_t pixels = size_t(setup.pixelBounds.Area());
    if (NeedsHalves(names)) {
        for (const char* feature : kFeatures) outputs_.push_back(OfHalf(Registry<AovKind>::Find(feature)()));
        halfCounts_.resize(2 * pixels);
    }
    for (const AovOutput& output : outputs_) stride_ += size_t(output.numSums);
    counts_.resize(2 * pixels);
    sums_ = ExactSums(pixels * stride_);
    if (setup.names) {
        objects_.names = setup.names->objects;
        for (const auto& [material, name] : setup.names->materials) {
            materialIds_[material] = int(materials_.names.size());
            materials_.names.push_back(name);
        }
    }
    PrepareIdLayer(&objects_, setup.cryptomatteRanks);
    PrepareIdLayer(&materials_, setup.cryptomatteRanks);
}

void AovBuffer::PrepareIdLayer(IdLayer* idLayer, int ranks) {
    if (idLayer->wantsId || idLayer->wantsLayer)
        idLayer->counts = std::make_unique<IdCounts>(counts_.size() / 2, int(idLayer->names.size()));
    if (idLayer->wantsLayer)
        idLayer->layer = std::make_unique<CryptomatteLayer>(idLayer->layerName, idLayer->names, ranks);
}

FirstHitNeeds AovBuffer::Needs() const {
    FirstHitNeeds needs;
    needs.any = objects_.counts || materials_.counts;
    for (const AovOutput& output : outputs_) needs = needs | output.needs;
    return needs;
}

void AovBuffer::Add(Int2 p, const FirstHit& hit, SampledSpectrum L, const SampledWavelengths& lambda,
                    Vec3 response, float weight) {
    const Int2 q = p - setup_.pixelBounds.min;
    const size_t pixel = size_t(q.y) * size_t(setup_.pixelBounds.Width()) + size_t(q.x);
    const bool isOfHalf = halves_.IsFirst(counts_[2 * pixel], pixel);
    Count(pixel, hit.hit, &counts_);
    if (isOfHalf && !halfCounts_.empty()) Count(pixel, hit.hit, &halfCounts_);
    const Transform cameraFromRender = setup_.spaces.renderFromCamera.At(hit.time).Inverse();
    const AovSample sample{hit,
                           L,
                           lambda,
                           response,
                           *setup_.spaces.color,
                           setup_.spaces.cameraSpace ? cameraFromRender : worldFromRender_,
                           cameraFromRender,
                           weight};
    size_t first = pixel * stride_;
    for (const AovOutput& output : outputs_) {
        if ((hit.hit || !output.needs.any) && (isOfHalf || !output.isOfHalf)) {
            std::array<double, kMaxAovSums> terms{};
            output.add(sample, terms.data());
            for (size_t i = 0; i < size_t(output.numSums); ++i) sums_.Add(first + i, terms[i]);
        }
        first += size_t(output.numSums);
    }
    if (hit.hit) AddIds(pixel, hit);
}

void AovBuffer::AddIds(size_t pixel, const FirstHit& hit) {
    if (objects_.counts && hit.object >= 0 && size_t(hit.object) < objects_.names.size())
        objects_.counts->Add(pixel, hit.object);
    if (!materials_.counts) return;
    const auto it = materialIds_.find(hit.material);
    if (it != materialIds_.end()) materials_.counts->Add(pixel, it->second);
}

std::vector<std::string> AovBuffer::Channels() const {
    std::vector<std::string> channels;
    for (const AovOutput& output : outputs_)
        channels.insert(channels.end(), output.channels.begin(), output.channels.end());
    for (const IdLayer* idLayer : {&objects_, &materials_}) {
        if (idLayer->wantsId) channels.push_back(idLayer->idChannel);
        if (!idLayer->layer) continue;
        const std::vector<std::string> ranks = idLayer->layer->Channels();
        channels.insert(channels.end(), ranks.begin(), ranks.end());
    }
    return channels;
}

void AovBuffer::AddMetadata(Metadata* metadata) const {
    for (const IdLayer* idLayer : {&objects_, &materials_}) {
        if (idLayer->wantsId)
            (*metadata)[idLayer->manifestKey] =
                JsonManifest(idLayer->names, [](size_t i) { return std::to_string(i + 1); });
        if (idLayer->layer) idLayer->layer->AddMetadata(metadata);
    }
}

void AovBuffer::Develop(size_t pixel, float* out) const {
    const AovCounts counts = CountsOf(counts_, pixel);
    const AovCounts halfCounts = halfCounts_.empty() ? counts : CountsOf(halfCounts_, pixel);
    size_t first = pixel * stride_;
    for (const AovOutput& output : outputs_) {
        std::array<double, kMaxAovSums> sums{};
        for (size_t i = 0; i < size_t(output.numSums); ++i) sums[i] = sums_[first + i];
        output.develop(*setup_.spaces.color, output.isOfHalf ? halfCounts : counts, sums.data(), out);
        first += size_t(output.numSums);
        out += output.channels.size();
    }
    for (const IdLayer* idLayer : {&objects_, &materials_}) {
        if (!idLayer->counts) continue;
        const std::vector<IdCount> ranked = idLayer->counts->Ranked(pixel);
        if (idLayer->wantsId) {
            // What most of the samples see; "nothing" takes part.
            const double misses = counts.samples - counts.hits;
            const bool seen = !ranked.empty() && ranked[0].count >= misses;
            *out++ = seen ? float(ranked[0].id + 1) : 0.f;
        }
        if (!idLayer->layer) continue;
        idLayer->layer->Develop(ranked, counts.samples, out);
        out += idLayer->layer->Channels().size();
    }
}

void AovBuffer::AppendState(const std::string& prefix, std::vector<StateArray>* arrays) {
    arrays->push_back({prefix + "counts", &counts_});
    if (!halfCounts_.empty()) arrays->push_back({prefix + "half counts", &halfCounts_});
    if (stride_ > 0) arrays->push_back({prefix + "sums", &sums_});
    if (objects_.counts) arrays->push_back({prefix + "objects", objects_.counts.get()});
    if (materials_.counts) arrays->push_back({prefix + "materials", materials_.counts.get()});
}

std::unique_ptr<Image> AovBuffer::AppendTo(const Image& rgb) const {
    // Which of our channels are new.
    const std::vector<std::string> ours = Channels();
    std::vector<size_t> added;
    std::vector<std::string> names;
    for (size_t i = 0; i < ours.size(); ++i) {
        if (rgb.FindChannel(ours[i]) >= 0) continue;
        added.push_back(i);
        names.push_back(ours[i]);
    }
    auto image = std::make_unique<Image>(rgb.WithRoomFor(names));
    AddMetadata(&image->metadata);
    // Geometry, counts and ids have no room in 16 bits; colours and directions have.
    std::vector<std::string> narrow;
    for (const AovOutput& output : outputs_)
        if (!output.needsFloats) narrow.insert(narrow.end(), output.channels.begin(), output.channels.end());
    for (const size_t i : added)
        if (!Contains(narrow, ours[i])) image->floatChannels.insert(ours[i]);

    const size_t before = size_t(rgb.NumChannels());
    std::vector<float> values(ours.size());
    float* out = image->Pixels().data();
    for (size_t pixel = 0; 2 * pixel < counts_.size(); ++pixel) {
        out += before;
        Develop(pixel, values.data());
        for (const size_t i : added) *out++ = values[i];
    }
    return image;
}

}  // namespace lacquer
