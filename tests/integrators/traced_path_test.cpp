// What every registered integrator owes to those who read counters and auxiliary outputs, whatever its light
// transport is: each ray is counted, each vertex is counted, and each camera ray's first surface is recorded,
// with its footprint. Rays and vertices are counted a second time by the scene itself: by a shape that every
// ray must ask, and by a material that knows which of its BxDFs were asked for anything.
#include "pbrt/integrators/traced_path.h"

#include <gtest/gtest.h>

#include <atomic>

#include "integrators/render_fixtures.h"
#include "pbrt/bxdfs/diffuse.h"

namespace lacquer::traced_path_test {
namespace {

using test::BuildText;

/// Around everything and never hit. Every ray to a nearest hit asks it once; a shadow ray also, unless it met
/// something before.
class RayCounter final : public Shape {
  public:
    explicit RayCounter(std::atomic<int64_t>* count) : count_(count) {}
    Bounds3 Bounds(int) const override { return {Point3(-1000), Point3(1000)}; }
    std::optional<ShapeHit> Intersect(const Ray&, float, float, int) const override {
        ++*count_;
        return std::nullopt;
    }
    void Interaction(const Ray&, const ShapeHit&, int, SurfaceInteraction*) const override {}
    float Area(int) const override { return 0; }
    std::optional<ShapeSample> SampleArea(int, Point2) const override { return std::nullopt; }

  private:
    std::atomic<int64_t>* count_;
};

/// Matte, and counted when it is asked for anything for the first time.
class CountedBxDF final : public BxDF {
  public:
    explicit CountedBxDF(std::atomic<int64_t>* count) : count_(count) {}
    Lobes Flags() const override { return diffuse_.Flags(); }
    BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const override {
        Count();
        return diffuse_.Evaluate(wo, wi, context);
    }
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u,
                                     const BxDFContext& context) const override {
        Count();
        return diffuse_.Sample(wo, u, context);
    }

  private:
    void Count() const {
        if (!counted_) ++*count_;
        counted_ = true;
    }
    std::atomic<int64_t>* count_;
    mutable bool counted_ = false;
    DiffuseBxDF diffuse_{SampledSpectrum(0.5f)};
};
class CountedMaterial final : public Material {
  public:
    explicit CountedMaterial(std::atomic<int64_t>* count) : count_(count) {}
    BxDF* MakeBxDF(const TextureContext&, SampledWavelengths&, Arena& arena) const override {
        return arena.New<CountedBxDF>(count_);
    }

  private:
    std::atomic<int64_t>* count_;
};

constexpr int kPixels = 20;
constexpr float kDistance = 4;

/// A wall at the distance kDistance, seen through a window of interface material. The light, between the two,
/// shines on the wall only: no ray to it is ever stopped. Camera and world space are the same.
const std::string kRoom =
    "Camera \"perspective\" \"float fov\" 90 Film \"rgb\" \"integer xresolution\" 20 \"integer yresolution\" "
    "20 Sampler \"independent\" Option \"rendercoordsys\" \"camera\" WorldBegin "
    "AttributeBegin Material \"interface\" Shape \"bilinearmesh\" \"point3 P\" "
    "[-50 -50 1  50 -50 1  -50 50 1  50 50 1] AttributeEnd "
    "LightSource \"spot\" \"point3 from\" [0 0 2] \"point3 to\" [0 0 4] "
    "Shape \"bilinearmesh\" \"point3 P\" [-50 -50 4  50 -50 4  -50 50 4  50 50 4] ";
/// The camera in a ball of fog with interface walls, in a uniform light.
std::string Fog(const std::string& medium, const std::string& behind) {
    return "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" " + medium +
           " MediumInterface \"\" \"fog\" Camera \"perspective\" \"float fov\" 90 Film \"rgb\" \"integer "
           "xresolution\" 20 \"integer yresolution\" 20 Sampler \"independent\" Option \"rendercoordsys\" "
           "\"camera\" WorldBegin LightSource \"infinite\" MediumInterface \"fog\" \"\" "
           "Material \"interface\" Shape \"sphere\" \"float radius\" 3.5 MediumInterface \"\" \"\" "
           "Material \"diffuse\" " +
           behind;
}

/// What was counted and recorded while each pixel took some samples.
struct Deeds final : FirstHitObserver {
    void Cover(float) override {}
    int64_t samples = 0, rays = 0, vertices = 0;  ///< as the integrator counted
    int64_t raysSeen = 0, verticesSeen = 0;       ///< as the scene did
    int records = 0, recordsOnTheWall = 0, recordsWithFootprint = 0;

