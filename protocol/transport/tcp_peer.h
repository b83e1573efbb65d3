// One connection of a TCP listener, from accept to close. Lives on the listener's thread alone.
#pragma once

// The standard library's headers stand before Asio's: Asio 1.22 chooses its allocation functions by a macro
// of theirs, and two sources that choose differently would free each other's memory wrongly.
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#define ASIO_STANDALONE 1
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/steady_timer.hpp>

#include "protocol/transport/image_queue.h"
#include "protocol/transport/link.h"
#include "protocol/transport/tcp_frame.h"
#include "protocol/transport/tls_session.h"
#include "protocol/wire/image.h"

namespace fire3dv::transport::tcp {

class Peer;

// What a connection asks of its listener. All calls come on the listener's thread.
class PeerHost {
 public:
  virtual ~PeerHost() = default;
  // A sound preface came: may this be a peer? On yes it has a PeerId from now on.
  virtual PrefaceStatus greet(Peer& peer) = 0;
  virtual void received_bytes(size_t bytes) = 0;
  // So many images were given up for newer ones, or for lack of room.
  virtual void dropped_images(size_t count) = 0;
  // A cause: the connection has to end.
  virtual std::optional<Cause> received(Peer& peer, FrameKind kind, std::vector<std::byte>&& message) = 0;
  // True: reading stops until resume() is called.
  virtual bool hold_back(const Peer& peer) = 0;
  // The connection is over. The peer must not be used after this. cause: it broke a rule; none: it left, or
  // was lost.
  virtual void ended(Peer& peer, const std::string& reason, std::optional<Cause> cause) = 0;
};

class Peer : public std::enable_shared_from_this<Peer> {
 public:
  static constexpr size_t kMostImageBytes = size_t{512} << 20;  // that wait

  // tls null: tcp://
  Peer(asio::ip::tcp::socket socket, PeerHost& host, MemoryBudget& budget, std::unique_ptr<TlsSession> tls);

  void start();
  void send(std::span<const std::byte> message);
  void send_image(uint64_t request, BudgetedBytes&& block);
  void resume();
  void end(const std::string& reason, std::optional<Cause> cause = {});

  PeerId id = 0;              // 0 until greeted
  int64_t greeted_at_ns = 0;  // these two are the host's
  bool has_spoken = false;    // a whole message came
  const std::string& remote() const { return remote_; }

 private:
  void watch();
  void read();
  void took(size_t bytes);
  void take_plain(std::span<const std::byte> plain);
  void answer_preface();
  void queue(std::vector<std::byte>&& bytes);
  bool queue_image();
  void write();

  asio::ip::tcp::socket socket_;
  PeerHost& host_;
  asio::steady_timer watch_timer_;
  std::string remote_;
  std::unique_ptr<TlsSession> tls_;
  std::vector<std::byte> preface_;  // what of it came
  FrameParser parser_;
  std::vector<std::byte> buffer_, plain_;
  std::deque<std::vector<std::byte>> outgoing_;  // as it goes on the wire
  size_t outgoing_bytes_ = 0;
  ImageQueue<BudgetedBytes> images_{kMostImageBytes, wire::kMostImageRequests};
  size_t image_bytes_ = 0;   // of outgoing_: the image at its front
  BudgetShare image_share_;  // of that image
  int image_pieces_ = 0;
  size_t bytes_since_watch_ = 0;
  std::string end_after_write_;  // the reason, once what is queued has gone
  std::optional<Cause> end_cause_;
  bool greeted_ = false;
  bool writing_ = false;
  bool held_back_ = false;
  bool over_ = false;
};

}  // namespace fire3dv::transport::tcp
