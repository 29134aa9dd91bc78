#include "cmd/render/display.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <mutex>

namespace lacquer::cmd {

namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds, std::chrono::seconds;

constexpr const char* kDefaultPort = "14158";
constexpr seconds kConnectLimit{5};
/// A viewer that takes no byte for so long while it renders is given up.
constexpr seconds kStallLimit{30};
constexpr seconds kStallLimitAtEnd{2}, kEndLimit{10};
/// How often a waiting thread looks whether it is still wanted.
constexpr milliseconds kLook{50};
/// Rows in one packet, so that none grows beyond a few megabytes.
constexpr int kRowsPerPacket = 64;

/// Packets as tev reads them: length of the whole (uint32), operation, arguments; numbers little-endian,
/// texts with a zero byte at their end.
enum class Operation : unsigned char { CreateImage = 4, UpdateImageV2 = 5 };
static_assert(std::endian::native == std::endian::little, "numbers are sent as they stand in memory");

class Packet {
  public:
    explicit Packet(Operation operation) : bytes_(4, '\0') { bytes_ += char(operation); }
    template <class T>
    Packet& Add(T value) {
        bytes_.append(reinterpret_cast<const char*>(&value), sizeof(value));
        return *this;
    }
    Packet& Add(const std::string& text) {
        bytes_ += text;
        bytes_ += '\0';
        return *this;
    }
    std::string Finish() {
        const auto length = uint32_t(bytes_.size());
        std::memcpy(bytes_.data(), &length, 4);
        return std::move(bytes_);
    }

  private:
    std::string bytes_;
};

constexpr std::array<const char*, 3> kChannels = {"R", "G", "B"};

std::string CreatePacket(const std::string& name, Int2 resolution) {
    constexpr char kGrabFocus = 1;
    Packet packet(Operation::CreateImage);
    packet.Add(kGrabFocus).Add(name).Add(int32_t(resolution.x)).Add(int32_t(resolution.y));
    packet.Add(int32_t(kChannels.size()));
    for (const char* channel : kChannels) packet.Add(std::string(channel));
    return packet.Finish();
}

/// The rows [begin, end) of all channels, one channel after the other.
std::string UpdatePacket(const std::string& name, const Image& image, int begin, int end) {
    constexpr char kGrabFocus = 0;
    Packet packet(Operation::UpdateImageV2);
    packet.Add(kGrabFocus).Add(name).Add(int32_t(kChannels.size()));
    for (const char* channel : kChannels) packet.Add(std::string(channel));
    const int width = image.Resolution().x;
    packet.Add(int32_t(0)).Add(int32_t(begin)).Add(int32_t(width)).Add(int32_t(end - begin));
    for (const char* channel : kChannels) {
        const int c = std::max(0, image.FindChannel(channel));
        for (int y = begin; y < end; ++y)
            for (int x = 0; x < width; ++x) packet.Add(image.Get({x, y}, c));
    }
    return packet.Finish();
}

/// Ends the sender. The text is what Problem() tells.
struct Lost {
    std::string problem;
};

}  // namespace

std::optional<DisplayAddress> DisplayAddress::Parse(const std::string& text) {
    DisplayAddress address{text, kDefaultPort};
    const size_t bracket = text.rfind(']');
    const size_t colon = text.rfind(':');
    const bool isBracketed = text.starts_with('[');
    if (isBracketed) {
        if (bracket == std::string::npos) return std::nullopt;
        address.host = text.substr(1, bracket - 1);
        if (bracket + 1 != text.size()) {
            if (colon != bracket + 1) return std::nullopt;
            address.port = text.substr(colon + 1);
        }
    } else if (colon != std::string::npos && text.find(':') == colon) {  // with more colons it is all host
        address.host = text.substr(0, colon);
        address.port = text.substr(colon + 1);
    }
    const bool isNumber =
        !address.port.empty() && address.port.size() <= 5 &&
        std::all_of(address.port.begin(), address.port.end(), [](char c) { return c >= '0' && c <= '9'; });
    if (address.host.empty() || !isNumber || std::stoi(address.port) < 1 || std::stoi(address.port) > 65535)
        return std::nullopt;
    return address;
}

/// What the two threads have in common; everything under `mutex`.
struct DisplayServer::Shared {
    mutable std::mutex mutex;
    std::condition_variable changed;
    std::unique_ptr<Image> next;  ///< the latest image that is not sent yet
    bool closing = false;         ///< no image comes any more
    bool abandoned = false;       ///< nobody waits for the sender any more
    bool done = false;            ///< the sender has ended
    Clock::time_point progress = Clock::now();
    std::string problem;

    /// An image to send; null if there will be none.
    std::unique_ptr<Image> Take() {
        std::unique_lock lock(mutex);
        changed.wait(lock, [&] { return next || closing || abandoned; });
        progress = Clock::now();
        return abandoned ? nullptr : std::move(next);
    }
    void NoteProgress() {
        const std::lock_guard lock(mutex);
        progress = Clock::now();
    }
    bool IsAbandoned() const {
        const std::lock_guard lock(mutex);
        return abandoned;
    }
    void End(const std::string& why) {
        const std::lock_guard lock(mutex);
        if (problem.empty()) problem = why;
        done = true;
        next.reset();
        changed.notify_all();
    }
};

