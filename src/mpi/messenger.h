// Messages between the processes of one job, in types of our own. What knows MPI is a module (open_mpi.cpp),
// loaded where a command asks for it: the program runs, and starts as fast, on machines without MPI.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace lacquer::mpi {

using Bytes = std::vector<unsigned char>;

struct Message {
    int from = 0;  ///< rank
    Bytes bytes;
};

/// One process of a job, which has a rank in [0, Count()). Of one thread, that which made it. Messages from
/// one rank to another arrive in the order in which they were sent. Errors: std::runtime_error.
class Messenger {
  public:
    /// Changes with every change of this file: a program takes no module of another version.
    static constexpr int kVersion = 1;
    /// Bytes of the longest message.
    static constexpr size_t kMaxBytes = (size_t(1) << 31) - 1;

    Messenger() = default;
    Messenger(const Messenger&) = delete;
    Messenger& operator=(const Messenger&) = delete;
    virtual ~Messenger() = default;

    virtual int Rank() const = 0;
    virtual int Count() const = 0;
    /// How many of the ranks run on this machine.
    virtual int CountHere() const = 0;
    /// Name of this machine.
    virtual std::string Host() const = 0;
    /// Returns at once; the bytes are on their way while TryReceive() or Flush() are called.
    virtual void Send(int to, Bytes bytes) = 0;
    /// The next message from any rank, if there is one.
    virtual std::optional<Message> TryReceive() = 0;
    /// Whether all that was sent has left this process.
    virtual bool Flush() = 0;
    /// Ends the process's part in the job; nothing is sent or received afterwards. All ranks have to call it.
    virtual void Finish() = 0;
    /// Ends all processes of the job, by force and with this exit status.
    [[noreturn]] virtual void Abort(int status) = 0;
};

}  // namespace lacquer::mpi

/// What the module exports: the messenger of this process, which the caller owns; null for another version
/// than its own. To be called once.
extern "C" [[gnu::visibility("default")]] lacquer::mpi::Messenger* LacquerMpi(int version);
