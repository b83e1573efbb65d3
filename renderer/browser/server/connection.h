// HTTP connection of the live view: serves the files of the page, and turns into a viewer's WebSocket when
// the page asks for it. Lives on the server's thread.
#pragma once

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <memory>
#include <optional>
#include <string>

#include "protocol/transport/http/deadline.h"
#include "renderer/browser/server/hub.h"
#include "renderer/browser/server/stream.h"

namespace fire3dv::serve {

class Connection : public std::enable_shared_from_this<Connection> {
 public:
  // tls: null for plain HTTP.
  Connection(boost::asio::ip::tcp::socket&& socket, boost::asio::ssl::context* tls, Hub& hub);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void start();
  void close();

 private:
  using ErrorCode = boost::system::error_code;
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;

  void read();
  void on_request(ErrorCode error);
  void answer(const Request& request);
  void upgrade(const Request& request);
  void write(unsigned status, std::string_view type, std::string_view body, const Request* request);
  void limit_time();

  Hub& hub_;
  const uint64_t number_;
  std::unique_ptr<Stream> stream_;  // null: a viewer's socket has it
  transport::http::Deadline deadline_;
  boost::beast::flat_buffer buffer_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::empty_body>> parser_;
  std::optional<boost::beast::http::response<boost::beast::http::string_body>> response_;
  int requests_ = 0;
};

}  // namespace fire3dv::serve
