// One visitor of the metrics: a request of a few lines, an answer, and the end. Whoever is slow, says too
// much or something else is sent away; nothing of a request is kept but what tells which page is wanted.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "protocol/transport/unique_fd.h"

namespace fire3dv::metrics {

constexpr size_t kMostRequestBytes = 8 << 10;

// The status with which a request is answered; nothing: it is not whole yet.
std::optional<int> judge_request(std::string_view request);

// A whole answer with this status. `page` is sent with 200 alone.
std::string write_response(int status, std::string_view page);

class HttpConnection {
 public:
  HttpConnection(transport::UniqueFd fd, int64_t now_ns) : fd_(std::move(fd)), came_at_ns_(now_ns) {}

  int fd() const { return fd_.get(); }
  int64_t came_at_ns() const { return came_at_ns_; }
  bool is_over() const { return over_; }
  bool was_answered() const { return state_ == State::draining; }
  // What poll(2) is to wait for.
  short wants() const;
  // Does what is possible without waiting. answer: the text for a status.
  void go_on(const std::function<std::string(int status)>& answer);

 private:
  void receive(const std::function<std::string(int status)>& answer);
  void send();
  void drain();

  enum class State { receiving, sending, draining };

  transport::UniqueFd fd_;
  int64_t came_at_ns_;
  State state_ = State::receiving;
  std::string request_, response_;
  size_t sent_ = 0;
  size_t drained_ = 0;
  bool over_ = false;
};

}  // namespace fire3dv::metrics
