#include "cmd/mpi/worker.h"

#include "cmd/mpi/unit_renderer.h"
#include "pbrt/core/check.h"

namespace lacquer::cmd {
namespace {

constexpr int kManager = 0;

}  // namespace

std::optional<mpi::Bytes> JobWorker::Await(JobMessage kind) {
    for (Backoff backoff; !isStopped_; Sleep(backoff.Next())) {
        std::optional<mpi::Message> message = messenger_->TryReceive();
        if (!message) continue;
        isStopped_ = KindOf(message->bytes) == JobMessage::Stop;
        if (isStopped_) break;
        LACQUER_CHECK(KindOf(message->bytes) == kind);
        return std::move(message->bytes);
    }
    return {};
}

std::optional<LoadOrder> JobWorker::AwaitLoad() {
    const std::optional<mpi::Bytes> message = Await(JobMessage::Load);
    if (!message) return {};
    return LoadOrderOf(*message);
}

std::optional<StartOrder> JobWorker::AwaitStart(const std::string& header, int threads) {
    messenger_->Send(kManager, MessageOf(RankReport{messenger_->Host(), header, threads}));
    const std::optional<mpi::Bytes> message = Await(JobMessage::Start);
    if (!message) return {};
    return StartOrderOf(*message);
}

void JobWorker::Serve(UnitRenderer::Renderer render) {
    UnitRenderer renderer(std::move(render));
    Backoff backoff;
    while (!isStopped_) {
        const std::optional<mpi::Message> message = messenger_->TryReceive();
        if (message) {
            isStopped_ = KindOf(message->bytes) == JobMessage::Stop;
            if (!isStopped_) renderer.Put(UnitOf(message->bytes));
        }
        const std::optional<RenderedUnit> rendered = renderer.TryTake();
        if (rendered) messenger_->Send(kManager, MessageOf(*rendered));
        if (message || rendered)
            backoff.Reset();
        else
            renderer.Wait(backoff.Next());
    }
}

void JobWorker::Fail(ExitStatus status, const std::string& text) {
    messenger_->Send(kManager, MessageOf(RankFailure{status, messenger_->Host(), text}));
    for (Backoff backoff; !isStopped_; Sleep(backoff.Next())) {
        const std::optional<mpi::Message> message = messenger_->TryReceive();
        isStopped_ = message && KindOf(message->bytes) == JobMessage::Stop;
    }
}

void JobWorker::End() {
    messenger_->Send(kManager, MessageOf(JobMessage::Ended));
    while (!messenger_->Flush()) Sleep(1e-3);
    messenger_->Finish();
}

}  // namespace lacquer::cmd
