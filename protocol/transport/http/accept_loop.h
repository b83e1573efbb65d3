// Accept loop of an HTTP server: binds HOST:PORT, and hands connections to the server within a limit. It owns
// the io_context of the server's thread.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/error.h"
#include "protocol/transport/core/address.h"

namespace fire3dv::transport::http {

// Clients are told apart by address: of IPv6 the first 64 bits, which one host has for itself.
std::string client_of(const boost::asio::ip::tcp::socket& socket);

// An open connection, for the choice of one that makes room.
struct OpenConnection {
  std::string client;
  std::chrono::steady_clock::time_point since;
  enum class Use : uint8_t {
    idle,       // waits for a request, a header or a token
    slow,       // a body that makes little progress
    receiving,  // a body
    kept,       // being answered, or a viewer
  };
  Use use = Use::idle;
  std::function<void()> close;
};

// The connection that makes room for one of `newcomer`; null: none does. Of the clients with the most
// connections the oldest idle or slow one; one that receives only if its client has more than the newcomer's
// would have.
const OpenConnection* choose_evicted(const std::vector<OpenConnection>& open, const std::string& newcomer);

// Part of the server; called on the thread of run().
class ConnectionOwner {
 public:
  virtual size_t open_connections() const = 0;
  virtual std::vector<OpenConnection> list_connections() = 0;
  virtual void serve(boost::asio::ip::tcp::socket&& socket) = 0;
  // The limit is reached and nothing could be evicted. The socket is closed afterwards.
  virtual void refuse(boost::asio::ip::tcp::socket&) {}

 protected:
  ~ConnectionOwner() = default;
};

struct ListenOptions {
  std::string at;              // HOST:PORT, port 0 for any free port
  std::string option;          // that has `at`, for errors: "--serve"
  uint16_t example_port = 80;  // for errors
  bool may_be_public = false;  // allows addresses other than loopback
  std::string risk;            // of other addresses, for the error that refuses them
  std::string remedy;          // other than a loopback address, or empty: "add --tls-cert"
  size_t max_connections = 64;
};

class AcceptLoop {
 public:
  // owner: borrowed, outlives this object, and so do the objects that handlers of io() refer to.
  static Result<std::unique_ptr<AcceptLoop>> open(const ListenOptions& options, ConnectionOwner& owner);
  AcceptLoop(const AcceptLoop&) = delete;
  AcceptLoop& operator=(const AcceptLoop&) = delete;

  boost::asio::io_context& io() { return io_; }
  std::string address() const { return address_; }   // "HOST:PORT" with the assigned port
  std::string host() const { return host_; }         // as in the options, without brackets
  bool is_loopback() const { return is_loopback_; }  // no other machine can connect

  // Accepts connections and runs the handlers of io() until stop(). A handler that throws for lack of memory
  // loses its connection only.
  void run();
  void stop() { io_.stop(); }  // from any thread

 private:
  AcceptLoop(ConnectionOwner& owner, size_t max_connections)
      : owner_(owner), max_connections_(max_connections) {}
  void accept();
  void take(boost::asio::ip::tcp::socket&& socket);

  ConnectionOwner& owner_;
  const size_t max_connections_;
  std::string address_, host_;
  bool is_loopback_ = false;
  boost::asio::io_context io_{1};
  boost::asio::ip::tcp::acceptor acceptor_{io_};
  boost::asio::steady_timer accept_again_{io_};
};

}  // namespace fire3dv::transport::http
