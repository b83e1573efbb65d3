// Byte stream of a connection, with or without TLS, as one type: the HTTP and WebSocket code is compiled
// once.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <optional>
#include <string>
#include <utility>

#include "protocol/transport/http/accept_loop.h"

namespace fire3dv::transport::http {

class Stream {
 public:
  using Socket = boost::asio::ip::tcp::socket;
  using executor_type = Socket::executor_type;

  // tls: null for a plain stream; borrowed.
  Stream(Socket&& socket, boost::asio::ssl::context* tls)
      : socket_(std::move(socket)), client_(client_of(socket_)) {
    if (tls) tls_.emplace(socket_, *tls);
  }

  Socket& socket() { return socket_; }
  const std::string& client() const { return client_; }
  std::chrono::steady_clock::time_point since() const { return since_; }
  executor_type get_executor() { return socket_.get_executor(); }

  // Calls handler(error_code) after the TLS handshake; at once for a plain stream.
  template <typename Handler>
  void async_handshake(Handler&& handler) {
    if (tls_)
      tls_->async_handshake(boost::asio::ssl::stream_base::server, std::forward<Handler>(handler));
    else
      handler(boost::system::error_code());
  }

  template <typename Buffers, typename Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler) {
    if (tls_)
      tls_->async_read_some(buffers, std::forward<Handler>(handler));
    else
      socket_.async_read_some(buffers, std::forward<Handler>(handler));
  }
  template <typename Buffers, typename Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    if (tls_)
      tls_->async_write_some(buffers, std::forward<Handler>(handler));
    else
      socket_.async_write_some(buffers, std::forward<Handler>(handler));
  }

 private:
  Socket socket_;
  const std::string client_;
  const std::chrono::steady_clock::time_point since_ = std::chrono::steady_clock::now();
  std::optional<boost::asio::ssl::stream<Socket&>> tls_;
};

// End of a WebSocket: its closing handshake has already told both sides, so TLS needs none.
template <typename Handler>
void async_teardown(boost::beast::role_type role, Stream& stream, Handler&& handler) {
  boost::beast::websocket::async_teardown(role, stream.socket(), std::forward<Handler>(handler));
}
inline void teardown(boost::beast::role_type role, Stream& stream, boost::system::error_code& error) {
  boost::beast::websocket::teardown(role, stream.socket(), error);
}
// Beast calls it when a time limit is over.
inline void beast_close_socket(Stream& stream) {
  boost::system::error_code ignored;
  stream.socket().close(ignored);
}

}  // namespace fire3dv::transport::http
