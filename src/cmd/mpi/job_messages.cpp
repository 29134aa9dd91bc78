#include "cmd/mpi/job_messages.h"

#include <chrono>
#include <thread>

namespace lacquer::cmd {
namespace {

/// RenderStats of a unit, as far as it is added up.
struct UnitCounters {
    double seconds;
    int64_t cameraRays, raysTraced, shadowRays, badSamples, pathLengthSum;
    BxDFCounters bxdf;
};

}  // namespace

mpi::Bytes MessageOf(const LoadOrder& order) { return MessageWriter(JobMessage::Load).Put(order).Take(); }
mpi::Bytes MessageOf(const StartOrder& order) { return MessageWriter(JobMessage::Start).Put(order).Take(); }
mpi::Bytes MessageOf(const RenderUnit& unit) { return MessageWriter(JobMessage::Unit).Put(unit).Take(); }
mpi::Bytes MessageOf(const RankReport& report) {
    return MessageWriter(JobMessage::Ready).Put(report.host).Put(report.header).Put(report.threads).Take();
}
mpi::Bytes MessageOf(const RankFailure& failure) {
    return MessageWriter(JobMessage::Failed).Put(failure.status).Put(failure.host).Put(failure.text).Take();
}
mpi::Bytes MessageOf(const RenderedUnit& unit) {
    const RenderStats& s = unit.stats;
    const UnitCounters counters = {s.seconds,    s.cameraRays,    s.raysTraced, s.shadowRays,
                                   s.badSamples, s.pathLengthSum, s.bxdf};
    mpi::Bytes bytes = MessageWriter(JobMessage::Result).Put(unit.unit).Put(counters).Take();
    bytes.insert(bytes.end(), unit.state.begin(), unit.state.end());
    return bytes;
}
mpi::Bytes MessageOf(JobMessage kind) { return MessageWriter(kind).Take(); }

JobMessage KindOf(const mpi::Bytes& message) { return MessageReader(message).Kind(); }
LoadOrder LoadOrderOf(const mpi::Bytes& message) { return MessageReader(message).Get<LoadOrder>(); }
StartOrder StartOrderOf(const mpi::Bytes& message) { return MessageReader(message).Get<StartOrder>(); }
RenderUnit UnitOf(const mpi::Bytes& message) { return MessageReader(message).Get<RenderUnit>(); }
RankReport ReportOf(const mpi::Bytes& message) {
    MessageReader reader(message);
    RankReport report;
    report.host = reader.GetText();
    report.header = reader.GetText();
    report.threads = reader.Get<int>();
    return report;
}
RenderedUnit RenderedUnitOf(const mpi::Bytes& message) {
    MessageReader reader(message);
    RenderedUnit unit;
    unit.unit = reader.Get<RenderUnit>();
    const auto counters = reader.Get<UnitCounters>();
    unit.stats.seconds = counters.seconds;
    unit.stats.cameraRays = counters.cameraRays;
    unit.stats.raysTraced = counters.raysTraced;
    unit.stats.shadowRays = counters.shadowRays;
    unit.stats.badSamples = counters.badSamples;
    unit.stats.pathLengthSum = counters.pathLengthSum;
    unit.stats.bxdf = counters.bxdf;
    unit.state = reader.Rest();
    return unit;
}
RankFailure FailureOf(const mpi::Bytes& message) {
    MessageReader reader(message);
    RankFailure failure;
    failure.status = reader.Get<ExitStatus>();
    failure.host = reader.GetText();
    failure.text = reader.GetText();
    return failure;
}

void Sleep(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

}  // namespace lacquer::cmd
