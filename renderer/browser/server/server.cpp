#include "renderer/browser/server/server.h"

#include <openssl/ssl.h>

#include <boost/asio/post.hpp>
#include <new>
#include <optional>
#include <string_view>
#include <utility>

#include "protocol/transport/core/link_thread.h"
#include "protocol/transport/http/session.h"
#include "protocol/transport/tcp/tcp_connection.h"
#include "renderer/browser/server/encoder.h"
#include "renderer/browser/server/hub.h"
#include "renderer/browser/server/page_files.h"
#include "renderer/browser/server/viewer_socket.h"

namespace fire3dv::serve {
namespace {

namespace asio = boost::asio;

namespace beast = boost::beast::http;
namespace http = transport::http;

constexpr uint16_t kExamplePort = 8080;
constexpr const char* kText = "text/plain";

// Scripts, styles and connections of this server only; nothing inline. Only ?embed=1 allows other local
// pages, such as a notebook's, to show the page in a frame.
constexpr std::string_view kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src "
    "'self'; base-uri 'none'; form-action 'none'; frame-ancestors ";
constexpr std::string_view kLocalPages =
    "'self' http://localhost:* http://127.0.0.1:* https://localhost:* https://127.0.0.1:*";

const char* type_of(std::string_view name) {
  if (name.ends_with(".js")) return "text/javascript; charset=utf-8";
  if (name.ends_with(".css")) return "text/css; charset=utf-8";
  if (name.ends_with(".svg")) return "image/svg+xml";
  return "text/html; charset=utf-8";
}

bool is_embedded(std::string_view target) {
  const size_t query = target.find('?');
  if (query == std::string_view::npos) return false;
  return ("&" + std::string(target.substr(query + 1)) + "&").find("&embed=1&") != std::string::npos;
}

http::Answer secured(unsigned status, const char* type, std::string_view body, bool is_in_frame = false) {
  return {status,
          type,
          std::string(body),
          {{"Content-Security-Policy",
            std::string(kPolicy) + std::string(is_in_frame ? kLocalPages : std::string_view("'none'"))},
           {"Referrer-Policy", "no-referrer"},
           {"Cross-Origin-Resource-Policy", "same-origin"}}};
}

}  // namespace

struct Server::State final : http::SessionOwner {
  explicit State(const ServerLimits& server_limits)
      : SessionOwner({0, 64, server_limits.handshake, server_limits.handshake, server_limits.handshake}) {
    hub.limits = server_limits;
  }

  std::string address, own_host;
  Hub hub;  // outlives the accept loop, whose handlers own the connections
  std::optional<asio::ssl::context> tls;
  std::unique_ptr<http::AcceptLoop> loop;
  transport::LinkThread thread;
  std::optional<Encoder> encoder;  // posts to the loop

  void use_tls(SSL_CTX* context) { tls_context = &tls.emplace(context); }
  size_t open_connections() const override { return SessionOwner::open_connections() + hub.sockets.size(); }
  void evict() override;
  void on_header(http::Session& session) override;
  http::Answer refusal(unsigned status, const std::string& text) const override {
    return secured(status, kText, text + "\n");
  }

 private:
  http::Answer answer_to(const http::Session& session) const;
};

// The oldest connection without a token makes room for a new one.
void Server::State::evict() {
  const size_t before = open_connections();
  SessionOwner::evict();
  if (open_connections() < before) return;
  for (const auto& [number, known] : hub.sockets) {
    const std::shared_ptr<ViewerSocket> socket = known.lock();
    if (!socket || socket->has_joined()) continue;
    hub.sockets.erase(number);
    return socket->abort();
  }
}

void Server::State::on_header(http::Session& session) {
  const std::string_view host = session.field(beast::field::host);
  if (!is_host_allowed(host, own_host, tls.has_value()))
    return session.answer(
        refusal(421, "the Host header must be an IP address, localhost or the host of --serve"));
  if (session.path() != "/socket" || !boost::beast::websocket::is_upgrade(session.request()))
    return session.answer(answer_to(session));
  if (!is_origin_allowed(session.field(beast::field::origin), host, tls.has_value()))
    return session.answer(refusal(403, "another web site may not connect"));
  std::make_shared<ViewerSocket>(session.release_stream(), hub)->start(session.request());
}

http::Answer Server::State::answer_to(const http::Session& session) const {
  if (session.request().method() != beast::verb::get) {
    http::Answer answer = refusal(405, "only GET is answered");
    answer.fields.emplace_back("Allow", "GET");
    return answer;
  }
  const std::string_view path = session.path();
  if (path == "/socket") return refusal(426, "this is a WebSocket");
  for (const PageFile& file : page_files()) {
    const bool is_start = path == "/" && file.name == "index.html";
    if (is_start || (path.size() > 1 && path.substr(1) == file.name))
      return secured(200, type_of(file.name), file.content,
                     is_embedded(http::view_of(session.request().target())));
  }
  return refusal(404, "there is no such page");
}

Server::Server(std::unique_ptr<State> state) : state_(std::move(state)) {}

Server::~Server() {
  state_->encoder.reset();
  if (state_->loop) state_->loop->stop();
  state_->thread.stop();
}

Result<std::unique_ptr<Server>> Server::open(const ServerOptions& options) {
  auto state = std::make_unique<State>(options.limits);
  Hub& hub = state->hub;
  const bool has_tls = !options.tls.certificate_file.empty();
  http::ListenOptions listen;
  listen.at = options.at;
  listen.option = "--serve";
  listen.example_port = kExamplePort;
  listen.may_be_public = options.insecure || has_tls;
  listen.risk = "images and links would cross the network unprotected";
  listen.remedy = "add --tls-cert and --tls-key";
  listen.max_connections = hub.limits.max_connections;
  auto loop = http::AcceptLoop::open(listen, *state);
  if (!loop) return loop.error();
  state->loop = std::move(*loop);
  state->own_host = state->loop->host();
  state->address = (has_tls ? "https://" : "http://") + state->loop->address();
  if (has_tls) {
    Result<transport::tcp::TlsContext> context =
        transport::tcp::make_server_context("--serve " + options.at, options.tls);
    if (!context) return context.error();
    ::SSL_CTX_up_ref(context->get());
    state->use_tls(context->get());
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
