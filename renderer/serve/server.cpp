#include "renderer/serve/server.h"

#include <fcntl.h>
#include <openssl/ssl.h>
#include <poll.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <exception>
#include <new>
#include <optional>
#include <utility>

#include "protocol/transport/core/link_thread.h"
#include "protocol/transport/tcp/tcp_connection.h"
#include "renderer/serve/connection.h"
#include "renderer/serve/encoder.h"
#include "renderer/serve/hub.h"
#include "renderer/serve/viewer_socket.h"

namespace fire3dv::serve {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

constexpr std::chrono::milliseconds kAcceptAgain{100};  // after descriptors ran out

// Host and port follow the rules of link URIs.
Result<transport::Uri> parse_address(const ServerOptions& options) {
  Result<transport::Uri> uri = transport::parse_uri("tcp://" + options.at);
  if (!uri)
    return Error{"--serve '" + options.at.substr(0, 80) +
                 "': must be HOST:PORT, such as 127.0.0.1:8080 or [::1]:8080"};
  if (options.insecure || !options.tls.certificate_file.empty()) return uri;
  const transport::Lookup lookup(*uri);
  while (!lookup.done()) ::poll(nullptr, 0, 1);
  for (const transport::Address& address : lookup.addresses()) {
    if (!address.is_loopback())
      return Error{
          "--serve " + options.at +
          ": images and links would cross the network unprotected; add --tls-cert and --tls-key, use " +
          (address.family() == AF_INET6 ? "[::1]" : "127.0.0.1") + ", or --insecure if that is wanted"};
  }
  return uri;
}

}  // namespace

struct Server::State {
  std::string address;
  Hub hub;  // outlives io, whose handlers own the connections
  asio::io_context io{1};
  std::optional<asio::ssl::context> tls;
  tcp::acceptor acceptor{io};
  asio::steady_timer accept_again{io};
  transport::LinkThread thread;
  std::optional<Encoder> encoder;  // posts to io

  void accept();
  void serve(tcp::socket&& socket);
  void evict();
  void run();
};

