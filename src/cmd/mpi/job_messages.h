// What the ranks of `render --mpi` say to each other.
#pragma once

#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "cmd/exit_status.h"
#include "cmd/mpi/unit_renderer.h"
#include "mpi/messenger.h"

namespace lacquer::cmd {

/// The first byte of a message.
enum class JobMessage : unsigned char {
    // From the manager, rank 0.
    Load,   ///< LoadOrder: load the scene
    Start,  ///< StartOrder: units will follow
    Unit,   ///< RenderUnit
    Stop,   ///< nothing follows; answered by Ended
    // To it.
    Ready,   ///< the scene is loaded: RankReport
    Result,  ///< RenderedUnit
    Failed,  ///< RankFailure; nothing but Ended follows
    Ended,   ///< nothing follows
};

struct LoadOrder {
    int filterSamples = 0;  ///< as BuildOptions::filterSamples; 0: unset
};
struct StartOrder {
    int halfBlock = 1;
};
/// What a rank has loaded.
struct RankReport {
    std::string host;
    std::string header;  ///< StateHeader::Text()
    int threads = 0;
};
/// Why a rank cannot go on, as a message for the user.
struct RankFailure {
    ExitStatus status = ExitStatus::Internal;
    std::string host, text;
};

/// Puts values one after another. All ranks run the same build (which is checked), so they are put as they
/// are in memory.
class MessageWriter {
  public:
    explicit MessageWriter(JobMessage kind) { bytes_.push_back(static_cast<unsigned char>(kind)); }
    template <class T>
    MessageWriter& Put(const T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        const auto* begin = reinterpret_cast<const unsigned char*>(&value);
        bytes_.insert(bytes_.end(), begin, begin + sizeof value);
        return *this;
    }
    MessageWriter& Put(const std::string& text) {
        Put(text.size());
        bytes_.insert(bytes_.end(), text.begin(), text.end());
        return *this;
    }
    mpi::Bytes Take() { return std::move(bytes_); }

  private:
    mpi::Bytes bytes_;
};

/// Gets them again. Errors: std::runtime_error for a message that ends too soon.
class MessageReader {
  public:
    explicit MessageReader(const mpi::Bytes& bytes) : bytes_(bytes) {
        Need(1);
        at_ = 1;
    }
    JobMessage Kind() const { return static_cast<JobMessage>(bytes_[0]); }
    template <class T>
    T Get() {
        static_assert(std::is_trivially_copyable_v<T>);
        T value;
        Need(sizeof value);
        std::memcpy(&value, bytes_.data() + at_, sizeof value);
        at_ += sizeof value;
        return value;
    }
    std::string GetText() {
        const auto size = Get<size_t>();
        Need(size);
        at_ += size;
        return {bytes_.begin() + ptrdiff_t(at_ - size), bytes_.begin() + ptrdiff_t(at_)};
    }
    mpi::Bytes Rest() const { return {bytes_.begin() + ptrdiff_t(at_), bytes_.end()}; }

  private:
    void Need(size_t size) const {
        if (size > bytes_.size() - at_) throw std::runtime_error("a message of another rank ends too soon");
    }
    const mpi::Bytes& bytes_;
    size_t at_ = 0;
};

mpi::Bytes MessageOf(const LoadOrder& order);
mpi::Bytes MessageOf(const StartOrder& order);
mpi::Bytes MessageOf(const RenderUnit& unit);
mpi::Bytes MessageOf(const RankReport& report);
mpi::Bytes MessageOf(const RenderedUnit& unit);
mpi::Bytes MessageOf(const RankFailure& failure);
/// Of one that is nothing but its kind.
mpi::Bytes MessageOf(JobMessage kind);

JobMessage KindOf(const mpi::Bytes& message);
LoadOrder LoadOrderOf(const mpi::Bytes& message);
StartOrder StartOrderOf(const mpi::Bytes& message);
RenderUnit UnitOf(const mpi::Bytes& message);
RankReport ReportOf(const mpi::Bytes& message);
RenderedUnit RenderedUnitOf(const mpi::Bytes& message);
RankFailure FailureOf(const mpi::Bytes& message);

/// Between looks for messages: longer from one time to the next, up to a millisecond, so that ranks that wait
/// leave the processors to others.
class Backoff {
  public:
    void Reset() { seconds_ = kFirst; }
    /// How long to wait this time.
    double Next() {
        const double now = seconds_;
        seconds_ = std::min(2 * seconds_, kLongest);
        return now;
    }

  private:
    static constexpr double kFirst = 20e-6, kLongest = 1e-3;
    double seconds_ = kFirst;
};
/// Lets the thread sleep.
void Sleep(double seconds);

}  // namespace lacquer::cmd
