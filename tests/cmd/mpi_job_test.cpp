// Renders by several ranks: what is given out and comes in against counting all samples one by one, and a
// job of threads, in place of processes, against a render of one.
#include <gtest/gtest.h>

#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <thread>

#include "cmd/mpi/manager.h"
#include "cmd/mpi/scene_units.h"
#include "cmd/mpi/unit_ledger.h"
#include "cmd/mpi/worker.h"
#include "cmd/render/film_record.h"
#include "integrators/render_fixtures.h"
#include "pbrt/core/rng.h"
#include "pbrt/integrators/rendered_image.h"
#include "support/statistics.h"

namespace lacquer::cmd::mpi_job_test {
namespace {

const Bounds2i kPixels{{5, 3}, {75, 50}};
constexpr int kFirst = 2, kEnd = 21;

size_t NumberOf(Int2 p) {
    return size_t(p.y - kPixels.min.y) * size_t(kPixels.Width()) + size_t(p.x - kPixels.min.x);
}

/// Adds units as a film would; every sample must be the next one of its pixel.
struct Counted {
    std::vector<int> counts;
    void Add(const RenderUnit& unit) {
        for (int y = unit.pixels.min.y; y < unit.pixels.max.y; ++y)
            for (int x = unit.pixels.min.x; x < unit.pixels.max.x; ++x) {
                int& count = counts[NumberOf({x, y})];
                ASSERT_EQ(kFirst + count, unit.first) << x << " " << y;
                count += unit.end - unit.first;
            }
    }
};

/// As a render leaves it that was stopped amid a pass.
std::vector<int> SomeTaken(Rng* rng) {
    std::vector<int> taken(size_t(kPixels.Area()), 4);
    for (int y = kPixels.min.y; y < kPixels.max.y; ++y)
        for (int x = kPixels.min.x; x < kPixels.max.x; ++x)
            if (y < 20 || (x > 30 && y < 27) || rng->UniformInt(200) == 0) taken[NumberOf({x, y})] = 9;
    return taken;
}

/// Gives out units of random sizes and lets them come in in random order.
void Drive(UnitLedger* ledger, Counted* counted, Rng* rng) {
    std::vector<RenderUnit> out;
    while (!ledger->IsDone()) {
        while (out.size() < 12) {
            const std::optional<RenderUnit> unit = ledger->Next(1 + rng->UniformInt(20000));
            if (!unit) break;
            out.push_back(*unit);
        }
        ASSERT_FALSE(out.empty());
        const size_t i = rng->UniformInt(uint32_t(out.size()));
        const RenderUnit unit = out[i];
        out.erase(out.begin() + ptrdiff_t(i));
        for (const auto& ready : ledger->ComeIn({unit, mpi::Bytes(3)})) counted->Add(ready.unit);
    }
    EXPECT_TRUE(out.empty());
    EXPECT_EQ(ledger->Left(), 0);
    EXPECT_EQ(ledger->WaitingBytes(), 0u);
}

TEST(UnitLedger, EverySampleIsGivenOutOnceAndCountsInOrder) {
    Rng rng(test::SeedOf(test::FullTestName()));
    for (const int side : {16, 32, 128})
        for (int trial = 0; trial < 5; ++trial) {
            Counted counted{std::vector<int>(size_t(kPixels.Area()), 0)};
            UnitLedger ledger(kPixels, counted.counts, kFirst, kEnd, side);
            EXPECT_EQ(ledger.Left(), int64_t(kPixels.Area()) * (kEnd - kFirst));
            Drive(&ledger, &counted, &rng);
            EXPECT_EQ(counted.counts, std::vector<int>(size_t(kPixels.Area()), kEnd - kFirst));
        }
}

TEST(UnitLedger, GoesOnFromPixelsWithDifferentNumbersOfSamples) {
    Rng rng(test::SeedOf(test::FullTestName()));
    for (const int side : {16, 64}) {
        Counted counted{SomeTaken(&rng)};
        int64_t missing = 0;
        for (const int taken : counted.counts) missing += kEnd - kFirst - taken;
        UnitLedger ledger(kPixels, counted.counts, kFirst, kEnd, side);
        EXPECT_EQ(ledger.Left(), missing);
        Drive(&ledger, &counted, &rng);
        EXPECT_EQ(counted.counts, std::vector<int>(size_t(kPixels.Area()), kEnd - kFirst));
    }
}

TEST(UnitLedger, WhatIsThereAlreadyIsNotGivenOut) {
    const std::vector<int> all(size_t(kPixels.Area()), kEnd - kFirst);
    UnitLedger ledger(kPixels, all, kFirst, kEnd, 32);
    EXPECT_TRUE(ledger.IsDone());
    EXPECT_FALSE(ledger.Next(1000).has_value());
}

TEST(UnitLedger, AResultThatCameInTooEarlyWaits) {
    const Bounds2i pixels{{0, 0}, {8, 8}};
    UnitLedger ledger(pixels, std::vector<int>(64, 0), 0, 30, 8);
    const RenderUnit a = *ledger.Next(640), b = *ledger.Next(640);
    EXPECT_EQ(a.first, 0);
    EXPECT_EQ(a.end, 8);  // a multiple of what samplers compute at once
    EXPECT_EQ(b.first, 8);
    EXPECT_TRUE(ledger.ComeIn({b, mpi::Bytes(10)}).empty());
    EXPECT_EQ(ledger.WaitingBytes(), 10u);
    const auto ready = ledger.ComeIn({a, mpi::Bytes(20)});
    ASSERT_EQ(ready.size(), 2u);
    EXPECT_EQ(ready[0].unit.first, 0);
    EXPECT_EQ(ready[1].unit.first, 8);
    EXPECT_FALSE(ledger.IsDone());
}

TEST(JobMessages, SayTheSameAfterwards) {
    RenderedUnit unit{{kPixels, 3, 9}, {1, 2, 3}, {}};
    unit.stats.badSamples = 7;
    unit.stats.seconds = 0.5;
    const RenderedUnit again = RenderedUnitOf(MessageOf(unit));
    EXPECT_EQ(again.unit.pixels, kPixels);
    EXPECT_EQ(again.unit.end, 9);
    EXPECT_EQ(again.state, unit.state);
    EXPECT_EQ(again.stats.badSamples, 7);
    EXPECT_EQ(again.stats.seconds, 0.5);
    const RankFailure failure = FailureOf(MessageOf(RankFailure{ExitStatus::File, "node7", "no file"}));
    EXPECT_EQ(failure.status, ExitStatus::File);
    EXPECT_EQ(failure.host + failure.text, "node7no file");
    EXPECT_EQ(KindOf(MessageOf(JobMessage::Stop)), JobMessage::Stop);
    EXPECT_THROW(KindOf({}), std::runtime_error);
    mpi::Bytes cut = MessageOf(RankReport{"node7", "header", 2});
    cut.resize(cut.size() - 1);
    EXPECT_THROW(ReportOf(cut), std::runtime_error);
}

/// The letter boxes of a job whose ranks are threads.
struct Post {
    explicit Post(int count) : boxes(size_t(count)) {}
    std::mutex mutex;
    std::vector<std::deque<mpi::Message>> boxes;
};

class ThreadMessenger final : public mpi::Messenger {
  public:
    ThreadMessenger(int rank, Post* post) : rank_(rank), post_(post) {}
    int Rank() const override { return rank_; }
    int Count() const override { return int(post_->boxes.size()); }
    int CountHere() const override { return Count(); }
    std::string Host() const override { return "here"; }
    void Send(int to, mpi::Bytes bytes) override {
        const std::lock_guard lock(post_->mutex);
        post_->boxes[size_t(to)].push_back({rank_, std::move(bytes)});
    }
    std::optional<mpi::Message> TryReceive() override {
        const std::lock_guard lock(post_->mutex);
        auto& box = post_->boxes[size_t(rank_)];
        if (box.empty()) return {};
        mpi::Message message = std::move(box.front());
        box.pop_front();
        return message;
    }
    bool Flush() override { return true; }
    void Finish() override {}
    [[noreturn]] void Abort(int) override { throw std::runtime_error("aborted"); }