void Server::State::accept() {
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

// The oldest connection without a token makes room for a new one.
void Server::State::evict() {
  if (!hub.connections.empty()) {
    const auto oldest = hub.connections.begin();
    const std::shared_ptr<Connection> connection = oldest->second.lock();
    hub.connections.erase(oldest);
    if (connection) connection->close();
    return;
  }
  for (const auto& [number, known] : hub.sockets) {
    const std::shared_ptr<ViewerSocket> socket = known.lock();
    if (!socket || socket->has_joined()) continue;
    hub.sockets.erase(number);
    return socket->abort();
  }
}

void Server::State::serve(tcp::socket&& socket) {
  if (hub.open() >= hub.limits.max_connections) evict();
  if (hub.open() >= hub.limits.max_connections) return;
  boost::system::error_code ignored;
  socket.set_option(tcp::no_delay(true), ignored);
  std::make_shared<Connection>(std::move(socket), tls ? &*tls : nullptr, hub)->start();
}

void Server::State::run() {
  accept();
  while (!io.stopped()) {
    try {
      io.run();
    } catch (const std::exception&) {  // memory or TLS: a connection is lost; its page connects again
    }
  }
}

Server::Server(std::unique_ptr<State> state) : state_(std::move(state)) {}

Server::~Server() {
  state_->encoder.reset();
  state_->io.stop();
  state_->thread.stop();
}

Result<std::unique_ptr<Server>> Server::open(const ServerOptions& options) {
  Result<transport::Uri> uri = parse_address(options);
  if (!uri) return uri.error();
  auto state = std::make_unique<State>();
  Hub& hub = state->hub;
  hub.limits = options.limits;
  hub.own_host = uri->host;
  hub.tls = !options.tls.certificate_file.empty();
  if (hub.tls) {
    Result<transport::tcp::TlsContext> context =
        transport::tcp::make_server_context("--serve " + options.at, options.tls);
    if (!context) return context.error();
    ::SSL_CTX_up_ref(context->get());
    state->tls.emplace(context->get());
  }
  if (options.token_file.empty()) {
    hub.tokens = random_tokens();
  } else {
    Result<Tokens> tokens = read_or_create_tokens(options.token_file);
    if (!tokens) return tokens.error();
    hub.tokens = std::move(*tokens);
  }
  Result<transport::BoundSocket> bound =
      transport::bind_listener(*uri, SOCK_STREAM, options.insecure || hub.tls);
  if (!bound) return Error{"--serve: " + bound.error().message};
  uri->port = bound->address.port();
  state->address =
      (hub.tls ? "https://" : "http://") + transport::uri_text(*uri).substr(std::string("tcp://").size());
  boost::system::error_code error;
  const int fd = ::fcntl(bound->fd.get(), F_DUPFD_CLOEXEC, 0);  // Asio owns its own descriptor
  state->acceptor.assign(bound->address.family() == AF_INET6 ? tcp::v6() : tcp::v4(), fd, error);
  if (error) return Error{"--serve " + options.at + ": " + error.message()};
  State* const raw = state.get();
  raw->encoder.emplace([raw](ViewerId viewer, std::vector<uint8_t>&& message) {
    asio::post(raw->io, [raw, viewer, message = std::move(message)]() mutable {
      const auto known = raw->hub.sockets.find(viewer);
      if (known == raw->hub.sockets.end()) return;
      const auto socket = known->second.lock();
      if (!socket) return;
      // Without memory an image is lost, and its viewer would wait for it: the page connects again and gets
      // the next.
      if (message.empty()) return socket->abort();
      try {
        socket->send(std::move(message));
      } catch (const std::bad_alloc&) {
        socket->abort();
      }
    });
  });
  auto server = std::unique_ptr<Server>(new Server(std::move(state)));
  if (Result<void> started = raw->thread.start("--serve " + options.at, [raw] { raw->run(); }); !started)
    return started.error();
  return server;
}

std::string Server::address() const {
  return state_->address;
}

std::string Server::link(Access access) const {
  const Tokens& tokens = state_->hub.tokens;
  return state_->address + "/#" + (access == Access::control ? tokens.control : tokens.view);
}

std::vector<Event> Server::take_events() {
  Hub& hub = state_->hub;
  std::vector<Event> events;
  const std::scoped_lock lock(hub.mutex);
  if (hub.events.empty()) return events;
  events.swap(hub.events);
  for (const Event& event : events) {
    if (event.kind == Event::Kind::left) state_->encoder->forget(event.viewer);
  }
  for (auto& [number, viewer] : hub.viewers) {
    viewer.pending = 0;
    if (!std::exchange(viewer.is_paused, false)) continue;
    asio::post(state_->io, [raw = state_.get(), number = number] {
      const auto known = raw->hub.sockets.find(number);
      if (known == raw->hub.sockets.end()) return;
      if (const auto socket = known->second.lock()) socket->resume();
    });
  }
  return events;
}

void Server::report_viewers_again() {
  Hub& hub = state_->hub;
  const std::scoped_lock lock(hub.mutex);
  for (const Event& event : hub.events) {
    if (event.kind == Event::Kind::left) state_->encoder->forget(event.viewer);
  }
  hub.events.clear();  // messages to the frame loop that has ended
  for (auto& [number, viewer] : hub.viewers)
    hub.events.push_back({Event::Kind::joined, number, viewer.access, {}});
}

size_t Server::viewers() const {
  const std::scoped_lock lock(state_->hub.mutex);
  return state_->hub.viewers.size();
}

void Server::send(ViewerId viewer, std::string text) {
  asio::post(state_->io, [raw = state_.get(), viewer, text = std::move(text)]() mutable {
    const auto known = raw->hub.sockets.find(viewer);
    if (known == raw->hub.sockets.end()) return;
    if (const auto socket = known->second.lock()) socket->send(std::move(text));
  });
}

void Server::send_image(ViewerId viewer, Image&& image) {
  state_->encoder->add(viewer, std::move(image));
}

}  // namespace fire3dv::serve
