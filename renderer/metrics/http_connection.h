// HTTP/1.1 connection of one metrics scraper: one request, one response, close. Slow, oversized or malformed
// requests are rejected. It never blocks.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "protocol/base/unique_fd.h"

namespace fire3dv::metrics {

constexpr size_t kMaxRequestBytes = 8 << 10;

// Returns the response status of a request, or nullopt while the request is incomplete.
std::optional<int> request_status(std::string_view request);

// Formats a complete response. `page` is the body of status 200 only.
std::string write_response(int status, std::string_view page);

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

}  // namespace fire3dv::metrics
