// One HTTP connection: reads a request within limits, hands it to the handler, and writes the answer.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "programs/drake/http/server.h"
#include "protocol/transport/http/deadline.h"

namespace fire3dv::drake {

class Session;

// State that all sessions share, on the server's thread.
struct Sessions {
  HttpLimits limits;
  HttpServer::Handler handler;
  uint64_t body_bytes = 0;            // see HttpLimits::max_total_bytes
  std::map<uint64_t, Session*> open;  // by age, oldest first
  uint64_t next_number = 0;

  // Closes the oldest connection that has not sent a whole header. False: there is none.
  bool evict_idle();
};

class Session : public std::enable_shared_from_this<Session> {
 public:
  Session(boost::asio::ip::tcp::socket socket, Sessions& sessions);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  void start() { read_header(); }
  bool is_idle() const { return is_idle_; }
  void close();

 private:
  using ErrorCode = boost::system::error_code;

  void read_header();
  void on_header(ErrorCode error);
  // Answer that needs no body, or nullopt.
  std::optional<HttpAnswer> answer_to_header() const;
  void read_body();
  void on_body(ErrorCode error);
  void on_read_error(ErrorCode error);
  void write(HttpAnswer&& answer, bool keep_alive);
  void drain();
  void limit_time(std::chrono::seconds seconds);
  void release_bytes();

  Sessions& sessions_;
  const uint64_t number_;
  boost::asio::ip::tcp::socket socket_;
  transport::http::Deadline deadline_;
  boost::beast::flat_buffer buffer_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::string_body>> parser_;
  std::optional<boost::beast::http::response<boost::beast::http::string_body>> response_;
  uint64_t charged_bytes_ = 0;  // in Sessions::body_bytes
  bool is_idle_ = true;         // no whole header yet
  bool timed_out_ = false;
};

}  // namespace fire3dv::drake
