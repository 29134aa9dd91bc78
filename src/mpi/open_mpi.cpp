// Messenger over MPI (messenger.h): non-blocking sends, and receives of what has been found by probing, so
// that nobody spins where ranks share processors.
#include <mpi.h>

#include <list>
#include <stdexcept>
#include <utility>

#include "mpi/messenger.h"

namespace lacquer::mpi {
namespace {

constexpr int kTag = 1;

void Check(int result, const char* what) {
    if (result == MPI_SUCCESS) return;
    char text[MPI_MAX_ERROR_STRING] = "";
    int length = 0;
    MPI_Error_string(result, text, &length);
    throw std::runtime_error(std::string("MPI: ") + what + ": " + std::string(text, size_t(length)));
}

class OpenMpiMessenger final : public Messenger {
  public:
    OpenMpiMessenger() {
        int provided = 0;
        Check(MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided), "start");
        if (provided < MPI_THREAD_FUNNELED)
            throw std::runtime_error("MPI: this library does not go with programs of several threads");
        MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
        Check(MPI_Comm_rank(MPI_COMM_WORLD, &rank_), "rank");
        Check(MPI_Comm_size(MPI_COMM_WORLD, &count_), "size");
        MPI_Comm here = MPI_COMM_NULL;
        Check(MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, rank_, MPI_INFO_NULL, &here),
              "split");
        Check(MPI_Comm_size(here, &countHere_), "size");
        MPI_Comm_free(&here);
        char name[MPI_MAX_PROCESSOR_NAME] = "";
        int length = 0;
        Check(MPI_Get_processor_name(name, &length), "name");
        host_.assign(name, size_t(length));
    }

    int Rank() const override { return rank_; }
    int Count() const override { return count_; }
    int CountHere() const override { return countHere_; }
    std::string Host() const override { return host_; }

    void Send(int to, Bytes bytes) override {
        if (bytes.size() > kMaxBytes) throw std::runtime_error("MPI: a message is too long");
        Sent& sent = sent_.emplace_back(Sent{std::move(bytes), MPI_REQUEST_NULL});
        Check(MPI_Isend(sent.bytes.data(), int(sent.bytes.size()), MPI_BYTE, to, kTag, MPI_COMM_WORLD,
                        &sent.request),
              "send");
    }

    std::optional<Message> TryReceive() override {
        Flush();
        int found = 0;
        MPI_Message handle = MPI_MESSAGE_NULL;
        MPI_Status status;
        Check(MPI_Improbe(MPI_ANY_SOURCE, kTag, MPI_COMM_WORLD, &found, &handle, &status), "probe");
        if (!found) return {};
        int size = 0;
        Check(MPI_Get_count(&status, MPI_BYTE, &size), "count");
        Message message{status.MPI_SOURCE, Bytes(size_t(size))};
        Check(MPI_Mrecv(message.bytes.data(), size, MPI_BYTE, &handle, MPI_STATUS_IGNORE), "receive");
        return message;
    }

    bool Flush() override {
        for (auto sent = sent_.begin(); sent != sent_.end();) {
            int isDone = 0;
            Check(MPI_Test(&sent->request, &isDone, MPI_STATUS_IGNORE), "test");
            sent = isDone ? sent_.erase(sent) : std::next(sent);
        }
        return sent_.empty();
    }

    void Finish() override { Check(MPI_Finalize(), "end"); }

    [[noreturn]] void Abort(int status) override {
        MPI_Abort(MPI_COMM_WORLD, status);
        throw std::runtime_error("MPI: the job cannot be ended");
    }

  private:
    struct Sent {
        Bytes bytes;
        MPI_Request request;
    };
    int rank_ = 0, count_ = 1, countHere_ = 1;
    std::string host_;
    std::list<Sent> sent_;  ///< on their way
};

}  // namespace
}  // namespace lacquer::mpi

lacquer::mpi::Messenger* LacquerMpi(int version) {
    using namespace lacquer::mpi;
    return version == Messenger::kVersion ? new OpenMpiMessenger : nullptr;
}
