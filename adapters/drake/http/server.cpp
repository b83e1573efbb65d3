#include "adapters/drake/http/server.h"

#include <fcntl.h>
#include <sys/socket.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <csignal>
#include <new>
#include <nlohmann/json.hpp>
#include <string_view>
#include <thread>
#include <utility>

#include "adapters/drake/http/session.h"
#include "protocol/base/text.h"
#include "protocol/transport/core/address.h"

namespace fire3dv::drake {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

constexpr size_t kMaxMessageBytes = 2000;
constexpr std::chrono::milliseconds kAcceptAgain{100};  // after descriptors ran out

// Refusal of a connection beyond the limit, as it is sent.
constexpr std::string_view kBusy =
    "HTTP/1.1 503 Service Unavailable\r\nContent-Type: application/json\r\nContent-Length: 78\r\n"
    "Connection: close\r\n\r\n"
    R"({"error":true,"message":"too many connections; ask again later","code":503}   )";
static_assert(kBusy.size() - kBusy.find("\r\n\r\n") - 4 == 78);

Result<transport::Uri> parse_address(const std::string& at, bool insecure) {
  const std::string shown = printable_text(at, 80);
  Result<transport::Uri> uri = transport::parse_uri("tcp://" + at);
  if (!uri)
    return Error{"the address '" + shown + "' must be HOST:PORT, such as 127.0.0.1:8000 or [::1]:8000"};
  const transport::Lookup lookup(*uri);
  while (!lookup.done()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  for (const transport::Address& address : lookup.addresses()) {
    if (!insecure && !address.is_loopback())
      return Error{"the address " + shown + " is open to the network, where anyone could render: use " +
                   (address.family() == AF_INET6 ? "[::1]" : "127.0.0.1") +
                   ", or --insecure if that is wanted"};
  }
  return uri;
}

}  // namespace

HttpAnswer http_error(unsigned status, const std::string& message) {
  const nlohmann::json body = {
      {"error", true}, {"message", printable_text(message, kMaxMessageBytes)}, {"code", status}};
  return {status, "application/json", body.dump() + "\n"};
}

struct HttpServer::State {
  std::string address;
  Sessions sessions;  // outlives io, whose handlers own the sessions
  asio::io_context io{1};
  tcp::acceptor acceptor{io};
  asio::steady_timer accept_again{io};

  void accept();
  void serve(tcp::socket&& socket);
};

void HttpServer::State::accept() {
  acceptor.async_accept([this](boost::system::error_code error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (!error) {
      accept();
      return serve(std::move(socket));
    }
    accept_again.expires_after(kAcceptAgain);
    accept_again.async_wait([this](boost::system::error_code stopped) {
      if (!stopped) accept();
    });
  });
}

void HttpServer::State::serve(tcp::socket&& socket) {
  boost::system::error_code ignored;
  if (sessions.open.size() >= sessions.limits.max_connections && !sessions.evict_idle()) {
    socket.non_blocking(true, ignored);
    socket.write_some(asio::buffer(kBusy.data(), kBusy.size()), ignored);
    return;
  }
  socket.set_option(tcp::no_delay(true), ignored);
  std::make_shared<Session>(std::move(socket), sessions)->start();
}

HttpServer::HttpServer(std::unique_ptr<State> state) : state_(std::move(state)) {}
HttpServer::~HttpServer() = default;

Result<std::unique_ptr<HttpServer>> HttpServer::open(const std::string& at, bool insecure,
                                                     const HttpLimits& limits, Handler handler) {
  Result<transport::Uri> uri = parse_address(at, insecure);
  if (!uri) return uri.error();
  Result<transport::BoundSocket> bound = transport::bind_listener(*uri, SOCK_STREAM, insecure);
  if (!bound) return bound.error();
  auto state = std::make_unique<State>();
  uri->port = bound->address.port();
  state->address = transport::uri_text(*uri).substr(std::string("tcp://").size());
  state->sessions.limits = limits;
  state->sessions.handler = std::move(handler);
  boost::system::error_code error;
  const int fd = ::fcntl(bound->fd.get(), F_DUPFD_CLOEXEC, 0);  // Asio owns its own descriptor
  state->acceptor.assign(bound->address.family() == AF_INET6 ? tcp::v6() : tcp::v4(), fd, error);
  if (error) return Error{"cannot serve " + at + ": " + error.message()};
  return std::unique_ptr<HttpServer>(new HttpServer(std::move(state)));
}

std::string HttpServer::address() const {
  return state_->address;
}

void HttpServer::run(const std::function<void()>& on_stop) {
  asio::signal_set signals(state_->io, SIGINT, SIGTERM);
  signals.async_wait([this](boost::system::error_code error, int) {
    if (!error) state_->io.stop();
  });
  state_->accept();
  while (!state_->io.stopped()) {
    try {
      state_->io.run();
    } catch (const std::bad_alloc&) {  // the connection is lost; its client asks again
    }
  }
  on_stop();
}

void HttpServer::stop() {
  state_->io.stop();
}

}  // namespace fire3dv::drake
