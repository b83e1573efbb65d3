// One connection of a TCP listener, from accept to close. Lives on the listener's thread alone.
#pragma once

// The standard library's headers stand before Asio's: Asio 1.22 chooses its allocation functions by a macro of theirs,
// and two sources that choose differently would free each other's memory wrongly.
#include <deque>
#include <functional>
#include <memory>
#include <string>

#define ASIO_STANDALONE 1
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/steady_timer.hpp>

#include "protocol/transport/link.h"
#include "protocol/transport/tcp_frame.h"

namespace fire3dv::transport::tcp {

class Peer;

// What a connection asks of its listener. All calls come on the listener's thread.
class PeerHost {
 public:
  virtual ~PeerHost() = default;
  // A sound preface came: may this be a peer? On yes it has a PeerId from now on.
  virtual PrefaceStatus greet(Peer& peer, const Preface& preface) = 0;
  virtual void received_bytes(size_t bytes) = 0;
  // False: the connection has to end, with what `reason` says.
  virtual bool received(Peer& peer, FrameKind kind, std::vector<std::byte>&& message,
                        std::string& reason) = 0;
  // True: reading stops until resume() is called.
  virtual bool hold_back(const Peer& peer) = 0;
  // The connection is over. The peer must not be used after this.
  virtual void ended(Peer& peer, const std::string& reason, bool at_fault) = 0;
};

class Peer : public std::enable_shared_from_this<Peer> {
 public:
  Peer(asio::ip::tcp::socket socket, PeerHost& host);

  void start();
  void send(std::vector<std::byte>&& message);
  void resume();
  // at_fault: it broke the rules; otherwise it left, or was lost.
  void end(const std::string& reason, bool at_fault = false);

  PeerId id = 0;  // 0 until greeted
  const std::string& remote() const { return remote_; }

 private:
  void read_preface_bytes();
  void answer_preface();
  void read();
  void took(size_t bytes);
  void write();

  asio::ip::tcp::socket socket_;
  PeerHost& host_;
  asio::steady_timer preface_timer_;
  std::string remote_;
  PrefaceBytes preface_{};
  PrefaceBytes answer_{};
  FrameParser parser_;
  std::vector<std::byte> buffer_;
  struct Outgoing {
    FrameHeader header;
    std::vector<std::byte> message;
  };
  std::deque<Outgoing> outgoing_;
  size_t outgoing_bytes_ = 0;
  bool greeted_ = false;
  bool writing_ = false;
  bool held_back_ = false;
  bool over_ = false;
};

}  // namespace fire3dv::transport::tcp
