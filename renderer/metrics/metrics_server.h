// HTTP metrics endpoint for Prometheus: GET /metrics only. It runs on its own thread; publishers of metrics
// never wait for it.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "base/error.h"
#include "protocol/transport/http/access_rules.h"
#include "renderer/metrics/metric_families.h"

namespace fire3dv::metrics {

class MetricsServer {
 public:
  // Writes the current metrics; called on the server's thread.
  using Page = std::function<void(Exposition&)>;

  // at: "HOST:PORT", port 0 for any free port. Non-loopback addresses are refused unless `insecure`.
  static Result<std::unique_ptr<MetricsServer>> open(const std::string& at, bool insecure, Page page,
                                                     const transport::http::AccessOptions& access = {});
  ~MetricsServer();
  MetricsServer(const MetricsServer&) = delete;
  MetricsServer& operator=(const MetricsServer&) = delete;

  std::string address() const;  // "HOST:PORT" with the assigned port

 private:
  struct State;
  explicit MetricsServer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace fire3dv::metrics
