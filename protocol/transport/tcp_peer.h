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

#include "protocol/base/peer_budget.h"
#include "protocol/transport/link.h"
#include "protocol/transport/tcp_frame.h"
#include "protocol/transport/tcp_send_queue.h"
#include "protocol/transport/tls_session.h"

namespace fire3dv::transport::tcp {

class Peer;

// What a connection asks of its listener. All calls come on the listener's thread.
class PeerHost {
 public:
  virtual ~PeerHost() = default;
  // A sound preface came: may this be a peer? On yes it has a PeerId, a budget and a queue from now on.
  virtual PrefaceStatus greet(Peer& peer) = 0;
  virtual void received_bytes(size_t bytes) = 0;
  // Runs `step` on the thread that computes TLS handshakes, and then `done` on the listener's thread.
  virtual void run_handshake(std::function<void()> step, std::function<void()> done) = 0;
  // So many poses did not fit the peer's budget.
  virtual void skipped_poses(size_t count) = 0;
  // A cause: the connection has to end. refusal_text() has the sentence.
  virtual std::optional<Cause> received(Peer& peer, FrameKind kind, std::vector<std::byte>&& message) = 0;
  virtual std::string refusal_text(const Peer& peer, Cause cause) const = 0;
  // True: reading stops until resume() is called.
  virtual bool hold_back(const Peer& peer) = 0;
  // The connection is over. The peer must not be used after this. cause: it broke a rule; none: it left, or
  // was lost.
  virtual void ended(Peer& peer, const std::string& reason, std::optional<Cause> cause) = 0;
};

class Peer : public std::enable_shared_from_this<Peer> {
 public:
  // What a connection without a greeting is charged: its receive buffer, and the state of a TLS handshake.
  static constexpr size_t kHalfOpenBytes = 128 << 10;

  // half_open: the charge of kHalfOpenBytes, which ends with the greeting. tls null: tcp://
  Peer(asio::ip::tcp::socket socket, PeerHost& host, BudgetCharge half_open, std::unique_ptr<TlsSession> tls);

  void start();
  // Sends on: something was added to `queue`.
  void write();
  void resume();
  void end(const std::string& reason, std::optional<Cause> cause = {});

  // Set by the host when it greets the peer.
  PeerId id = 0;  // 0 until then
  std::shared_ptr<PeerBudget> budget;
  std::shared_ptr<SendQueue> queue;
  int64_t greeted_at_ns = 0;

  int64_t heard_at_ns() const { return heard_at_ns_; }
  const std::string& remote() const { return remote_; }

 private:
  void watch();
  template <typename Work>
  void without_memory_end(Work&& work);
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
  std::unique_ptr<TlsSession> tls_;  // on the handshake's thread while a step of it runs
  std::vector<std::byte> preface_;   // what of it came
  BudgetCharge message_charge_;      // of the message that is not whole
  std::string charge_problem_;       // why that was refused
  FrameParser parser_;
  uint64_t skipped_poses_ = 0;  // of the parser, as told to the host
  std::vector<std::byte> buffer_, plain_, tls_answer_;
  std::deque<std::vector<std::byte>> outgoing_;  // as it goes on the wire
  BudgetCharge outgoing_charge_;                 // of the message from `queue` in outgoing_
  size_t bytes_since_watch_ = 0;
  int64_t heard_at_ns_ = 0;
  std::string end_after_write_;  // the reason, once what is queued has gone
  std::optional<Cause> end_cause_;
  bool greeted_ = false;
  bool writing_ = false;
  bool held_back_ = false;
  bool over_ = false;
};

}  // namespace fire3dv::transport::tcp
