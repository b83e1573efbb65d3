// HTTP/1.1 connections of a server: requests within limits of size and time, and their answers. What requests
// mean is up to the owner of the sessions. All runs on the thread of the accept loop.
#pragma once

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "protocol/transport/http/accept_loop.h"
#include "protocol/transport/http/access_rules.h"
#include "protocol/transport/http/deadline.h"
#include "protocol/transport/http/stream.h"

namespace fire3dv::transport::http {

struct SessionLimits {
  uint64_t max_body_bytes = 0;             // of one request
  int max_requests = 64;                   // of one connection
  std::chrono::seconds header_timeout{5};  // also of a TLS handshake, and of a connection without a request
  std::chrono::seconds body_timeout{5};    // of the whole body
  std::chrono::seconds write_timeout{5};
  std::chrono::seconds body_silence{5};  // between two pieces of a body
  // Of all bodies, as far as they have arrived, until their answers. One client may have half of it.
  uint64_t max_total_body_bytes = UINT64_MAX;
};

struct Answer {
  unsigned status = 200;
  std::string content_type, body;
  std::vector<std::pair<std::string, std::string>> fields = {};
};

class Session;

class SessionOwner : public ConnectionOwner {
 public:
  using Request = boost::beast::http::request<boost::beast::http::string_body>;

  virtual ~SessionOwner() = default;
  size_t open_connections() const override { return open_.size(); }
  std::vector<OpenConnection> list_connections() override;
  void serve(boost::asio::ip::tcp::socket&& socket) override;
  void refuse(boost::asio::ip::tcp::socket& socket) override;

  // A header has come that the access rules allow: calls session.answer(), read_body() or release_stream().
  virtual void on_header(Session& session) = 0;
  // The request is whole: session.answer() is called now or later.
  virtual void on_body(Session&) {}
  // Answer to a request that breaks the rules of HTTP or a limit. text: without line end.
  virtual Answer refusal(unsigned status, const std::string& text) const;

 protected:
  explicit SessionOwner(const SessionLimits& session_limits) : limits(session_limits) {}

  // Logs a refusal's reason. At most a few different lines a minute: clients choose what is in them.
  void report_refusal(const std::string& reason);

  // Set before the first connection.
  SessionLimits limits;
  std::optional<AccessRules> access;                 // nullopt: requests of all sites are answered
  boost::asio::ssl::context* tls_context = nullptr;  // null: plain HTTP; borrowed
  // Counts since the start.
  std::map<unsigned, uint64_t> answered;  // by status
  uint64_t timed_out = 0, evicted = 0;    // connections without an answer
  // Of all bodies that have arrived, until their answers.
  uint64_t body_bytes = 0;

 private:
  friend class Session;
  // Charges a session's client with bytes that have arrived. Makes room by refusing the session that receives
  // of the client with the most; false: this is the session's own.
  bool charge(Session& session, uint64_t bytes);
  // The answer to a request that the access rules refuse.
  std::optional<Answer> check_access(const Request& request);

  std::map<uint64_t, Session*> open_;  // by age, oldest first
  uint64_t next_number_ = 0;
  std::vector<std::string> reported_;  // in the minute since reported_since_
  std::chrono::steady_clock::time_point reported_since_{};
  uint64_t unreported_ = 0;
};

class Session : public std::enable_shared_from_this<Session> {
 public:
  using Request = SessionOwner::Request;

  Session(boost::asio::ip::tcp::socket&& socket, SessionOwner& owner);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  void start();
  void close();
  const std::string& client() const { return client_; }
  Stream::executor_type executor() { return stream_->get_executor(); }

  // For the owner, from on_header() on.
  const Request& request() const { return parser_->get(); }
  std::string_view path() const;  // without query
  std::string_view field(boost::beast::http::field name) const;
  std::optional<uint64_t> content_length() const;  // nullopt: none, or a chunked body
  void read_body();
  std::string take_body() { return std::move(parser_->get().body()); }
  void answer(Answer&& answer);
  // Ends the session; the connection is the caller's, with what its client has sent since the request.
  std::unique_ptr<Stream> release_stream();

 private:
  friend class SessionOwner;
  using ErrorCode = boost::system::error_code;

  void read_header();
  void parse_header();
  void on_read_error(ErrorCode error);
  void refuse(ErrorCode error);
  void drain();
  void limit_time(std::chrono::steady_clock::duration time);
  void continue_body();
  void refuse_for_lack_of_room();
  OpenConnection::Use use() const;

  SessionOwner& owner_;
  const uint64_t number_;
  std::unique_ptr<Stream> stream_;
  const std::string client_;
  const std::chrono::steady_clock::time_point since_;
  Deadline deadline_;
  boost::beast::flat_buffer buffer_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::string_body>> parser_;
  std::optional<boost::beast::http::response<boost::beast::http::string_body>> response_;
  uint64_t charged_bytes_ = 0;  // in SessionOwner::body_bytes
  std::chrono::steady_clock::time_point body_since_{}, body_grew_{};
  int requests_ = 0;
  bool is_idle_ = true;  // waits for a request, or for its connection to end
  bool receives_body_ = false, is_over_time_ = false;
};

inline std::string_view view_of(boost::beast::string_view text) {
  return {text.data(), text.size()};
}

}  // namespace fire3dv::transport::http
