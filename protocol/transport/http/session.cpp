#include "protocol/transport/http/session.h"

#include <algorithm>
#include <sstream>

namespace fire3dv::transport::http {
namespace {

namespace beast = boost::beast::http;

constexpr uint32_t kMaxHeaderBytes = 16 << 10;
constexpr size_t kReadBytes = 4 << 10, kMaxBufferBytes = 1 << 20;
constexpr std::chrono::seconds kDrainTime{2};
// A body that comes slower than this makes room for other connections.
constexpr std::chrono::seconds kSlowAfter{1};
constexpr std::chrono::milliseconds kStalledAfter{250};
constexpr double kSlowBytesPerSecond = 64 << 10;
constexpr std::chrono::seconds kReportPeriod{60};
constexpr size_t kMaxReports = 4;  // in a period
constexpr const char* kText = "text/plain; charset=utf-8";

using Response = beast::response<beast::string_body>;

Response response_of(Answer&& answer, bool keep_alive) {
  Response response(static_cast<beast::status>(answer.status), 11);
  response.set(beast::field::content_type, answer.content_type);
  // Bodies may hold untrusted text, which browsers must not take for HTML.
  response.set("X-Content-Type-Options", "nosniff");
  response.set(beast::field::cache_control, "no-store");
  for (const auto& [name, value] : answer.fields) response.set(name, value);
  response.keep_alive(keep_alive);
  response.body() = std::move(answer.body);
  response.prepare_payload();
  return response;
}

// Bytes of other protocols, and lines that end by a line feed alone: the parser could wait for more of them.
bool is_other_protocol(std::string_view header, bool is_start) {
  if (is_start && (header.front() < 0x20 || header.front() > 0x7e)) return true;
  for (size_t end = header.find('\n'); end != std::string_view::npos; end = header.find('\n', end + 1)) {
    if (end == 0 || header[end - 1] != '\r') return true;
  }
  return false;
}

}  // namespace

std::vector<OpenConnection> SessionOwner::list_connections() {
  std::vector<OpenConnection> list;
  for (const auto& [number, session] : open_) {
    list.push_back({session->client(), session->since_, session->use(), [this, number = number] {
                      const auto found = open_.find(number);
                      if (found == open_.end()) return;
                      Session* const closed = found->second;
                      open_.erase(found);
                      ++evicted;
                      closed->close();
                    }});
  }
  return list;
}

bool SessionOwner::charge(Session& session, uint64_t bytes) {
  const auto bytes_of = [this](const std::string& client) {
    uint64_t sum = 0;
    for (const auto& [number, each] : open_) sum += each->client() == client ? each->charged_bytes_ : 0;
    return sum;
  };
  if (limits.max_total_body_bytes != UINT64_MAX) {
    if (bytes_of(session.client()) + bytes > limits.max_total_body_bytes / 2) return false;
    while (bytes > limits.max_total_body_bytes - std::min(body_bytes, limits.max_total_body_bytes)) {
      Session* largest = nullptr;
      uint64_t most = bytes_of(session.client()) + bytes;
      for (const auto& [number, each] : open_) {
        const uint64_t sum = each->receives_body_ && each != &session ? bytes_of(each->client()) : 0;
        if (sum <= most) continue;
        most = sum;
        largest = each;
      }
      if (!largest) return false;
      largest->refuse_for_lack_of_room();
    }
  }
  body_bytes += bytes;
  session.charged_bytes_ += bytes;
  return true;
}

void SessionOwner::serve(boost::asio::ip::tcp::socket&& socket) {
  std::make_shared<Session>(std::move(socket), *this)->start();
}

void SessionOwner::refuse(boost::asio::ip::tcp::socket& socket) {
  std::ostringstream text;
  text << response_of(refusal(503, "too many connections; ask again later"), false);
  boost::system::error_code ignored;
  socket.non_blocking(true, ignored);
  if (!tls_context) socket.write_some(boost::asio::buffer(text.str()), ignored);
}

Answer SessionOwner::refusal(unsigned status, const std::string& text) const {
  return {status, kText, text + "\n"};
}

std::optional<Answer> SessionOwner::check_access(const Request& request) {
  if (!access) return {};
  const auto refused = [this](unsigned status, const std::string& reason) {
    report_refusal(reason);
    return refusal(status, reason);
  };
  const std::string_view host = view_of(request[beast::field::host]);
  if (!access->allows_host(host)) return refused(421, host_refusal(host));
  const bool is_socket = beast::token_list(request[beast::field::upgrade]).exists("websocket");
  const bool is_checked = is_socket || (access->clients == AccessRules::Clients::programs &&
                                        request.count(beast::field::origin) > 0);
  const std::string_view origin = view_of(request[beast::field::origin]);
  if (is_checked && !access->allows_origin(origin, host)) return refused(403, origin_refusal(origin));
  return {};
}

void SessionOwner::report_refusal(const std::string& reason) {
  if (!access || !access->options.log) return;
  const auto now = std::chrono::steady_clock::now();
  if (now - reported_since_ > kReportPeriod) {
    reported_.clear();
    reported_since_ = now;
  }
  if (reported_.size() >= kMaxReports || std::ranges::find(reported_, reason) != reported_.end()) {
    ++unreported_;
    return;
  }
  reported_.push_back(reason);
  const uint64_t more = std::exchange(unreported_, 0);
  access->options.log("a request was refused: " + reason +
                      (more > 0 ? " (" + std::to_string(more) + " more before)" : ""));
}

Session::Session(boost::asio::ip::tcp::socket&& socket, SessionOwner& owner)
    : owner_(owner),
      number_(owner.next_number_++),
      stream_(std::make_unique<Stream>(std::move(socket), owner.tls_context)),
      client_(stream_->client()),
      since_(stream_->since()),
      deadline_(stream_->get_executor()),
      buffer_(kMaxBufferBytes) {
  owner_.open_.emplace(number_, this);
}

Session::~Session() {
  owner_.body_bytes -= charged_bytes_;
  owner_.open_.erase(number_);
}

void Session::start() {
  limit_time(owner_.limits.header_timeout);
  stream_->async_handshake([self = shared_from_this()](ErrorCode error) {
    if (!error) self->read_header();
  });
}

void Session::close() {
  deadline_.cancel();
  ErrorCode ignored;
  if (stream_) stream_->socket().close(ignored);
}

// Ends the pending read or write after this time.
void Session::limit_time(std::chrono::steady_clock::duration time) {
  is_over_time_ = false;
  deadline_.set(time, weak_from_this(), [](Session& self) {
    self.is_over_time_ = true;
    ErrorCode ignored;
    if (self.stream_) self.stream_->socket().cancel(ignored);
  });
}

std::string_view Session::path() const {
  const std::string_view target = view_of(request().target());
  return target.substr(0, target.find('?'));
}

std::string_view Session::field(beast::field name) const {
  return view_of(request()[name]);
}

std::optional<uint64_t> Session::content_length() const {
  const auto length = parser_->content_length();
  return length && !parser_->chunked() ? std::optional<uint64_t>(*length) : std::nullopt;
}

std::unique_ptr<Stream> Session::release_stream() {
  deadline_.cancel();
  owner_.open_.erase(number_);
  return std::move(stream_);
}

void Session::read_header() {
  is_idle_ = true;
  parser_.emplace();
  parser_->header_limit(kMaxHeaderBytes);
  parser_->body_limit(owner_.limits.max_body_bytes);
  limit_time(owner_.limits.header_timeout);
  parse_header();
}

void Session::parse_header() {
  if (buffer_.size() > 0) {
    const std::string_view bytes(static_cast<const char*>(buffer_.data().data()), buffer_.size());
    const size_t end = bytes.find("\r\n\r\n");
    if (is_other_protocol(bytes.substr(0, end), !parser_->got_some()))
      return refuse(beast::error::bad_method);
    ErrorCode error;
    buffer_.consume(parser_->put(buffer_.data(), error));
    // The parser waits for a version of full length, even if the header ends before.
    if (error == beast::error::need_more && end != std::string_view::npos)
      error = beast::error::bad_line_ending;
    if (error && error != beast::error::need_more) return refuse(error);
    if (!error) {
      is_idle_ = false;
      if (std::optional<Answer> refused = owner_.check_access(request())) return answer(std::move(*refused));
      return owner_.on_header(*this);
    }
  }
  stream_->async_read_some(buffer_.prepare(kReadBytes),
                           [self = shared_from_this()](ErrorCode error, size_t count) {
                             if (error) return self->on_read_error(error);
                             self->buffer_.commit(count);
                             self->parse_header();
                           });
}

OpenConnection::Use Session::use() const {
  if (!receives_body_) return is_idle_ ? OpenConnection::Use::idle : OpenConnection::Use::kept;
  const auto now = std::chrono::steady_clock::now();
  const auto age = now - body_since_;
  const bool is_slow =
      now - body_grew_ > kStalledAfter ||
      (age > kSlowAfter && static_cast<double>(charged_bytes_) <
                               kSlowBytesPerSecond * std::chrono::duration<double>(age).count());
  return is_slow ? OpenConnection::Use::slow : OpenConnection::Use::receiving;
}

void Session::read_body() {
  receives_body_ = true;
  body_since_ = body_grew_ = std::chrono::steady_clock::now();
  continue_body();
}

// Piece by piece: what has only been announced is not charged.
void Session::continue_body() {
  if (parser_->is_done()) {
    receives_body_ = false;
    deadline_.cancel();
    return owner_.on_body(*this);
  }
  const auto left = body_since_ + owner_.limits.body_timeout - std::chrono::steady_clock::now();
  limit_time(std::min<std::chrono::steady_clock::duration>(left, owner_.limits.body_silence));
  beast::async_read_some(*stream_, buffer_, *parser_, [self = shared_from_this()](ErrorCode error, size_t) {
    if (!self->receives_body_) return;  // refused meanwhile
    if (error) return self->on_read_error(error);
    const uint64_t arrived = self->parser_->get().body().size() - self->charged_bytes_;
    if (arrived > 0) self->body_grew_ = std::chrono::steady_clock::now();
    if (!self->owner_.charge(*self, arrived)) return self->refuse_for_lack_of_room();
    self->continue_body();
  });
}

void Session::refuse_for_lack_of_room() {
  receives_body_ = false;
  ErrorCode ignored;
  stream_->socket().cancel(ignored);
  answer(owner_.refusal(503, "too many requests are being received; ask again later"));
}

void Session::on_read_error(ErrorCode error) {
  if (is_over_time_) {
    if (parser_->got_some() || buffer_.size() > 0)
      return answer(owner_.refusal(408, "the request did not arrive in time"));
    owner_.timed_out += requests_ == 0 ? 1 : 0;
    return;
  }
  const bool is_fault = error.category() == beast::make_error_code(beast::error::bad_method).category();
  if (is_fault && error != beast::error::end_of_stream && error != beast::error::partial_message)
    refuse(error);  // else the connection has ended
}

void Session::refuse(ErrorCode error) {
  const auto refused = [&](unsigned status, const std::string& text) {
    answer(owner_.refusal(status, text));
  };
  if (error == beast::error::header_limit)
    return refused(431, "the request's header exceeds " + std::to_string(kMaxHeaderBytes) + " bytes");
  if (error == beast::error::body_limit)
    return refused(413, "the request exceeds the limit of " +
                            std::to_string(owner_.limits.max_body_bytes >> 20) + " MiB");
  if (error == beast::error::bad_version) return refused(505, "the request is not HTTP/1.1");
  refused(400, "the request is not HTTP/1.1: " + error.message());
}

void Session::answer(Answer&& answer) {
  owner_.body_bytes -= std::exchange(charged_bytes_, 0);
  receives_body_ = false;
  ++owner_.answered[answer.status];
  is_idle_ = false;
  const bool keeps_alive =
      ++requests_ < owner_.limits.max_requests && parser_->is_done() && parser_->get().keep_alive();
  response_ = response_of(std::move(answer), keeps_alive);
  limit_time(owner_.limits.write_timeout);
  beast::async_write(*stream_, *response_, [self = shared_from_this(), keeps_alive](ErrorCode error, size_t) {
    if (error) return;
    if (keeps_alive) return self->read_header();
    ErrorCode ignored;
    self->stream_->socket().shutdown(Stream::Socket::shutdown_send, ignored);
    self->limit_time(kDrainTime);
    self->is_idle_ = true;
    self->drain();
  });
}

// Reads what the client still sends, for a moment: a reset could overtake the answer.
void Session::drain() {
  buffer_.clear();
  stream_->async_read_some(buffer_.prepare(kMaxBufferBytes),
                           [self = shared_from_this()](ErrorCode error, size_t) {
                             if (!error) self->drain();
                           });
}

}  // namespace fire3dv::transport::http