    void Record(const SurfaceInteraction& si, const BxDF&, Vec3) override {
        ++records;
        recordsOnTheWall += std::abs(si.p.z - kDistance) < 1e-4f;
        // The neighbouring pixel's ray meets the wall a constant step aside; what the smallest pixel would
        // give differs from that by its orientation, all over the image.
        const float step = 2 * kDistance / kPixels;
        recordsWithFootprint += Length(si.dpdx - Vec3(step, 0, 0)) < 1e-3f * step;
    }
};

/// A scene that counts.
class CountingScene {
  public:
    explicit CountingScene(const std::string& text) : setup_(BuildText(text)), material_(&vertices_) {
        // The scene of the text is taken apart; nothing else has seen it yet.
        SceneParts parts = std::move(const_cast<SceneParts&>(setup_.scene->Parts()));
        for (Primitive& p : parts.groups[0])
            if (!p.material || !p.material->IsInvisible()) p.material = &material_;
        Primitive counter;
        counter.shape = std::make_unique<RayCounter>(&rays_);
        // An interface, so that it counts as no surface that scatters.
        parts.materials.push_back(Registry<MaterialKind>::Find("interface")(
            {test::ParamsFromText("material \"interface\"", ""), *parts.textures, {}}));
        counter.material = parts.materials.back().get();
        parts.groups[0].push_back(std::move(counter));
        setup_.integrator.reset();
        setup_.scene = std::make_unique<Scene>(std::move(parts));
    }

    const Scene& World() const { return *setup_.scene; }
    std::unique_ptr<Integrator> Make(const std::string& name, const std::string& parameters = "") const {
        const Params params = test::ParamsFromText("integrator", parameters);
        return Registry<IntegratorKind>::Find(name)({params, *setup_.scene});
    }

    /// One sample or more of each pixel.
    Deeds Observe(const Integrator& integrator, int samplesPerPixel = 4) {
        Deeds deeds;
        ThreadState state;
        state.firstHit = &deeds;
        if (integrator.MakesSplats()) {
            setup_.film->PrepareForSplats(1);
            state.film = setup_.film.get();
        }
        rays_ = vertices_ = 0;
        // So few photons are traced by one thread.
        const auto shared = integrator.ShareSample({.film = *setup_.film,
                                                    .state = [&]() -> ThreadState& { return state; },
                                                    .isStopped = [] { return false; }});
        state.shared = shared.get();
        const auto sampler = setup_.sampler->Clone();
        for (int i = 0; i < kPixels * kPixels * samplesPerPixel; ++i) {
            const Int2 pixel(i % kPixels, i / kPixels % kPixels);
            sampler->StartPixelSample(pixel, i);
            state.rng = Rng(Hash(i));
            SampledWavelengths lambda = SampledWavelengths::SampleVisible(sampler->Get1D());
            const auto ray =
                setup_.scene->Camera().GenerateRay({Point2(pixel) + sampler->Get2D(), Point2(0.5f), 0.5f});
            integrator.Li(*ray, lambda, *sampler, state);
            state.arena.Reset();
            ++deeds.samples;
        }
        deeds.rays = state.rays.nearest + state.rays.shadow;
        deeds.vertices = state.pathLengthSum;
        deeds.raysSeen = rays_;
        deeds.verticesSeen = vertices_;
        return deeds;
    }

