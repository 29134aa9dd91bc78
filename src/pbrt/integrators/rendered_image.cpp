#include "pbrt/integrators/rendered_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "pbrt/film/passes.h"

namespace lacquer {

RenderOptions RenderOptionsOf(const RenderSetup& setup) {
    RenderOptions options;
    options.endSample = setup.samplesPerPixel;
    options.plannedSamples = setup.plannedSamples;
    options.seed = setup.generatorSeed;
    options.jitter = {!setup.options.disablePixelJitter, !setup.options.disableWavelengthJitter};
    return options;
}

std::vector<std::string> AovNames() {
    std::vector<std::string> names = AovBuffer::Names();
    const std::vector<std::string> passes = PassNames();
    names.insert(names.end(), passes.begin(), passes.end());
    return names;
}

void CheckAovs(const std::vector<std::string>& names, const RenderSetup& setup) {
    const auto asksFor = [&](const char* name) {
        return std::find(names.begin(), names.end(), name) != names.end();
    };
    if (asksFor("motion"))
        if (const std::string why = setup.scene->Camera().WhyNoRaster(); !why.empty())
            throw OverrideError(fmt::format(
                "the auxiliary output \"motion\": {}; \"perspective\" and \"orthographic\" do", why));
    if (asksFor("half") && setup.integrator->MakesSplats())
        throw OverrideError(
            "the auxiliary output \"half\": the integrator of this scene traces light from the lights, which "
            "belongs to no half of a pixel's samples; \"path\", \"volpath\", \"simplepath\", "
            "\"simplevolpath\", \"randomwalk\" and \"ambientocclusion\" can");
}

std::unique_ptr<AovBuffer> MakeAovBuffer(const std::vector<std::string>& names, int cryptomatteRanks,
                                         const RenderSetup& setup) {
    return MakeAovBuffer(names, cryptomatteRanks, setup, setup.film->PixelBounds());
}

std::unique_ptr<AovBuffer> MakeAovBuffer(const std::vector<std::string>& names, int cryptomatteRanks,
                                         const RenderSetup& setup, const Bounds2i& pixels) {
    if (names.empty()) return nullptr;
    AovSetup aovs;
    aovs.pixelBounds = pixels;
    aovs.spaces = {&setup.film->ColorSpace(), setup.renderFromWorld,
                   setup.scene->Camera().RenderFromCamera()};
    aovs.names = &setup.scene->Names();
    aovs.cryptomatteRanks = cryptomatteRanks;
    return std::make_unique<AovBuffer>(names, aovs);
}

namespace {

void CheckSplits(const Scene& scene) {
    for (const auto& material : scene.Parts().materials)
        if (const std::string why = material->WhyNoVertices(); !why.empty())
            throw LightPathError(fmt::format(
                "the passes layered.surface, layered.single and layered.rest cannot be told apart: {}", why));
}

}  // namespace

std::unique_ptr<PassSet> MakePasses(const std::vector<std::string>& names, const RenderSetup& setup) {
    if (std::none_of(names.begin(), names.end(), IsPass)) return nullptr;
    if (!setup.integrator->TellsPasses())
        throw LightPathError(
            "the integrator of this scene cannot tell passes from each other (direct, lightgroups, "
            "layered.single, lpe:...); \"path\" and \"volpath\" can");
    const std::vector<std::string>& groups = setup.scene->Parts().lightGroups;
    auto passes = std::make_unique<PassSet>(PassesOf(names, groups), groups);
    if (passes->HasLayeredParts()) CheckSplits(*setup.scene);
    setup.film->KeepPasses(passes->Layers());
    return passes;
}

Metadata SceneMetadata(const RenderSetup& setup) {
    const Camera& camera = setup.scene->Camera();
    const Transform cameraFromWorld = camera.RenderFromCamera().Start().Inverse() * setup.renderFromWorld;
    Metadata metadata;
    metadata["seed"] = setup.options.seed;
    metadata["worldToCamera"] = cameraFromWorld.Matrix();
    if (const auto screenFromCamera = camera.ScreenFromCamera())
        metadata["worldToNDC"] = (*screenFromCamera * cameraFromWorld).Matrix();
    return metadata;
}

std::unique_ptr<Image> DevelopFilm(const Film& film, const AovBuffer* aovs, bool hasPasses,
                                   const Metadata& ofScene, const ImageOrigin& origin) {
    std::unique_ptr<Image> image = film.Develop();
    if (aovs) image = aovs->AppendTo(*image);
    if (hasPasses) image = film.AppendPasses(*image);
    if (origin.showsSampleCounts && image->FindChannel("samples") < 0) {
        const std::vector<int> counts = film.SampleCounts();
        *image = image->WithChannel("samples", {counts.begin(), counts.end()});
    }
    // Light that is traced from the lights has no halves, and those of the rest would mislead.
    if (film.SplatBytes() > 0) *image = AovBuffer::WithoutHalves(*image);
    for (const auto& [name, value] : ofScene) image->metadata[name] = value;
    image->metadata["samplesPerPixel"] = origin.samplesPerPixel;
    image->metadata["firstSample"] = origin.firstSample;
    image->metadata["renderTimeSeconds"] = float(origin.seconds);
    image->metadata["Software"] = origin.software;
    image->metadata["scene"] = origin.scene;
    return image;
}

std::unique_ptr<Image> DevelopRender(const RenderSetup& setup, const AovBuffer* aovs, const PassSet* passes,
                                     const ImageOrigin& origin) {
    return DevelopFilm(*setup.film, aovs, passes != nullptr, SceneMetadata(setup), origin);
}

std::string StatisticsText(const RenderSetup& setup, const RenderStats& stats, const RenderCosts& costs,
                           const std::string& version, const std::string& image) {
    const double samples = double(std::max<int64_t>(1, stats.cameraRays));
    const Bounds2i pixels = setup.film->PixelBounds();
    const std::vector<int> counts = setup.film->SampleCounts();
    const auto [least, most] = std::minmax_element(counts.begin(), counts.end());
    nlohmann::ordered_json statistics = {
        {"version", version},
        {"image", image},
        {"resolution", {pixels.Width(), pixels.Height()}},
        {"samples_per_pixel", stats.samplesPerPixel},
        {"samples",
         {{"least", *least}, {"most", *most}, {"mean", double(stats.samples) / double(pixels.Area())}}},
        {"threads", stats.threads},
        {"seed", setup.options.seed},
        {"seconds",
         {{"parse", costs.parseSeconds},
          {"build", costs.buildSeconds},
          {"render", stats.seconds},
          {"write", costs.writeSeconds}}},
        {"rays", {{"camera", stats.cameraRays}, {"path", stats.raysTraced}, {"shadow", stats.shadowRays}}},
        {"samples_per_second", double(stats.cameraRays) / std::max(stats.seconds, 1e-9)},
        {"mean_path_length", double(stats.pathLengthSum) / samples},
        {"bad_samples", stats.badSamples},
        {"product_sampling",
         {{"queries", stats.bxdf.productQueries}, {"fallbacks", stats.bxdf.productFallbacks}}},
        {"primitives", setup.scene->NumPrimitives()},
        {"lights", setup.scene->Lights().size()},
        {"memory_bytes",
         {{"peak", costs.peakBytes},
          {"geometry", setup.scene->GeometryBytes()},
          {"splats", setup.film->SplatBytes()},
          {"acceleration_structure", setup.scene->Accelerator().MemoryBytes()}}},
        {"complete", !stats.interrupted && !stats.timedOut},
    };
    for (const PhaseTime& t : setup.phases)
        statistics["build_phases"].push_back(
            {{"phase", t.phase}, {"seconds", t.seconds}, {"processors", t.processors}});
    if (costs.pilotSeconds > 0) statistics["seconds"]["pilots"] = costs.pilotSeconds;
    if (stats.noise) statistics["noise"] = *stats.noise;
    return statistics.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

Image WithoutAovs(const Image& image, const std::vector<std::string>& names,
                  const std::vector<std::string>& kept) {
    std::vector<std::string> helpers = AovBuffer::ChannelsOf(names);
    for (const std::string& channel : AovBuffer::ChannelsOf(kept)) std::erase(helpers, channel);
    return image.OnlyChannels([&](const std::string& channel) {
        return std::find(helpers.begin(), helpers.end(), channel) == helpers.end();
    });
}

}  // namespace lacquer