  private:
    int rank_;
    Post* post_;
};

constexpr const char* kScene = R"(LookAt 0 1 -5  0 0.5 0  0 1 0
    Camera "perspective" Film "gbuffer" "integer xresolution" 70 "integer yresolution" 40
    Sampler "halton" "integer pixelsamples" 12 Integrator "path"
    WorldBegin LightSource "point" "rgb I" [3 1 2] "point3 from" [3 2 -3]
    Material "diffuse" Shape "sphere" Shape "bilinearmesh" "point3 P" [-5 0 -5  5 0 -5  -5 0 5  5 0 5])";

/// A scene and what is summed of it.
struct Whole {
    Whole() {
        SceneDescription description = ParseText(kScene, "scene.pbrt", "", nullptr);
        nlohmann::ordered_json directives = FilmDirectives(description);
        BuildOptions options;
        options.film.keepsHalves = true;
        setup = BuildScene(std::move(description), options, nullptr);
        aovs = MakeAovBuffer(kOutputs, 6, setup);
        units.setup = &setup;
        units.film = FilmRecord(std::move(directives), setup, aovs.get(), 6, nullptr);
        units.aovs = kOutputs;
        units.halfBlock = BestHalfBlock(setup.samplesPerPixel);
    }
    std::unique_ptr<Image> Develop() const { return aovs->AppendTo(*setup.film->Develop()); }

