// What is measured, for Prometheus and its kin: GET /metrics over HTTP, and nothing else. A thread of its own
// answers; whoever measures hands numbers over and waits for nobody.
#pragma once

#include <array>
#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <string>

#include "protocol/error.h"
#include "protocol/transport/link_thread.h"
#include "protocol/transport/unique_fd.h"
#include "renderer/metrics/exposition.h"
#include "renderer/metrics/http_connection.h"

namespace fire3dv::metrics {

class HttpServer {
 public:
  // Adds what is to be said now, on the server's thread.
  using Page = std::function<void(Exposition&)>;

  // at: "HOST:PORT", port 0 for any. Addresses other than loopback are refused unless insecure.
  static Result<std::unique_ptr<HttpServer>> open(const std::string& at, bool insecure, Page page);
  ~HttpServer() { thread_.stop(); }

  std::string address() const { return address_; }

 private:
  HttpServer(std::string address, transport::UniqueFd fd, Page page);
  void run();
  void accept_all(int64_t now_ns);
  void serve_all(int64_t now_ns);
  std::string answer(int status);

  const std::string address_;
  const transport::UniqueFd listening_;
  const Page page_;

  // On the thread alone.
  std::deque<HttpConnection> connections_;  // oldest first
  struct Answered {
    int status;
    uint64_t count;
  };
  std::array<Answered, 6> answered_{{{200, 0}, {400, 0}, {404, 0}, {405, 0}, {431, 0}, {505, 0}}};
  uint64_t sent_away_slow_ = 0, sent_away_full_ = 0;
  int64_t accept_again_ns_ = 0;  // after the system had no descriptor left

  transport::LinkThread thread_;
};

}  // namespace fire3dv::metrics
