#include "renderer/browser/server/connection.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "renderer/browser/server/page_files.h"
#include "renderer/browser/server/viewer_socket.h"

namespace fire3dv::serve {
namespace {

namespace http = boost::beast::http;

constexpr uint32_t kMaxHeaderBytes = 16 << 10;
constexpr size_t kMaxBufferBytes = 64 << 10;
constexpr int kMaxRequests = 64;  // of one connection

// Scripts, styles and connections of this server only; nothing inline. Only ?embed=1 allows other local
// pages, such as a notebook's, to show the page in a frame.
constexpr std::string_view kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src "
    "'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors ";
constexpr std::string_view kLocalPages =
    "'self' http://localhost:* http://127.0.0.1:* https://localhost:* https://127.0.0.1:*";

std::string_view view_of(boost::beast::string_view text) {
  return {text.data(), text.size()};
}

std::string_view type_of(std::string_view name) {
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

}  // namespace

Connection::Connection(boost::asio::ip::tcp::socket&& socket, boost::asio::ssl::context* tls, Hub& hub)
    : hub_(hub),
      number_(hub.next_connection++),
      stream_(std::make_unique<Stream>(std::move(socket), tls)),
      deadline_(stream_->get_executor()),
      buffer_(kMaxBufferBytes) {}

Connection::~Connection() {
  hub_.connections.erase(number_);
}

void Connection::start() {
  hub_.connections[number_] = weak_from_this();
  limit_time();
  stream_->async_handshake([self = shared_from_this()](ErrorCode error) {
    if (!error) self->read();
  });
}

void Connection::close() {
  deadline_.cancel();
  ErrorCode ignored;
  if (stream_) stream_->socket().close(ignored);
}

// Ends the connection unless it gets on before this time.
void Connection::limit_time() {
  deadline_.set(hub_.limits.handshake, weak_from_this(), [](Connection& self) { self.close(); });
}

void Connection::read() {
  parser_.emplace();
  parser_->header_limit(kMaxHeaderBytes);
  parser_->body_limit(0);
  limit_time();
  http::async_read(*stream_, buffer_, *parser_,
                   [self = shared_from_this()](ErrorCode error, size_t) { self->on_request(error); });
}

void Connection::on_request(ErrorCode error) {
  if (!error) return answer(parser_->get());
  if (error == http::error::header_limit)
    return write(431, "text/plain", "the header is too long\n", nullptr);
  if (error == http::error::body_limit) return write(413, "text/plain", "requests have no body\n", nullptr);
  const bool is_syntax_error = error.category() == http::make_error_code(http::error::bad_method).category();
  if (is_syntax_error && error != http::error::end_of_stream && error != http::error::partial_message)
    write(400, "text/plain", "this is not HTTP/1.1\n", nullptr);
}

void Connection::answer(const Request& request) {
  if (!is_host_allowed(view_of(request[http::field::host]), hub_.own_host, hub_.tls))
    return write(421, "text/plain",
                 "the Host header must be an IP address, localhost or the host of --serve\n", &request);
  const std::string_view target = view_of(request.target());
  const std::string_view path = target.substr(0, target.find('?'));
  if (request.method() != http::verb::get)
    return write(405, "text/plain", "only GET is answered\n", &request);
  if (path == "/socket") return upgrade(request);
  for (const PageFile& file : page_files()) {
    const bool is_start = path == "/" && file.name == "index.html";
    if (is_start || (path.size() > 1 && path.substr(1) == file.name))
      return write(200, type_of(file.name), file.content, &request);
  }
  write(404, "text/plain", "there is no such page\n", &request);
}

void Connection::upgrade(const Request& request) {
  if (!boost::beast::websocket::is_upgrade(request))
    return write(426, "text/plain", "this is a WebSocket\n", &request);
  if (!is_origin_allowed(view_of(request[http::field::origin]), view_of(request[http::field::host]),
                         hub_.tls))
    return write(403, "text/plain", "another web site may not connect\n", &request);
  deadline_.cancel();
  const auto socket = std::make_shared<ViewerSocket>(std::move(stream_), hub_);
  socket->start(request);
}

void Connection::write(unsigned status, std::string_view type, std::string_view body,
                       const Request* request) {
  response_.emplace(static_cast<http::status>(status), 11);
  response_->set(http::field::content_type, boost::beast::string_view(type.data(), type.size()));
  const bool is_embed = request && is_embedded(view_of(request->target()));
  response_->set("Content-Security-Policy",
                 std::string(kPolicy) + std::string(is_embed ? kLocalPages : std::string_view("'none'")));
  response_->set("X-Content-Type-Options", "nosniff");
  response_->set("Referrer-Policy", "no-referrer");
  response_->set("Cross-Origin-Resource-Policy", "same-origin");
  response_->set(http::field::cache_control, "no-store");
  if (status == 405) response_->set(http::field::allow, "GET");
  const bool keeps = request && request->keep_alive() && ++requests_ < kMaxRequests;
  response_->keep_alive(keeps);
  response_->body() = std::string(body);
  response_->prepare_payload();
  limit_time();
  http::async_write(*stream_, *response_, [self = shared_from_this(), keeps](ErrorCode error, size_t) {
    if (error) return;
    if (keeps) return self->read();
    ErrorCode ignored;
    self->stream_->socket().shutdown(Stream::Socket::shutdown_send, ignored);
  });
}

}  // namespace fire3dv::serve
