#include "programs/drake/http/session.h"

#include <algorithm>
#include <boost/asio/post.hpp>
#include <string_view>
#include <utility>

namespace fire3dv::drake {
namespace {

namespace http = boost::beast::http;
using boost::asio::ip::tcp;

constexpr uint32_t kMaxHeaderBytes = 16 << 10;
constexpr size_t kReadBufferBytes = 1 << 20;
constexpr std::chrono::seconds kDrainTime{2};
constexpr std::string_view kAbout =
    "FIRE-3DV renders here for Drake: RenderEngineGltfClient posts its scenes to /render.\n";

std::string_view view_of(boost::beast::string_view text) {
  return {text.data(), text.size()};
}

bool is_form(std::string_view content_type) {
  constexpr std::string_view kForm = "multipart/form-data";
  return content_type.size() >= kForm.size() &&
         std::equal(kForm.begin(), kForm.end(), content_type.begin(),
                    [](char a, char b) { return a == (b >= 'A' && b <= 'Z' ? b - 'A' + 'a' : b); });
}

}  // namespace

bool Sessions::evict_idle() {
  for (const auto& [number, session] : open) {
    if (!session->is_idle()) continue;
    session->close();
    open.erase(number);
    return true;
  }
  return false;
}

Session::Session(tcp::socket socket, Sessions& sessions)
    : sessions_(sessions),
      number_(sessions.next_number++),
      socket_(std::move(socket)),
      deadline_(socket_.get_executor()),
      buffer_(kReadBufferBytes) {
  sessions_.open.emplace(number_, this);
}

Session::~Session() {
  release_bytes();
  sessions_.open.erase(number_);
}

void Session::release_bytes() {
  sessions_.body_bytes -= std::exchange(charged_bytes_, 0);
}

void Session::close() {
  ErrorCode ignored;
  deadline_.cancel();
  socket_.close(ignored);
}

// Ends the pending read or write after this time.
void Session::limit_time(std::chrono::seconds seconds) {
  timed_out_ = false;
  deadline_.set(seconds, weak_from_this(), [](Session& self) {
    self.timed_out_ = true;
    ErrorCode ignored;
    self.socket_.cancel(ignored);
  });
}

void Session::read_header() {
  is_idle_ = true;
  parser_.emplace();
  parser_->header_limit(kMaxHeaderBytes);
  parser_->body_limit(sessions_.limits.max_body_bytes);
  limit_time(sessions_.limits.header_timeout);
  http::async_read_header(socket_, buffer_, *parser_,
                          [self = shared_from_this()](ErrorCode error, size_t) { self->on_header(error); });
}

void Session::on_header(ErrorCode error) {
  if (error) return on_read_error(error);
  is_idle_ = false;
  if (std::optional<HttpAnswer> answer = answer_to_header()) return write(std::move(*answer), false);
  read_body();
}

std::optional<HttpAnswer> Session::answer_to_header() const {
  const auto& header = parser_->get();
  const std::string_view target = view_of(header.target());
  const std::string_view path = target.substr(0, target.find('?'));
  if (path == "/" && header.method() == http::verb::get)
    return HttpAnswer{200, "text/plain; charset=utf-8", std::string(kAbout)};
  if (path != "/render") return http_error(404, "the only endpoint is /render");
  if (header.method() != http::verb::post) return http_error(405, "/render takes POST only");
  if (!is_form(view_of(header[http::field::content_type])))
    return http_error(415, "the Content-Type must be multipart/form-data");
  const auto length = parser_->content_length();
  if (!length || parser_->chunked()) return http_error(411, "the request must have a Content-Length");
  if (*length > sessions_.limits.max_total_bytes - sessions_.body_bytes)
    return http_error(503, "too many requests are being received; ask again later");
  return std::nullopt;
}

void Session::read_body() {
  charged_bytes_ = *parser_->content_length();
  sessions_.body_bytes += charged_bytes_;
  limit_time(sessions_.limits.body_timeout);
  http::async_read(socket_, buffer_, *parser_,
                   [self = shared_from_this()](ErrorCode error, size_t) { self->on_body(error); });
}

void Session::on_body(ErrorCode error) {
  if (error) return on_read_error(error);
  deadline_.cancel();
  http::request<http::string_body> message = parser_->release();
  parser_.reset();
  const bool keep_alive = message.keep_alive();
  HttpRequest request{std::string(view_of(message[http::field::content_type])), std::move(message.body())};
  // The session is handed on as a whole, so that it ends on this thread.
  sessions_.handler(std::move(request), [self = shared_from_this(), keep_alive](HttpAnswer&& answer) mutable {
    const auto executor = self->socket_.get_executor();
    boost::asio::post(executor, [self = std::move(self), keep_alive, answer = std::move(answer)]() mutable {
      self->write(std::move(answer), keep_alive);
    });
  });
}

void Session::on_read_error(ErrorCode error) {
  if (timed_out_) {
    if (is_idle_ && buffer_.size() == 0) return;  // between two requests
    return write(http_error(408, "the request did not arrive in time"), false);
  }
  if (error == http::error::body_limit)
    return write(http_error(413, "the request is larger than the limit of " +
                                     std::to_string(sessions_.limits.max_body_bytes >> 20) +
                                     " MiB; raise it with --max-request"),
                 false);
  if (error == http::error::header_limit)
    return write(
        http_error(431, "the request's header exceeds " + std::to_string(kMaxHeaderBytes) + " bytes"), false);
  const bool is_syntax_error = error.category() == http::make_error_code(http::error::bad_method).category();
  if (!is_syntax_error || error == http::error::end_of_stream || error == http::error::partial_message)
    return;  // the connection ended
  write(http_error(400, "the request is not HTTP/1.1: " + error.message()), false);
}

void Session::write(HttpAnswer&& answer, bool keep_alive) {
  release_bytes();
  response_.emplace(static_cast<http::status>(answer.status), 11);
  response_->set(http::field::server, "fire3dv-drake");
  response_->set(http::field::content_type, answer.content_type);
  if (answer.status == 405) response_->set(http::field::allow, "POST");
  response_->keep_alive(keep_alive);
  response_->body() = std::move(answer.body);
  response_->prepare_payload();
  limit_time(sessions_.limits.write_timeout);
  http::async_write(socket_, *response_, [self = shared_from_this(), keep_alive](ErrorCode error, size_t) {
    if (error) return;
    if (keep_alive) return self->read_header();
    ErrorCode ignored;
    self->socket_.shutdown(tcp::socket::shutdown_send, ignored);
    self->limit_time(kDrainTime);
    self->is_idle_ = true;
    self->drain();
  });
}

// Reads what the client still sends, for a moment: a reset could overtake the answer.
void Session::drain() {
  buffer_.clear();
  socket_.async_read_some(buffer_.prepare(kReadBufferBytes),
                          [self = shared_from_this()](ErrorCode error, size_t) {
                            if (!error) self->drain();
                          });
}

}  // namespace fire3dv::drake
