#include "protocol/transport/tcp_peer.h"

#include <algorithm>
#include <array>
#include <asio/write.hpp>
#include <utility>

#include "protocol/transport/tcp_socket.h"

namespace fire3dv::transport::tcp {
namespace {

constexpr std::chrono::seconds kGreetingTimeout{5};
// Who begins a message and then sends less than this is holding a place, not sending.
constexpr std::chrono::seconds kProgressEvery{10};
constexpr size_t kLeastProgressBytes = 4 << 10;
constexpr size_t kReadBytes = 64 << 10;
constexpr size_t kMostUnsentBytes = 4 << 20;
constexpr size_t kMostUnsentMessages = 4096;

std::string remote_of(const asio::ip::tcp::socket& socket) {
  asio::error_code error;
  const auto endpoint = socket.remote_endpoint(error);
  return error ? "a peer that is gone already" : endpoint.address().to_string(error);
}

}  // namespace

Peer::Peer(asio::ip::tcp::socket socket, PeerHost& host, MemoryBudget& budget,
           std::unique_ptr<TlsSession> tls)
    : socket_(std::move(socket)),
      host_(host),
      watch_timer_(socket_.get_executor()),
      remote_(remote_of(socket_)),
      tls_(std::move(tls)),
      parser_(&budget) {}

void Peer::start() {
  tune_socket(socket_.native_handle());
  watch();
  read();
}

// Half-open connections, and those that hand over a message byte by byte, lose their place.
void Peer::watch() {
  watch_timer_.expires_after(greeted_ ? kProgressEvery : kGreetingTimeout);
  watch_timer_.async_wait([self = shared_from_this()](const asio::error_code& error) {
    if (error || self->over_) return;
    if (!self->greeted_) return self->end("no greeting came in time", Cause::silent);
    const size_t came = std::exchange(self->bytes_since_watch_, 0);
    if (self->parser_.in_message() && !self->held_back_ && came < kLeastProgressBytes)
      return self->end("it began a message and does not go on with it", Cause::silent);
    self->watch();
  });
}

void Peer::read() {
  if (over_ || !end_after_write_.empty()) return;
  if (greeted_ && host_.hold_back(*this)) {
    held_back_ = true;
    return;
  }
  buffer_.resize(kReadBytes);
  socket_.async_read_some(asio::buffer(buffer_), [self = shared_from_this()](const asio::error_code& error,
                                                                             size_t bytes) {
    if (self->over_) return;
    if (error == asio::error::eof && !self->greeted_)
      return self->end(self->preface_.empty() ? "it left without a greeting" : "its greeting was cut short",
                       Cause::malformed);
    if (error == asio::error::eof) return self->end("the publisher closed the connection");
    if (error) return self->end("the connection broke (" + error.message() + ")");
    // Lack of memory for what one peer sends is that peer's end, and nobody else's.
    try {
      self->took(bytes);
    } catch (const std::exception&) {
      self->end("there is no memory for what it sends", Cause::no_memory);
    }
  });
}

void Peer::took(size_t bytes) {
  host_.received_bytes(bytes);
  bytes_since_watch_ += bytes;
  const std::span<const std::byte> came(buffer_.data(), bytes);
  if (!tls_) {
    take_plain(came);
  } else {
    std::vector<std::byte> to_send;
    plain_.clear();
    const bool sound = tls_->receive(came, plain_, to_send);
    queue(std::move(to_send));
    if (!sound) {
      if (tls_->problem().empty()) return end("the publisher closed the connection");
      end_after_write_ = tls_->problem();
      end_cause_ = Cause::bad_key;
    } else {
      take_plain(plain_);
    }
  }
  write();  // and the end, when it waits for nothing else
  read();
}

void Peer::take_plain(std::span<const std::byte> plain) {
  if (!greeted_) {
    const size_t taken = std::min(plain.size(), kPrefaceBytes - preface_.size());
    preface_.insert(preface_.end(), plain.begin(), plain.begin() + static_cast<std::ptrdiff_t>(taken));
    plain = plain.subspan(taken);
    if (preface_.size() < kPrefaceBytes) return;
    answer_preface();
  }
  if (over_ || !end_after_write_.empty()) return;
  std::optional<Cause> cause;
  const auto fault = parser_.feed(plain, [&](FrameKind kind, std::vector<std::byte>&& message) {
    if (!cause) cause = host_.received(*this, kind, std::move(message));
  });
  if (cause == Cause::no_memory) return end("the messages of all peers together are too large", cause);
  if (cause) return end("it sent more control messages than were read", cause);
  switch (fault) {
    case FrameParser::Fault::none:
      return;
    case FrameParser::Fault::bad_header:
      return end("it sent a damaged frame header", Cause::malformed);
    case FrameParser::Fault::too_long:
      return end("it sent a message of more than 256 MiB", Cause::oversize);
    case FrameParser::Fault::no_memory:
      return end("the messages of all peers together are too large", Cause::no_memory);
  }
}

void Peer::answer_preface() {
  Preface theirs;
  if (!read_preface(std::span(preface_).first<kPrefaceBytes>(), theirs))
    return end("its greeting is not FIRE-3DV's", Cause::malformed);
  greeted_ = true;
  Preface ours;
  ours.status = theirs.version == kTransportVersion ? host_.greet(*this) : PrefaceStatus::version_mismatch;
  if (ours.status == PrefaceStatus::version_mismatch) {
    end_after_write_ = "it speaks transport version " + std::to_string(theirs.version) +
                       ", this program speaks " + std::to_string(kTransportVersion) +
                       "; use the same version on both sides";
    end_cause_ = Cause::version;
  }
  if (ours.status == PrefaceStatus::full) {
    end_after_write_ = "as many peers as allowed are connected";
    end_cause_ = Cause::full;
  }
  const PrefaceBytes bytes = write_preface(ours);
  std::vector<std::byte> wire;
  if (!tls_)
    wire.assign(bytes.begin(), bytes.end());
  else if (!tls_->seal(bytes, wire))
    return end("TLS failed", Cause::bad_key);
  queue(std::move(wire));
}

void Peer::resume() {
  if (!held_back_ || over_) return;
  held_back_ = false;
  bytes_since_watch_ = kLeastProgressBytes;  // the silence was ours
  read();
}

void Peer::queue(std::vector<std::byte>&& bytes) {
  if (bytes.empty()) return;
  outgoing_bytes_ += bytes.size();
  outgoing_.push_back(std::move(bytes));
}

void Peer::send(std::span<const std::byte> message) {
  if (over_) return;
  // An image that is on its way may be long, and does not count.
  if (outgoing_bytes_ - image_bytes_ + message.size() > kMostUnsentBytes ||
      outgoing_.size() >= kMostUnsentMessages)
    return end("it does not read what is sent to it", Cause::unread);
  const auto header = write_frame_header(FrameKind::control, static_cast<uint32_t>(message.size()));
  std::vector<std::byte> wire(header.size() + message.size());
  std::copy(message.begin(), message.end(), std::copy(header.begin(), header.end(), wire.begin()));
  if (tls_) {
    const std::vector<std::byte> plain = std::exchange(wire, {});
    if (!tls_->seal(plain, wire)) return end("TLS failed", Cause::bad_key);
  }
  queue(std::move(wire));
  write();
}

void Peer::send_image(uint64_t request, BudgetedBytes&& block) {
  if (over_ || !greeted_ || !end_after_write_.empty()) return;
  if (const size_t dropped = images_.push(request, std::move(block)).size(); dropped != 0)
    host_.dropped_images(dropped);
  write();
}

// The oldest image goes out when nothing else has to. Its header goes ahead as bytes of its own, so that the
// pixels are not copied for 8 bytes.
bool Peer::queue_image() {
  if (images_.empty()) return false;
  BudgetedBytes image = images_.pop();
  std::vector<std::byte>& block = image.bytes;
  image_share_ = std::move(image.share);
  const auto header = write_frame_header(FrameKind::image, static_cast<uint32_t>(block.size()));
  if (!tls_) {
    image_bytes_ = header.size() + block.size();
    image_pieces_ = 2;
    queue({header.begin(), header.end()});
    queue(std::move(block));
    return true;
  }
  std::vector<std::byte> sealed;
  if (!tls_->seal(header, sealed) || !tls_->seal(block, sealed)) {
    end("TLS failed", Cause::bad_key);
    return false;
  }
  image_bytes_ = sealed.size();
  image_pieces_ = 1;
  queue(std::move(sealed));
  return true;
}

void Peer::write() {
  if (writing_ || over_) return;
  if (outgoing_.empty() && end_after_write_.empty() && !queue_image() && over_) return;
  if (outgoing_.empty()) {
    if (!end_after_write_.empty()) end(std::string(end_after_write_), end_cause_);
    return;
  }
  writing_ = true;
  asio::async_write(socket_, asio::buffer(outgoing_.front()),
                    [self = shared_from_this()](const asio::error_code& error, size_t) {
                      if (self->over_) return;
                      self->writing_ = false;
                      if (error) return self->end("the connection broke (" + error.message() + ")");
                      const size_t gone = self->outgoing_.front().size();
                      self->outgoing_bytes_ -= gone;
                      self->outgoing_.pop_front();
                      if (self->image_pieces_ != 0) {
                        self->image_bytes_ -= gone;
                        if (--self->image_pieces_ == 0) self->image_share_ = {};
                      }
                      self->write();
                    });
}

void Peer::end(const std::string& reason, std::optional<Cause> cause) {
  if (over_) return;
  over_ = true;
  asio::error_code ignored;
  watch_timer_.cancel();
  socket_.shutdown(asio::ip::tcp::socket::shutdown_both, ignored);
  socket_.close(ignored);
  host_.ended(*this, reason, cause);
}

}  // namespace fire3dv::transport::tcp
