#include "renderer/browser/server/server.h"

#include <openssl/evp.h>
#include <openssl/sha.h>
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
constexpr std::string_view kIndex = "index.html", kSocket = "socket";
constexpr const char* kNoUpgrade =
    "a WebSocket came without the header Upgrade: the proxy must pass Upgrade and Connection on (see "
    "docs/browser.md)";

// Scripts, styles and connections of this server only. Inline is one script alone, by its hash. Only ?embed=1
// allows other pages, such as a notebook's, to show the page in a frame: local ones, and those allowed.
constexpr std::string_view kPolicyBegin = "default-src 'none'; script-src 'self' ";
constexpr std::string_view kPolicyEnd =
    "; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; base-uri 'none'; form-action "
    "'none'; "
    "frame-ancestors ";
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

// Source expression of the page's inline script, which adds the / that an address below a proxy's path lacks.
std::string hash_inline_script() {
  constexpr std::string_view kBegin = "<script>", kEnd = "</script>";
  for (const PageFile& file : page_files()) {
    const size_t begin = file.name == kIndex ? file.content.find(kBegin) : std::string_view::npos;
    if (begin == std::string_view::npos) continue;
    const std::string_view from = file.content.substr(begin + kBegin.size());
    const std::string_view script = from.substr(0, from.find(kEnd));
    unsigned char digest[SHA256_DIGEST_LENGTH], text[64] = {};
    ::SHA256(reinterpret_cast<const unsigned char*>(script.data()), script.size(), digest);
    ::EVP_EncodeBlock(text, digest, sizeof digest);
    return "'sha256-" + std::string(reinterpret_cast<const char*>(text)) + "'";
  }
  return "";
}

http::Answer secured(unsigned status, const char* type, std::string_view body,
                     std::string_view frame_ancestors = "'none'") {
  static const std::string policy =
      std::string(kPolicyBegin) + hash_inline_script() + std::string(kPolicyEnd);
  return {status,
          type,
          std::string(body),
          {{"Content-Security-Policy", policy + std::string(frame_ancestors)},
           {"Referrer-Policy", "no-referrer"},
           {"Cross-Origin-Resource-Policy", "same-origin"}}};
}

// Proxies may leave their own path before that of the page, or double slashes.
std::string_view last_part(std::string_view path) {
  return path.substr(path.rfind('/') + 1);
}

}  // namespace

struct Server::State final : http::SessionOwner {
  explicit State(const ServerLimits& server_limits)
      : SessionOwner({0, 64, server_limits.handshake, server_limits.handshake, server_limits.handshake}) {
    hub.limits = server_limits;
  }

  std::string address;
  Hub hub;  // outlives the accept loop, whose handlers own the connections
  std::optional<asio::ssl::context> tls;
  std::unique_ptr<http::AcceptLoop> loop;
  transport::LinkThread thread;
  std::optional<Encoder> encoder;            // posts to the loop
  std::string frame_ancestors{kLocalPages};  // pages that may show this one in a frame with ?embed=1

  void use_tls(SSL_CTX* context) { tls_context = &tls.emplace(context); }
  void set_access(http::AccessRules&& rules) { access = std::move(rules); }
  size_t open_connections() const override { return SessionOwner::open_connections() + hub.sockets.size(); }
  std::vector<http::OpenConnection> list_connections() override;
  void on_header(http::Session& session) override;
  http::Answer refusal(unsigned status, const std::string& text) const override {
    return secured(status, kText, text + "\n");
  }

 private:
  http::Answer answer_to(const http::Session& session) const;
  http::Answer answer_without_upgrade(const http::Session& session) const;
};

// Viewers stay; WebSockets that have not shown a token make room for a new connection.
std::vector<http::OpenConnection> Server::State::list_connections() {
  std::vector<http::OpenConnection> list = SessionOwner::list_connections();
  for (const auto& [number, known] : hub.sockets) {
    const std::shared_ptr<ViewerSocket> socket = known.lock();
    if (!socket) continue;
    using Use = http::OpenConnection::Use;
    list.push_back({socket->client(), socket->since(), socket->has_joined() ? Use::kept : Use::idle,
                    [this, number = number, known = known] {
                      hub.sockets.erase(number);
                      if (const auto closed = known.lock()) closed->abort();
                    }});
  }
  return list;
}

void Server::State::on_header(http::Session& session) {
  const bool is_socket = last_part(session.path()) == kSocket;
  if (is_socket && boost::beast::websocket::is_upgrade(session.request())) {
    std::make_shared<ViewerSocket>(session.release_stream(), hub)->start(session.request());
    return;
  }
  // Proxies that pass no upgrade headers on leave the key.
  if (is_socket && session.request().count(beast::field::sec_websocket_key) > 0) report_refusal(kNoUpgrade);
  session.answer(answer_to(session));
}

http::Answer Server::State::answer_to(const http::Session& session) const {
  if (session.request().method() != beast::verb::get) {
    http::Answer answer = refusal(405, "only GET is answered");
    answer.fields.emplace_back("Allow", "GET");
    return answer;
  }
  const std::string_view name = last_part(session.path());
  if (name == kSocket) return answer_without_upgrade(session);
  for (const PageFile& file : page_files()) {
    if (file.name == (name.empty() ? kIndex : name))
      return secured(200, type_of(file.name), file.content,
                     is_embedded(http::view_of(session.request().target())) ? frame_ancestors : "'none'");
  }
  return refusal(404, "there is no such page; the address of the live view's page ends with /");
}

// The page asks this way why its WebSocket was refused, as browsers do not show a script that answer. A GET
// of a page's own origin has no Origin header, so the page says it.
http::Answer Server::State::answer_without_upgrade(const http::Session& session) const {
  constexpr std::string_view kQuery = "?origin=";
  const std::string_view target = http::view_of(session.request().target());
  const size_t query = target.find(kQuery);
  if (query != std::string_view::npos) {
    const std::string_view origin = target.substr(query + kQuery.size());
    const bool is_encoded = origin.find('%') != std::string_view::npos;  // by a proxy
    if (!is_encoded && !access->allows_origin(origin, session.field(beast::field::host)))
      return refusal(403, http::origin_refusal(origin));
  }
  http::Answer answer = refusal(426, kNoUpgrade);
  answer.fields.emplace_back("Upgrade", "websocket");
  answer.fields.emplace_back("Connection", "upgrade");
  return answer;
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
  for (const std::string& origin : options.access.sites.origins) state->frame_ancestors += " " + origin;
  state->set_access({.own_host = state->loop->host(), .has_tls = has_tls, .options = options.access});
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