  private:
    std::atomic<int64_t> rays_ = 0, vertices_ = 0;
    RenderSetup setup_;
    CountedMaterial material_;
};

/// What an integrator forgot in kRoom; empty if nothing.
std::string ForgottenInTheRoom(const Deeds& d) {
    std::string forgotten;
    if (d.rays != d.raysSeen) forgotten += "rays ";
    if (d.vertices < d.verticesSeen) forgotten += "vertices ";
    if (d.records != d.samples) forgotten += "records ";
    if (d.recordsOnTheWall != d.records) forgotten += "the window ";
    if (d.recordsWithFootprint != d.records) forgotten += "footprints ";
    return forgotten;
}

/// Names of the integrators that render surfaces: all but those that refuse the room.
std::vector<std::string> SurfaceIntegrators(const CountingScene& room) {
    std::vector<std::string> names;
    for (const std::string& name : Registry<IntegratorKind>::Names()) {
        try {
            room.Make(name);
            names.push_back(name);
        } catch (const SceneError&) {
        }
    }
    return names;
}

// Ambient occlusion looks a little way only, so that the window is not in its way.
const std::string kParameters = "\"float maxdistance\" 0.5 ";

TEST(TracedPath, EveryIntegratorCountsAndRecords) {
    CountingScene room(kRoom);
    const std::vector<std::string> names = SurfaceIntegrators(room);
    EXPECT_EQ(names.size() + 1, Registry<IntegratorKind>::Names().size());  // "simplevolpath" refuses
    for (const std::string& name : names) {
        const auto integrator = room.Make(name, kParameters + "\"integer maxdepth\" 3");
        const Deeds d = room.Observe(*integrator);
        EXPECT_EQ(ForgottenInTheRoom(d), "") << name;
        // Through the window to the wall, where all integrators scatter light; lights shine on it, too. Paths
        // of chains are none of camera samples.
        EXPECT_GE(d.rays, 2 * d.samples) << name;
        if (!integrator->UsesChains()) {
            EXPECT_GE(d.vertices, d.samples) << name;
        }
        EXPECT_GT(d.raysSeen, 0) << name;
    }
}

TEST(TracedPath, FirstHitsAreRecordedAlsoWhereNothingMayScatter) {
    CountingScene room(kRoom);
    for (const std::string& name : SurfaceIntegrators(room)) {
        const Deeds d = room.Observe(*room.Make(name, kParameters + "\"integer maxdepth\" 0"));
        EXPECT_EQ(ForgottenInTheRoom(d), "") << name;
    }
}

TEST(TracedPath, IntegratorsOfMediaCountThereAndRecordWhatIsSeenUnscattered) {
    const std::string wall = "Shape \"bilinearmesh\" \"point3 P\" [-50 -50 4  50 -50 4  -50 50 4  50 50 4] ";
    const std::string clear = "\"rgb sigma_a\" [.1 .1 .1] \"rgb sigma_s\" [0 0 0]";
    // Next to nothing comes unscattered through 17.5 free paths: 400 e^-17.5 is 1e-5.
    const std::string dense = "\"rgb sigma_a\" [0 0 0] \"rgb sigma_s\" [5 5 5]";
    // Rays from the sky do not all meet what counts them.
    const auto observe = [](CountingScene& scene, const Integrator& integrator, int samples) {
        Deeds deeds = scene.Observe(integrator, samples);
        if (integrator.MakesSplats() || integrator.SharesSamples()) {
            EXPECT_GE(deeds.rays, deeds.raysSeen);
            deeds.raysSeen = deeds.rays;
        }
        return deeds;
    };
    int tried = 0;
    for (const std::string& name : Registry<IntegratorKind>::Names()) {
        CountingScene open(Fog(dense, ""));
        const auto inTheOpen = open.Make(name, "\"integer maxdepth\" 2");
        if (!inTheOpen->RendersMedia()) continue;
        ++tried;
        const Deeds d = observe(open, *inTheOpen, 1);
        EXPECT_EQ(d.rays, d.raysSeen) << name;
        // Paths from the lights add theirs; those of chains are none of camera samples.
        if (!inTheOpen->MakesSplats()) {
            EXPECT_EQ(d.vertices, 2 * d.samples) << name;
        }
        EXPECT_EQ(d.records, 0) << name;

        CountingScene scattered(Fog(dense, wall)), seen(Fog(clear, wall));
        std::unique_ptr<Integrator> integrator;
        try {
            integrator = seen.Make(name, "\"integer maxdepth\" 2");
        } catch (const SceneError&) {
            continue;
        }
        EXPECT_EQ(ForgottenInTheRoom(observe(seen, *integrator, 4)), "") << name;
        const auto lost = scattered.Make(name, "\"integer maxdepth\" 1000 \"integer bootstrapsamples\" 100");
        EXPECT_EQ(scattered.Observe(*lost, 1).records, 0) << name;
    }
    EXPECT_GE(tried, 2);
}

/// Forgets one duty, by ways around TracedPath that tests/structure forbids to integrators.
class Forgetful final : public Integrator {
  public:
    enum class Duty { Nothing, Rays, Vertices, Records, Window, Footprint };
    Forgetful(const Scene& scene, Duty forgotten)
        : scene_(scene), footprint_(scene.Camera(), scene.Resolution(), 1), forgotten_(forgotten) {}

