#include "renderer/metrics/http_server.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <vector>

#include "protocol/base/clock.h"
#include "protocol/transport/core/address.h"

namespace fire3dv::metrics {

namespace {

constexpr size_t kMaxDrainedBytes = 64 << 10;

bool only_waits(int error) {
  return error == EAGAIN || error == EWOULDBLOCK || error == EINTR;
}

const char* reason_of(int status) {
  switch (status) {
    case 200:
      return "OK";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    case 431:
      return "Request Header Fields Too Large";
    case 505:
      return "HTTP Version Not Supported";
  }
  return "Bad Request";
}

bool is_printable(char c) {
  return c >= 0x20 && c <= 0x7e;
}

// Parses a request line without line end, for example "GET /metrics HTTP/1.1". Returns the response status.
int judge_line(std::string_view line) {
  if (!std::all_of(line.begin(), line.end(), is_printable)) return 400;
  const size_t first = line.find(' ');
  const size_t last = line.rfind(' ');
  if (first == std::string_view::npos || first == 0 || first == last) return 400;
  const std::string_view method = line.substr(0, first);
  std::string_view target = line.substr(first + 1, last - first - 1);
  const std::string_view version = line.substr(last + 1);
  if (target.empty() || target.find(' ') != std::string_view::npos) return 400;
  if (!version.starts_with("HTTP/")) return 400;
  if (!version.starts_with("HTTP/1.") || version.size() != 8) return 505;
  if (method != "GET") return 405;
  target = target.substr(0, target.find('?'));  // scrapers may add query parameters; they are ignored
  return target == "/metrics" ? 200 : 404;
}

}  // namespace

std::optional<int> request_status(std::string_view request) {
  // Other protocols are rejected by their first byte; their data may never contain a line end.
  if (!request.empty() && !is_printable(request.front())) return 400;
  size_t end = request.find("\r\n\r\n");
  end = std::min(end, request.find("\n\n"));
  if (end == std::string_view::npos) {
    if (request.size() >= kMaxRequestBytes) return 431;
    return {};
  }
  std::string_view line = request.substr(0, request.find('\n'));
  if (line.ends_with('\r')) line.remove_suffix(1);
  return judge_line(line);
}

std::string write_response(int status, std::string_view page) {
  const std::string reason = reason_of(status);
  const std::string plain =
      status == 404 ? "metrics are at /metrics\n" : std::to_string(status) + " " + reason + "\n";
  const std::string_view body = status == 200 ? page : std::string_view(plain);
  std::string text = "HTTP/1.0 " + std::to_string(status) + " " + reason + "\r\n";
  text += std::string("Content-Type: text/plain; ") + (status == 200 ? "version=0.0.4; " : "") +
          "charset=utf-8\r\n";
  if (status == 405) text += "Allow: GET\r\n";
  // Stream names are untrusted: nosniff prevents browsers from interpreting them as HTML.
  text += "X-Content-Type-Options: nosniff\r\nCache-Control: no-store\r\nConnection: close\r\n";
  text += "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n";
  return text.append(body);
}

short HttpConnection::wants() const {
  return state_ == State::sending ? POLLOUT : POLLIN;
}

void HttpConnection::go_on(const std::function<std::string(int status)>& answer) {
  if (state_ == State::receiving) receive(answer);
  if (state_ == State::sending && !over_) send();
  if (state_ == State::draining && !over_) drain();
}

void HttpConnection::receive(const std::function<std::string(int status)>& answer) {
  char buffer[2048];
  while (true) {
    const ssize_t got = ::recv(fd(), buffer, sizeof buffer, MSG_DONTWAIT);
    if (got < 0 && only_waits(errno)) return;
    if (got <= 0) {
      over_ = true;
      return;
    }
    request_.append(buffer, static_cast<size_t>(got));
    const std::optional<int> status = request_status(request_);
    if (!status) continue;
    request_ = {};
    response_ = answer(*status);
    state_ = State::sending;
    return;
  }
}

void HttpConnection::send() {
  while (sent_ < response_.size()) {
    const ssize_t sent =
        ::send(fd(), response_.data() + sent_, response_.size() - sent_, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent < 0 && only_waits(errno)) return;
    if (sent < 0) {
      over_ = true;
      return;
    }
    sent_ += static_cast<size_t>(sent);
  }
  ::shutdown(fd(), SHUT_WR);
  state_ = State::draining;
}

// Drains unread input before close(): otherwise TCP resets the connection and discards the response.
void HttpConnection::drain() {
  char buffer[2048];
  while (true) {
    const ssize_t got = ::recv(fd(), buffer, sizeof buffer, MSG_DONTWAIT);
    if (got < 0 && only_waits(errno)) return;
    if (got > 0) drained_ += static_cast<size_t>(got);
    if (got <= 0 || drained_ > kMaxDrainedBytes) {
      over_ = true;
      return;
    }
  }
}

namespace {

// Timeout from accept to the end of the response. A scrape on loopback takes milliseconds.
constexpr int64_t kLongestVisitNs = 5 * kSecondNs;
constexpr size_t kMaxConnections = 32;
constexpr int64_t kAcceptAgainNs = 100 * kMillisecondNs;
constexpr int64_t kIdleNs = kSecondNs;

// Host and port follow the rules of link URIs.
Result<transport::Uri> parse(const std::string& at) {
  Result<transport::Uri> uri = transport::parse_uri("tcp://" + at);
  if (!uri)
    return Error{"--metrics '" + at.substr(0, 80) +
                 "': must be HOST:PORT, such as 127.0.0.1:9464 or [::1]:9464"};
  return uri;
}

Result<void> check_is_loopback(const transport::Uri& uri, const std::string& at) {
  const transport::Lookup lookup(uri);
  while (!lookup.done()) ::poll(nullptr, 0, 1);
  for (const transport::Address& address : lookup.addresses()) {
    if (!address.is_loopback())
      return Error{"--metrics " + at + ": anyone on the network could read the metrics there; use " +
                   (address.family() == AF_INET6 ? "[::1]" : "127.0.0.1") +
                   ", or --insecure if that is wanted"};
  }
  return {};
}

}  // namespace

Result<std::unique_ptr<HttpServer>> HttpServer::open(const std::string& at, bool insecure, Page page) {
  const Result<transport::Uri> uri = parse(at);
  if (!uri) return uri.error();
  if (!insecure) {
    if (Result<void> loopback = check_is_loopback(*uri, at); !loopback) return loopback.error();
  }
  auto bound = transport::bind_listener(*uri, SOCK_STREAM, insecure);
  if (!bound) return Error{"--metrics: " + bound.error().message};
  transport::Uri chosen = *uri;
  chosen.port = bound->address.port();
  const std::string address = transport::uri_text(chosen).substr(std::string("tcp://").size());
  std::unique_ptr<HttpServer> server(new HttpServer(address, std::move(bound->fd), std::move(page)));
  auto started = server->thread_.start("--metrics " + at, [raw = server.get()] { raw->run(); });
  if (!started) return started.error();
  return server;
}

HttpServer::HttpServer(std::string address, UniqueFd fd, Page page)
    : address_(std::move(address)), listening_(std::move(fd)), page_(std::move(page)) {}

void HttpServer::run() {
  std::vector<pollfd> polled;
  while (!thread_.stopping()) {
    try {
      polled.clear();
      for (const HttpConnection& connection : connections_)
        polled.push_back({connection.fd(), connection.wants(), 0});
      const int64_t now_ns = monotonic_ns();
      if (now_ns >= accept_again_ns_) polled.push_back({listening_.get(), POLLIN, 0});
      polled.push_back({thread_.wake_fd(), POLLIN, 0});
      ::poll(polled.data(), polled.size(),
             static_cast<int>((connections_.empty() ? kIdleNs : kAcceptAgainNs) / kMillisecondNs));
      accept_all(monotonic_ns());
      serve_all(monotonic_ns());
    } catch (const std::exception&) {  // no memory: whoever asked comes again
      connections_.clear();
    }
  }
}

void HttpServer::accept_all(int64_t now_ns) {
  if (now_ns < accept_again_ns_) return;
  // Accepts a bounded number per turn, so that a flood does not starve open connections.
  for (size_t i = 0; i < kMaxConnections; ++i) {
    UniqueFd fd(::accept4(listening_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (!fd) {
      const bool nobody = errno == EAGAIN || errno == EWOULDBLOCK;
      if (!nobody && errno != EINTR && errno != ECONNABORTED) accept_again_ns_ = now_ns + kAcceptAgainNs;
      return;
    }
    if (connections_.size() == kMaxConnections) {  // evict the oldest connection
      connections_.pop_front();
      ++evicted_;
    }
    connections_.emplace_back(std::move(fd), now_ns);
  }
}

void HttpServer::serve_all(int64_t now_ns) {
  for (HttpConnection& connection : connections_)
    connection.go_on([this](int status) { return answer(status); });
  std::erase_if(connections_, [&](const HttpConnection& connection) {
    if (connection.is_over()) return true;
    if (now_ns - connection.came_at_ns() < kLongestVisitNs) return false;
    timed_out_ += connection.was_answered() ? 0 : 1;
    return true;
  });
}

std::string HttpServer::answer(int status) {
  for (Answered& answered : answered_) answered.count += answered.status == status;
  if (status != 200) return write_response(status, {});
  Exposition exposition;
  page_(exposition);
  exposition.family("fire3dv_metrics_requests_total", "counter", "Requests to this page, by answer.");
  for (const Answered& answered : answered_)
    exposition.sample({{"code", std::to_string(answered.status)}}, answered.count);
  exposition.family("fire3dv_metrics_sent_away_total", "counter",
                    "Connections to this page that were closed without an answer.");
  exposition.sample({{"cause", "slow"}}, timed_out_);
  exposition.sample({{"cause", "full"}}, evicted_);
  return write_response(200, exposition.text());
}

}  // namespace fire3dv::metrics
