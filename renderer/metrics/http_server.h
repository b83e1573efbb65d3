// HTTP metrics endpoint for Prometheus: GET /metrics only. It runs on its own thread; publishers of metrics
// never wait for it.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "protocol/base/error.h"
#include "protocol/base/unique_fd.h"
#include "protocol/transport/core/link_thread.h"
#include "renderer/metrics/metric_families.h"

namespace fire3dv::metrics {

constexpr size_t kMaxRequestBytes = 8 << 10;

// Returns the response status of a request, or nullopt while the request is incomplete.
std::optional<int> request_status(std::string_view request);

// Formats a complete response. `page` is the body of status 200 only.
std::string write_response(int status, std::string_view page);

// HTTP/1.1 connection of one metrics scraper: one request, one response, close. Slow, oversized or malformed
// requests are rejected. It never blocks.
class HttpConnection {
 public:
  HttpConnection(UniqueFd fd, int64_t now_ns) : fd_(std::move(fd)), came_at_ns_(now_ns) {}

  int fd() const { return fd_.get(); }
  int64_t came_at_ns() const { return came_at_ns_; }
  bool is_over() const { return over_; }
  bool was_answered() const { return state_ == State::draining; }
  // Event mask for poll(2).
  short wants() const;
  // Makes progress without blocking. answer: formats the response of a status.
  void go_on(const std::function<std::string(int status)>& answer);

 private:
  void receive(const std::function<std::string(int status)>& answer);
  void send();
  void drain();

  enum class State { receiving, sending, draining };

  UniqueFd fd_;
  int64_t came_at_ns_;
  State state_ = State::receiving;
  std::string request_, response_;
  size_t sent_ = 0;
  size_t drained_ = 0;
  bool over_ = false;
};

class HttpServer {
 public:
  // Writes the current metrics; called on the server's thread.
  using Page = std::function<void(Exposition&)>;

  // at: "HOST:PORT", port 0 for any free port. Non-loopback addresses are refused unless `insecure`.
  static Result<std::unique_ptr<HttpServer>> open(const std::string& at, bool insecure, Page page);
  ~HttpServer() { thread_.stop(); }

  std::string address() const { return address_; }

 private:
  HttpServer(std::string address, UniqueFd fd, Page page);
  void run();
  void accept_all(int64_t now_ns);
  void serve_all(int64_t now_ns);
  std::string answer(int status);

  const std::string address_;
  const UniqueFd listening_;
  const Page page_;

  // Owned by the server thread.
  std::deque<HttpConnection> connections_;  // oldest first
  struct Answered {
    int status;
    uint64_t count;
  };
  std::array<Answered, 6> answered_{{{200, 0}, {400, 0}, {404, 0}, {405, 0}, {431, 0}, {505, 0}}};
  uint64_t timed_out_ = 0, evicted_ = 0;
  int64_t accept_again_ns_ = 0;  // back-off after descriptors ran out

  transport::LinkThread thread_;
};

}  // namespace fire3dv::metrics