    SampledSpectrum Li(const CameraRay& cameraRay, SampledWavelengths& lambda, Sampler&,
                       ThreadState& state) const override {
        RayCounts uncounted;
        RayCounts& counts = forgotten_ == Duty::Rays ? uncounted : state.rays;
        SurfaceInteraction si;
        scene_.Intersect(cameraRay.ray, Infinity, &si, counts);
        if (forgotten_ == Duty::Window) Record(si, *Made(si, lambda, state), state);
        scene_.Intersect(SpawnRay(si, cameraRay.ray.d), Infinity, &si, counts);
        if (forgotten_ == Duty::Footprint)
            footprint_.ApproximateFootprint(&si);
        else
            footprint_.AtFirstHit(cameraRay, &si);
        const BxDF* bxdf = Made(si, lambda, state);
        if (forgotten_ != Duty::Records && forgotten_ != Duty::Window) Record(si, *bxdf, state);
        bxdf->Evaluate({0, 0, 1}, {0, 0, 1}, {.rng = &state.rng});
        if (forgotten_ != Duty::Vertices) ++state.pathLengthSum;
        return SampledSpectrum(0);
    }

  private:
    static BxDF* Made(const SurfaceInteraction& si, SampledWavelengths& lambda, ThreadState& state) {
        BxDF* bxdf = si.material->MakeBxDF(TextureContext(si), lambda, state.arena);
        return bxdf ? bxdf : state.arena.New<DiffuseBxDF>(SampledSpectrum(0));
    }
    static void Record(const SurfaceInteraction& si, const BxDF& bxdf, ThreadState& state) {
        state.firstHit->Record(si, bxdf, {0, 0, 1});
    }

    const Scene& scene_;
    FootprintEstimator footprint_;
    Duty forgotten_;
};

// Power: each control forgets what an integrator without TracedPath could, and is told so.
TEST(TracedPath, EachForgottenDutyIsNoticed) {
    using Duty = Forgetful::Duty;
    CountingScene room(kRoom);
    for (const auto& [duty, notice] : {std::pair(Duty::Nothing, ""),
                                       {Duty::Rays, "rays "},
                                       {Duty::Vertices, "vertices "},
                                       {Duty::Records, "records "},
                                       {Duty::Window, "the window footprints "},
                                       {Duty::Footprint, "footprints "}})
        EXPECT_EQ(ForgottenInTheRoom(room.Observe(Forgetful(room.World(), duty))), notice);
}

}  // namespace
}  // namespace lacquer::traced_path_test