/// The thread's side: connects, and sends what it is given.
class DisplayServer::Sender {
  public:
    Sender(std::shared_ptr<Shared> shared, DisplayAddress address)
        : s_(std::move(shared)), a_(std::move(address)) {}
    ~Sender() {
        if (socket_ >= 0) close(socket_);
    }
    Sender(const Sender&) = delete;
    Sender& operator=(const Sender&) = delete;

    static void Run(const std::shared_ptr<Shared>& shared, const DisplayAddress& address,
                    const std::string& name, Int2 resolution) {
        try {
            Sender sender(shared, address);
            sender.Connect();
            sender.Send(CreatePacket(name, resolution));
            while (const auto image = shared->Take())
                for (int y = 0; y < resolution.y; y += kRowsPerPacket)
                    sender.Send(UpdatePacket(name, *image, y, std::min(y + kRowsPerPacket, resolution.y)));
            shared->End("");
        } catch (const Lost& lost) {
            shared->End(lost.problem);
        } catch (const std::exception& e) {  // out of memory, say
            shared->End(fmt::format("cannot be served ({})", e.what()));
        }
    }

  private:
    /// Tries all addresses of the host: "localhost" may mean ::1 and 127.0.0.1.
    void Connect() {
        addrinfo hints{};
        hints.ai_socktype = SOCK_STREAM;
        hints.ai_flags = AI_NUMERICSERV;
        addrinfo* found = nullptr;
        if (const int error = getaddrinfo(a_.host.c_str(), a_.port.c_str(), &hints, &found))
            throw Lost{fmt::format("cannot be found ({})", gai_strerror(error))};
        const std::unique_ptr<addrinfo, void (*)(addrinfo*)> all(found, freeaddrinfo);
        int error = 0;
        for (const addrinfo* a = all.get(); a; a = a->ai_next) {
            error = ConnectTo(*a);
            if (error == 0) return;
        }
        throw Lost{error == ECONNREFUSED ? std::string("is not there (nobody listens)")
                                         : fmt::format("is not there ({})", std::strerror(error))};
    }

    /// 0, or what went wrong.
    int ConnectTo(const addrinfo& a) {
        if (socket_ >= 0) close(socket_);
        socket_ = socket(a.ai_family, a.ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, a.ai_protocol);
        if (socket_ < 0) return errno;
        if (connect(socket_, a.ai_addr, a.ai_addrlen) == 0) return 0;
        if (errno != EINPROGRESS) return errno;
        if (!WaitWritable(kConnectLimit)) return ETIMEDOUT;
        int error = 0;
        socklen_t size = sizeof(error);
        return getsockopt(socket_, SOL_SOCKET, SO_ERROR, &error, &size) == 0 ? error : errno;
    }

    /// False after `limit`.
    bool WaitWritable(seconds limit) {
        for (const auto end = Clock::now() + limit; Clock::now() < end;) {
            if (s_->IsAbandoned()) throw Lost{""};
            pollfd p{socket_, POLLOUT, 0};
            if (poll(&p, 1, int(kLook.count())) > 0) return true;
        }
        return false;
    }

    void Send(const std::string& packet) {
        for (size_t sent = 0; sent < packet.size();) {
            const ssize_t n = send(socket_, packet.data() + sent, packet.size() - sent, MSG_NOSIGNAL);
            if (n > 0) {
                sent += size_t(n);
                s_->NoteProgress();
            } else if (n < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
                if (!WaitWritable(kStallLimit)) throw Lost{"does not read what is sent to it"};
            } else if (!(n < 0 && errno == EINTR)) {
                throw Lost{"went away"};
            }
        }
    }

    std::shared_ptr<Shared> s_;
    DisplayAddress a_;
    int socket_ = -1;
};

DisplayServer::DisplayServer(const DisplayAddress& address, const std::string& name, Int2 resolution)
    : shared_(std::make_shared<Shared>()), thread_(Sender::Run, shared_, address, name, resolution) {}

DisplayServer::~DisplayServer() { Finish(); }

void DisplayServer::Show(std::unique_ptr<Image> image) {
    const std::lock_guard lock(shared_->mutex);
    if (shared_->done) return;
    shared_->next = std::move(image);
    shared_->changed.notify_all();
}

void DisplayServer::Finish() {
    if (!thread_.joinable()) return;
    std::unique_lock lock(shared_->mutex);
    shared_->closing = true;
    shared_->changed.notify_all();
    const auto isDone = [this] { return shared_->done; };
    const Clock::time_point start = Clock::now();
    while (!shared_->changed.wait_for(lock, kLook, isDone)) {
        const Clock::time_point now = Clock::now();
        if (now - std::max(start, shared_->progress) > kStallLimitAtEnd || now - start > kEndLimit) break;
    }
    if (!shared_->done) {
        shared_->abandoned = true;
        if (shared_->problem.empty()) shared_->problem = "does not take the last image in time";
        shared_->changed.notify_all();
    }
    const bool ends = shared_->changed.wait_for(lock, 4 * kLook, isDone);
    lock.unlock();
    if (ends)
        thread_.join();
    else
        thread_.detach();  // in a name look-up, which nothing can stop
}

std::string DisplayServer::Problem() const {
    const std::lock_guard lock(shared_->mutex);
    return shared_->problem;
}

}  // namespace lacquer::cmd
