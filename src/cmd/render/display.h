// Live view in an image viewer that speaks the protocol of tev.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "pbrt/image/image.h"

namespace lacquer::cmd {

/// Where a viewer listens.
struct DisplayAddress {
    std::string host, port;
    /// "host:port", "host" (tev's own port 14158), "[::1]:port" or "::1". Empty if it is none of them.
    static std::optional<DisplayAddress> Parse(const std::string& text);
};

/// Sends images to a viewer from a thread of its own. The caller never waits for the network: an image that
/// was not sent before the next one came is dropped. Errors end the connection, for Problem() to tell.
class DisplayServer {
  public:
    /// Begins to connect. The viewer shows a black image of this size, called `name`, as soon as it is there.
    DisplayServer(const DisplayAddress& address, const std::string& name, Int2 resolution);
    /// As Finish().
    ~DisplayServer();
    DisplayServer(const DisplayServer&) = delete;
    DisplayServer& operator=(const DisplayServer&) = delete;

    /// Shows channels R, G and B of an image of the resolution given above (its first channel as a grey where
    /// it has no colours). Cost: none but the hand-over.
    void Show(std::unique_ptr<Image> image);
    /// Waits until the last image is sent, for two seconds without progress and ten in all at most.
    void Finish();
    /// Why nothing is sent any more, as the rest of a sentence about the viewer; empty while all is well.
    std::string Problem() const;

  private:
    struct Shared;
    class Sender;
    /// The thread may outlive this object where a name look-up hangs: what it needs is its own as well.
    std::shared_ptr<Shared> shared_;
    std::thread thread_;
};

}  // namespace lacquer::cmd
