#include "cmd/display.h"

#include <netdb.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cstring>

namespace lacquer {

namespace {

// Packet types of tev's protocol; each packet begins with its own length (uint32, little-endian).
enum class Operation : unsigned char { CreateImage = 4, UpdateImageV2 = 5 };

class Packet {
  public:
    explicit Packet(Operation operation) : bytes_(4, '\0') { bytes_ += char(operation); }
    template <class T>
    Packet& Add(T value) {
        bytes_.append(reinterpret_cast<const char*>(&value), sizeof(value));
        return *this;
    }
    Packet& AddText(const std::string& text) {
        bytes_ += text;
        bytes_ += '\0';
        return *this;
    }
    std::string Finish() {
        const auto length = uint32_t(bytes_.size());
        std::memcpy(bytes_.data(), &length, 4);
        return bytes_;
    }

  private:
    std::string bytes_;
};

// Rows in one packet, so that none grows beyond a few megabytes.
constexpr int kRowsPerPacket = 64;

}  // namespace

std::unique_ptr<DisplayServer> DisplayServer::Connect(const std::string& address, std::string* problem) {
    const size_t colon = address.rfind(':');
    if (colon == std::string::npos) {
        *problem = "expected host:port";
        return nullptr;
    }
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    const int error =
        getaddrinfo(address.substr(0, colon).c_str(), address.substr(colon + 1).c_str(), &hints, &found);
    if (error) {
        *problem = gai_strerror(error);
        return nullptr;
    }
    int connected = -1;
    for (const addrinfo* a = found; a && connected < 0; a = a->ai_next) {
        const int s = socket(a->ai_family, a->ai_socktype, a->ai_protocol);
        if (s < 0) continue;
        const timeval limit{5, 0};
        setsockopt(s, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof(limit));
        if (connect(s, a->ai_addr, a->ai_addrlen) == 0)
            connected = s;
        else
            close(s);
    }
    freeaddrinfo(found);
    if (connected < 0) {
        *problem = "nobody listens there";
        return nullptr;
    }
    return std::unique_ptr<DisplayServer>(new DisplayServer(connected));
}

DisplayServer::~DisplayServer() {
    if (socket_ >= 0) close(socket_);
}

bool DisplayServer::Send(const std::string& packet) {
    size_t sent = 0;
    while (sent < packet.size()) {
        const ssize_t n = send(socket_, packet.data() + sent, packet.size() - sent, MSG_NOSIGNAL);
        if (n <= 0) {
            close(socket_);
            socket_ = -1;
            return false;
        }
        sent += size_t(n);
    }
    return true;
}

bool DisplayServer::Show(const std::string& name, const Image& image) {
    if (socket_ < 0) return false;
    const Int2 resolution = image.Resolution();
    const int channels = std::min(3, image.NumChannels());
    if (!created_) {
        Packet packet(Operation::CreateImage);
        packet.Add(char(1))
            .AddText(name)
            .Add(int32_t(resolution.x))
            .Add(int32_t(resolution.y))
            .Add(int32_t(channels));
        for (int c = 0; c < channels; ++c) packet.AddText(image.Channels()[size_t(c)]);
        if (!Send(packet.Finish())) return false;
        created_ = true;
    }
    for (int c = 0; c < channels; ++c)
        for (int y0 = 0; y0 < resolution.y; y0 += kRowsPerPacket) {
            const int rows = std::min(kRowsPerPacket, resolution.y - y0);
            Packet packet(Operation::UpdateImageV2);
            packet.Add(char(0)).AddText(name).Add(int32_t(1)).AddText(image.Channels()[size_t(c)]);
            packet.Add(int32_t(0)).Add(int32_t(y0)).Add(int32_t(resolution.x)).Add(int32_t(rows));
            for (int y = y0; y < y0 + rows; ++y)
                for (int x = 0; x < resolution.x; ++x) packet.Add(image.Get({x, y}, c));
            if (!Send(packet.Finish())) return false;
        }
    return true;
}

}  // namespace lacquer
