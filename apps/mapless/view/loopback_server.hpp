#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace mapless::app {

struct HttpAnswer {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string body;
};

/// A small HTTP server for the browser on this computer: it listens on 127.0.0.1 alone, answers GET, one
/// request a connection, one at a time, and refuses requests that name another host, as those of a foreign
/// page in the same browser do. Nothing of a request but its path is used.
class LoopbackServer {
 public:
  /// `port` 0: any free one. Throws ParameterError if the port cannot be had.
  explicit LoopbackServer(std::uint16_t port);
  ~LoopbackServer();
  LoopbackServer(const LoopbackServer&) = delete;
  LoopbackServer& operator=(const LoopbackServer&) = delete;

  [[nodiscard]] std::uint16_t port() const { return port_; }

  /// Answers requests until `ended` is true, which is looked at five times a second. `answer` gets the path
  /// of a request, without what follows a question mark.
  void run(const std::function<HttpAnswer(std::string_view path)>& answer,
           const std::function<bool()>& ended) const;

 private:
  int socket_ = -1;
  std::uint16_t port_ = 0;
};

}  // namespace mapless::app
