// Renders in parts: interrupted anywhere and resumed from a file, or divided into ranges of samples and
// added. Each gives the bits of a whole render, in all films and outputs.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <memory>

#include "integrators/render_fixtures.h"
#include "pbrt/core/error.h"
#include "pbrt/core/parallel.h"
#include "pbrt/film/state_file.h"
#include "pbrt/integrators/rendered_image.h"
#include "support/stopping_observer.h"

namespace lacquer::resume_test {
namespace {

constexpr int kSamples = 16, kHalfBlock = 4;

/// What is rendered, and what is kept of it.
struct ResumeCase {
    const char* name;
    const char* film;
    const char* integrator;
    std::vector<std::string> outputs;
};

/// Lights of two groups, a lens, glass, a textured floor with holes.
std::string SceneOf(const ResumeCase& c) {
    return std::string(R"(LookAt 0 1 -5  0 0.5 0  0 1 0
        Camera "perspective" "float fov" 45 "float lensradius" 0.05 "float focaldistance" 5
        PixelFilter "mitchell" Sampler "sobol" "integer pixelsamples" 16 Film )") +
           c.film + R"( "integer xresolution" 37 "integer yresolution" 23 Integrator )" + c.integrator + R"(
        WorldBegin
        AttributeBegin AreaLightSource "diffuse" "rgb L" [9 8 7] "string group" "key"
            Translate 0 3 0 Rotate 90 1 0 0 Shape "disk" AttributeEnd
        LightSource "point" "rgb I" [3 1 2] "point3 from" [3 2 -3]
        Texture "check" "spectrum" "checkerboard"
            "rgb tex1" [0.1 0.7 0.2] "rgb tex2" [0.8 0.8 0.8] "float uscale" 8 "float vscale" 8
        AttributeBegin ActiveTransform EndTime Translate 0.4 0.3 0 ActiveTransform All
            Material "dielectric" Translate 1 0.6 0 Shape "sphere" "float radius" 0.6 AttributeEnd
        AttributeBegin Material "conductor" "float roughness" 0.2
            Translate -1 0.7 0 Shape "sphere" "float radius" 0.7 AttributeEnd
        Material "diffuse" "texture reflectance" "check"
        Shape "bilinearmesh" "point3 P" [-5 0 -5  5 0 -5  -5 0 5  5 0 5] "float alpha" 0.7
    )";
}

/// A render that can be left and taken up.
class Part {
  public:
    explicit Part(const ResumeCase& c) {
        BuildOptions options;
        options.keepNames = true;
        options.film.keepsHalves = AovBuffer::NeedsHalves(c.outputs);
        setup_ = BuildScene(ParseText(SceneOf(c), "scene.pbrt", "", nullptr), options, nullptr);
        passes_ = MakePasses(c.outputs, setup_);
        aovs_ = MakeAovBuffer(c.outputs, 6, setup_);
        if (setup_.integrator->MakesSplats()) setup_.film->PrepareForSplats(MaxThreads());
    }
    /// @param units  of samples after which it is stopped
    RenderStats Render(int first, int end, int64_t units, bool resumes = false) {
        RenderOptions options = RenderOptionsOf(setup_);
        options.firstSample = first;
        options.endSample = end;
        options.resumes = resumes;
        options.halfBlock = kHalfBlock;
        options.aovs = aovs_.get();
        options.passes = passes_.get();
        test::StoppingObserver observer(units);
        return lacquer::Render(*setup_.scene, *setup_.integrator, *setup_.sampler, *setup_.film, options,
                               observer);
    }
    /// As AddState(), of all pixels.
    std::string Add(const std::vector<StoredArray>& stored) {
        const Bounds2i pixels = setup_.film->PixelBounds();
        return AddState(stored, State(), pixels, pixels);
    }
    std::vector<StateArray> State() {
        std::vector<StateArray> arrays;
        setup_.film->AppendState(&arrays);
        if (aovs_) aovs_->AppendState("outputs: ", &arrays);
        return arrays;
    }
    std::unique_ptr<Image> Develop() const {
        std::unique_ptr<Image> image = setup_.film->Develop();
        if (aovs_) image = aovs_->AppendTo(*image);
        return passes_ ? setup_.film->AppendPasses(*image) : std::move(image);
    }

  private:
    RenderSetup setup_;
    std::unique_ptr<PassSet> passes_;
    std::unique_ptr<AovBuffer> aovs_;
};

constexpr int64_t kNever = int64_t(1) << 60;

bool SameBits(const Image& a, const Image& b) {
    return a.Channels() == b.Channels() && a.Pixels().size() == b.Pixels().size() &&
           std::memcmp(a.Pixels().data(), b.Pixels().data(), a.Pixels().size() * sizeof(float)) == 0;
}

class RenderInParts : public testing::TestWithParam<ResumeCase> {
  protected:
    void SetUp() override {
        folder_ = std::filesystem::path(testing::TempDir()) / (std::string("parts-") + GetParam().name);
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
        Part whole(GetParam());
        EXPECT_EQ(whole.Render(0, kSamples, kNever).samplesPerPixel, kSamples);
        whole_ = whole.Develop();
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }
    std::string File(const std::string& name) const { return (folder_ / name).string(); }

