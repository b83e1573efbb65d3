#include "renderer/browser/server/viewer_socket.h"

#include <algorithm>
#include <string_view>
#include <utility>

namespace fire3dv::serve {
namespace {

namespace websocket = boost::beast::websocket;
using Clock = std::chrono::steady_clock;

}  // namespace

ViewerSocket::ViewerSocket(std::unique_ptr<transport::http::Stream> stream, Hub& hub)
    : hub_(hub),
      number_(hub.next_viewer++),
      stream_(std::move(stream)),
      socket_(*stream_),
      timer_(stream_->get_executor()),
      credit_(hub.limits.max_messages_per_second),
      credited_(Clock::now()) {}

ViewerSocket::~ViewerSocket() {
  hub_.sockets.erase(number_);
  hub_.leave(number_);
}

void ViewerSocket::start(const transport::http::Session::Request& request) {
  hub_.sockets[number_] = weak_from_this();
  websocket::stream_base::timeout timeout;
  timeout.handshake_timeout = hub_.limits.handshake;
  timeout.idle_timeout = hub_.limits.idle;
  timeout.keep_alive_pings = true;
  socket_.set_option(timeout);
  socket_.read_message_max(kMaxMessageBytes);
  timer_.expires_after(hub_.limits.handshake);
  timer_.async_wait([weak = weak_from_this()](ErrorCode error) {
    const std::shared_ptr<ViewerSocket> self = weak.lock();
    if (!error && self && self->access_ == Access::none) self->abort();
  });
  socket_.async_accept(request, [self = shared_from_this()](ErrorCode error) {
    if (!error) self->read();
  });
}

void ViewerSocket::abort() {
  is_closing_ = true;
  hub_.leave(number_);
  ErrorCode ignored;
  stream_->socket().close(ignored);
}

void ViewerSocket::read() {
  is_reading_ = true;
  buffer_.clear();
  socket_.async_read(buffer_, [self = shared_from_this()](ErrorCode error, size_t) { self->on_read(error); });
}

void ViewerSocket::on_read(ErrorCode error) {
  is_reading_ = false;
  if (error || is_closing_) return;  // the last handler ends this object
  const boost::asio::const_buffer bytes = buffer_.data();
  if (!socket_.got_text()) return close(websocket::close_code::unknown_data, "messages are text");
  if (!take({static_cast<const char*>(bytes.data()), bytes.size()})) return;
  wait_for_rate();
}

bool ViewerSocket::take(std::string_view text) {
  Result<ClientMessage> message = parse_message(text);
  if (!message) {
    close(websocket::close_code::policy_error, message.error().message);
    return false;
  }
  if (access_ == Access::none) return take_hello(*message);
  if (message->kind == ClientMessage::Kind::hello) {
    close(websocket::close_code::policy_error, "hello comes once");
    return false;
  }
  if (needs_control(message->kind) && access_ != Access::control)
    return true;  // the page offers none of these
  if (hub_.push(number_, std::move(*message))) return true;
  wait_for_frame_loop();
  return false;
}

// Keeps this object while nothing else does.
void ViewerSocket::wait_for_frame_loop() {
  timer_.expires_after(hub_.limits.idle);
  timer_.async_wait([self = shared_from_this()](ErrorCode error) {
    if (!error && !self->is_closing_) self->wait_for_frame_loop();
  });
}

bool ViewerSocket::take_hello(const ClientMessage& message) {
  const bool is_hello = message.kind == ClientMessage::Kind::hello;
  const Access access = is_hello ? access_of(hub_.tokens, message.token) : Access::none;
  if (access == Access::none) {
    close(static_cast<CloseCode>(4401), "the link's token is wrong: use the link that fire3dv printed");
    return false;
  }
  if (!hub_.join(number_, access)) {
    close(websocket::close_code::try_again_later, "there are too many viewers");
    return false;
  }
  access_ = access;
  timer_.cancel();
  return true;
}

// Token bucket: a faster viewer is read more slowly, which TCP passes on to it.
void ViewerSocket::wait_for_rate() {
  const Clock::time_point now = Clock::now();
  const double rate = hub_.limits.max_messages_per_second;
  credit_ = std::min(rate, credit_ + rate * std::chrono::duration<double>(now - credited_).count()) - 1;
  credited_ = now;
  if (credit_ >= 0) return read();
  timer_.expires_after(std::chrono::microseconds(static_cast<int64_t>(-credit_ / rate * 1e6) + 1));
  timer_.async_wait([self = shared_from_this()](ErrorCode error) {
    if (!error && !self->is_closing_) self->read();
  });
}

void ViewerSocket::resume() {
  if (is_reading_ || is_closing_) return;
  timer_.cancel();
  wait_for_rate();
}

void ViewerSocket::send(std::string&& text) {
  queue({true, std::move(text), {}});
}

void ViewerSocket::send(std::vector<uint8_t>&& binary) {
  queue({false, {}, std::move(binary)});
}

void ViewerSocket::queue(Outgoing&& outgoing) {
  if (is_closing_) return;
  queued_bytes_ += outgoing.bytes();
  queue_.push_back(std::move(outgoing));
  if (queued_bytes_ > hub_.limits.max_queued_bytes) return abort();
  if (!is_writing_) write();
}

void ViewerSocket::write() {
  is_writing_ = true;
  const Outgoing& next = queue_.front();
  socket_.text(next.is_text);
  const auto bytes = next.is_text ? boost::asio::buffer(next.text) : boost::asio::buffer(next.binary);
  socket_.async_write(bytes, [self = shared_from_this()](ErrorCode error, size_t) {
    self->is_writing_ = false;
    if (error) return self->abort();
    self->queued_bytes_ -= self->queue_.front().bytes();
    self->queue_.pop_front();
    if (!self->queue_.empty() && !self->is_closing_) self->write();
  });
}

// A close frame may follow a message that is being written: Beast orders them.
void ViewerSocket::close(CloseCode code, std::string reason) {
  if (std::exchange(is_closing_, true)) return;
  hub_.leave(number_);
  constexpr size_t kMaxReasonBytes = 120;
  websocket::close_reason why(code);
  reason.resize(std::min(reason.size(), kMaxReasonBytes));
  why.reason = reason;
  timer_.expires_after(hub_.limits.handshake);
  timer_.async_wait([weak = weak_from_this()](ErrorCode error) {
    if (const std::shared_ptr<ViewerSocket> self = weak.lock(); !error && self) self->abort();
  });
  socket_.async_close(why, [self = shared_from_this()](ErrorCode) { self->timer_.cancel(); });
}

}  // namespace fire3dv::serve
