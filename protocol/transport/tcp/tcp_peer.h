// One connection of a TCP listener, from accept to close. Used on the listener's thread only.
#pragma once

// Standard headers precede Asio's: Asio 1.22 selects its allocation functions by a macro of theirs.
// Translation units that differ would mix allocators.
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#define ASIO_STANDALONE 1
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/steady_timer.hpp>

#include "base/peer_budget.h"
#include "protocol/transport/link.h"
#include "protocol/transport/tcp/tcp_connection.h"
#include "protocol/transport/tcp/tcp_frame.h"
#include "protocol/transport/tcp/tcp_send_queue.h"

namespace fire3dv::transport::tcp {

class Peer;

// Callbacks of a connection to its listener, on the listener's thread.
class PeerHost {
 public:
  virtual ~PeerHost() = default;
  // Called for a valid preface. On ok the peer has an id, a budget and a queue.
  virtual PrefaceStatus greet(Peer& peer) = 0;
  virtual void received_bytes(size_t bytes) = 0;
  // Runs `step` on the TLS handshake thread, then `done` on the listener's thread.
  virtual void run_handshake(std::function<void()> step, std::function<void()> done) = 0;
  // Reports the number of poses that did not fit the peer's budget.
  virtual void skipped_poses(size_t count) = 0;
  // Delivers a message. Returns a cause if the connection must end; refusal_text() has the message.
  virtual std::optional<Cause> received(Peer& peer, FrameKind kind, std::vector<std::byte>&& message) = 0;
  virtual std::string refusal_text(const Peer& peer, Cause cause) const = 0;
  // True: reading stops until resume() is called.
  virtual bool should_pause(const Peer& peer) = 0;
  // Reports the end of the connection, after which the peer must not be used. cause: rule violation; none: it
  // left or was lost.
  virtual void ended(Peer& peer, const std::string& reason, std::optional<Cause> cause) = 0;
};

class Peer : public std::enable_shared_from_this<Peer> {
 public:
  // Charge of an ungreeted connection: receive buffer and TLS handshake state.
  static constexpr size_t kHalfOpenBytes = 128 << 10;

  // half_open: the charge of kHalfOpenBytes, released by the greeting. tls null: tcp://
  Peer(asio::ip::tcp::socket socket, PeerHost& host, BudgetCharge half_open, std::unique_ptr<TlsSession> tls);

  void start();
  // Sends the items of `queue`.
  void write();
  void resume();
  void end(const std::string& reason, std::optional<Cause> cause = {});

  // Set by the host in greet().
  PeerId id = 0;  // 0 before
  std::shared_ptr<PeerBudget> budget;
  std::shared_ptr<SendQueue> queue;
  int64_t greeted_at_ns = 0;

  int64_t heard_at_ns() const { return heard_at_ns_; }
  const std::string& remote() const { return remote_; }

 private:
  void watch();
  template <typename Work>
  void end_on_bad_alloc(Work&& work);
  void read();
  void took(size_t bytes);
  void took_sealed(bool is_sound);
  void take_plain(std::span<const std::byte> plain);
  void continue_reading();
  void answer_preface();
  bool charge_message(size_t bytes);
  void put(std::vector<std::byte>&& bytes);
  bool put_next();

  asio::ip::tcp::socket socket_;
  PeerHost& host_;
  asio::steady_timer watch_timer_;
  std::string remote_;
  BudgetCharge half_open_;
  std::unique_ptr<TlsSession> tls_;  // used by the handshake thread while a step runs
  std::vector<std::byte> preface_;   // received part
  BudgetCharge message_charge_;      // for the incomplete message
  std::string charge_problem_;       // reason of a refused charge
  FrameParser parser_;
  uint64_t skipped_poses_ = 0;  // number already reported to the host
  std::vector<std::byte> buffer_, plain_, tls_answer_;
  std::deque<std::vector<std::byte>> outgoing_;  // in wire format
  BudgetCharge outgoing_charge_;                 // for the message of `queue` in outgoing_
  size_t bytes_since_watch_ = 0;
  int64_t heard_at_ns_ = 0;
  std::string end_after_write_;  // reason; the connection ends after the queue is sent
  std::optional<Cause> end_cause_;
  bool greeted_ = false;
  bool writing_ = false;
  bool held_back_ = false;
  bool over_ = false;
};

}  // namespace fire3dv::transport::tcp
