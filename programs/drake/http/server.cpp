#include "programs/drake/http/server.h"

#include <algorithm>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <csignal>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>

#include "base/text.h"

namespace fire3dv::drake {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast::http;
namespace http = transport::http;

constexpr size_t kMaxMessageBytes = 2000;
constexpr uint16_t kExamplePort = 8000;

constexpr std::string_view kAbout =
    "FIRE-3DV renders here for Drake: RenderEngineGltfClient posts its scenes to /render.\n";

}  // namespace

HttpAnswer http_error(unsigned status, const std::string& message) {
  const nlohmann::json body = {
      {"error", true}, {"message", printable_text(message, kMaxMessageBytes)}, {"code", status}};
  return {status, "application/json", body.dump() + "\n"};
}

struct HttpServer::State final : http::SessionOwner {
  State(const HttpLimits& http_limits, Handler request_handler)
      : SessionOwner({.max_body_bytes = http_limits.max_body_bytes,
                      .max_requests = std::numeric_limits<int>::max(),
                      .header_timeout = http_limits.header_timeout,
                      .body_timeout = http_limits.body_timeout,
                      .write_timeout = http_limits.write_timeout,
                      .body_silence = std::min(http_limits.body_silence, http_limits.body_timeout),
                      .max_total_body_bytes = http_limits.max_total_bytes}),
        handler(std::move(request_handler)) {}

  const Handler handler;
  std::unique_ptr<http::AcceptLoop> loop;  // destroyed first: its handlers own the sessions

  http::Answer refusal(unsigned status, const std::string& text) const override {
    return http_error(status, text + (status == 413 ? "; raise it with --max-request" : ""));
  }
  void set_access(http::AccessRules&& rules) { access = std::move(rules); }
  void on_header(http::Session& session) override {
    const std::string_view path = session.path();
    const auto method = session.request().method();
    const std::string type = lower_case(std::string(session.field(beast::field::content_type)));
    const auto refuse = [&](unsigned status, const char* text) { session.answer(http_error(status, text)); };
    if (path == "/" && method == beast::verb::get)
      return session.answer({200, "text/plain; charset=utf-8", std::string(kAbout)});
    if (path != "/render") return refuse(404, "the only endpoint is /render");
    if (method != beast::verb::post) {
      http::Answer answer = http_error(405, "/render takes POST only");
      answer.fields = {{"Allow", "POST"}};
      return session.answer(std::move(answer));
    }
    if (!type.starts_with("multipart/form-data"))
      return refuse(415, "the Content-Type must be multipart/form-data");
    if (!session.content_length()) return refuse(411, "the request must have a Content-Length");
    session.read_body();
  }
  // The session is handed on as a whole, so that it ends on this thread.
  void on_body(http::Session& session) override {
    HttpRequest request{std::string(session.field(beast::field::content_type)), session.take_body(),
                        session.client()};
    handler(std::move(request), [self = session.shared_from_this()](HttpAnswer&& answer) mutable {
      const auto executor = self->executor();
      asio::post(executor, [self = std::move(self), answer = std::move(answer)]() mutable {
        self->answer(std::move(answer));
      });
    });
  }
};

HttpServer::HttpServer(std::unique_ptr<State> state) : state_(std::move(state)) {}
HttpServer::~HttpServer() = default;

Result<std::unique_ptr<HttpServer>> HttpServer::open(const std::string& at, bool insecure,
                                                     const HttpLimits& limits, Handler handler,
                                                     const http::AccessOptions& access) {
  auto state = std::make_unique<State>(limits, std::move(handler));
  http::ListenOptions listen;
  listen.at = at;
  listen.option = "the address";
  listen.example_port = kExamplePort;
  listen.may_be_public = insecure;
  listen.risk = "it is open to the network, where anyone could render";
  listen.max_connections = limits.max_connections;
  auto loop = http::AcceptLoop::open(listen, *state);
  if (!loop) return loop.error();
  state->loop = std::move(*loop);
  state->set_access({.own_host = state->loop->host(),
                     .is_public = !state->loop->is_loopback(),
                     .clients = http::AccessRules::Clients::programs,
                     .options = access});
  return std::unique_ptr<HttpServer>(new HttpServer(std::move(state)));
}

std::string HttpServer::address() const {
  return state_->loop->address();
}

void HttpServer::run(const std::function<void()>& on_stop) {
  asio::signal_set signals(state_->loop->io(), SIGINT, SIGTERM);
  signals.async_wait([this](boost::system::error_code error, int) {
    if (!error) state_->loop->stop();
  });
  state_->loop->run();
  on_stop();
}

void HttpServer::stop() {
  state_->loop->stop();
}

}  // namespace fire3dv::drake
