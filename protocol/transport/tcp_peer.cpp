#include "protocol/transport/tcp_peer.h"

#include <array>
#include <asio/read.hpp>
#include <asio/write.hpp>

#include "protocol/transport/tcp_socket.h"

namespace fire3dv::transport::tcp {
namespace {

constexpr std::chrono::seconds kPrefaceTimeout{5};
constexpr size_t kReadBytes = 64 << 10;
constexpr size_t kMostUnsentBytes = 4 << 20;
constexpr size_t kMostUnsentMessages = 4096;

std::string remote_of(const asio::ip::tcp::socket& socket) {
  asio::error_code error;
  const auto endpoint = socket.remote_endpoint(error);
  return error ? "a peer that is gone already" : endpoint.address().to_string(error);
}

}  // namespace

Peer::Peer(asio::ip::tcp::socket socket, PeerHost& host)
    : socket_(std::move(socket)),
      host_(host),
      preface_timer_(socket_.get_executor()),
      remote_(remote_of(socket_)) {}

void Peer::start() {
  tune_socket(socket_.native_handle());
  preface_timer_.expires_after(kPrefaceTimeout);
  preface_timer_.async_wait([self = shared_from_this()](const asio::error_code& error) {
    if (!error && !self->greeted_) self->end("no greeting came in time");
  });
  read_preface_bytes();
}

void Peer::read_preface_bytes() {
  asio::async_read(
      socket_, asio::buffer(preface_),
      [self = shared_from_this()](const asio::error_code& error, size_t bytes) {
        if (self->over_) return;
        self->host_.received_bytes(bytes);
        if (error) return self->end(bytes == 0 ? "it left without a greeting" : "its greeting was cut short");
        self->answer_preface();
      });
}

void Peer::answer_preface() {
  Preface theirs;
  if (!read_preface(preface_, theirs)) return end("its greeting is not FIRE-3DV's");
  greeted_ = true;
  preface_timer_.cancel();
  Preface ours;
  ours.status =
      theirs.version == kTransportVersion ? host_.greet(*this, theirs) : PrefaceStatus::version_mismatch;
  answer_ = write_preface(ours);
  writing_ = true;
  asio::async_write(socket_, asio::buffer(answer_),
                    [self = shared_from_this(), status = ours.status, version = theirs.version](
                        const asio::error_code& error, size_t) {
                      if (self->over_) return;
                      self->writing_ = false;
                      if (error) return self->end("the connection broke");
                      if (status == PrefaceStatus::version_mismatch)
                        return self->end("it speaks transport version " + std::to_string(version) +
                                         ", this program speaks " + std::to_string(kTransportVersion) +
                                         "; use the same version on both sides");
                      if (status == PrefaceStatus::full)
                        return self->end("as many peers as allowed are connected");
                      self->write();
                      self->read();
                    });
}

void Peer::read() {
  if (over_) return;
  if (host_.hold_back(*this)) {
    held_back_ = true;
    return;
  }
  buffer_.resize(kReadBytes);
  socket_.async_read_some(asio::buffer(buffer_),
                          [self = shared_from_this()](const asio::error_code& error, size_t bytes) {
                            if (self->over_) return;
                            if (error == asio::error::eof)
                              return self->end("the publisher closed the connection");
                            if (error) return self->end("the connection broke (" + error.message() + ")");
                            self->took(bytes);
                          });
}

void Peer::took(size_t bytes) {
  host_.received_bytes(bytes);
  std::string reason;
  const auto fault =
      parser_.feed({buffer_.data(), bytes}, [&](FrameKind kind, std::vector<std::byte>&& message) {
        if (reason.empty() && !host_.received(*this, kind, std::move(message), reason) && reason.empty())
          reason = "it was not welcome";
      });
  if (!reason.empty()) return end(reason, true);
  if (fault == FrameParser::Fault::bad_header) return end("it sent a damaged frame header", true);
  if (fault == FrameParser::Fault::too_long) return end("it sent a message of more than 256 MiB", true);
  read();
}

void Peer::resume() {
  if (!held_back_ || over_) return;
  held_back_ = false;
  read();
}

void Peer::send(std::vector<std::byte>&& message) {
  if (over_) return;
  outgoing_bytes_ += message.size();
  if (outgoing_bytes_ > kMostUnsentBytes || outgoing_.size() >= kMostUnsentMessages)
    return end("it does not read what is sent to it", true);
  const auto header = write_frame_header(FrameKind::control, static_cast<uint32_t>(message.size()));
  outgoing_.push_back({header, std::move(message)});
  write();
}

void Peer::write() {
  if (writing_ || over_ || outgoing_.empty()) return;
  writing_ = true;
  const Outgoing& next = outgoing_.front();
  const std::array<asio::const_buffer, 2> pieces{asio::buffer(next.header), asio::buffer(next.message)};
  asio::async_write(socket_, pieces, [self = shared_from_this()](const asio::error_code& error, size_t) {
    if (self->over_) return;
    self->writing_ = false;
    if (error) return self->end("the connection broke (" + error.message() + ")");
    self->outgoing_bytes_ -= self->outgoing_.front().message.size();
    self->outgoing_.pop_front();
    self->write();
  });
}

void Peer::end(const std::string& reason, bool at_fault) {
  if (over_) return;
  over_ = true;
  asio::error_code ignored;
  preface_timer_.cancel();
  socket_.shutdown(asio::ip::tcp::socket::shutdown_both, ignored);
  socket_.close(ignored);
  host_.ended(*this, reason, at_fault);
}

}  // namespace fire3dv::transport::tcp
