#include "protocol/transport/tcp/tcp_peer.h"

#include <algorithm>
#include <asio/write.hpp>
#include <new>
#include <utility>

#include "base/clock.h"

namespace fire3dv::transport::tcp {
namespace {

constexpr std::chrono::seconds kGreetingTimeout{5};
// Minimum throughput of a peer with an incomplete message: a slower one only occupies a connection.
constexpr std::chrono::seconds kProgressEvery{10};
constexpr size_t kLeastProgressBytes = 4 << 10;
constexpr size_t kReadBytes = 64 << 10;

std::string remote_of(const asio::ip::tcp::socket& socket) {
  asio::error_code error;
  const auto endpoint = socket.remote_endpoint(error);
  return error ? "a peer that is gone already" : endpoint.address().to_string(error);
}

}  // namespace

Peer::Peer(asio::ip::tcp::socket socket, PeerHost& host, BudgetCharge half_open,
           std::unique_ptr<TlsSession> tls)
    : socket_(std::move(socket)),
      host_(host),
      watch_timer_(socket_.get_executor()),
      remote_(remote_of(socket_)),
      half_open_(std::move(half_open)),
      tls_(std::move(tls)),
      parser_([this](size_t bytes) { return charge_message(bytes); }),
      heard_at_ns_(monotonic_ns()) {}

void Peer::start() {
  tune_socket(socket_.native_handle());
  watch();
  read();
}

// Ends half-open connections, and those that send a message too slowly.
void Peer::watch() {
  watch_timer_.expires_after(greeted_ ? kProgressEvery : kGreetingTimeout);
  watch_timer_.async_wait([self = shared_from_this()](const asio::error_code& error) {
    if (error || self->over_) return;
    if (!self->greeted_) return self->end("no greeting came in time", Cause::silent);
    const size_t came = std::exchange(self->bytes_since_watch_, 0);
    if (self->parser_.in_message() && !self->held_back_ && came < kLeastProgressBytes)
      return self->end("it began a message and does not complete it", Cause::silent);
    self->watch();
  });
}

// Runs `work`. Out of memory ends this connection only.
template <typename Work>
void Peer::end_on_bad_alloc(Work&& work) {
  try {
    work();
  } catch (const std::exception&) {
    end("there is no memory for its messages", Cause::no_memory);
  }
}

void Peer::read() {
  if (over_ || !end_after_write_.empty()) return;
  if (greeted_ && host_.should_pause(*this)) {
    held_back_ = true;
    return;
  }
  buffer_.resize(kReadBytes);
  socket_.async_read_some(asio::buffer(buffer_), [self = shared_from_this()](const asio::error_code& error,
                                                                             size_t bytes) {
    if (self->over_) return;
    if (error && self->tls_ && !self->tls_->established())
      return self->end("it left during the TLS handshake", Cause::silent);
    if (error == asio::error::eof && !self->greeted_)
      return self->end(self->preface_.empty() ? "it left without a greeting" : "its greeting was cut short",
                       Cause::malformed);
    if (error == asio::error::eof) return self->end("the publisher closed the connection");
    if (error) return self->end("the connection broke (" + error.message() + ")");
    self->end_on_bad_alloc([&] { self->took(bytes); });
  });
}

void Peer::took(size_t bytes) {
  host_.received_bytes(bytes);
  bytes_since_watch_ += bytes;
  heard_at_ns_ = monotonic_ns();
  const std::span<const std::byte> came(buffer_.data(), bytes);
  if (!tls_) {
    take_plain(came);
    return continue_reading();
  }
  plain_.clear();
  tls_answer_.clear();
  if (tls_->established()) return took_sealed(tls_->receive(came, plain_, tls_answer_));
  // A handshake step takes milliseconds. This connection is not read until it is done.
  enum class Step { no_memory, unsound, sound };
  const auto outcome = std::make_shared<Step>(Step::no_memory);
  host_.run_handshake(
      [self = shared_from_this(), came, outcome] {
        *outcome = self->tls_->receive(came, self->plain_, self->tls_answer_) ? Step::sound : Step::unsound;
      },
      [self = shared_from_this(), outcome] {
        if (self->over_) return;
        self->end_on_bad_alloc([&] {
          if (*outcome == Step::no_memory) throw std::bad_alloc();
          self->took_sealed(*outcome == Step::sound);
        });
      });
}

void Peer::took_sealed(bool is_sound) {
  put(std::exchange(tls_answer_, {}));
  if (is_sound) {
    take_plain(plain_);
  } else if (tls_->problem().empty()) {
    return end("the publisher closed the connection");
  } else {
    end_after_write_ = tls_->problem();
    end_cause_ = Cause::bad_key;
  }
  continue_reading();
}

void Peer::continue_reading() {
  write();  // also ends the connection if nothing else is queued
  read();
}

// Lack of memory for one peer's message affects this peer only.
bool Peer::charge_message(size_t bytes) {
  if (bytes == 0) {
    message_charge_.release();
    return true;
  }
  Result<void> charged;
  if (message_charge_.amount() != 0) {
    charged = message_charge_.resize(bytes);
  } else {
    Result<BudgetCharge> taken = BudgetCharge::take(budget, Resource::received_bytes, bytes);
    if (taken)
      message_charge_ = std::move(*taken);
    else
      charged = taken.error();
  }
  if (!charged) charge_problem_ = charged.error().message;
  return charged.ok();
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
  if (const uint64_t skipped = parser_.skipped_poses(); skipped != skipped_poses_)
    host_.skipped_poses(skipped - std::exchange(skipped_poses_, skipped));
  if (cause) return end(host_.refusal_text(*this, *cause), cause);
  switch (fault) {
    case FrameParser::Fault::none:
      return;
    case FrameParser::Fault::bad_header:
      return end("it sent a damaged frame header", Cause::malformed);
    case FrameParser::Fault::too_long:
      return end("it sent a message of more than 256 MiB", Cause::oversize);
    case FrameParser::Fault::no_memory:
      return end(charge_problem_, Cause::no_memory);
  }
}

void Peer::answer_preface() {
  Preface theirs;
  if (!read_preface(std::span(preface_).first<kPrefaceBytes>(), theirs))
    return end("its greeting is not FIRE-3DV's", Cause::malformed);
  greeted_ = true;
  half_open_.release();
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
  put(std::move(wire));
}

void Peer::resume() {
  if (!held_back_ || over_) return;
  held_back_ = false;
  bytes_since_watch_ = kLeastProgressBytes;  // the pause was caused by this side
  read();
}

void Peer::put(std::vector<std::byte>&& bytes) {
  if (!bytes.empty()) outgoing_.push_back(std::move(bytes));
}

// Writes the next queued message. An image's header is written separately, to avoid a copy of the pixels.
bool Peer::put_next() {
  std::optional<SendQueue::Bytes> next = queue && end_after_write_.empty() ? queue->next() : std::nullopt;
  if (!next) return false;
  outgoing_charge_ = std::move(next->charge);
  const auto header = write_frame_header(FrameKind::image, static_cast<uint32_t>(next->size()));
  if (!tls_) {
    if (next->is_image) put({header.begin(), header.end()});
    put(std::move(next->bytes));
    return true;
  }
  std::vector<std::byte> sealed;
  if ((next->is_image && !tls_->seal(header, sealed)) || !tls_->seal(next->bytes, sealed)) {
    end("TLS failed", Cause::bad_key);
    return false;
  }
  put(std::move(sealed));
  return true;
}

void Peer::write() {
  if (writing_ || over_) return;
  if (outgoing_.empty()) outgoing_charge_.release();
  if (outgoing_.empty() && !put_next()) {
    if (!over_ && !end_after_write_.empty()) end(std::string(end_after_write_), end_cause_);
    return;
  }
  writing_ = true;
  asio::async_write(socket_, asio::buffer(outgoing_.front()),
                    [self = shared_from_this()](const asio::error_code& error, size_t) {
                      if (self->over_) return;
                      self->writing_ = false;
                      if (error) return self->end("the connection broke (" + error.message() + ")");
                      self->outgoing_.pop_front();
                      self->write();
                    });
}

void Peer::end(const std::string& reason, std::optional<Cause> cause) {
  if (over_) return;
  over_ = true;
  if (queue) queue->close();
  asio::error_code ignored;
  watch_timer_.cancel();
  socket_.shutdown(asio::ip::tcp::socket::shutdown_both, ignored);
  socket_.close(ignored);
  host_.ended(*this, reason, cause);
}

}  // namespace fire3dv::transport::tcp
