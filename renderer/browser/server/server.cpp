#include "renderer/browser/server/server.h"

#include <openssl/ssl.h>

#include <boost/asio/post.hpp>
#include <new>
#include <optional>
#include <utility>

#include "protocol/transport/core/link_thread.h"
#include "protocol/transport/http/accept_loop.h"
#include "protocol/transport/tcp/tcp_connection.h"
#include "renderer/browser/server/connection.h"
#include "renderer/browser/server/encoder.h"
#include "renderer/browser/server/hub.h"
#include "renderer/browser/server/viewer_socket.h"

namespace fire3dv::serve {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

constexpr uint16_t kExamplePort = 8080;

}  // namespace

struct Server::State final : transport::http::ConnectionOwner {
  std::string address;
  Hub hub;  // outlives the accept loop, whose handlers own the connections
  std::optional<asio::ssl::context> tls;
  std::unique_ptr<transport::http::AcceptLoop> loop;
  transport::LinkThread thread;
  std::optional<Encoder> encoder;  // posts to the loop

  size_t open_connections() const override { return hub.open(); }
  void evict() override;
  void serve(tcp::socket&& socket) override;
};

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
  std::make_shared<Connection>(std::move(socket), tls ? &*tls : nullptr, hub)->start();
}

Server::Server(std::unique_ptr<State> state) : state_(std::move(state)) {}

Server::~Server() {
  state_->encoder.reset();
  if (state_->loop) state_->loop->stop();
  state_->thread.stop();
}

Result<std::unique_ptr<Server>> Server::open(const ServerOptions& options) {
  auto state = std::make_unique<State>();
  Hub& hub = state->hub;
  hub.limits = options.limits;
  hub.tls = !options.tls.certificate_file.empty();
  transport::http::ListenOptions listen;
  listen.at = options.at;
  listen.option = "--serve";
  listen.example_port = kExamplePort;
  listen.may_be_public = options.insecure || hub.tls;
  listen.risk = "images and links would cross the network unprotected";
  listen.remedy = "add --tls-cert and --tls-key";
  listen.max_connections = hub.limits.max_connections;
  auto loop = transport::http::AcceptLoop::open(listen, *state);
  if (!loop) return loop.error();
  state->loop = std::move(*loop);
  hub.own_host = state->loop->host();
  state->address = (hub.tls ? "https://" : "http://") + state->loop->address();
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
  State* const raw = state.get();
  raw->encoder.emplace([raw](ViewerId viewer, std::vector<uint8_t>&& message) {
    asio::post(raw->loop->io(), [raw, viewer, message = std::move(message)]() mutable {
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
  if (Result<void> started = raw->thread.start("--serve " + options.at, [raw] { raw->loop->run(); });
      !started)
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
    asio::post(state_->loop->io(), [raw = state_.get(), number = number] {
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

EncodeTotals Server::encode_totals(Codec codec) const {
  return state_->encoder->totals(codec);
}

void Server::send(ViewerId viewer, std::string text) {
  asio::post(state_->loop->io(), [raw = state_.get(), viewer, text = std::move(text)]() mutable {
    const auto known = raw->hub.sockets.find(viewer);
    if (known == raw->hub.sockets.end()) return;
    if (const auto socket = known->second.lock()) socket->send(std::move(text));
  });
}

void Server::send_image(ViewerId viewer, Image&& image) {
  state_->encoder->add(viewer, std::move(image));
}

}  // namespace fire3dv::serve
