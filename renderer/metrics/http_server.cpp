#include "renderer/metrics/http_server.h"

#include <poll.h>
#include <sys/socket.h>

#include <cerrno>
#include <vector>

#include "protocol/base/clock.h"
#include "protocol/transport/core/address.h"
#include "protocol/transport/core/uri.h"

namespace fire3dv::metrics {
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