    std::filesystem::path folder_;
    std::unique_ptr<Image> whole_;
};

/// Stopped amid passes, by several threads at once, time and again.
TEST_P(RenderInParts, ResumedTheyGiveTheSameBits) {
    Rng rng(test::SeedOf(test::FullTestName()));
    for (int trial = 0; trial < 4; ++trial) {
        const ThreadLimit threads(1 + trial);
        std::string file;
        int stops = 0;
        while (true) {
            Part part(GetParam());
            const std::string why = file.empty() ? "" : part.Add(ReadStateFile(file).arrays);
            ASSERT_EQ(why, "");
            const RenderStats stats = part.Render(0, kSamples, 1 + rng.UniformInt(9000), !file.empty());
            file = File("trial.state");
            WriteStateFile(file, "{}", part.State());
            if (!stats.interrupted) {
                EXPECT_EQ(stats.samples, int64_t(kSamples) * 37 * 23);
                EXPECT_TRUE(SameBits(*part.Develop(), *whole_)) << trial;
                break;
            }
            ASSERT_LT(++stops, 100);
        }
        EXPECT_GT(stops, 0) << "it has to be stopped at least once";
    }
}

/// Ranges of any lengths, rendered by themselves, in any order. What one of them lacks is seen, and what
/// comes twice.
TEST_P(RenderInParts, AddedTheyGiveTheSameBits) {
    Rng rng(test::SeedOf(test::FullTestName()));
    for (int trial = 0; trial < 3; ++trial) {
        std::vector<std::vector<StoredArray>> states;
        for (int first = 0; first < kSamples;) {
            const int end = std::min(kSamples, first + 1 + int(rng.UniformInt(6)));
            Part part(GetParam());
            part.Render(first, end, kNever);
            WriteStateFile(File("part.state"), "{}", part.State());
            states.push_back(ReadStateFile(File("part.state")).arrays);
            first = end;
        }
        for (size_t i = states.size(); i > 1; --i)
            std::swap(states[i - 1], states[rng.UniformInt(uint32_t(i))]);
        Part sum(GetParam());
        for (size_t i = 0; i + 1 < states.size(); ++i) ASSERT_EQ(sum.Add(states[i]), "");
        EXPECT_FALSE(SameBits(*sum.Develop(), *whole_));
        ASSERT_EQ(sum.Add(states.back()), "");
        EXPECT_TRUE(SameBits(*sum.Develop(), *whole_)) << trial;
        ASSERT_EQ(sum.Add(states.back()), "");
        EXPECT_FALSE(SameBits(*sum.Develop(), *whole_));
    }
}

INSTANTIATE_TEST_SUITE_P(
    All, RenderInParts,
    testing::Values(
        ResumeCase{"Rgb", "\"rgb\"", R"("path" "integer maxdepth" 4)", {}},
        ResumeCase{
            "GBuffer", "\"gbuffer\" \"string filename\" \"a.exr\"", R"("path" "integer maxdepth" 4)", {}},
        ResumeCase{"Spectral",
                   "\"spectral\" \"string filename\" \"a.exr\" \"integer nbuckets\" 7",
                   R"("path" "integer maxdepth" 4)",
                   {}},
        ResumeCase{"Bidirectional", "\"rgb\"", R"("bdpt" "integer maxdepth" 4)", {"albedo", "samples"}},
        ResumeCase{"Guided", "\"rgb\"", R"("path" "integer maxdepth" 4 "bool guiding" true)", {"half"}},
        ResumeCase{"LightPath", "\"rgb\"", R"("lightpath" "integer maxdepth" 4)", {}},
        ResumeCase{"Outputs",
                   "\"rgb\"",
                   R"("volpath" "integer maxdepth" 4)",
                   {"half", "variance", "albedo", "normal", "ng", "position", "depth", "uv", "alpha",
                    "motion", "samples", "object", "material", "cryptoobject", "cryptomaterial", "direct",
                    "indirect", "lightgroups"}}),
    [](const auto& instance) { return std::string(instance.param.name); });

/// Rounded means of parts are not the whole, and this is why states exist.
TEST(RenderInPartsControl, MeansOfImagesHaveOtherBits) {
    const ResumeCase c{"Rgb", "\"rgb\"", R"("path" "integer maxdepth" 4)", {}};
    Part whole(c), first(c), second(c);
    whole.Render(0, kSamples, kNever);
    first.Render(0, 5, kNever);
    second.Render(5, kSamples, kNever);
    const auto a = first.Develop(), b = second.Develop(), all = whole.Develop();
    int differ = 0;
    for (size_t i = 0; i < all->Pixels().size(); ++i)
        differ += all->Pixels()[i] != (5 * a->Pixels()[i] + 11 * b->Pixels()[i]) / 16;
    EXPECT_GT(differ, 100);
}

/// A checkpoint on time, amid a pass, while threads go on afterwards.
TEST(Checkpoints, ComeOnTimeAndChangeNothing) {
    const ResumeCase c{"Rgb", "\"rgb\"", R"("path" "integer maxdepth" 4)", {}};
    Part whole(c);
    whole.Render(0, kSamples, kNever);
    const RenderSetup setup = test::BuildText(SceneOf(c));
    RenderOptions options;
    options.halfBlock = kHalfBlock;
    int calls = 0;
    int64_t before = -1;
    options.checkpoint = [&](double seconds) {
        ++calls;
        EXPECT_GE(seconds, 0);
        const std::vector<int> counts = setup.film->SampleCounts();
        int64_t sum = 0;
        for (const int count : counts) sum += count;
        EXPECT_GE(sum, before);
        before = sum;
    };
    options.checkpointInterval = 5e-4;
    const RenderStats stats = test::RenderAll(setup, options);
    EXPECT_GT(calls, 2);
    EXPECT_EQ(stats.samplesPerPixel, kSamples);
    EXPECT_TRUE(SameBits(*setup.film->Develop(), *whole.Develop()));
}

}  // namespace
}  // namespace lacquer::resume_test
