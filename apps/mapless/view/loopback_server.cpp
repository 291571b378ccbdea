#include "view/loopback_server.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <strings.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <mapless/core/errors.hpp>

namespace mapless::app {
namespace {

constexpr int kLook_ms = 200;                  // between two looks at whether the server is to end
constexpr std::size_t kMaxRequest = 16384;     // [bytes]; a browser sends less than 2000
constexpr std::size_t kMaxConnections = 32;    // open ones; a browser opens six, some of them in advance
constexpr timeval kSlowest{5, 0};              // a reader that takes nothing for so long is given up [s]
constexpr std::string_view kEnd = "\r\n\r\n";  // of the head of a request

struct Connection {
  int socket;
  std::string request;
};

std::string_view reason_of(int status) {
  switch (status) {
    case 200:
      return "OK";
    case 202:
      return "Accepted";
    case 403:
      return "Forbidden";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    default:
      return "Internal Server Error";
  }
}

// The value of a field of the head, without blanks before it; names of fields have no case.
std::string_view field_of(std::string_view request, std::string_view name) {
  for (std::size_t at = request.find("\r\n"); at != std::string_view::npos; at = request.find("\r\n", at)) {
    at += 2;
    if (at + name.size() >= request.size() || request[at + name.size()] != ':') continue;
    if (strncasecmp(request.data() + at, name.data(), name.size()) != 0) continue;
    std::string_view value = request.substr(at + name.size() + 1);
    value = value.substr(0, value.find("\r\n"));
    value.remove_prefix(std::min(value.size(), value.find_first_not_of(" \t")));
    return value;
  }
  return {};
}

HttpAnswer answer_to(std::string_view request, std::uint16_t port,
                     const std::function<HttpAnswer(std::string_view path)>& answer) {
  const std::string_view line = request.substr(0, request.find("\r\n")), host = field_of(request, "Host");
  if (host != fmt::format("127.0.0.1:{}", port) && host != fmt::format("localhost:{}", port))
    return {403, {}, "This server answers requests to 127.0.0.1 alone.\n"};
  if (!line.starts_with("GET ")) return {405, {}, "Only GET is answered.\n"};
  const std::string_view target = line.substr(4, line.find(' ', 4) - 4);
  return answer(target.substr(0, target.find('?')));
}

void send_all(int socket, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return;  // the browser has left
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
}

void reply(int socket, const HttpAnswer& answer) {
  send_all(socket,
           fmt::format("HTTP/1.1 {} {}\r\nContent-Type: {}\r\nContent-Length: {}\r\n"
                       "Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n"
                       "Connection: close\r\n\r\n",
                       answer.status, reason_of(answer.status),
                       answer.type.empty() ? "text/plain; charset=utf-8" : answer.type, answer.body.size()));
  send_all(socket, answer.body);
}

// Takes what has come. False: nothing more will, or too much has.
bool receive(Connection& connection) {
  char some[4096];
  const ssize_t size = recv(connection.socket, some, sizeof some, MSG_DONTWAIT);
  if (size < 0) return errno == EAGAIN || errno == EINTR;
  connection.request.append(some, static_cast<std::size_t>(size));
  return size > 0 && connection.request.size() <= kMaxRequest;
}

void accept_into(std::vector<Connection>& connections, int listening) {
  const int socket = accept4(listening, nullptr, nullptr, SOCK_CLOEXEC);
  if (socket < 0) return;
  if (connections.size() >= kMaxConnections) {  // the oldest has sent no request
    close(connections.front().socket);
    connections.erase(connections.begin());
  }
  setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &kSlowest, sizeof kSlowest);
  connections.push_back({socket, {}});
}

}  // namespace

LoopbackServer::LoopbackServer(std::uint16_t port) : socket_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  auto* const generic = reinterpret_cast<sockaddr*>(&address);
  socklen_t size = sizeof address;
  const int on = 1;  // the port of a server that has just ended can be had at once
  setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (socket_ < 0 || bind(socket_, generic, size) != 0 || listen(socket_, kMaxConnections) != 0 ||
      getsockname(socket_, generic, &size) != 0) {
    const std::string reason = std::strerror(errno);
    if (socket_ >= 0) close(socket_);
    throw ParameterError(
        {"--port", "", std::to_string(port), reason, "give another one, or 0 for a free one"});
  }
  port_ = ntohs(address.sin_port);
}

LoopbackServer::~LoopbackServer() { close(socket_); }

void LoopbackServer::run(const std::function<HttpAnswer(std::string_view path)>& answer,
                         const std::function<bool()>& ended) const {
  std::vector<Connection> connections;
  while (!ended()) {
    std::vector<pollfd> waiting{{socket_, POLLIN, 0}};
    for (const Connection& c : connections) waiting.push_back({c.socket, POLLIN, 0});
    if (poll(waiting.data(), waiting.size(), kLook_ms) <= 0) continue;
    std::vector<Connection> open;
    for (std::size_t i = 0; i < connections.size(); ++i) {
      Connection& c = connections[i];
      const bool more = waiting[i + 1].revents == 0 || receive(c);
      const bool whole = c.request.find(kEnd) != std::string::npos;
      if (whole) reply(c.socket, answer_to(c.request, port_, answer));
      if (more && !whole)
        open.push_back(std::move(c));
      else
        close(c.socket);
    }
    connections = std::move(open);
    if (waiting.front().revents != 0) accept_into(connections, socket_);
  }
  for (const Connection& c : connections) close(c.socket);
}

}  // namespace mapless::app