    inline static const std::vector<std::string> kOutputs = {"half", "depth", "variance"};
    RenderSetup setup;
    std::unique_ptr<AovBuffer> aovs;
    SceneUnits units;
};

/// @param fails  the last rank does, at its first unit
/// @param checkpoint  as RenderOptions::checkpoint
RenderStats RunJob(int ranks, bool fails, Whole* whole,
                   const std::function<void(double seconds)>& checkpoint = {}) {
    Post post(ranks);
    std::vector<std::thread> workers;
    for (int rank = 1; rank < ranks; ++rank)
        workers.emplace_back([&, rank] {
            ThreadMessenger messenger(rank, &post);
            JobWorker worker(&messenger);
            try {
                if (worker.AwaitLoad() && worker.AwaitStart(StateHeader().Text(), 1))
                    worker.Serve([&](const RenderUnit& unit, Observer& observer) {
                        if (fails && rank == ranks - 1) throw std::runtime_error("the disk is gone");
                        return whole->units.Render(unit, observer);
                    });
            } catch (const std::exception& e) {
                worker.Fail(ExitStatus::File, e.what());
            }
            worker.End();
        });
    ThreadMessenger messenger(0, &post);
    JobManager manager(&messenger);
    std::exception_ptr error;
    RenderStats stats;
    try {
        manager.LetLoad({});
        RenderOptions options = RenderOptionsOf(whole->setup);
        options.checkpoint = checkpoint;
        ManagedRender render;
        render.render = [&](const RenderUnit& unit, Observer& o) { return whole->units.Render(unit, o); };
        render.film = whole->setup.film.get();
        render.aovs = whole->aovs.get();
        render.range = {0, whole->setup.samplesPerPixel};
        render.halfBlock = whole->units.halfBlock;
        render.options = &options;
        Observer observer;
        stats = manager.Render(render, &observer);
    } catch (...) {
        error = std::current_exception();
    }
    manager.End(ExitStatus::Complete);
    for (std::thread& worker : workers) worker.join();
    if (error) std::rethrow_exception(error);
    return stats;
}

TEST(MpiJob, HasTheBitsOfOneRender) {
    Whole alone;
    RenderOptions options = RenderOptionsOf(alone.setup);
    options.aovs = alone.aovs.get();
    Observer observer;
    const RenderStats expected = Render(*alone.setup.scene, *alone.setup.integrator, *alone.setup.sampler,
                                        *alone.setup.film, options, observer);
    const std::unique_ptr<Image> image = alone.Develop();
    for (const int ranks : {1, 2, 5}) {
        Whole whole;
        const RenderStats stats = RunJob(ranks, false, &whole);
        EXPECT_EQ(stats.samples, expected.samples);
        EXPECT_EQ(stats.cameraRays, expected.cameraRays);
        EXPECT_EQ(stats.raysTraced, expected.raysTraced);
        EXPECT_EQ(stats.samplesPerPixel, expected.samplesPerPixel);
        EXPECT_FALSE(stats.interrupted);
        const std::unique_ptr<Image> other = whole.Develop();
        ASSERT_EQ(other->Channels(), image->Channels());
        EXPECT_EQ(std::memcmp(other->Pixels().data(), image->Pixels().data(),
                              image->Pixels().size() * sizeof(float)),
                  0)
            << ranks;
    }
}

TEST(MpiJob, ARankThatFailsEndsItWithItsMessageAndAState) {
    Whole whole;
    int states = 0;
    try {
        RunJob(3, true, &whole, [&](double) { ++states; });
        FAIL() << "no error";
    } catch (const RankError& e) {
        EXPECT_STREQ(e.what(), "rank 2 on here: the disk is gone");
        EXPECT_EQ(e.Status(), ExitStatus::File);
        EXPECT_EQ(states, 1);
    }
}

}  // namespace
}  // namespace lacquer::cmd::mpi_job_test
