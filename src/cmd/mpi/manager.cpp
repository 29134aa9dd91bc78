#include "cmd/mpi/manager.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "cmd/mpi/unit_ledger.h"
#include "cmd/mpi/unit_renderer.h"
#include "pbrt/core/clock.h"
#include "pbrt/film/state_file.h"

namespace lacquer::cmd {
namespace {

/// Seconds that a unit should take, at least, and samples of the first ones, while nobody knows how long they
/// take.
constexpr double kUnitSeconds = 1;
constexpr int64_t kFirstSamples = 65536;
/// The largest part of rank 0's time for adding results: where it is more, units become longer.
constexpr double kAddingShare = 0.3;
/// Units that a rank has at a time: one to render and one to go on with, so that nobody waits for messages.
constexpr int kUnitsAtOnce = 2;
/// Seconds between images for who looks on, and the largest part of the time for them.
constexpr double kShowInterval = 2, kLargestShare = 0.05;
/// Seconds that other ranks have to end by themselves.
constexpr double kGrace = 5;

std::string NameOf(int rank, const std::string& host) { return fmt::format("rank {} on {}", rank, host); }

/// The first thing in which two ranks differ; empty if there is none.
std::string DifferingPart(const StateHeader& a, const StateHeader& b) {
    const auto find = [](const nlohmann::ordered_json& x, const nlohmann::ordered_json& y) -> std::string {
        for (const auto& [key, value] : x.items())
            if (!y.contains(key) || y[key] != value) return key;
        for (const auto& [key, value] : y.items())
            if (!x.contains(key)) return key;
        return {};
    };
    if (const std::string key = find(a.program, b.program); !key.empty())
        return fmt::format("the program's {}", key);
    if (const std::string key = find(a.scene, b.scene); !key.empty())
        return fmt::format("the scene's file \"{}\"", key);
    if (const std::string key = find(a.settings, b.settings); !key.empty()) return fmt::format("\"{}\"", key);
    if (a.pixels != b.pixels) return "the pixels";
    if (a.samplerValues != b.samplerValues || a.samplesPerPixel != b.samplesPerPixel) return "the samples";
    if (a.halfBlock != b.halfBlock || a.film != b.film) return "the film";
    return {};
}

[[noreturn]] void Fail(int rank, const RankFailure& failure) {
    throw RankError(failure.status, fmt::format("{}: {}", NameOf(rank, failure.host), failure.text));
}

/// One render of all ranks.
class ManagedLoop {
  public:
    ManagedLoop(const ManagedRender& render, mpi::Messenger* messenger, JobTraffic* traffic,
                Observer* observer)
        : r_(render),
          messenger_(messenger),
          traffic_(traffic),
          observer_(observer),
          pixels_(render.film->PixelBounds()),
          ledger_(MakeLedger()),
          ranks_(size_t(messenger->Count())),
          local_(render.render) {
        r_.film->AppendState(&sums_);
        if (r_.aovs) r_.aovs->AppendState("outputs: ", &sums_);
        checkpointInterval_ = r_.options->checkpointInterval;
    }

    RenderStats Run() {
        observer_->Begin("Rendering", ledger_.Left(), "samples");
        for (int rank = 1; rank < messenger_->Count(); ++rank)
            messenger_->Send(rank, MessageOf(StartOrder{r_.halfBlock}));
        try {
            Loop();
        } catch (...) {
            observer_->End();
            if (r_.options->checkpoint) r_.options->checkpoint(SecondsSince(start_));
            throw;
        }
        observer_->End();
        return Finish();
    }

  private:
    /// What is known of a rank.
    struct Rank {
        int out = 0;       ///< units that it has
        double speed = 0;  ///< samples per second; 0: not known yet
    };

    UnitLedger MakeLedger() const {
        size_t bytes = r_.film->MemoryBytes() + (r_.aovs ? r_.aovs->MemoryBytes() : 0);
        bytes /= size_t(pixels_.Area());
        const int side = r_.wholeImages ? std::max(pixels_.Width(), pixels_.Height())
                                        : BoxSide(pixels_, messenger_->Count(), bytes);
        return {pixels_, r_.film->SampleCounts(), r_.range.first, r_.range.second, side};
    }

