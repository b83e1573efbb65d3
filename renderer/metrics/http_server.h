// HTTP metrics endpoint for Prometheus: GET /metrics only. It runs on its own thread; publishers of metrics
// never wait for it.
#pragma once

#include <array>
#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <string>

#include "protocol/base/error.h"
#include "protocol/base/unique_fd.h"
#include "protocol/transport/core/link_thread.h"
#include "renderer/metrics/exposition.h"
#include "renderer/metrics/http_connection.h"

namespace fire3dv::metrics {

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
