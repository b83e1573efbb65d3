// HTTP/1.1 server of one endpoint, POST /render. Connections are served concurrently on the thread of run();
// a handler answers each request, at any later time and from any thread.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "base/error.h"
#include "protocol/transport/http/session.h"

namespace fire3dv::drake {

struct HttpLimits {
  uint64_t max_body_bytes = uint64_t{256} << 20;  // of one request
  uint64_t max_total_bytes = uint64_t{1} << 30;   // of all bodies that have arrived, until their answers
  size_t max_connections = 64;
  std::chrono::seconds header_timeout{20};  // also of a connection without a request
  std::chrono::seconds body_timeout{60};
  std::chrono::seconds body_silence{5};
  std::chrono::seconds write_timeout{60};
};

struct HttpRequest {
  std::string content_type, body;
  std::string client;  // address
};

using HttpAnswer = transport::http::Answer;
// Error answer in the form of Drake's own server, shorter than the 8,192 bytes that its client shows.
HttpAnswer http_error(unsigned status, const std::string& message);

class HttpServer {
 public:
  using Answer = std::function<void(HttpAnswer&&)>;  // call it once, before the server is destroyed
  using Handler = std::function<void(HttpRequest&&, Answer)>;

  // at: "HOST:PORT", port 0 for any free port. Addresses other than loopback are refused unless `insecure`.
  // handler: called on the thread of run(); it must not block.
  static Result<std::unique_ptr<HttpServer>> open(const std::string& at, bool insecure,
                                                  const HttpLimits& limits, Handler handler,
                                                  const transport::http::AccessOptions& access = {});
  ~HttpServer();

  std::string address() const;  // with the assigned port
  // Serves until SIGINT or SIGTERM, or stop(). on_stop is called first then.
  void run(const std::function<void()>& on_stop);
  void stop();  // from any thread

 private:
  struct State;
  explicit HttpServer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace fire3dv::drake