    void Loop() {
        Backoff backoff;
        while (!ledger_.IsDone() && !observer_->ShouldStop()) {
            GiveOut();
            bool cameIn = TakeOwn();
            cameIn |= TakeMessages();
            CheckpointIfDue();
            ShowIfDue();
            if (cameIn)
                backoff.Reset();
            else
                local_.Wait(backoff.Next());
        }
    }

    /// One unit for each rank before any has a second one.
    void GiveOut() {
        for (int depth = 1; depth <= kUnitsAtOnce; ++depth)
            for (size_t rank = 0; rank < ranks_.size(); ++rank) {
                if (ranks_[rank].out >= depth) continue;
                const std::optional<RenderUnit> unit = ledger_.Next(SamplesFor(ranks_[rank]));
                if (!unit) return;
                ++ranks_[rank].out;
                if (rank == 0)
                    local_.Put(*unit);
                else
                    messenger_->Send(int(rank), MessageOf(*unit));
            }
    }
    /// Towards the end, units become smaller, so that all ranks end together.
    int64_t SamplesFor(const Rank& rank) const {
        const int64_t share = ledger_.Left() / int64_t(2 * ranks_.size());
        const int64_t usual = rank.speed > 0 ? int64_t(rank.speed * UnitSeconds()) : kFirstSamples;
        return std::min(usual, share);
    }
    double UnitSeconds() const {
        if (traffic_->results == 0) return kUnitSeconds;
        const double adding = traffic_->seconds / double(traffic_->results);
        return std::max(kUnitSeconds, double(ranks_.size()) * adding / kAddingShare);
    }

    bool TakeOwn() {
        std::optional<RenderedUnit> unit = local_.TryTake();
        if (unit) ComeIn(0, std::move(*unit));
        return unit.has_value();
    }
    /// One at a time: own results wait for no more than that.
    bool TakeMessages() {
        const std::optional<mpi::Message> message = messenger_->TryReceive();
        if (!message) return false;
        if (KindOf(message->bytes) == JobMessage::Failed) {
            Fail(message->from, FailureOf(message->bytes));
        }
        if (KindOf(message->bytes) == JobMessage::Result)
            ComeIn(message->from, RenderedUnitOf(message->bytes));
        return true;
    }

    void ComeIn(int from, RenderedUnit unit) {
        Rank& rank = ranks_[size_t(from)];
        --rank.out;
        rank.speed = double(unit.unit.Samples()) / std::max(unit.stats.seconds, 1e-6);
        stats_.cameraRays += unit.stats.cameraRays;
        stats_.raysTraced += unit.stats.raysTraced;
        stats_.shadowRays += unit.stats.shadowRays;
        stats_.badSamples += unit.stats.badSamples;
        stats_.pathLengthSum += unit.stats.pathLengthSum;
        stats_.bxdf += unit.stats.bxdf;
        observer_->Advance(unit.unit.Samples());
        const Clock::time_point start = Clock::now();
        ++traffic_->results;
        traffic_->bytes += int64_t(unit.state.size());
        for (const UnitLedger::Result& ready : ledger_.ComeIn({unit.unit, std::move(unit.state)}))
            Add(ready, from);
        traffic_->seconds += SecondsSince(start);
    }
    void Add(const UnitLedger::Result& result, int from) {
        const std::string name = fmt::format("a result of rank {}", from);
        const StateFile state = ReadState(name, result.state);
        const std::string why = AddState(state.arrays, sums_, result.unit.pixels, pixels_);
        if (!why.empty()) throw RankError(ExitStatus::Internal, fmt::format("{}: {}", name, why));
    }

