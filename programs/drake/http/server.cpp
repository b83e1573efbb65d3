#include "programs/drake/http/server.h"

#include <boost/asio/signal_set.hpp>
#include <csignal>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "base/text.h"
#include "programs/drake/http/session.h"
#include "protocol/transport/http/accept_loop.h"

namespace fire3dv::drake {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

constexpr size_t kMaxMessageBytes = 2000;
constexpr uint16_t kExamplePort = 8000;

// Refusal of a connection beyond the limit, as it is sent.
constexpr std::string_view kBusy =
    "HTTP/1.1 503 Service Unavailable\r\nContent-Type: application/json\r\nContent-Length: 78\r\n"
    "Connection: close\r\n\r\n"
    R"({"error":true,"message":"too many connections; ask again later","code":503}   )";
static_assert(kBusy.size() - kBusy.find("\r\n\r\n") - 4 == 78);

}  // namespace

HttpAnswer http_error(unsigned status, const std::string& message) {
  const nlohmann::json body = {
      {"error", true}, {"message", printable_text(message, kMaxMessageBytes)}, {"code", status}};
  return {status, "application/json", body.dump() + "\n"};
}

struct HttpServer::State final : transport::http::ConnectionOwner {
  Sessions sessions;  // outlives the accept loop, whose handlers own the sessions
  std::unique_ptr<transport::http::AcceptLoop> loop;

  size_t open_connections() const override { return sessions.open.size(); }
  void evict() override { sessions.evict_idle(); }
  void serve(tcp::socket&& socket) override {
    std::make_shared<Session>(std::move(socket), sessions)->start();
  }
  void refuse(tcp::socket& socket) override {
    boost::system::error_code ignored;
    socket.non_blocking(true, ignored);
    socket.write_some(asio::buffer(kBusy.data(), kBusy.size()), ignored);
  }
};

HttpServer::HttpServer(std::unique_ptr<State> state) : state_(std::move(state)) {}
HttpServer::~HttpServer() = default;

Result<std::unique_ptr<HttpServer>> HttpServer::open(const std::string& at, bool insecure,
                                                     const HttpLimits& limits, Handler handler) {
  auto state = std::make_unique<State>();
  state->sessions.limits = limits;
  state->sessions.handler = std::move(handler);
  transport::http::ListenOptions listen;
  listen.at = at;
  listen.option = "the address";
  listen.example_port = kExamplePort;
  listen.may_be_public = insecure;
  listen.risk = "it is open to the network, where anyone could render";
  listen.max_connections = limits.max_connections;
  auto loop = transport::http::AcceptLoop::open(listen, *state);
  if (!loop) return loop.error();
  state->loop = std::move(*loop);
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
