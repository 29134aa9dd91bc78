// Live view in an image viewer that speaks the protocol of tev.
#pragma once

#include <memory>
#include <string>

#include "pbrt/image/image.h"

namespace lacquer {

/// A connection to `host:port`. Sending never blocks a render for long and never fails it.
class DisplayServer {
  public:
    /// Empty pointer, and the reason in `problem`, if there is no such server.
    static std::unique_ptr<DisplayServer> Connect(const std::string& address, std::string* problem);
    ~DisplayServer();
    DisplayServer(const DisplayServer&) = delete;
    DisplayServer& operator=(const DisplayServer&) = delete;

    /// Shows the image under `name`, replacing what was there. False once the connection is lost.
    bool Show(const std::string& name, const Image& image);

  private:
    explicit DisplayServer(int socket) : socket_(socket) {}
    bool Send(const std::string& packet);
    int socket_;
    bool created_ = false;
};

}  // namespace lacquer