    void CheckpointIfDue() {
        if (!r_.options->checkpoint || SecondsSince(lastCheckpoint_) < checkpointInterval_) return;
        const Clock::time_point start = Clock::now();
        r_.options->checkpoint(SecondsSince(start_));
        lastCheckpoint_ = Clock::now();
        checkpointInterval_ =
            std::max(r_.options->checkpointInterval, SecondsSince(start) / r_.options->checkpointShare);
    }
    void ShowIfDue() {
        if (!r_.showImage || SecondsSince(lastShown_) < showInterval_) return;
        const Clock::time_point start = Clock::now();
        r_.showImage(Span().least, SecondsSince(start_));
        lastShown_ = Clock::now();
        showInterval_ = std::max(kShowInterval, SecondsSince(start) / kLargestShare);
    }

    SampleSpan Span() const {
        return SampleSpanOf(r_.film->SampleCounts(), pixels_, nullptr, r_.range.first);
    }
    RenderStats Finish() {
        stats_.seconds = SecondsSince(start_);
        stats_.interrupted = !ledger_.IsDone();
        const SampleSpan span = Span();
        stats_.samplesPerPixel = std::min(span.least, r_.range.second - r_.range.first);
        stats_.maxSamples = std::max(span.most, stats_.samplesPerPixel);
        for (const int count : r_.film->SampleCounts()) stats_.samples += count;
        return stats_;
    }

    const ManagedRender& r_;
    mpi::Messenger* messenger_;
    JobTraffic* traffic_;
    Observer* observer_;
    const Bounds2i pixels_;
    std::vector<StateArray> sums_;
    UnitLedger ledger_;
    std::vector<Rank> ranks_;
    RenderStats stats_;
    const Clock::time_point start_ = Clock::now();
    Clock::time_point lastCheckpoint_ = start_, lastShown_ = start_;
    double checkpointInterval_ = 0, showInterval_ = kShowInterval;
    UnitRenderer local_;  ///< last: its thread ends first
};

}  // namespace

void JobManager::LetLoad(std::optional<int> filterSamples) {
    for (int rank = 1; rank < messenger_->Count(); ++rank)
        messenger_->Send(rank, MessageOf(LoadOrder{filterSamples.value_or(0)}));
    // They are to begin while this rank loads.
    while (!messenger_->Flush()) Sleep(Backoff().Next());
}

void JobManager::AwaitLoaded(const StateHeader& header) {
    Backoff backoff;
    for (int missing = messenger_->Count() - 1; missing > 0;) {
        const std::optional<mpi::Message> message = messenger_->TryReceive();
        if (!message) {
            Sleep(backoff.Next());
            continue;
        }
        backoff.Reset();
        if (KindOf(message->bytes) == JobMessage::Failed) Fail(message->from, FailureOf(message->bytes));
        Compare(message->from, ReportOf(message->bytes), header);
        --missing;
    }
}

void JobManager::Compare(int rank, const RankReport& report, const StateHeader& header) {
    const std::string name = NameOf(rank, report.host);
    const std::string what = DifferingPart(header, StateHeader::Read(name, report.header));
    if (!what.empty())
        throw RankError(
            ExitStatus::File,
            fmt::format("{} differs from rank 0 in {}: all need the same program, files and options", name,
                        what));
    otherThreads_ += report.threads;
}

RenderStats JobManager::Render(const ManagedRender& render, Observer* observer) {
    RenderStats stats = ManagedLoop(render, messenger_, &traffic_, observer).Run();
    stats.threads = render.threads + otherThreads_;
    return stats;
}

void JobManager::End(ExitStatus status) {
    for (int rank = 1; rank < messenger_->Count(); ++rank)
        messenger_->Send(rank, MessageOf(JobMessage::Stop));
    const Clock::time_point start = Clock::now();
    int left = messenger_->Count() - 1;
    while (left > 0 || !messenger_->Flush()) {
        const std::optional<mpi::Message> message = messenger_->TryReceive();
        if (message && KindOf(message->bytes) == JobMessage::Ended) --left;
        if (SecondsSince(start) > kGrace) messenger_->Abort(int(status));
        if (!message) Sleep(1e-3);
    }
    messenger_->Finish();
}

}  // namespace lacquer::cmd
